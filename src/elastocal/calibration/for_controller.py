"""What of a calibrated robot goes into a controller: zeros of joints, tools, bases.

A controller has numbers for these, not for lengths, angles and compliances of an arm. What they
leave is therefore said, too: zeros alone may make an arm worse whose lengths err.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.calibration.calibrated_robot import CalibratedRobot
from elastocal.calibration.placed import TCP, Carried, carried_point, placed
from elastocal.elastic.load_cases import LoadCases
from elastocal.measuring.best_fit import unseen_turn
from elastocal.robot.chain import Robot, transform
from elastocal.robot.controller_axes import Coupling
from elastocal.robot.geometry import ZEROS, group_of, with_errors
from elastocal.robot.joint_kinds import JointKind
from elastocal.robot.posture import forward_kinematics

_DRAWS = 400
_ENDLESS = np.pi  # how far joints without limits are moved [rad or m]


@dataclass(frozen=True)
class ZeroShift:
    """How far a joint stands from where its controller shows it.

    Attributes:
        joint: Name of the joint.
        kind: Whether it turns or slides.
        shift: What must be added to what the controller shows [rad or m].
        error: Standard error of that.
        seen: Whether it was measured; else it rests on what was known before.
        sought: Whether it was an unknown at all.
    """

    joint: str
    kind: JointKind
    shift: float
    error: float
    seen: bool
    sought: bool


@dataclass(frozen=True)
class MountedTool:
    """The tool of a mounting, in the frame of the flange.

    Attributes:
        mounting: Name of the mounting.
        points: Its TCP and reflectors.
        errors: (K, 3) standard errors of their coordinates on the flange [m]; NaN where nothing
            carries the point.
        frame: (4, 4) the frame of the tool: its TCP, turned as the reflectors are against their
            drawing [m]; None if fewer than three of them say how.
    """

    mounting: str
    points: tuple[Carried, ...]
    errors: Array
    frame: Array | None

    def __post_init__(self) -> None:
        freeze(self, "errors")


@dataclass(frozen=True)
class StandingBase:
    """Where a station stands, seen from the base of the robot.

    Attributes:
        station: Its name.
        T_base_station: (4, 4) its frame in that of the base [m].
        errors: (6,) standard errors of its origin [m] and of its turn about x, y, z [rad], in the
            axes of the base.
    """

    station: str
    T_base_station: Array
    errors: Array

    def __post_init__(self) -> None:
        freeze(self, "T_base_station", "errors")


@dataclass(frozen=True)
class LeftOver:
    """What a controller leaves that has tool and base, over its joint ranges.

    Attributes:
        drawn: Root mean square error of the point, if nothing else is entered [m].
        zeros: The same with the zeros of the joints.
        point: Name of the point.
        payload: What hung on the flange; empty for nothing.
    """

    drawn: float
    zeros: float
    point: str
    payload: str


@dataclass(frozen=True)
class ForController:
    """Everything that goes into a controller.

    Attributes:
        zeros: Of all joints that move on their own.
        tools: By mounting.
        bases: By station.
        left: What they leave.
    """

    zeros: tuple[ZeroShift, ...]
    tools: tuple[MountedTool, ...]
    bases: tuple[StandingBase, ...]
    left: LeftOver


def for_controller(calibrated: CalibratedRobot, coupling: Coupling) -> ForController:
    """What goes into a controller that shows joint values by `coupling`."""
    count = len(calibrated.mountings)
    return ForController(
        zeros=_zeros(calibrated, coupling),
        tools=tuple(_tool(calibrated, m) for m in range(count)),
        bases=tuple(_base(calibrated, s) for s in range(len(calibrated.stations))),
        left=_left(calibrated),
    )


def _zeros(calibrated: CalibratedRobot, coupling: Coupling) -> tuple[ZeroShift, ...]:
    """The shifts, as the controller counts them."""
    robot, errors = calibrated.model.robot, calibrated.model.errors
    first, n = calibrated.parameters.arm, len(robot.joints)
    pick = np.zeros((n, len(errors)))
    for j, name in enumerate(robot.joint_names):
        if (zero := f"zero {name}") in errors.names:
            pick[j, errors.names.index(zero)] = 1.0
    own = slice(first, first + len(errors))
    shown = coupling.matrix @ pick
    shift = shown @ calibrated.state.geometry
    deviation = np.sqrt(np.einsum("ij,jk,ik->i", shown, calibrated.covariance[own, own], shown))
    seen = calibrated.seen[own]
    return tuple(
        ZeroShift(
            joint.name,
            joint.kind,
            float(shift[j]),
            float(deviation[j]),
            bool(seen[shown[j] != 0.0].all()),
            bool(shown[j].any()),
        )
        for j, joint in enumerate(robot.joints)
    )


def _tool(calibrated: CalibratedRobot, mounting: int) -> MountedTool:
    tool = calibrated.model.tool
    read = calibrated.parameters.targets[mounting, :-1].astype(bool)
    names = [n for n, one in zip(tool.marker_names, read.tolist(), strict=True) if one]
    points = [carried_point(calibrated, mounting, name) for name in names]
    if TCP not in names:
        points.insert(0, carried_point(calibrated, mounting))
    errors = [
        np.sqrt(np.einsum("iu,uv,iv->i", p.slope, calibrated.covariance, p.slope))
        if p.measured
        else np.full(3, np.nan)
        for p in points
    ]
    frame = None
    if points[0].measured and not unseen_turn(tool.markers[read]):
        frame = transform(points[0].rotation, points[0].point)
    return MountedTool(calibrated.mountings[mounting], tuple(points), np.array(errors), frame)


def _base(calibrated: CalibratedRobot, station: int) -> StandingBase:
    """The inverse of the pose of the base, with what a small step of that does to it.

    A step shifts the base by s and turns it by w about its origin, in the frame of the station:
    the origin of the station moves by Rᵀ (w × t - s) in the frame of the base, and turns by -Rᵀ w.
    """
    base = calibrated.state.base[station]
    R, t = base[:3, :3], base[:3, 3]
    T = transform(R.T, -R.T @ t)
    cross = np.array([[0.0, -t[2], t[1]], [t[2], 0.0, -t[0]], [-t[1], t[0], 0.0]])
    slope = np.zeros((6, 6))
    slope[:3, :3], slope[:3, 3:], slope[3:, 3:] = -R.T, -R.T @ cross, -R.T
    own = 6 * station + np.arange(6)
    spread = slope @ calibrated.covariance[np.ix_(own, own)] @ slope.T
    errors = np.sqrt(np.maximum(np.diagonal(spread), 0.0))
    return StandingBase(calibrated.stations[station], T, errors)


def _left(calibrated: CalibratedRobot) -> LeftOver:
    """By chance over the joint ranges, with the first payload if there is any."""
    model, rng = calibrated.model, np.random.default_rng(0)
    q = _anywhere(model.robot, rng)
    payload = 0 if model.payloads else -1
    carried = carried_point(calibrated)
    true = placed(calibrated, LoadCases(q, np.zeros((len(q), 6))), carried, payload=payload).point
    zeros = np.array([group == ZEROS for group in group_of(model.errors, model.robot)], dtype=bool)
    values = np.where(zeros, calibrated.state.geometry, 0.0)
    corrected = with_errors(model.robot, model.errors, values)
    sizes = []
    for robot in (model.robot, corrected):
        flange = forward_kinematics(robot, q)
        off = flange[:, :3, :3] @ carried.point + flange[:, :3, 3] - true
        sizes.append(float(np.sqrt((off**2).sum(axis=1).mean())))
    name = model.payloads[payload].name if payload >= 0 else ""
    return LeftOver(sizes[0], sizes[1], carried.name, name)


def _anywhere(robot: Robot, rng: np.random.Generator) -> Array:
    """(N, n) configurations within the limits."""
    lower = np.where(np.isfinite(robot.lower), robot.lower, -_ENDLESS)
    upper = np.where(np.isfinite(robot.upper), robot.upper, _ENDLESS)
    return rng.uniform(lower, upper, (_DRAWS, len(robot.joints)))
