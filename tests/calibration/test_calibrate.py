"""Calibrations of virtual arms: what is told comes out, what is not is said, nothing in between."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.calibration.arm_model import ArmModel, State
from elastocal.calibration.calibrate import Calibration, calibrate
from elastocal.calibration.calibrated_robot import put_away
from elastocal.calibration.doubts import doubts
from elastocal.calibration.nested import ladder
from elastocal.calibration.parameters import parameters_of
from elastocal.calibration.prediction import predicted
from elastocal.calibration.validate import check, check_set_up, rms_of
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import joint_springs, subset
from elastocal.elastic.unknowns import each_spring
from elastocal.errors import InputError
from elastocal.files.models.calibration_file import read_calibration
from elastocal.files.models.calibration_writing import write_calibration
from elastocal.fitting.goodness import quantile
from elastocal.fitting.robust import Huber
from elastocal.measuring.positions import Positions, chosen_poses
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.compensators import Compensator
from elastocal.robot.geometry import geometric_errors
from elastocal.robot.payloads import Payload
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.robot.sources.dh import DHRow, from_dh

NOISE = 2e-5
QUARTER = np.pi / 2


def arm() -> Robot:
    """A six-axis arm with two parallel axes and masses."""
    table = [
        ("A1", 0.4, 0.2, QUARTER, 60.0),
        ("A2", 0.0, 0.8, 0.0, 40.0),
        ("A3", 0.0, 0.1, QUARTER, 30.0),
        ("A4", 0.9, 0.0, -QUARTER, 10.0),
        ("A5", 0.0, 0.0, QUARTER, 5.0),
        ("A6", 0.2, 0.0, 0.0, 1.0),
    ]
    rows = [
        DHRow(name, 0.0, d, a, alpha, mass=mass, center=(-a / 2, 0.0, -d / 2))
        for name, d, a, alpha, mass in table
    ]
    return from_dh("arm", rows, modified=False)


def model_of(groups: tuple[str, ...], springs: tuple[str, ...], markers: int = 2) -> ArmModel:
    robot = arm()
    tool = Tool(
        "balls",
        np.zeros(3),
        np.array([[0.1, 0.0, 0.1], [-0.05, 0.12, 0.1], [0.0, -0.1, 0.15]])[:markers],
        ("T1", "T2", "T3")[:markers],
    )
    compliances = each_spring(subset(joint_springs(robot), springs))
    gravity = np.array([0.0, 0.0, -9.81])
    load = Payload("weight", 40.0, np.array([0.0, 0.0, 0.2]))
    return ArmModel(robot, tool, geometric_errors(robot, groups), compliances, gravity, (load,))


def truth_of(rng: np.random.Generator, model: ArmModel) -> State:
    base = np.tile(np.eye(4), (1, 1, 1))
    base[0, :3, :3] = from_rotation_vectors(rng.normal(size=(1, 3)))[0]
    base[0, :3, 3] = [2.0, -1.0, 0.3]
    return State(
        base,
        np.asarray(model.tool.markers)[None]
        + 0.01 * rng.normal(size=(1, len(model.tool.markers), 3)),
        np.eye(3)[None],
        5e-4 * rng.normal(size=len(model.errors)),
        1e-6 * rng.uniform(0.3, 1.0, len(model.compliances)),
        np.array([[p.mass, *(p.mass * p.center)] for p in model.payloads]),
    )


def campaign(rng: np.random.Generator, model: ArmModel, truth: State, count: int = 40) -> Positions:
    """Half of the poses with the weight."""
    k = len(model.tool.markers)
    case, marker = np.repeat(np.arange(count), k), np.tile(np.arange(k), count)
    empty = Positions(
        model.tool,
        LoadCases(rng.uniform(-1.2, 1.2, (count, 6)), np.zeros((count, 6))),
        tuple(f"P{i}" for i in range(count)),
        case,
        marker,
        np.zeros((len(case), 3)),
        np.tile(NOISE**2 * np.eye(3), (len(case), 1, 1)),
        np.zeros(len(case)),
        payload=np.where(np.arange(count) % 2, 0, -1),
        payloads=("weight",),
    )
    there = -predicted(model, empty, parameters_of(model, empty), truth).error
    return replace(empty, value=there + NOISE * rng.normal(size=there.shape))


def fitted(model: ArmModel, positions: Positions) -> Calibration:
    return calibrate(model, positions, parameters_of(model, positions))


WHOLE = model_of(("zeros", "lengths", "angles"), ("A2", "A3"))


def test_what_is_told_comes_out_within_its_interval() -> None:
    inside, count = 0, 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        truth = truth_of(rng, WHOLE)
        found = fitted(WHOLE, campaign(rng, WHOLE, truth))
        mine = found.parameters.of("compliance")
        error = np.abs(found.state.compliance - truth.compliance)
        width = quantile(0.975, found.dof) * found.standard_error[mine]
        inside, count = inside + int((error < width).sum()), count + len(mine)
        assert found.redundancy.seen[mine].all()
        assert (width < 0.2e-6).all()
    assert inside >= count - 3


def test_poses_left_out_are_what_fits_without_them_say() -> None:
    rng = np.random.default_rng(3)
    positions = campaign(rng, WHOLE, truth_of(rng, WHOLE), 25)
    found = fitted(WHOLE, positions)
    for pose in (0, 7):
        keep = np.arange(25) != pose
        without = fitted(WHOLE, chosen_poses(positions, keep))
        error = check(put_away(without), chosen_poses(positions, ~keep)).error
        assert found.left_out[positions.case == pose] == pytest.approx(error, abs=3e-6)


def test_gauge_freedom_has_no_interval() -> None:
    """Zero of the first joint and turn of the base do the same; so do offsets along one axis."""
    rng = np.random.default_rng(4)
    found = fitted(WHOLE, campaign(rng, WHOLE, truth_of(rng, WHOLE)))
    seen = dict(zip(found.parameters.names, found.redundancy.seen, strict=True))
    for name in ("base turn z", "zero A1", "d A1", "base z", "d A2", "d A3", "zero A6", "d A6"):
        assert not seen[name], name
    for name in ("zero A2", "a A2", "zero A3", "alpha A2", "A2", "A3"):
        assert seen[name], name
    # Along what is open nothing moves, and the truth is not nearer than its prior.
    rows = predicted(WHOLE, found.positions, found.parameters, found.state).rows
    for row in found.redundancy.open:
        assert np.abs(rows @ row).max() < 1e-4 * np.abs(rows).max()
    assert found.redundancy.told + len(found.redundancy.open) == len(found.parameters)


@pytest.mark.parametrize("name", ["zero A3", "a A2", "alpha A4", "d A4", "beta A2"])
def test_an_error_planted_alone_is_found_alone(name: str) -> None:
    rng = np.random.default_rng(5)
    truth = truth_of(rng, WHOLE)
    geometry = np.zeros(len(WHOLE.errors))
    geometry[WHOLE.errors.names.index(name)] = 1e-3
    positions = campaign(rng, WHOLE, replace(truth, geometry=geometry))
    found = fitted(WHOLE, positions)
    first = found.parameters.arm
    for i, other in enumerate(WHOLE.errors.names):
        if not found.redundancy.seen[first + i]:
            continue
        error = abs(found.state.geometry[i] - geometry[i])
        assert error < 4.5 * found.standard_error[first + i], other


def test_the_ladder_proposes_what_is_needed() -> None:
    rng = np.random.default_rng(6)
    zeros = model_of(("zeros",), ())
    positions = campaign(rng, zeros, truth_of(rng, zeros))
    steps = [("base and tool", ()), ("zeros", ("zeros",)), ("lengths", ("zeros", "lengths"))]
    models = [(name, model_of(groups, ())) for name, groups in steps]
    grown = ladder([(n, m, parameters_of(m, positions)) for n, m in models], positions)
    assert grown.proposed == 1
    assert grown.rungs[0].left_out > 5.0 * grown.rungs[1].left_out
    assert grown.rungs[1].left_out == pytest.approx(NOISE * np.sqrt(3.0), rel=0.2)
    last = grown.rungs[-1].calibration
    assert last is not None
    assert "smaller-will-do" in {doubt.code for doubt in doubts(last, grown)}


def test_a_model_that_lacks_something_scatters_and_says_so() -> None:
    rng = np.random.default_rng(7)
    positions = campaign(rng, WHOLE, truth_of(rng, WHOLE))
    found = fitted(model_of((), ("A2", "A3")), positions)
    assert "model-scatters" in {doubt.code for doubt in doubts(found)}
    assert np.hypot(found.noise.own, found.noise.shared)[0] > 5 * NOISE
    assert found.noise.shared[0] > found.noise.own[0]  # both reflectors are off together


def test_a_spring_below_zero_names_the_geometry() -> None:
    rng = np.random.default_rng(7)
    truth = truth_of(rng, WHOLE)
    geometry = np.zeros(len(WHOLE.errors))
    geometry[WHOLE.errors.names.index("zero A3")] = 4e-3
    soft = replace(truth, geometry=geometry, compliance=np.full(2, 1e-8))
    positions = campaign(rng, WHOLE, soft)
    odd = doubts(fitted(model_of((), ("A2", "A3")), positions))
    below = [doubt for doubt in odd if doubt.code == "spring-below-zero"]
    assert below
    assert below[0].because == ("geometry",)


def test_a_robust_loss_holds_against_bad_rows() -> None:
    rng = np.random.default_rng(8)
    truth = truth_of(rng, WHOLE)
    positions = campaign(rng, WHOLE, truth)
    value = np.array(positions.value)
    bad = rng.choice(len(value), 4, replace=False)
    value[bad] += 5e-3 * rng.normal(size=(4, 3))
    spoilt = replace(positions, value=value)
    parameters = parameters_of(WHOLE, spoilt)
    plain, tame = (calibrate(WHOLE, spoilt, parameters, loss=loss) for loss in (None, Huber()))
    fresh = campaign(rng, WHOLE, truth, 20)
    assert check(put_away(tame), fresh).rms < 0.5 * check(put_away(plain), fresh).rms
    large = [r for r in bad if np.linalg.norm(value[r] - positions.value[r]) > 20.0 * NOISE]
    assert (tame.noise.weight[large] < 0.2).all()
    assert np.median(tame.noise.weight) == 1.0


def moved(positions: Positions, rng: np.random.Generator) -> Positions:
    """The same readings from another station."""
    turn = from_rotation_vectors(rng.normal(size=(1, 3)))[0]
    return replace(positions, value=positions.value @ turn.T + rng.normal(size=3))


def test_other_series_are_checked_with_base_and_tool_from_some_of_their_poses() -> None:
    rng = np.random.default_rng(9)
    truth = truth_of(rng, WHOLE)
    fresh = campaign(rng, WHOLE, truth, 40)
    found = put_away(fitted(WHOLE, campaign(rng, WHOLE, truth, 60)))
    own = check(found, fresh)
    assert own.rms == pytest.approx(own.expected, rel=0.15)
    there = check_set_up(found, moved(fresh, rng), 12)
    assert len(there.positions.cases) == 28
    assert there.rms == pytest.approx(there.expected, rel=0.3)
    assert there.rms < 2.0 * own.rms
    with pytest.raises(InputError, match="expected fewer"):
        check_set_up(found, fresh, 40)


def test_a_station_that_is_not_known_is_named() -> None:
    rng = np.random.default_rng(10)
    truth = truth_of(rng, WHOLE)
    positions = campaign(rng, WHOLE, truth)
    found = fitted(WHOLE, positions)
    other = replace(positions, stations=("north", "south"))
    with pytest.raises(InputError, match="station 'north' is not one of the calibration"):
        check(put_away(found), other)


def test_what_nobody_asks_for_is_held() -> None:
    rng = np.random.default_rng(11)
    truth = truth_of(rng, WHOLE)
    at_base = replace(truth, base=np.eye(4)[None], markers=np.asarray(WHOLE.tool.markers)[None])
    positions = campaign(rng, WHOLE, at_base)
    parameters = parameters_of(WHOLE, positions, held=("base", "tool"))
    found = calibrate(WHOLE, positions, parameters)
    assert np.array_equal(found.state.base, at_base.base)
    assert np.array_equal(found.state.markers, at_base.markers)
    assert not found.standard_error[parameters.held].any()
    assert found.redundancy.seen[parameters.names.index("zero A1")]
    assert rms_of(found.error) < 2.0 * NOISE * np.sqrt(3.0)


def test_payloads_are_weighed() -> None:
    rng = np.random.default_rng(12)
    known = model_of(("zeros", "lengths", "angles"), ("A2", "A3"))
    truth = truth_of(rng, known)
    positions = campaign(rng, known, truth, 60)
    doubted = replace(known, payloads=(Payload("weight", 30.0, np.zeros(3), 20.0, 0.3),))
    found = fitted(doubted, positions)
    mass = found.parameters.names.index("mass of weight")
    # Masses scale the compliances: the links' own are known, so the payload's mass can be told.
    assert found.redundancy.seen[mass]
    assert abs(found.state.payload[0, 0] - 40.0) < 3.0 * found.standard_error[mass]


def test_reflectors_told_by_an_exact_payload_are_said_to_be() -> None:
    rng = np.random.default_rng(15)
    found = fitted(WHOLE, campaign(rng, WHOLE, truth_of(rng, WHOLE)))
    told = replace(found.redundancy, seen=np.ones(len(found.parameters), dtype=bool))
    odd = [d for d in doubts(replace(found, redundancy=told)) if d.code == "payload-exact"]
    assert odd[0].about == ("weight",)
    open_ = replace(found.redundancy, seen=np.zeros(len(found.parameters), dtype=bool))
    assert not [d for d in doubts(replace(found, redundancy=open_)) if d.code == "payload-exact"]


def test_a_compensator_is_found_beside_the_spring_of_its_joint(tmp_path: Path) -> None:
    rng = np.random.default_rng(14)
    spring = Compensator("gas", 1, 0.3, 1.2, 0.4, 0.5)
    held = replace(WHOLE, compensators=(spring,))
    # 200 kN/m at a joint of 0.8 µrad/(N·m): two milliradians.
    truth = replace(truth_of(rng, held), compensator=np.array([0.16]))
    found = fitted(held, campaign(rng, held, truth, 60))
    mine = found.parameters.of("compensator")
    assert found.redundancy.seen[mine].all()
    error = abs(found.state.compensator[0] - 0.16)
    assert error < 4.0 * found.standard_error[mine[0]] < 0.02
    without = fitted(WHOLE, found.positions)
    assert rms_of(without.left_out) > 1.5 * rms_of(found.left_out)
    # The file brings it back.
    write_calibration(put_away(found), tmp_path / "model.json")
    again = read_calibration(tmp_path / "model.json", held.robot)
    (held_again,) = again.model.compensators
    assert held_again.angle == pytest.approx(spring.angle, abs=1e-12)
    assert replace(held_again, angle=spring.angle) == spring
    fresh = campaign(rng, held, truth, 10)
    there, here = check(again, fresh), check(put_away(found), fresh)
    assert there.error == pytest.approx(here.error, abs=1e-12)
    assert there.rms == pytest.approx(there.expected, rel=0.4)


def in_order(values: Array) -> bool:
    return bool((np.diff(values) >= 0.0).all())


def test_larger_models_fit_closer() -> None:
    rng = np.random.default_rng(13)
    positions = campaign(rng, WHOLE, truth_of(rng, WHOLE))
    errors = [
        rms_of(fitted(model_of(groups, ("A2", "A3")), positions).error)
        for groups in ((), ("zeros",), ("zeros", "lengths"), ("zeros", "lengths", "angles"))
    ]
    assert in_order(-np.array(errors))
