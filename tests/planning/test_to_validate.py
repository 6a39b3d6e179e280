"""Load cases to validate with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import InfeasibleError
from elastocal.planning.near import NEAR, distances
from elastocal.planning.to_validate import to_validate
from elastocal.robot.chain import Robot
from elastocal.terminal.plans import show_to_validate
from tests.kr270 import kr270_study
from tests.planning.test_promise import PLAN


def between(robot: Robot, one: ec.LoadCases, other: ec.LoadCases) -> np.ndarray:
    return distances(robot, one.q, one.wrench, other.q, other.wrench)


def test_they_are_feasible_and_far_from_what_is_fitted_and_from_each_other() -> None:
    study = kr270_study()
    found = to_validate(study, PLAN, 8)
    assert len(found.load_cases) == 8
    assert not ec.assess(study, found.load_cases, found.repeats).violations
    away = between(study.robot, found.load_cases, PLAN).min(axis=1)
    each = between(study.robot, found.load_cases, found.load_cases)
    nearest = np.minimum(away, (each + np.diag(np.full(8, np.inf))).min(axis=1))
    np.testing.assert_allclose(found.apart, nearest)
    assert found.apart.min() > 3.0 * NEAR
    assert found.schedule.hours > 0.0
    assert (found.load_cases.q[:, 0] == 0.0).all()  # A1 does not matter under a hung weight


def test_random_ones_are_nearer() -> None:
    """Negative control: as many random load cases leave some that are hardly others."""
    study = kr270_study()
    found = to_validate(study, PLAN, 8).apart.min()
    rng = np.random.default_rng(0)
    drawn = [study.space.load_cases(study.space.sample(8, rng)) for _ in range(20)]
    assert found > max(between(study.robot, cases, PLAN).min() for cases in drawn)


def test_the_same_seed_finds_the_same() -> None:
    one, same, other = (to_validate(kr270_study(), PLAN, 3, seed=s) for s in (0, 0, 1))
    np.testing.assert_array_equal(one.load_cases.q, same.load_cases.q)
    assert (one.load_cases.q != other.load_cases.q).any()


def test_where_there_are_no_others_is_said() -> None:
    study = kr270_study()
    held = replace(study, limits=np.repeat(PLAN.q[:1], 2, axis=0))
    one = ec.LoadCases(PLAN.q[:1], PLAN.wrench[:1])
    with pytest.raises(InfeasibleError, match="there are 0 configurations to validate with"):
        to_validate(held, one, 2)


def test_loads_that_differ_are_in_the_table(capsys: pytest.CaptureFixture[str]) -> None:
    """A hung weight is the control: it is said once, with the plan."""
    study = kr270_study()
    found = to_validate(study, PLAN, 2)
    show_to_validate(study.robot, found)
    assert "force N" not in capsys.readouterr().out
    wrench = found.load_cases.wrench * [[1.0], [0.5]]
    other = replace(found, load_cases=ec.LoadCases(found.load_cases.q, wrench))
    show_to_validate(study.robot, other)
    shown = capsys.readouterr().out
    assert "force N" in shown
    assert "-1250" in shown
    assert "torque" not in shown
