"""Load cases that are near to each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import elastocal as ec
from elastocal.elastic.case_errors import CaseErrors
from elastocal.planning.near import near_configurations, near_load_cases
from elastocal.planning.with_errors import WithErrors
from tests.kr270 import kr270_study
from tests.planning.test_aim import told
from tests.planning.test_promise import ALL, PLAN, REPEATS

ROBOT = kr270_study().robot


def beside(cases: ec.LoadCases, degrees: float) -> ec.LoadCases:
    """The load cases, and each again with one joint turned a little."""
    q = cases.q.copy()
    q[:, 3] += np.radians(degrees)
    return ec.LoadCases(np.concatenate([cases.q, q]), np.tile(cases.wrench, (2, 1)))


def test_a_chain_of_near_ones_is_one() -> None:
    q = np.zeros((5, 6))
    q[:, 2] = np.radians([0.0, 9.0, 18.0, 100.0, 361.0])
    assert near_configurations(ROBOT, q).tolist() == [0, 0, 0, 1, 0]


def test_another_load_is_another_load_case() -> None:
    wrench = np.zeros((4, 6))
    wrench[:, :3] = [[0, 0, -2500], [0, 0, 2500], [100, 0, -2490], [0, 0, -900]]
    cases = ec.LoadCases(np.zeros((4, 6)), wrench)
    telling = np.eye(4)[:, :, None] * np.eye(4)[:, None]
    assert near_load_cases(ROBOT, cases.q, wrench, telling).tolist() == [0, 1, 0, 3]
    telling[3] = (1.0 + 1e-5) * telling[1]  # what tells the same is the same
    assert near_load_cases(ROBOT, cases.q, wrench, telling).tolist() == [0, 1, 0, 1]


def test_the_wrist_turned_over_is_no_other_load_case() -> None:
    study = told(ALL, 12)
    assert study.nuisance is not None
    q = PLAN.q.copy()
    q[:, 3:] = q[:, 3:] * [1.0, -1.0, 1.0] + [np.pi, 0.0, np.pi]
    turned = ec.LoadCases(np.concatenate([PLAN.q, q]), np.tile(PLAN.wrench, (2, 1)))
    known = WithErrors(study, study.nuisance)
    found = known.sharing(turned, np.tile(REPEATS, 2)[None])
    np.testing.assert_allclose(found, np.tile(2 * REPEATS, 2)[None])


def test_splitting_a_load_case_promises_nothing_more() -> None:
    """Half of the readings a degree beside it, where friction and discrepancy are the same."""
    study = told(replace(ALL, gain=0.0, tilt=0.0, repeatability=0.0), 12)
    one = ec.assess(study, PLAN, 2 * REPEATS).promise
    split = ec.assess(study, beside(PLAN, 0.5), np.tile(REPEATS, 2)).promise
    apart = ec.assess(study, beside(PLAN, 25.0), np.tile(REPEATS, 2)).promise
    assert one is not None
    assert split is not None
    assert apart is not None
    assert abs(split.rho0 / one.rho0 - 1.0) < 0.02
    assert apart.rho0 < 0.9 * one.rho0  # negative control: those count


def test_what_is_new_with_every_reading_does_not_mind() -> None:
    study = told(CaseErrors(gain=0.01), 12)
    one = ec.assess(study, PLAN, 2 * REPEATS).promise
    split = ec.assess(study, beside(PLAN, 1e-4), np.tile(REPEATS, 2)).promise
    assert one is not None
    assert split is not None
    assert abs(split.rho0 / one.rho0 - 1.0) < 1e-4
