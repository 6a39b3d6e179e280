"""Rows of the tables: standard errors, margins, support, criteria.

In: plan and other assessments. Out: rows of text with the length of their bars.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from elastocal.planning.assessment import TOLERANCE, Assessment
from elastocal.planning.plan import Plan
from elastocal.robot.joint_kinds import KINDS, JointKind
from elastocal.study.criteria import CRITERIA
from elastocal.wording.numbers import (
    described,
    fixed,
    length,
    number,
    percent,
    shown_unit,
    vector,
    words,
)

_MOST_SUPPORT = 8


@dataclass(frozen=True)
class Row:
    """One line of a table.

    Attributes:
        cells: Text of the cells, the first one names the line.
        share: Length of its bar between 0 and 1.
        state: "", "active" or "broken".
    """

    cells: tuple[str, ...]
    share: float = 0.0
    state: str = ""


@dataclass(frozen=True)
class BarTable:
    """A table with a bar in each line.

    Attributes:
        heads: Text above the cells.
        rows: The lines.
        caption: What it shows.
        others: How many further lines were left out.
    """

    heads: tuple[str, ...]
    rows: tuple[Row, ...]
    caption: str = ""
    others: int = 0


def standard_errors(plan: Plan) -> list[BarTable]:
    """Standard errors of angular and of linear compliances, apart because units differ."""
    springs, errors = plan.study.springs, plan.assessment.standard_error
    tables = []
    for si in dict.fromkeys(springs.units):
        chosen = [i for i, own in enumerate(springs.units) if own == si]
        factor, unit = shown_unit(si)
        finite = errors[chosen][np.isfinite(errors[chosen])]
        largest = float(finite.max()) if len(finite) else 1.0
        rows = tuple(
            Row((springs.names[i], number(factor * errors[i])), _share(errors[i] / largest))
            for i in chosen
        )
        heads = ("Joint", f"Standard error [{unit}]")
        tables.append(BarTable(heads, rows, springs_named(si)))
    return tables


def springs_named(si: str) -> str:
    """What has this SI unit, in the plural."""
    kinds = {kind.compliance: f"{kind.spring} springs" for kind in KINDS}
    return kinds.get(si, "angles" if si == "rad" else "lengths")


def nuisance(plan: Plan) -> BarTable | None:
    """What moves readings besides, how large, and who says so; None if nothing does."""
    told = plan.study.nuisance
    if told is None or not len(told.names):
        return None
    rows = []
    for name, kind, size, source in zip(
        told.names, told.unknowns.kinds, told.deviation.tolist(), told.source, strict=True
    ):
        factor, unit = shown_unit(kind.compliance)
        rows.append(Row((name, f"{number(factor * size)} × {unit}", source)))
    return BarTable(("Nuisance", "Standard uncertainty", "From"), tuple(rows))


def margins(plan: Plan) -> BarTable:
    """Nearest constraint of every configuration."""
    largest: dict[str, float] = {}
    for near in plan.assessment.nearest:
        largest[near.unit] = max(largest.get(near.unit, 0.0), near.margin)
    rows = []
    for i, near in enumerate(plan.assessment.nearest):
        state = "active" if near.margin < TOLERANCE else ""
        state = "broken" if near.margin < -TOLERANCE else state
        room = described(near.margin, near.unit).replace("-", "−")
        shown = {"broken": f"{room}: broken", "active": "on the limit", "": room}[state]
        share = _share(near.margin / largest[near.unit]) if not state else 0.0
        rows.append(Row((str(i + 1), words(near.name), shown), share, state))
    return BarTable(("No.", "Nearest constraint", "Room left"), tuple(rows))


def view(plan: Plan) -> BarTable | None:
    """Which marker the tracker sees in which configuration; None if there is no tracker."""
    seen = plan.view
    if seen is None:
        return None
    rows = []
    longest = float(seen.range.max(initial=0.0))
    for i in range(seen.seen.shape[1]):
        for k, marker in enumerate(seen.markers):
            angle = np.degrees(seen.incidence[k, i])
            shown = fixed(float(angle), 1) + "°" if np.isfinite(angle) else "–"
            told = "seen" if seen.seen[k, i] else f"not seen: {words(seen.broken[k][i])}"
            cells = (str(i + 1), marker, f"{fixed(float(seen.range[k, i]), 3)} m", shown, told)
            state = "" if seen.seen[k, i] else "broken"
            rows.append(Row(cells, _share(seen.range[k, i] / longest), state))
    return BarTable(("No.", "Marker", "Range", "Off its axis", "Tracker"), tuple(rows))


def support(plan: Plan) -> BarTable | None:
    """Load cases of the continuous design behind the bound, largest weights first."""
    certificate, robot = plan.certificate, plan.study.robot
    cases, weights = certificate.support, certificate.weights
    if cases is None or weights is None or not len(weights):
        return None
    order = np.argsort(-weights)[:_MOST_SUPPORT]
    order = order[weights[order] >= 5e-4]
    joints = (f"{joint.name} [{joint.kind.shown_unit}]" for joint in robot.joints)
    heads = ("Weight", *joints, "Force [N]")
    rows = []
    for i in order:
        values = [fixed(float(value), 1) for value in robot.shown_scale * cases.q[i]]
        cells = (f"{fixed(100.0 * weights[i], 1)} %", *values, vector(cases.wrench[i, :3]))
        rows.append(Row(cells, _share(weights[i] / weights.max())))
    return BarTable(heads, tuple(rows), others=len(weights) - len(order))


def peak(plan: Plan) -> BarTable | None:
    """Configuration where the sensitivity is largest."""
    case, robot = plan.certificate.peak, plan.study.robot
    if case is None:
        return None
    rows = []
    for joint, v in zip(robot.joints, case.q[0], strict=True):
        rows.append(Row((joint.name, joint_value(float(v), joint.kind) + joint.kind.suffix)))
    rows.append(Row(("Force", f"{vector(case.wrench[0, :3])} N")))
    if np.any(case.wrench[0, 3:]):
        rows.append(Row(("Torque", f"{vector(case.wrench[0, 3:], 1)} N·m")))
    return BarTable(("Joint", "Value"), tuple(rows))


def criteria(plan: Plan, others: Mapping[str, Assessment]) -> BarTable:
    """Every criterion's value for this plan and for others."""
    heads = ("Criterion", "This plan", *others, "Unit", "Better", "What it measures")
    rows = []
    for name, value in plan.assessment.criteria.items():
        criterion = CRITERIA[name]
        better = "larger" if criterion.larger_is_better else "smaller"
        values = [value, *(other.criteria.get(name, np.nan) for other in others.values())]
        factor, unit = shown_unit(criterion.unit(plan.study.springs), values)
        shown = tuple(number(factor * v) for v in values)
        state = "chosen" if name == plan.criterion else ""
        rows.append(Row((name, *shown, unit, better, criterion.meaning), state=state))
    return BarTable(heads, tuple(rows))


def test_pose_errors(plan: Plan) -> BarTable:
    """Error at each test pose; of paths the root mean square, and the worst point."""
    study, worth = plan.study, plan.assessment
    errors, paths = worth.rho0_each, any(worth.worst_points)
    largest = max((e for e in errors if np.isfinite(e)), default=1.0)
    rows = []
    for pose, weight, error, worst in zip(
        study.test_poses, study.shares, errors, worth.worst_points, strict=True
    ):
        cells = [pose.name, percent(weight) if weight else "judged only", length(error)]
        if worst is not None:
            cells += [length(worst.rho0), f"point {worst.name} of {len(pose.regressors)}"]
        elif paths:
            cells += ["", ""]
        rows.append(Row(tuple(cells), _share(error / largest)))
    heads = ("Test pose", "Weight", "Position error", *(("Worst", "Where") if paths else ()))
    return BarTable(heads, tuple(rows))


def joint_value(value: float, kind: JointKind) -> str:
    """A joint value [rad or m] as people read it, without its unit."""
    return fixed(kind.scale * value, kind.decimals)


def _share(value: float) -> float:
    return float(np.clip(value, 0.0, 1.0)) if np.isfinite(value) else 1.0


test_pose_errors.__test__ = False  # type: ignore[attr-defined]
