"""Rows of load cases that err: their information, and its gradients."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from elastocal.design.space import information
from elastocal.elastic.case_errors import CaseErrors
from elastocal.planning.with_errors import WithErrors
from elastocal.study.experiment_space import LoadCaseEvaluation, LoadCaseSpace
from tests.core.spaces import random_errors, random_space
from tests.planning.test_aim import COMMON, told
from tests.planning.test_promise import ALL, PLAN, REPEATS

shapes = st.tuples(
    st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=1, max_size=6), st.integers(1, 3)
)


def erring(shape: tuple[int, list[bool], int]) -> LoadCaseSpace:
    """A space of any shape whose load cases err."""
    space, rng = random_space(*shape), np.random.default_rng(shape[0])
    assume(not space.arm.weighs)
    return replace(space, errors=random_errors(rng, space.arm.springs))


@settings(max_examples=60)
@given(shapes)
def test_gradients_of_what_information_is_worth(shape: tuple[int, list[bool], int]) -> None:
    space, rng = erring(shape), np.random.default_rng(shape[0])
    x = rng.uniform(space.lower, space.upper, (4, len(space.lower)))
    repeats = rng.uniform(0.5, 9.0, len(x))
    root = rng.normal(size=(space.parameters, 3))

    def worth(at: np.ndarray) -> np.ndarray:
        blocks = LoadCaseEvaluation(space, at, repeats).blocks
        return np.asarray(((blocks @ root) ** 2).sum(axis=(1, 2)))

    found = LoadCaseEvaluation(space, x, repeats)
    cotangent = 2.0 * found.blocks @ root @ root.T
    gradient = found.pull(cotangent, 0.0 * found.margins)
    size = np.abs(gradient).max()
    assume(size > 0.0)
    step = 1e-6
    for i in np.flatnonzero(space.lower < 0.0):  # whether a load is there is not moved
        move = step * np.eye(len(space.lower))[i]
        slope = (worth(x + move) - worth(x - move)) / (2.0 * step)
        np.testing.assert_allclose(gradient[:, i], slope, rtol=0, atol=3e-6 * size)


@pytest.mark.parametrize("errors", [ALL, COMMON, CaseErrors(friction=0.1), CaseErrors(gain=0.02)])
def test_information_of_load_cases_that_err(errors: CaseErrors) -> None:
    """Against their covariances; the second route inverts these, case by case."""
    study = told(errors)
    assert study.nuisance is not None
    known = WithErrors(study, study.nuisance)
    space, x = known.space, study.space.points(PLAN)
    found = LoadCaseEvaluation(space, x, REPEATS.astype(float))
    each = REPEATS[:, None, None] * information(found.blocks)
    expected = known.informations(PLAN, REPEATS)
    size = np.sqrt(np.diagonal(expected.mean(axis=0)))
    size[size == 0.0] = 1.0
    np.testing.assert_allclose(
        each / np.outer(size, size), expected / np.outer(size, size), rtol=0, atol=1e-9
    )


def test_repeats_that_nobody_states() -> None:
    """A space says how often its load cases are measured together."""
    study = told(COMMON)
    assert study.nuisance is not None
    space = WithErrors(study, study.nuisance).space
    x = study.space.points(PLAN)
    often = LoadCaseEvaluation(space.measured_together(4.0), x, None)
    stated = LoadCaseEvaluation(space, x, np.full(len(x), 4.0))
    np.testing.assert_array_equal(often.blocks, stated.blocks)
    once = information(LoadCaseEvaluation(space, x, None).blocks)
    assert (
        np.trace(information(often.blocks), axis1=1, axis2=2) < np.trace(once, axis1=1, axis2=2)
    ).all()
