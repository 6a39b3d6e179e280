"""What looks odd in measurements: said in a sentence, never guessed at or corrected."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.files.tables.units import factor, split_header
from elastocal.measuring.measurements import Measurements
from elastocal.study.study import Study

_LARGE = 0.1  # m; no arm that works bends so far
_MANY = 5  # names in a sentence


def remarks(found: Measurements, study: Study, units: dict[str, str]) -> tuple[str, ...]:
    """Sentences on what looks odd.

    Args:
        found: What was read.
        study: The campaign it belongs to.
        units: Units of the columns in the file, by key.
    """
    return (
        *_joints(found, study, units),
        *_loads(found, study),
        *_deflections(found),
        *_counts(found, study),
    )


def unused(headers: Sequence[str]) -> tuple[str, ...]:
    """A sentence on columns that are not used although they look as if they should be."""
    looks = {
        name: kind for name in headers if (kind := _looks_like(*split_header(name))) is not None
    }
    return tuple(
        f"column {name!r} looks like {kind} but is not used; its name means nothing here"
        for name, kind in looks.items()
    )


def _looks_like(name: str, unit: str | None) -> str | None:
    if re.match(r"u ?\(|u_|sigma|std|uncert", name.lower()):
        return "an uncertainty"
    kinds = {"force": "a force", "torque": "a torque", "mass": "a load"}
    return next((w for kind, w in kinds.items() if unit and factor(unit, kind) is not None), None)


def _joints(found: Measurements, study: Study, units: dict[str, str]) -> Iterator[str]:
    robot, q = study.robot, found.cases.q
    turning = [j for j, joint in enumerate(robot.joints) if not joint.prismatic]
    for unit, other in (("rad", "degrees"), ("deg", "radians")):
        own = [j for j in turning if units.get(f"q:{robot.joints[j].name}") == unit]
        if not own:
            continue
        largest = float(np.abs(q[:, own]).max())
        shown = np.degrees(largest) if unit == "deg" else largest
        if unit == "rad" and shown > 2.0 * np.pi:
            yield f"joint values reach {shown:.4g} rad, more than a full turn: were {other} meant?"
        if unit == "deg" and 0.0 < shown < 2.0 * np.pi:
            yield f"no joint value is beyond {shown:.3g}°: were {other} meant?"
    for j, joint in enumerate(robot.joints):
        scale, unit = joint.kind.shown
        beyond = (q[:, j] < joint.lower - 1e-9) | (q[:, j] > joint.upper + 1e-9)
        if beyond.any():
            first = int(beyond.argmax())
            yield (
                f"{_named(found, beyond)}: {joint.name} is beyond its limits "
                f"{scale * joint.lower:.6g} … {scale * joint.upper:.6g} {unit} (at "
                f"{scale * q[first, j]:.6g} {unit})"
            )


def _loads(found: Measurements, study: Study) -> Iterator[str]:
    wrench, plan = found.cases.wrench, study.experiments
    idle = ~wrench.any(axis=1)
    if idle.any():
        yield f"{_named(found, idle)}: no load at all, so nothing can deflect"
    size = np.linalg.norm(wrench[:, :3], axis=1)
    wanted = plan.force.size
    far = np.asarray(~idle & (np.abs(size - wanted) > 0.2 * wanted))
    if wanted > 0.0 and far.any():
        first = int(far.argmax())
        yield (
            f"{_named(found, far)}: the force is {size[first]:.4g} N where the study plans "
            f"{wanted:.4g} N"
        )
    elif wanted > 0.0:
        unit = wrench[:, :3] / np.where(idle, 1.0, size)[:, None]
        aside = np.asarray(~idle & (plan.force.margin(wanted * unit) < -0.1 * wanted))
        if aside.any():
            first = int(aside.argmax())
            yield (
                f"{_named(found, aside)}: the force points along "
                f"[{' '.join(f'{v:.2f}' for v in unit[first])}], which the study does not plan"
            )
    if plan.moment.size > 0.0 and not wrench[:, 3:].any():
        yield f"the study plans torques of {plan.moment.size:.4g} N·m, the file has none"
    if len(found.cases) >= 5 and _sensor_is_stuck(wrench[~idle, :3]):
        yield (
            "the force has one value in some experiments and to the last digit another in the "
            "rest: is the force sensor stuck?"
        )


def _sensor_is_stuck(force: Array) -> bool:
    """Readings that scatter as those of a sensor do, and then stay: a run of equal ones."""
    if len(force) < 5:
        return False
    same = (force[1:] == force[:-1]).all(axis=1)
    runs = np.diff(np.flatnonzero(np.concatenate([[True], ~same, [True]])))
    return bool(runs.max() >= 3 and (runs == 1).sum() >= 3)


def _deflections(found: Measurements) -> Iterator[str]:
    size = np.linalg.norm(found.deflection, axis=1)
    if not len(size):
        return
    large = np.asarray(size > _LARGE)
    if large.any():
        yield (
            f"{_named(found, _cases_of(found, large))}: the deflection is {size[large][0]:.4g} m: "
            "were millimetres or micrometres meant, or positions of different points subtracted?"
        )
    noise = np.sqrt(np.einsum("rii->r", found.covariance))
    if (size < 3.0 * noise).all():
        yield (
            f"no deflection is above three times its noise (the largest is "
            f"{1e3 * size.max():.3g} mm, with noise of {1e3 * noise[size.argmax()]:.3g} mm): were "
            "the robot and the gauge as they should be?"
        )
        return
    along = np.einsum("rc,rc->r", found.deflection, found.cases.wrench[found.case, :3])
    clear = (size > 3.0 * noise) & (along != 0.0)
    if clear.sum() >= 3 and (along[clear] < 0.0).mean() > 0.8:
        yield (
            f"{(along[clear] < 0.0).sum()} of {clear.sum()} deflections go against the force: were "
            "loaded and unloaded exchanged, or the sign of the force?"
        )
    still = ~found.deflection.any(axis=1)
    if still.any():
        yield f"{_named(found, _cases_of(found, still))}: the deflection is exactly zero"


def _counts(found: Measurements, study: Study) -> Iterator[str]:
    per_case = np.bincount(found.case, minlength=len(found.cases))
    if len(per_case) and per_case.min() != per_case.max():
        fewer = per_case < per_case.max()
        yield (
            f"{_named(found, fewer)}: {per_case[fewer][0]} of up to {per_case.max()} readings that "
            "other experiments have"
        )
    unseen = sorted(set(range(len(found.tool.markers))) - set(np.unique(found.marker).tolist()))
    if unseen:
        yield f"marker {found.tool.marker_names[unseen[0]]!r} was never measured"
    if len(found.cases) < study.experiments.count:
        yield _unfinished(found, study)


def _unfinished(found: Measurements, study: Study) -> str:
    planned = study.experiments.count
    return f"{len(found.cases)} of the {planned} experiments of the study are in the file"


def kept_aside(found: Measurements, study: Study) -> Measurements:
    """Readings that are not the campaign of the study: their number is no matter."""
    said = _unfinished(found, study)
    return replace(found, remarks=tuple(remark for remark in found.remarks if remark != said))


def _cases_of(found: Measurements, readings: Any) -> BoolArray:
    """(N,) experiments that have one of these readings."""
    count = np.bincount(found.case[readings], minlength=len(found.cases))
    return np.asarray(count > 0)


def _named(found: Measurements, cases: Any) -> str:
    """'experiments 3, 5 and 7 others' for (N,) cases."""
    places = np.flatnonzero(cases)
    names = [found.names[i][:40] for i in places[:_MANY]]
    rest = len(places) - len(names)
    more = f" and {rest} more" if rest else ""
    return f"experiment{'s' if len(places) > 1 else ''} {', '.join(names)}{more}"
