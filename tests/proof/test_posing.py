"""Statements of studies: the same function as the rest of the program has, and never a larger
bound than what a plan reaches."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.constraints import (
    AcceptanceCone,
    BeamRange,
    Constraint,
    Elevation,
    HalfSpace,
    MinRadius,
    Tilt,
)
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, InPlane, ThereOrNot
from elastocal.elastic.case_errors import CaseErrors
from elastocal.errors import InputError
from elastocal.files.study.study_file import parse_study, read_study
from elastocal.measuring.common_errors import CommonErrors
from elastocal.measuring.instrument import PoseProbe
from elastocal.planning.promise import promise
from elastocal.proof.posing import ToProve, posed
from elastocal.proof.reference import margins, sensitivity
from elastocal.proof.statement import AnyDirection, InCone, SteadyLoad
from elastocal.robot.posture import Posture, forward_kinematics
from elastocal.study.criteria import losses
from elastocal.study.study import Study, with_count
from elastocal.wording import worded
from tests.proof.bounds import bound_by_chance
from tests.robot.sources.test_mimic_on_chain import arm
from tests.test_examples import ROOT

ROBOTS = ("kr270", "cobot-ur10e", "rail-arm", "scara-700", "gantry-5", "arm-7r")
UP = FixedVector(np.array([0.0, 0.0, 300.0]))


@cache
def example(name: str) -> Study:
    return read_study(ROOT / "examples" / f"{name}.yaml")


def robot(name: str) -> Study:
    return example(f"robots/{name}/study")


def loaded(study: Study, **loads: object) -> Study:
    return replace(study, experiments=replace(study.experiments, **loads))  # type: ignore[arg-type]


def probed(study: Study) -> Study:
    return replace(study, instrument=PoseProbe(study.instrument, 2e-4))


STUDIES = {
    **{name: lambda name=name: robot(name) for name in ROBOTS},
    "three-link": lambda: example("three-link/study"),
    "rotation": lambda: probed(robot("cobot-ur10e")),
    "moment": lambda: loaded(robot("rail-arm"), moment=UP),
    "moment alone": lambda: loaded(
        probed(robot("kr270")), moment=UP, force=FixedVector(np.zeros(3))
    ),
    "free": lambda: loaded(robot("kr270"), force=FreeDirection(900.0, np.array([1.0, 0, 0]))),
    "cone": lambda: loaded(robot("kr270"), force=FreeDirection(900.0, np.array([1.0, 1, 0]), 0.8)),
    "plane": lambda: loaded(robot("cobot-ur10e"), force=InPlane(80.0, np.array([1.0, 2, 0]))),
    "nuisance": lambda: parse_study(NUISANCE, ROOT / "examples" / "robots" / "rail-arm" / "s.yaml"),
}  # fmt: skip
NUISANCE = (ROOT / "examples/robots/rail-arm/study.yaml").read_text("utf-8") + (
    "nuisance:\n  compliance_urad_per_Nm: {J1: .6, J2: .3, J3: .4, J4: 3, J5: 3, J6: 2}\n"
    "  tilt_nrad_per_Nm: {J3: 250, J4: 100}\n  foot_turning_nrad_per_Nm: 50\n"
)


def posed_of(study: Study, seed: int = 0) -> ToProve:
    return posed(study, bound_by_chance(study, seed))


@pytest.mark.parametrize("name", STUDIES)
def test_the_function_is_that_of_the_study(name: str) -> None:
    """tr(Vᵀ A_xᵀ Σ⁻¹ A_x V) of the space of load cases at 1000 points, constraints too."""
    study = STUDIES[name]()
    made = posed_of(study).statement
    space, rng = study.space, np.random.default_rng(1)
    x = rng.uniform(space.lower, space.upper, (1000, len(space.lower)))
    seen = ((space.evaluate(x).blocks @ made.V) ** 2).sum(axis=(1, 2))
    cases = space.load_cases(x)
    force = None if isinstance(made.load, SteadyLoad) else cases.wrench[:, :3]
    np.testing.assert_allclose(sensitivity(made, cases.q, force), seen, rtol=1e-10)
    allowed = np.ones(len(x), dtype=bool)
    posture = Posture(study.robot, cases.q)
    for constraint in study.constraints:
        if constraint.name not in made.left_out:
            allowed &= constraint.at(posture)[0] >= 0.0
    np.testing.assert_array_equal((margins(made, cases.q) >= 0.0).all(axis=1), allowed)
    assert made.root.tolist() == study.limits.tolist()


def test_constraints_of_every_kind() -> None:
    """Feasible where the constraint of the study is; what cannot be used is named."""
    study, rng = robot("kr270"), np.random.default_rng(2)
    point, place = rng.normal(size=3), np.array([0.5, 0.3, 1.0])
    axis = np.array([0.0, 0.6, 0.8])
    kinds: list[Constraint] = [
        HalfSpace("half-space", point, axis, 0.7),
        MinRadius("radius", point, 1.9),
        Elevation("elevation", axis, 0.6),
        Tilt("tilt", axis, [1.0, 0.0, 0.2], 1.2),
        BeamRange("far", "M", point, place, 2.0, upper=False),
        BeamRange("near", "M", point, place, 2.4, upper=True),
        Elevation("any elevation", axis, 1.6),
        Tilt("any tilt", axis, axis, 3.2),
        BeamRange("any range", "M", point, place, 0.0, upper=False),
        AcceptanceCone("cone", "M", point, place, axis, 0.5),
    ]
    q = rng.uniform(*study.limits, (2000, 6))
    posture = Posture(study.robot, q)
    for kind in kinds:
        other = replace(study, constraints=(kind,))
        made = posed_of(other)
        values = margins(made.statement, q)
        feasible = kind.at(posture)[0] >= 0.0
        if kind.name == "cone":
            assert made.statement.left_out == ("cone",)
            assert "does not use: cone" in worded(made.doubts[0])
        elif kind.name.startswith("any"):
            assert values.shape == (2000, 0)
            assert feasible.all()
        else:
            np.testing.assert_array_equal((values >= 0.0).all(axis=1), feasible)
            assert 0.02 < feasible.mean() < 0.98
            assert not made.doubts


def chance_plans(study: Study, count: int) -> list[tuple[Array, Array]]:
    """(design points, repeats) of feasible plans by chance."""
    rng, m = np.random.default_rng(3), study.experiments.count
    x = study.space.sample(5 * count, rng).reshape(count, 5, -1)
    return [(one, rng.multinomial(m - 5, np.full(5, 0.2)) + 1) for one in x]


def bound_at(made: ToProve, q: Array, force: Array) -> float:
    """What the statement says of plans of these load cases alone: U is the largest d of them."""
    s = made.statement
    free = not isinstance(s.load, SteadyLoad)
    largest = sensitivity(s, q, force if free else None).max()
    square = np.trace(s.V.T @ s.K) ** 2 / (np.trace(s.V.T @ s.B @ s.V) + s.count * largest)
    return float(np.sqrt(square + made.beyond))


@pytest.mark.parametrize("criterion", ["test-pose", "worst", "coordinate", "G", "A", "E"])
def test_no_plan_is_below_what_follows_of_its_own_load_cases(criterion: str) -> None:
    study = replace(robot("cobot-ur10e"), criterion=criterion)
    made = posed_of(study)
    ratios = []
    for x, repeats in chance_plans(study, 20):
        cases = study.space.load_cases(x)
        each = study.space.information(cases)
        total = np.einsum("i,ijk->jk", repeats.astype(float), each)
        ratios.append(
            bound_at(made, cases.q, cases.wrench[:, :3]) / losses(study, total)[criterion]
        )
    assert 0.05 < max(ratios) <= 1.0


def test_a_design_reaches_its_bound_but_for_rounding() -> None:
    """With U the mean of d over the design: tr(KᵀM⁻¹K) itself, prior and test paths included."""
    study = parse_study(NUISANCE, ROOT / "examples" / "robots" / "rail-arm" / "s.yaml")
    for known in (study, example("kr270/study_path")):
        bound = bound_by_chance(known)
        assert bound.design is not None
        s = posed(known, bound).statement
        x = bound.design.x
        mean = sensitivity(s, x[:, : len(s.joints)]).mean()
        reached = np.trace(s.V.T @ s.K) ** 2 / (np.trace(s.V.T @ s.B @ s.V) + s.count * mean)
        value = 1.0 / float(bound.aim.criterion.value(bound.design.total[None] * s.count)[0])
        assert reached == pytest.approx(value, rel=2e-5)
        assert reached <= value * (1.0 + 1e-12)


ERRORS = CaseErrors(
    friction=0.1,
    discrepancy=0.02,
    discrepancy_length=5e-6,
    gain=0.01,
    tilt=0.01,
    repeatability=8e-6,
    common_gain=0.01,
    common_tilt=0.01,
    process_force="other",
)


def test_errors_of_load_cases_only_take_information_away() -> None:
    known = STUDIES["nuisance"]()
    assert known.nuisance is not None
    study = replace(known, nuisance=replace(known.nuisance, errors=ERRORS))
    made = posed_of(study)
    s = made.statement
    assert made.beyond > 0.0
    assert s.left_out[-1] == "errors of load cases"
    assert "errors of load cases" in worded(made.doubts[-1])
    assert s.unknowns[-4:] == ("load gain", *(f"turn of all loads {i}" for i in (1, 2, 3)))
    assert not s.V[-3:].any()
    assert not s.make[:, -3:].any()
    assert s.sigma == pytest.approx(np.hypot(study.sigma, 5e-6))  # two markers come back together
    for x, repeats in chance_plans(study, 6):
        cases = study.space.load_cases(x)
        promised = promise(study, cases, repeats)
        assert promised is not None
        assert bound_at(made, cases.q, cases.wrench[:, :3]) < promised.rho0


def test_a_tracker_at_its_best() -> None:
    study = example("kr270/tracker")
    made = posed_of(study)
    s = made.statement
    by_code = {doubt.code: doubt for doubt in made.doubts}
    # 1 m away, the least range allowed, it is best along the beam: 5.15 µm a reading.
    assert s.sigma == pytest.approx(np.sqrt(2.0) * 5.15e-6)
    assert by_code["proof-best-noise"].numbers["sigma"] == s.sigma
    assert any("acceptance" in name or "cone" in name for name in s.left_out), s.left_out
    x = study.space.sample(50, np.random.default_rng(0))
    seen = ((study.space.evaluate(x).blocks @ s.V) ** 2).sum(axis=(1, 2))
    assert (seen < sensitivity(s, x)).all()
    # Far away a marker cannot be near, and the reach is never less than it is.
    far = replace(
        study.instrument.single,  # type: ignore[arg-type]
        position=np.array([9.0, 1.0, 0.5]),
    )
    away = replace(study, instrument=far, constraints=())
    best = posed_of(away).statement.sigma
    q = np.random.default_rng(1).uniform(*away.limits, (4000, 6))
    tips = forward_kinematics(away.robot, q) @ np.append(away.experiments.tool.markers[0], 1.0)
    nearest = np.linalg.norm(tips[:, :3] - far.position, axis=1).min()
    assert s.sigma < best < np.sqrt(2.0) * far.deviations(np.array(nearest))[0] * (1.0 + 1e-12)


def test_a_design_of_its_own_where_noise_is_left_out() -> None:
    """It bounds closer what the statement keeps, and is still below every plan."""
    study = example("kr270/tracker")
    bound = bound_by_chance(study)
    first, second = posed(study, bound), posed(study, bound, np.random.default_rng(0))
    x = study.space.sample(400, np.random.default_rng(1))
    cases = study.space.load_cases(x)
    closer = [bound_at(one, cases.q, cases.wrench[:, :3]) for one in (first, second)]
    assert closer[1] > 1.2 * closer[0]
    for plan, repeats in chance_plans(study, 3):
        cases = study.space.load_cases(plan)
        each = study.space.information(cases)
        total = np.einsum("i,ijk->jk", repeats.astype(float), each)
        assert bound_at(second, cases.q, cases.wrench[:, :3]) < losses(study, total)["test-pose"]


def test_noise_that_readings_share_is_left_out() -> None:
    study = robot("cobot-ur10e")
    shared = replace(study, instrument=CommonErrors(probed(study).instrument, 1e-5, 1e-4))
    made = posed_of(shared)
    assert made.statement.sigma == study.sigma
    assert made.statement.sigma_turn == 2e-4
    x = study.space.sample(50, np.random.default_rng(0))
    seen = ((shared.space.evaluate(x).blocks @ made.statement.V) ** 2).sum(axis=(1, 2))
    assert (seen < sensitivity(made.statement, x)).all()
    assert "share" in worded(made.doubts[0])


def test_loads() -> None:
    kinds = {
        "free": AnyDirection, "cone": InCone, "plane": AnyDirection, "moment": SteadyLoad,
    }  # fmt: skip
    for name, kind in kinds.items():
        assert isinstance(posed_of(STUDIES[name]()).statement.load, kind)
    wide = loaded(robot("kr270"), force=FreeDirection(9.0, np.array([1.0, 1, 0]), 1.7))
    assert isinstance(posed_of(wide).statement.load, AnyDirection)


def refused(study: Study) -> str:
    bound = bound_by_chance(robot("kr270"))
    bound = replace(bound, aim=replace(bound.aim, space=study.space))
    with pytest.raises(InputError) as found:
        posed(study, bound)
    return str(found.value)


def test_what_is_refused() -> None:
    study = robot("kr270")
    weight = ThereOrNot(np.array([0.0, 0, -900.0]))
    turning = FreeDirection(50.0, np.array([0.0, 0, 1]))
    assert "there or not" in refused(loaded(study, force=weight))
    assert "torques" in refused(loaded(study, moment=turning))
    assert "torques" in refused(loaded(STUDIES["free"](), moment=UP))
    assert "taken off" in refused(loaded(study, weighs=True))
    assert "plans for D" in refused(replace(study, criterion="D"))
    bound = bound_by_chance(study)
    following = replace(bound.aim, space=replace(study.space, arm=arm()))
    with pytest.raises(InputError, match="joints that follow others"):
        posed(study, replace(bound, aim=following))
    none = replace(bound, design=None)
    with pytest.raises(InputError, match="no bound to be proved"):
        posed(study, none)


def test_the_same_V_serves_other_counts_where_nothing_is_known() -> None:
    study = robot("kr270")
    first, second = (posed_of(with_count(study, m)).statement for m in (3, 12))
    np.testing.assert_allclose(first.V, second.V)
    assert (first.count, second.count) == (3, 12)
