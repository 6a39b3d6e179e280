"""What a plan cannot see, against campaigns that are drawn and fitted here, and published sizes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scipy.stats import chi2

import elastocal as ec
from elastocal.elastic.case_errors import CaseErrors, own_covariance, shared_covariance
from elastocal.elastic.effects import Size, effects_of, tilt_of
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.springs import VirtualJoints
from elastocal.files.study.study_file import read_study
from elastocal.fitting.power import seen_half
from elastocal.planning.blind import (
    BlindEffect,
    BlindErrors,
    blind_errors,
    least_seen,
    worst_together,
)
from elastocal.planning.blind_columns import columns_of
from elastocal.planning.with_errors import WithErrors
from elastocal.robot.sources import USUAL
from elastocal.study.study import Study
from elastocal.study.two_steps import with_nuisance
from tests.kr270 import FOLDER, kr270_study
from tests.planning.test_promise import ALL, PLAN, REPEATS, two_axes_a_joint

NOMINAL = np.array(USUAL["kuka-kr270"])


def found_for(study: Study) -> BlindErrors:
    found = blind_errors(study, PLAN, REPEATS)
    assert found is not None
    return found


def one(found: BlindErrors, kind: str, carrier: str = "", about: str = "") -> BlindEffect:
    """The effect about an axis of the base; alike in every direction if none is said."""
    for effect in found.effects:
        if effect.kind == kind and carrier in ("", *effect.carriers):
            along = "" if not len(effect.axis) else "xyz"[int(np.abs(effect.axis).argmax())]
            if along == about:
                return effect
    raise AssertionError(f"no {kind} of {carrier} about {about}")


class Drawn(NamedTuple):
    """A campaign written out reading by reading."""

    x: np.ndarray  # (R, f) rows over sigma
    task: np.ndarray  # (3, f)
    prior: np.ndarray  # (f, f)


def drawn(study: Study) -> Drawn:
    rows = study.fitted.columns(ec.regressor(study.fitted_arm, PLAN))
    x = np.repeat(rows, REPEATS, axis=0).reshape(-1, rows.shape[2]) / study.sigma
    return Drawn(x, np.asarray(study.test_poses[0].regressor), np.asarray(study.prior))


def columns(study: Study, springs: VirtualJoints) -> tuple[np.ndarray, np.ndarray]:
    """What the sum of springs moves: readings over sigma, and the tool at the test pose."""
    pose = study.test_poses[0]
    assert pose.tool is not None
    assert pose.case is not None
    arm = replace(study.arm, springs=springs)
    read = ec.regressor(arm, PLAN).sum(axis=2)
    there = ec.regressor(replace(arm, tool=pose.tool.at_tcp), pose.case).sum(axis=2)[0]
    return np.repeat(read, REPEATS, axis=0).ravel() / study.sigma, there


def bearing(study: Study, joint: int) -> VirtualJoints:
    """Springs in the bearing of a joint, about two axes across."""
    robot = study.robot
    frame = robot.links[joint]
    at, slides = np.tile(frame[:3, 3], (2, 1)), np.zeros(2, dtype=bool)
    return VirtualJoints(("x", "y"), np.full(2, joint), frame[:3, :2].T, at, slides)


def with_tilts(size: float) -> Study:
    """The demonstration with bearings of the wrist in the fit."""
    study = kr270_study()
    sizes = {tilt_of(name): Size(size, "") for name in ("A4", "A5", "A6")}
    effects = effects_of(study.robot, sizes)
    u = len(effects.unknowns)
    nuisance = Nuisance(
        effects.unknowns, np.zeros(u), effects.deviation, effects.signed, effects.source, NOMINAL
    )
    return with_nuisance(study, nuisance)


def test_published_sizes() -> None:
    """An independent script has these of the plan of the demonstration."""
    found = found_for(kr270_study())
    assert found.dof == 4
    assert found.seen_half == pytest.approx(6.42, abs=5e-3)
    assert found.seen_half * found.if_estimated**2 == pytest.approx(7.62, abs=5e-3)
    upright = one(found, "bearing", "A2", "z")
    assert upright.invisible
    assert upright.error == pytest.approx(62.7e-6, rel=1e-3)
    np.testing.assert_allclose(np.abs(upright.axis), [0.0, 0.0, 1.0], atol=1e-6)
    assert found.effects[0].invisible
    springs = [e for e in found.visible if e.kind in ("foot", "bearing") and e.half < e.largest]
    assert 17e-6 < max(e.error for e in springs) < 19e-6


def test_what_nothing_tells_apart_may_be_as_large_as_either() -> None:
    """The foot and the bearing of A1: the softer of the two is believed."""
    study = read_study(FOLDER / "study_aslant.yaml")
    cases = study.space.load_cases(study.space.sample(12, np.random.default_rng(0)))
    once = np.ones(12, dtype=np.int64)
    told, found = columns_of(study, cases, once), blind_errors(study, cases, once)
    assert told is not None
    assert found is not None
    largest = {f.kind: f.largest for f in told.families if f.carrier in ("", "A1")}
    assert largest["foot"] < largest["bearing"]
    (foot, *_) = (effect for effect in found.effects if effect.kind == "foot")
    assert foot.carriers == ("A1",)
    assert foot.largest == largest["bearing"]


@pytest.mark.parametrize("size", [0.0, 3e-8])
def test_power_and_error_left_of_drawn_campaigns(size: float) -> None:
    """Fits of drawn readings: the test of the means sees half, and the task is off by as much."""
    study = with_tilts(size) if size else kr270_study()
    found = found_for(study)
    effect = one(found, "bearing", "A3")
    b, b0 = columns(study, bearing(study, 2))
    campaign, rng, n = drawn(study), np.random.default_rng(3), 4000
    spread = np.zeros((len(campaign.prior), 0))
    if size:
        spread = np.vstack([np.zeros((5, 3)), np.eye(3) * size])
    true = NOMINAL[1:6].tolist() + [0.0] * spread.shape[1]
    unknowns = np.array(true) + rng.normal(size=(n, spread.shape[1])) @ spread.T
    y = unknowns @ campaign.x.T + effect.half * b + rng.normal(size=(n, len(b)))
    m = np.concatenate([np.eye(3) * np.sqrt(r) for r in REPEATS])
    assert m.shape == (9, 3)
    groups = np.repeat(np.arange(3), REPEATS)
    means = np.stack([y.reshape(n, 12, 3)[:, groups == g].mean(axis=1) for g in range(3)], axis=1)
    rows = np.stack([campaign.x.reshape(12, 3, -1)[groups == g].mean(axis=0) for g in range(3)])
    root = np.sqrt(REPEATS)[:, None, None]
    x, z = (rows * root).reshape(9, -1), (means * root[:, :, 0]).reshape(n, 9)
    scale = 1e-7
    total = (campaign.prior + x.T @ x) * scale**2
    estimate = scale * np.linalg.solve(total, scale * x.T @ z.T).T
    rest = z - estimate @ x.T
    square = (rest**2).sum(axis=1) + np.einsum("ni,ij,nj->n", estimate, campaign.prior, estimate)
    seen = (square > chi2.ppf(0.95, found.dof)).mean()
    assert seen == pytest.approx(0.5, abs=0.03)
    off = (estimate - unknowns) @ campaign.task.T - effect.half * b0
    assert np.linalg.norm(off.mean(axis=0)) == pytest.approx(effect.error, rel=0.03)


def test_power_where_repeats_share_errors() -> None:
    """Errors of absolute size, drawn for load cases and for readings: the test sees half, too."""
    study = with_nuisance(kr270_study(), two_axes_a_joint(ALL))
    assert study.nuisance is not None
    effect = one(found_for(study), "bearing", "A2")
    b, b0 = columns(study, bearing(study, 1))
    told, n, rng = WithErrors(study, study.nuisance), 4000, np.random.default_rng(5)
    arm = replace(study.fitted_arm, springs=told.bending)
    shared = shared_covariance(ALL, arm, told.usual, PLAN)
    own = own_covariance(ALL, arm, told.usual, PLAN) + study.sigma**2 * np.eye(3)
    noise = np.zeros((36, 36))
    for i, start in enumerate(np.cumsum(REPEATS) - REPEATS):
        size = REPEATS[i]
        block = slice(3 * start, 3 * (start + size))
        noise[block, block] = np.kron(np.ones((size, size)), shared[i])
        noise[block, block] += np.kron(np.eye(size), own[i])
    rows = study.fitted.columns(ec.regressor(study.fitted_arm, PLAN))
    x = np.repeat(rows, REPEATS, axis=0).reshape(36, -1)
    prior = np.asarray(study.prior)
    draw = np.linalg.cholesky(noise)
    spread = np.zeros((len(prior), 12))
    spread[5:] = np.diag(study.nuisance.deviation)
    unknowns = np.concatenate([NOMINAL[1:], np.zeros(12)]) + rng.normal(size=(n, 12)) @ spread.T
    y = unknowns @ x.T + effect.half * b * study.sigma + rng.normal(size=(n, 36)) @ draw.T
    weighed = np.linalg.solve(noise, x)
    estimate = 1e-7 * np.linalg.solve((prior + x.T @ weighed) * 1e-14, 1e-7 * weighed.T @ y.T).T
    groups = np.repeat(np.arange(3), REPEATS)
    mean = np.kron((groups == np.arange(3)[:, None]) / REPEATS[:, None], np.eye(3))
    rest = (y - estimate @ x.T) @ mean.T
    inverse = np.linalg.inv(mean @ noise @ mean.T)
    square = np.einsum("ni,ij,nj->n", rest, inverse, rest)
    square += np.einsum("ni,ij,nj->n", estimate, prior, estimate)
    assert (square > chi2.ppf(0.95, 4)).mean() == pytest.approx(0.5, abs=0.03)
    task = np.asarray(study.test_poses[0].regressor)
    off = ((estimate - unknowns) @ task.T).mean(axis=0) - effect.half * b0
    assert np.linalg.norm(off) == pytest.approx(effect.leak * effect.half, rel=0.05)


def test_an_effect_that_is_in_the_fit_leaves_what_its_prior_does() -> None:
    """Leak and visibility without it, over 1 + T² λ."""
    prior = 2e-8
    study = with_tilts(prior)
    assert study.nuisance is not None
    nuisance = study.nuisance
    inside = one(found_for(study), "bearing", "A4")
    sizes = {tilt_of(name): Size(prior, "") for name in ("A5", "A6")}
    effects = effects_of(study.robot, sizes)
    others = replace(
        nuisance,
        unknowns=effects.unknowns,
        mean=np.zeros(2),
        deviation=effects.deviation,
        signed=effects.signed,
        source=effects.source,
    )
    outside = one(found_for(with_nuisance(kr270_study(), others)), "bearing", "A4")
    shrunk = 1.0 + prior**2 * outside.visibility
    assert shrunk > 1.3
    assert inside.leak == pytest.approx(outside.leak / shrunk, rel=1e-6)
    assert inside.visibility == pytest.approx(outside.visibility / shrunk, rel=1e-6)


def test_the_axis_that_is_seen_least() -> None:
    rng = np.random.default_rng(0)
    angle = np.linspace(0.0, np.pi, 100_001)
    x = np.array([np.cos(angle) ** 2, np.sin(angle) ** 2, np.cos(angle) * np.sin(angle)])
    for _ in range(20):
        root = rng.normal(size=(3, 3))
        seen = root @ root.T
        least = least_seen(seen)
        own = np.array([np.cos(least) ** 2, np.sin(least) ** 2, np.cos(least) * np.sin(least)])
        value = np.einsum("in,ij,jn->n", x, seen, x)
        assert own @ seen @ own == pytest.approx(value.min(), rel=1e-6)
    assert least_seen(np.zeros((3, 3))) == 0.0


def test_the_axes_that_span_a_plane_do_not_matter() -> None:
    """Columns of turned axes are combinations of those before, and the axis stays where it is."""
    rng = np.random.default_rng(1)
    for turn in rng.uniform(0.0, np.pi, 10).tolist():
        c, s = np.cos(turn), np.sin(turn)
        b = rng.normal(size=(5, 3))
        turned = [
            [c * c, s * s, c * s],
            [s * s, c * c, -c * s],
            [-2 * c * s, 2 * c * s, c * c - s * s],
        ]
        moved = b @ np.array(turned).T
        apart = least_seen(b.T @ b) - least_seen(moved.T @ moved) - turn
        assert np.sin(apart) == pytest.approx(0.0, abs=1e-6)


def test_the_worst_combination_as_published() -> None:
    """Foot and bearings of A2 to A6 about two axes each, 10 nrad/(N·m): a script has 43.9 µm."""
    told = columns_of(kr270_study(), PLAN, REPEATS)
    assert told is not None
    own, first = [], 0
    for family in told.families:
        if family.kind == "foot" or (family.kind == "bearing" and family.carrier != "A1"):
            own += [first, first + 1]
        first += family.columns
    left, seen = 1e-8 * told.left[:, own], 1e-16 * told.seen[np.ix_(own, own)]
    found = worst_together(left, seen, seen_half(4))
    assert found == pytest.approx(43.9e-6, rel=2e-3)
    rng = np.random.default_rng(0)
    x = rng.normal(size=(12, 20_000))
    x *= np.sqrt(chi2.ppf(0.95, 12)) / np.linalg.norm(x, axis=0)
    x *= np.minimum(1.0, np.sqrt(seen_half(4) / np.einsum("in,ij,jn->n", x, seen, x)))
    assert np.linalg.norm(left @ x, axis=0).max() < found


def test_all_effects_together_leave_more_than_each(tmp_path: Path) -> None:
    """With usual sizes known; a combination is bounded, and no single one of usual size is more."""
    text = (FOLDER / "study.yaml").read_text("utf-8")
    path = tmp_path / "study.yaml"
    path.write_text(text.replace("\nconstraints:", "\nnuisance: typical\nconstraints:"), "utf-8")
    found = found_for(read_study(path))
    assert np.isnan(found_for(kr270_study()).together)
    single = [
        e.leak * min(e.half, e.usual)
        for e in found.effects
        if e.kind in ("foot", "link", "tool-sliding")
    ]
    assert max(single) < found.together < 10.0 * sum(single)


def test_loads_wrong_alike_are_invisible_where_the_process_force_is_exact() -> None:
    study = with_tilts(1e-8)
    assert study.nuisance is not None
    exact = replace(study.nuisance, errors=CaseErrors(process_force="exact"))
    effect = one(found_for(with_nuisance(kr270_study(), exact)), "load-gain")
    task = np.asarray(kr270_study().test_poses[0].regressor) @ NOMINAL[1:]
    assert effect.invisible
    assert effect.leak == pytest.approx(np.linalg.norm(task), rel=0.1)


def test_plans_that_tell_nothing_say_nothing() -> None:
    study = kr270_study()
    one_case = ec.LoadCases(PLAN.q[:1], PLAN.wrench[:1])
    assert blind_errors(study, one_case, np.array([1])) is None
    pose = replace(study.test_poses[0], tool=None, case=None)
    assert blind_errors(replace(study, test_poses=(pose,)), PLAN, REPEATS) is None
