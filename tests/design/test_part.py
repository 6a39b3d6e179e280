"""Criteria of some of the unknowns; what every criterion must be is in test_criteria.py."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.design.matrix_means import MatrixMean
from elastocal.design.observability import SingularValueRatio
from elastocal.design.part import InformationOnPart, OnPart, information_on, on_part
from tests.design.examples import information_matrix


def test_information_on_a_part_is_the_inverse_of_its_covariance() -> None:
    matrices = np.array([information_matrix(np.random.default_rng(i), 5) for i in range(4)])
    wanted = [3, 0]
    covariance = np.linalg.inv(matrices)[:, wanted][:, :, wanted]
    np.testing.assert_allclose(
        information_on(wanted, matrices), np.linalg.inv(covariance), rtol=1e-8
    )


def test_what_is_known_exactly_leaves_its_own_block() -> None:
    """A prior that grows without end: the others count as held."""
    matrix = information_matrix(np.random.default_rng(1), 4)
    certain = matrix + np.diag([0.0, 0.0, 1e12, 1e12])
    found = information_on([0, 1], certain[None])[0]
    np.testing.assert_allclose(found, matrix[:2, :2], rtol=1e-6)
    unknown = information_on([0, 1], matrix[None])[0]
    assert np.linalg.eigvalsh(found - unknown)[0] > 0.0


def test_all_unknowns_are_no_part() -> None:
    a, ratio = MatrixMean(-1.0), SingularValueRatio(1)
    assert on_part(a, [0, 1, 2], 3) is a
    assert isinstance(on_part(a, [0], 3), InformationOnPart)
    assert type(on_part(ratio, [0], 3)) is OnPart


@pytest.mark.parametrize("order", [-1.0, -np.inf])
def test_smooth_stands_in_on_the_same_part(order: float) -> None:
    made = InformationOnPart(MatrixMean(order), [0, 2])
    matrix = information_matrix(np.random.default_rng(2))[None]
    np.testing.assert_allclose(made.smooth.value(matrix), made.value(matrix), rtol=0.01)
    assert (made.smooth is made) == (order == -1.0)
