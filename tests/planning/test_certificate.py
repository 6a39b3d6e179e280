"""Bounds of studies: floored where the optimum is singular, computed anew where refuted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastocal.design.continuous import ContinuousDesign
from elastocal.design.dual_bound import DualBound
from elastocal.design.space import information
from elastocal.files.study.study_file import parse_study
from elastocal.planning import certificate as certificate_file
from elastocal.planning.assessment import assess
from elastocal.planning.certificate import Bound, certificate, confirmed, left_out, lower_bound
from elastocal.planning.trade_off import random_plans
from elastocal.study.criteria import criterion_of
from elastocal.study.study import Study, TestPose
from elastocal.terminal.certificates import certificate_sentences
from elastocal.wording.plans import floor_sentence
from tests.paper.problems import three_link_study


def judged_by(study: Study, joint: int) -> Study:
    """Only one compliance matters, three times."""
    square = np.zeros((3, 3))
    square[joint, joint] = 3.0
    return replace(study, test_poses=(TestPose("one alone", square),))


@pytest.fixture(scope="module")
def sound() -> tuple[Study, Bound]:
    study = three_link_study(5)
    return study, lower_bound(study, np.random.default_rng(0))


def test_a_singular_optimum_gets_a_floor() -> None:
    """J2 is told from J3 best where nothing is told of J1. The bound holds for all plans."""
    study = judged_by(three_link_study(5), 1)
    shares: list[float] = []
    found = lower_bound(
        study, np.random.default_rng(0), progress=lambda what, share: shares.append(share)
    )
    assert found.floored
    assert found.target is not found.aim.criterion
    assert found.design is not None
    reached = 1.0 / np.sqrt(5.0 * found.aim.criterion.value(found.design.total[None])[0])
    assert 0.995 * reached < found.loss(5) < reached
    assert found.loss(5) < random_plans(study, 2000).min()
    assert min(shares) >= 0.0
    assert max(shares) <= 0.4
    assert shares == sorted(shares)


def test_a_singular_optimum_of_very_many_poses_gets_a_floor() -> None:
    """Forty poses that ask for J2 alone, each a little less: the first decides, and all are one."""
    study = judged_by(three_link_study(5), 1)
    (pose,) = study.test_poses
    many = tuple(
        replace(pose, name=str(i), regressor=pose.regressor * (1.0 - 0.01 * i)) for i in range(40)
    )
    worst = replace(study, test_poses=many, criterion="worst")
    rng = np.random.default_rng
    found, alone = lower_bound(worst, rng(0)), lower_bound(study, rng(0))
    assert found.floored
    assert found.loss(5) == pytest.approx(alone.loss(5), rel=5e-3)
    least = replace(study, test_poses=many[-1:])
    assert lower_bound(least, rng(0)).loss(5) < 0.7 * found.loss(5)  # the control


@pytest.mark.parametrize("known", [0.0, 20.0])
def test_a_bound_by_hand(known: float) -> None:
    """A force of 1 across the stretched arm moves its tip by 2.35² times J1, with σ of 1.

    What is known before is known for all five experiments together. If nothing is, a floor keeps
    plans from seeing J1 alone, which is best.
    """
    study = replace(judged_by(three_link_study(5), 0), prior=known * np.eye(3))
    found = lower_bound(study, np.random.default_rng(0))
    best = 3.0 / np.sqrt(known + 5.0 * 2.35**4)
    assert found.loss(5) == pytest.approx(best, rel=1e-4)
    assert found.loss(5) <= best * (1.0 + 1e-6)
    assert found.floored is (known == 0.0)


def test_a_bound_that_climbs_refute_is_computed_anew(sound: tuple[Study, Bound]) -> None:
    """Two thirds of the largest sensitivity: any plan refutes it, the new bound is the old one."""
    study, bound = sound
    assert bound.design is not None
    dual = bound.design.certificate
    false = replace(dual, largest=dual.largest / 1.5)
    low = replace(bound, design=replace(bound.design, certificate=false))
    x = study.space.sample(6, np.random.default_rng(1))
    mended = confirmed(study, low, x, np.random.default_rng(2))
    assert low.loss(5) > 1.2 * bound.loss(5)
    assert mended.loss(5) == pytest.approx(bound.loss(5), rel=2e-5)
    assert confirmed(study, bound, x, np.random.default_rng(2)) is bound


def test_no_plan_is_better_than_its_bound(
    sound: tuple[Study, Bound], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bound too low by less than a search can tell, or again and again, is raised."""
    study, bound = sound
    assert bound.design is not None
    dual = bound.design.certificate
    count = 1000
    repeats = np.maximum(np.round(count * bound.design.weights), 1).astype(int)
    worth = assess(study, study.space.load_cases(bound.design.x), repeats)
    for share in (1e-6, 0.1):
        low = replace(dual, largest=dual.largest * (1.0 - share))
        false = replace(bound, design=replace(bound.design, certificate=low))
        monkeypatch.setattr(certificate_file, "lower_bound", lambda *_, bound=false, **__: bound)
        raised = confirmed(study, false, bound.design.x, np.random.default_rng(2))
        assert raised.design is not None
        assert raised.design.certificate.largest == pytest.approx(dual.largest, rel=1e-5)
        found = certificate(study, raised, worth, int(repeats.sum()))
        assert 0.99 < found.efficiency <= 1.0
        assert found.lower_bound <= worth.rho0 * (1.0 + 1e-12)


def test_a_certificate_says_what_the_bound_rests_on(sound: tuple[Study, Bound]) -> None:
    study, bound = sound
    assert bound.design is not None
    cases = study.space.load_cases(bound.design.x)
    worth = assess(study, cases, np.ones(len(bound.design.x), dtype=int))
    count = len(bound.design.x)
    found = certificate(study, bound, worth, count)
    assert found.support is not None
    assert found.weights is not None
    assert found.peak is not None
    assert found.weights.sum() == pytest.approx(1.0, abs=1e-2)
    assert (np.diff(found.weights) <= 0.0).all()
    assert len(found.support) == len(found.weights) <= count
    assert found.peak_ratio == pytest.approx(1.0, abs=1e-5)
    assert found.efficiency == pytest.approx((bound.loss(count) / worth.rho0) ** 2, rel=1e-6)
    optimum = assess(study, found.support, 1000.0 * found.weights)  # type: ignore[arg-type]
    assert optimum.rho0 == pytest.approx(bound.loss(1000), rel=1e-2)
    assert found.fresh_starts >= 600
    assert found.attained >= 12


def asking_for(*row: float) -> Study:
    """A test pose that asks for one combination of the three compliances."""
    square = np.zeros((3, 3))
    square[0] = row
    return replace(three_link_study(5), test_poses=(TestPose("one", square),))


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ((0.0, 3.0, 0.0), "The criterion does not ask for J1; the criterion does not ask for J3."),
        (
            (0.0, 3.0, 4.0),
            "The criterion does not ask for J1; J2 and J3 are determined only together: "
            "0.6 J2 + 0.8 J3.",
        ),
        (
            (4.0, -3.0, 0.0),
            "The criterion does not ask for J3; J1 and J2 are determined only together: "
            "0.8 J1 - 0.6 J2.",
        ),
    ],
)
def test_what_a_singular_optimum_leaves_out_is_named(row: tuple[float, ...], words: str) -> None:
    study = asking_for(*row)
    blocks = information(
        study.space.evaluate(study.space.sample(50, np.random.default_rng(1))).blocks
    )
    total, weights = blocks.mean(axis=0), np.full(50, 0.02)
    gradient = criterion_of(study).gradient(total[None])[0]
    x = study.space.sample(50, np.random.default_rng(1))
    dual = DualBound(gradient, 0.0, 1.0, x[0], 600, 12, 0, 0, 12, x, np.ones(50))
    found = left_out(study, ContinuousDesign(x, weights, blocks, total, dual, 0.0))
    assert floor_sentence(found) == f"{words} A small floor keeps all of them identifiable."


def test_a_stretched_arm_is_told_what_it_leaves_out() -> None:
    """A vertical force on an arm stretched out: J2 and J3 lower the tip together, 0.98 to 0.21."""
    study = parse_study(STRETCHED, Path("study.yaml"))
    bound = lower_bound(study, np.random.default_rng(0))
    assert bound.floored
    cases = study.space.load_cases(study.space.sample(3, np.random.default_rng(0)))
    worth = assess(study, cases, np.ones(3, dtype=int))
    found = certificate(study, bound, worth, 3)
    assert [doubt.code for doubt in found.left_out] == ["criterion-ignores", "criterion-together"]
    assert found.left_out[1].about == ("J2", "J3")
    (said,) = certificate_sentences(found, 3)
    assert "J2 and J3 are determined only together: 0.98 J2 + 0.21 J3." in said
    assert not certificate(study, replace(bound, target=bound.aim.criterion), worth, 3).left_out


STRETCHED = """\
elastocal: 1
robot: three-link
test_poses:
  - {tool: tip, q_deg: [0, 0, 0], force_N: [0, 0, -960]}
experiments: {tool: tip, max_force_N: 1000, direction: free, count: 3}
instrument: {sigma_mm: 0.1}
"""
