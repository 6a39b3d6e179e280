"""What looks odd in measurements: said, never guessed at or corrected."""

from __future__ import annotations

import re
from collections.abc import Container, Iterator, Sequence
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.errors import Doubt
from elastocal.files.measurements.rotation_scale import rotations_unlike_positions
from elastocal.files.tables.units import factor, split_header
from elastocal.measuring.measurements import Measurements, Quantity
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot
from elastocal.study.study import Study

_LARGE = 0.1  # m; no arm that works bends so far
_NOTHING_BUT_NOISE = 3.0  # deflections over their noise


def doubts(
    found: Measurements, study: Study, units: dict[str, str], shown: Array
) -> tuple[Doubt, ...]:
    """What looks odd.

    Args:
        found: What was read.
        study: The campaign it belongs to.
        units: Units of the columns in the file, by key.
        shown: (N, n) joint values with their whole turns [rad or m].
    """
    return (
        *_units(shown, study.robot, units),
        *_joints(found, study.robot),
        *_loads(found, study),
        *_deflections(found),
        *rotations_unlike_positions(found, study, units),
        *_readings_each(found),
        *_counts(found, study),
    )


def position_doubts(
    found: Positions, robot: Robot, units: dict[str, str], shown: Array
) -> tuple[Doubt, ...]:
    """What looks odd in absolute readings; arguments as those of `doubts`."""
    return (*_units(shown, robot, units), *_joints(found, robot), *_readings_each(found))


def unused(headers: Sequence[str], turned: Container[str], *, chosen: bool) -> tuple[Doubt, ...]:
    """What is said of columns that are not used, those first that look as if they should be.

    Args:
        headers: Their headers.
        turned: Those of rotations: of no use where positions alone are measured.
        chosen: Whether a mapping left them out; then no column looks like what it is not used for.
    """
    parts = {name: split_header(name) for name in headers}
    rotations = tuple(name for name in parts if name in turned)
    looks = {
        name: kind
        for name, part in parts.items()
        if not chosen and name not in rotations and (kind := _looks_like(*part)) is not None
    }
    others = tuple(name for name in parts if name not in rotations and name not in looks)
    found = [Doubt("rotations-not-used", rotations)] if rotations else []
    found += [Doubt("looks-used", (name,), (kind,)) for name, kind in looks.items()]
    return (*found, *([Doubt("columns-not-used", others)] if others else []))


def _looks_like(name: str, unit: str | None) -> str | None:
    if re.match(r"u ?\(|u_|sigma|std|uncert", name.lower()):
        return "an uncertainty"
    kinds = {"force": "a force", "torque": "a torque", "mass": "a load"}
    return next((w for kind, w in kinds.items() if unit and factor(unit, kind) is not None), None)


_FULL_TURN = 2.0 * np.pi + 0.01  # rad; means of readings about it are a little beyond


def _units(q: Array, robot: Robot, units: dict[str, str]) -> Iterator[Doubt]:
    turning = [j for j, joint in enumerate(robot.joints) if not joint.prismatic]
    for unit in ("rad", "deg"):
        own = [j for j in turning if units.get(f"q:{robot.joints[j].name}") == unit]
        if not own:
            continue
        largest = float(np.abs(q[:, own]).max())
        if unit == "rad" and largest > _FULL_TURN:
            yield Doubt("degrees-for-radians", numbers={"largest": largest})
        if unit == "deg" and 0.0 < np.degrees(largest) < 2.0 * np.pi:
            yield Doubt("radians-for-degrees", numbers={"largest": largest})


def _joints(found: Measurements | Positions, robot: Robot) -> Iterator[Doubt]:
    for j, joint in enumerate(robot.joints):
        value = found.cases.q[:, j]
        beyond = np.asarray((value < joint.lower - 1e-9) | (value > joint.upper + 1e-9))
        if beyond.any():
            ends = {"least": float(value[beyond].min()), "most": float(value[beyond].max())}
            limits = {"lower": joint.lower, "upper": joint.upper, **ends}
            named = _named(found, beyond)
            yield Doubt("beyond-joint-limits", named, (joint.name,), limits, joint.kind.unit)


def _loads(found: Measurements, study: Study) -> Iterator[Doubt]:
    wrench, plan = found.cases.wrench, study.experiments
    idle = np.asarray(~wrench.any(axis=1))
    if idle.any():
        yield Doubt("no-load", _named(found, idle))
    size = np.linalg.norm(wrench[:, :3], axis=1)
    wanted = plan.force.size
    far = np.asarray(~idle & (np.abs(size - wanted) > 0.2 * wanted))
    if wanted > 0.0 and far.any():
        forces = {"least": float(size[far].min()), "most": float(size[far].max())}
        forces["planned"] = wanted
        yield Doubt("other-force", _named(found, far), numbers=forces)
    elif wanted > 0.0:
        unit = wrench[:, :3] / np.where(idle, 1.0, size)[:, None]
        room = plan.force.margin(wanted * unit)
        aside = np.asarray(~idle & (room < -0.1 * wanted))
        if aside.any():
            worst = int(np.where(aside, room, np.inf).argmin())
            along = dict(zip("xyz", unit[worst].tolist(), strict=True))
            names = _named(found, aside)
            yield Doubt("other-direction", names, (found.names[worst],), along)
    if plan.moment.size > 0.0 and not wrench[:, 3:].any():
        yield Doubt("no-torques", numbers={"planned": plan.moment.size})
    if len(found.cases) >= 5 and _sensor_is_stuck(wrench[~idle, :3]):
        yield Doubt("stuck-sensor")


def _sensor_is_stuck(force: Array) -> bool:
    """Readings that scatter as those of a sensor do, and then stay: a run of equal ones."""
    if len(force) < 5:
        return False
    same = (force[1:] == force[:-1]).all(axis=1)
    runs = np.diff(np.flatnonzero(np.concatenate([[True], ~same, [True]])))
    return bool(runs.max() >= 3 and (runs == 1).sum() >= 3)


def _deflections(found: Measurements) -> Iterator[Doubt]:
    for kind in found.quantities:
        yield from _of_kind(found, kind)


def _of_kind(found: Measurements, kind: Quantity) -> Iterator[Doubt]:
    """What looks odd in the positions, or in the rotations."""
    size, own = found.length, kind.readings
    unit = "" if kind.unit == "m" else kind.unit
    large = np.asarray(own & (size > _LARGE))
    if large.any():
        ends = {"least": float(size[large].min()), "most": float(size[large].max())}
        names = _named(found, _cases_of(found, large))
        yield Doubt("large-deflection", names, numbers=ends, unit=unit)
    noise = np.sqrt(np.einsum("rii->r", found.covariance))
    clear = own & (size >= _NOTHING_BUT_NOISE * noise)
    if not clear.any():
        largest = int(np.where(own, size, -1.0).argmax())
        sizes = {"deflection": float(size[largest]), "noise": float(noise[largest])}
        yield Doubt("only-noise", numbers=sizes, unit=unit)
        return
    still = np.asarray(own & ~found.deflection.any(axis=1))
    if kind.unit == "m":
        yield from _against_force(found, size > _NOTHING_BUT_NOISE * noise)
    if still.any():
        yield Doubt("zero-deflection", _named(found, _cases_of(found, still)), unit=unit)


def _against_force(found: Measurements, clear: BoolArray) -> Iterator[Doubt]:
    """Most of the deflections that are `clear`, (R,), go against the force."""
    along = np.einsum("rc,rc->r", found.deflection, found.cases.wrench[found.case, :3])
    along = along[~found.rotations & clear & (along != 0.0)]
    if len(along) >= 3 and (along < 0.0).mean() > 0.8:
        counts = {"against": int((along < 0.0).sum()), "clear": len(along)}
        yield Doubt("against-force", numbers=counts)


def _readings_each(found: Measurements | Positions) -> Iterator[Doubt]:
    per_case = np.bincount(found.case, minlength=len(found.cases))
    if len(per_case) and per_case.min() != per_case.max():
        fewer = per_case < per_case.max()
        few = per_case[fewer]
        counts = {"least": int(few.min()), "most": int(few.max()), "others": int(per_case.max())}
        yield Doubt("fewer-readings", _named(found, fewer), numbers=counts)
    unseen = sorted(set(range(len(found.tool.targets))) - set(np.unique(found.marker).tolist()))
    if unseen:
        unit = "rad" if unseen[0] == len(found.tool.markers) else ""
        yield Doubt("marker-not-measured", (found.tool.targets[unseen[0]],), unit=unit)


def _counts(found: Measurements, study: Study) -> Iterator[Doubt]:
    if len(found.cases) < study.experiments.count:
        counts = {"experiments": len(found.cases), "planned": study.experiments.count}
        yield Doubt("unfinished", numbers=counts)


def kept_aside(found: Measurements) -> Measurements:
    """Readings that are not the campaign of the study: their number is no matter."""
    left = tuple(doubt for doubt in found.doubts if doubt.code != "unfinished")
    return replace(found, doubts=left)


def _cases_of(found: Measurements, readings: BoolArray) -> BoolArray:
    """(N,) experiments that have one of these (R,) readings."""
    count = np.bincount(found.case[readings], minlength=len(found.cases))
    return np.asarray(count > 0)


def _named(found: Measurements | Positions, cases: BoolArray) -> tuple[str, ...]:
    """Names of (N,) experiments."""
    return tuple(found.names[i] for i in np.flatnonzero(cases))
