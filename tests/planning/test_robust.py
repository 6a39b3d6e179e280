"""Plans that can lose a configuration."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

import elastocal as ec
from elastocal.design.exact import ExactDesign
from elastocal.errors import Doubt, InputError
from elastocal.planning.aim import aim_of
from elastocal.planning.near import NEAR, near_configurations
from elastocal.planning.robust import least_loss, robust
from elastocal.study.study import Study, with_count
from elastocal.wording import worded
from tests.kr270 import kr270_study
from tests.planning.test_promise import PLAN, REPEATS

BEST = 2.784e-6  # m, the bound on ρ0


def asked(share: float | None, configurations: int | None = None) -> Study:
    study = with_count(kr270_study(), 12, configurations)
    return replace(study, experiments=replace(study.experiments, robust=share))


def lost(study: Study, cases: ec.LoadCases, repeats: np.ndarray) -> float:
    found = ec.assess(study, cases, repeats).loss
    assert found is not None
    return found.rho0


def test_losing_a_configuration_costs_little() -> None:
    """A tenth of a per cent of ρ0 for a loss that is half as large; the control is the plan that
    does not ask."""
    study = asked(1.25)
    made, plain = ec.plan(study), ec.plan(asked(None))
    assert lost(study, made.load_cases, made.repeats) <= 1.251 * BEST
    assert made.assessment.rho0 < 1.01 * plain.assessment.rho0
    assert lost(study, plain.load_cases, plain.repeats) > 1.8 * BEST
    assert not any(doubt.code == "loss-above" for doubt in made.doubts)
    assert made.repeats.sum() == 12
    assert not made.assessment.violations
    assert len(set(near_configurations(study.robot, made.load_cases.q))) == len(made.repeats)


def test_what_cannot_be_held_is_said() -> None:
    made = ec.plan(asked(1.05, 4))
    said = [worded(doubt) for doubt in made.doubts if doubt.code == "loss-above"]
    assert len(said) == 1
    assert "where no more than 1.05 times the best are asked for; with 4" in said[0]
    assert "configurations no plan leaves less than 1.15 times" in said[0]
    assert len(made.repeats) <= 4


def test_the_least_loss_of_few_configurations() -> None:
    """Three alike ones of a plane, each seeing one direction of three in turn: by hand."""
    assert least_loss(1) == np.inf
    assert least_loss(4) == pytest.approx(np.sqrt(4.0 / 3.0))
    turns = [np.radians(angle) for angle in (0.0, 60.0, 120.0)]
    rows = [np.array([np.cos(t), np.sin(t)]) for t in turns]
    whole = sum(np.outer(r, r) for r in rows)
    least = min(
        np.trace(np.linalg.inv(np.outer(a, a) + np.outer(b, b))) for a, b in combinations(rows, 2)
    )
    assert np.sqrt(least / np.trace(np.linalg.inv(whole))) >= least_loss(3)


def test_configurations_stay_apart() -> None:
    """One that is split in two would be lost as a whole."""
    study = asked(1.5, 6)
    aim = aim_of(study)
    before = ExactDesign(aim.space.points(PLAN), REPEATS, 0.0)
    after = robust(aim, aim.space, aim.goal(), before, 1.5 * BEST, np.random.default_rng(0))
    q = aim.space.load_cases(after.x).q
    between = np.abs(q[:, None] - q).max(axis=2) + np.diag(np.full(len(q), np.inf))
    assert between.min() > NEAR
    assert after.counts.sum() == 12


def test_another_criterion_is_refused_before_any_search() -> None:
    with pytest.raises(InputError, match="criterion must be test-pose, found 'D'"):
        ec.plan(replace(asked(1.25), criterion="D"))


def test_a_loss_that_leaves_nothing_is_said_without_a_number() -> None:
    numbers = {"times": np.inf, "asked": 1.25, "configurations": 2, "least": 2**0.5}
    said = worded(Doubt("loss-above", numbers=numbers))
    assert "does not tell the compliances apart" in said
    assert "∞" not in said
