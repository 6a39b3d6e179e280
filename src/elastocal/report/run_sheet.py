"""Run sheet: what the operator does, in order, with boxes to tick.

In: plan, stage. Out: one card for each configuration.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from elastocal.drawing.picture import portrait
from elastocal.drawing.stage import Stage
from elastocal.planning.plan import Plan
from elastocal.report.tables import joint_value
from elastocal.wording.numbers import direction, fixed, plain, vector


@dataclass(frozen=True)
class Card:
    """One configuration to go to.

    Attributes:
        number: Place in the order of execution, from 1.
        picture: How the robot should look.
        joints: Name, value and unit of every joint.
        loads: Lines about force and torque.
        at: Where the load point is then, in the base frame.
        experiments: Running numbers of the repeats.
        passed: Lines with the joint values to pass without stopping on the way there.
    """

    number: int
    picture: Markup
    joints: tuple[tuple[str, str, str], ...]
    loads: tuple[str, ...]
    at: str
    experiments: tuple[int, ...]
    passed: tuple[str, ...] = ()


def run_sheet(plan: Plan, stage: Stage) -> list[Card]:
    """Cards in the order of execution."""
    robot, cases = plan.study.robot, plan.load_cases
    cards: list[Card] = []
    done = 0
    for i, figure in enumerate(stage.planned):
        repeats = int(plan.repeats[i])
        joints = tuple(
            (joint.name, joint_value(float(value), joint.kind), joint.kind.shown_unit)
            for joint, value in zip(robot.joints, cases.q[i], strict=True)
        )
        cards.append(
            Card(
                number=i + 1,
                picture=portrait(figure, stage),
                joints=joints,
                loads=tuple(_loads(plan, i)),
                at=f"{vector(1e3 * figure.skeleton.load_point, 1)} mm",
                experiments=tuple(range(done + 1, done + repeats + 1)),
                passed=tuple(_passed(plan, i)),
            )
        )
        done += repeats
    return cards


def _passed(plan: Plan, i: int) -> list[str]:
    """Via points before configuration `i`, from 0; the last `i` is the way home."""
    return [
        ", ".join(
            f"{joint.name} {joint_value(float(value), joint.kind)} {joint.kind.shown_unit}"
            for joint, value in zip(plan.study.robot.joints, q, strict=True)
        )
        for q in (plan.via[i] if plan.via else ())
    ]


def way_home(plan: Plan) -> list[str]:
    """Lines with the joint values to pass on the way home."""
    return _passed(plan, len(plan.load_cases))


def _loads(plan: Plan, i: int) -> list[str]:
    """Force and torque of one load case in words."""
    lines = []
    wrench = plan.load_cases.wrench[i]
    for name, part, unit in (("Force", wrench[:3], "N"), ("Torque", wrench[3:], "N·m")):
        size = float(np.linalg.norm(part))
        if size == 0.0:
            continue
        decimals = 0 if np.allclose(part, np.round(part)) else 1
        way = direction(part)
        said = f" {way}" if way and name == "Force" else ""
        lines.append(f"{name} {plain(size)} {unit}{said}: {vector(part, decimals)} {unit}")
    return lines


def tool_points(plan: Plan) -> list[tuple[str, str]]:
    """Load point and markers of the calibration tool, in the flange frame."""
    tool = plan.study.experiments.tool
    points = [("load point", tool.load_point), *zip(tool.marker_names, tool.markers, strict=True)]
    rows = [
        (name, "[" + ", ".join(fixed(1e3 * float(v), 1) for v in point) + "] mm")
        for name, point in points
    ]
    return [*rows, ("rotation", "of the flange is read too")] if tool.rotation else rows
