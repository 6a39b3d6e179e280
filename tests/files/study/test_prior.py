"""What is known before a campaign: as standard errors, as a matrix, or as a plan."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.errors import StudyError
from tests.files.campaign import STUDY_TEXT, study

FIVE = "prior: {{information_N2m2: {}}}\n"
DIAGONAL = np.diag([1.0, 2.0, 3.0, 4.0, 5.0]) * 1e12


def of(matrix: np.ndarray) -> str:
    return STUDY_TEXT + FIVE.format(matrix.tolist())


def with_entry(i: int, j: int, value: float) -> np.ndarray:
    matrix = DIAGONAL.copy()
    matrix[i, j] = value
    return matrix


def test_standard_errors_are_information_of_two_joints() -> None:
    text = "prior: {standard_error_rad_per_Nm: {A5: 2.0e-8, A3: 4.0e-8}}\n"
    expected = np.diag([0.0, 1.0 / 16.0, 0.0, 0.25, 0.0]) * 1e16
    np.testing.assert_allclose(study(STUDY_TEXT + text).prior, expected, rtol=1e-12)


def test_a_matrix_is_taken_as_it_is() -> None:
    root = np.random.default_rng(0).normal(size=(5, 3))
    information = 1e12 * (root @ root.T)  # singular, which is allowed
    np.testing.assert_allclose(study(of(information)).prior, information, rtol=1e-12)


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        (DIAGONAL[:4], "must be 5 rows of 5 numbers, one for each of A2, A3, A4, A5, A6"),
        (DIAGONAL[:, :4], "must be 5 rows of 5 numbers"),
        (with_entry(0, 1, 1e10), "is not symmetric"),
        (with_entry(2, 2, -1e9), "has a negative eigenvalue"),
    ],
)
def test_a_matrix_that_cannot_be_is_refused_with_its_line(matrix: np.ndarray, words: str) -> None:
    line = STUDY_TEXT.count("\n") + 1
    with pytest.raises(StudyError, match=rf"line {line}.*{words}"):
        study(of(matrix))


def test_rounding_is_no_fault() -> None:
    study(of(with_entry(2, 2, -1e2)))
    matrix = with_entry(0, 1, 1e10)
    matrix[1, 0] = 1e10 * (1.0 + 1e-7)
    study(of(matrix))
