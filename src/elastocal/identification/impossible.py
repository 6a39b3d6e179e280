"""What no measurement of any arm can be: refused, for a model of it would be nonsense.

In: readings, or what was fitted to them. Out: a refusal that names what is off. The limits are
wide, so that real data, with more noise than promised or a wrong convention, only get remarks.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import BoolArray
from elastocal.errors import Doubt, InputError
from elastocal.identification.convention_search import other_convention
from elastocal.identification.result import Identification
from elastocal.measuring.measurements import Measurements, Quantity
from elastocal.robot.chain import Robot
from elastocal.robot.controller_axes import Coupling
from elastocal.robot.posture import Posture
from elastocal.wording import together, worded

LOAD = 1e6
"""N or N·m; no robot bears a hundred tonnes."""
SHARE = 0.25
"""Share of the distance from the base by which no arm is bent."""
NOISES = 30.0
"""Residuals over the promised noise, from which on a negative compliance is no chance."""
SURELY = 3.0
"""Standard errors below zero of a compliance that is surely negative."""
_NOTHING = 1e-9
"""m or rad; what no instrument tells from nothing, and rounding may leave of it."""
_COPIES = 3  # distinct load cases whose deflections are not the same
_ASKED = 500  # experiments that tell how far from the base the arm reaches
_CLEARLY = 1.0 / 360.0  # of what is far outside: a degree
_RANGES = 10.0  # ranges of a sliding joint that are far outside
_TURN = 2.0 * np.pi  # of a turning one


def refuse_impossible_readings(data: Measurements, robot: Robot) -> None:
    """Refuse readings most of which cannot be.

    Raises:
        InputError: in most experiments a joint is more than a turn beyond its limits, or the load
            more than any robot bears; or most deflections are a quarter of the way from the base,
            or exactly zero under load, or all of them the same.
    """
    for doubt in (
        _joints(data, robot),
        _loads(data),
        _deflections(data, robot),
        *(_not_read(data, robot, kind) for kind in data.quantities),
    ):
        if doubt is not None:
            raise InputError(f"{data.source}: {worded(doubt)}").with_doubts(doubt)


def refuse_impossible_fit(found: Identification, table: Coupling | None = None) -> None:
    """Refuse a fit that no springs explain.

    Where σ is estimated, or outliers count less, nothing was promised that could be broken.

    Args:
        found: The fit.
        table: What the controller shows, as assumed: another convention that explains the readings
            is named.

    Raises:
        InputError: the residuals are many times the promised noise, and compliances are negative
            or joints beyond their limits; or all compliances are surely negative.
    """
    data, promised = found.measurements, not (found.how.robust or found.how.estimates_sigma)
    negative = tuple(
        name
        for name, compliance in zip(found.identified, found.compliance, strict=True)
        if compliance < 0.0 or name in found.held
    )
    doubt = None
    surely = found.compliance < -SURELY * found.standard_error
    if surely.all() and len(surely) > 1:
        doubt = Doubt("impossible-signs", negative)
    elif promised and found.scale > NOISES:
        robot = found.arm.robot
        outside = [_most(joint) for joint in _outside(data, robot, _CLEARLY).T]
        beyond = tuple(n for n, off in zip(robot.joint_names, outside, strict=True) if off)
        if negative or beyond:
            doubt = Doubt("impossible-fit", negative, beyond, {"scale": found.scale})
    if doubt is not None:
        other = other_convention(found, table) if table is not None else None
        said = (doubt,) if other is None else (doubt, other.doubt)
        raise InputError(f"{data.source}: {together(said)}").with_doubts(*said)


def _most(cases: BoolArray) -> bool:
    return len(cases) > 0 and bool(cases.mean() > 0.5)


def _outside(data: Measurements, robot: Robot, share: float) -> BoolArray:
    """(N, n) where joints are outside their limits by a share of what is far outside."""
    far = [_RANGES * (j.upper - j.lower) if j.prismatic else _TURN for j in robot.joints]
    room, q = share * np.array(far), data.cases.q
    return np.asarray((q < robot.lower - room) | (q > robot.upper + room))


def _joints(data: Measurements, robot: Robot) -> Doubt | None:
    far = _outside(data, robot, 1.0)
    cases = np.asarray(far.any(axis=1))
    if not _most(cases):
        return None
    names = tuple(n for n, off in zip(robot.joint_names, far.T, strict=True) if off.any())
    i, j = divmod(int(far.argmax()), far.shape[1])
    numbers = {"experiments": int(cases.sum()), "value": float(data.cases.q[i, j])}
    joint = robot.joints[j]
    return Doubt("impossible-joints", names, (joint.name,), numbers, joint.kind.unit)


def _loads(data: Measurements) -> Doubt | None:
    for side, unit in ((slice(0, 3), "N"), (slice(3, 6), "N·m")):
        size = np.linalg.norm(data.cases.wrench[:, side], axis=1)
        if _most(size > LOAD):
            return Doubt("impossible-loads", numbers={"load": float(np.median(size))}, unit=unit)
    return None


def _deflections(data: Measurements, robot: Robot) -> Doubt | None:
    size = data.length[~data.rotations]
    posture = Posture(robot, data.cases.q[:_ASKED])
    points = [posture.point(marker) for marker in data.tool.markers]
    far = float(max(np.linalg.norm(point, axis=0).max() for point in points))
    if not _most(size > SHARE * far):
        return None
    sizes = {"deflection": float(np.median(size)), "distance": far}
    return Doubt("impossible-deflections", numbers=sizes)


def _not_read(data: Measurements, robot: Robot, kind: Quantity) -> Doubt | None:
    """Deflections that no gauge has read: nothing under load, or one value for all loads."""
    if kind.unit == "rad" and robot.prismatic.all():
        return None  # nothing turns there
    loaded = kind.readings & data.cases.wrench[data.case].any(axis=1)
    cases, case, deflection = data.cases, data.case[loaded], data.deflection[loaded]
    zero = np.asarray((np.abs(deflection) < _NOTHING).all(axis=1))
    if _most(zero):
        counts = {"zero": int(zero.sum()), "readings": len(zero)}
        return Doubt("impossible-zeros", numbers=counts, unit=kind.unit)
    if not len(case) or (np.ptp(deflection, axis=0) >= _NOTHING).any():
        return None
    distinct = len(np.unique(np.hstack([cases.q, cases.wrench])[case], axis=0))
    if distinct >= _COPIES:
        numbers = {"readings": len(case), "cases": distinct}
        return Doubt("impossible-copies", numbers=numbers, unit=kind.unit)
    return None
