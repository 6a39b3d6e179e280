"""Via points in plan files: configurations that the robot passes without stopping."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.errors import PlanFileError
from elastocal.files.plans.load_case_entries import (
    ConfigurationFile,
    configuration_at,
    configuration_entry,
    section_at,
)
from elastocal.robot.chain import Robot

VIA = "via"
"""What stands for the number of a configuration in plan.csv where none is measured."""
_MOST = 10_000


class ViaFile(ConfigurationFile):
    """A configuration on the way to a load case, or home."""

    to: Any = None


def via_document(robot: Robot, via: Sequence[Array]) -> dict[str, Any]:
    """The key `via` of plan.json; nothing if the plan needs none."""
    entries = []
    for leg, points in enumerate(via):
        for q in points:
            to = leg + 1 if leg < len(via) - 1 else "home"
            entries.append({"to": to, **configuration_entry(robot, q)})
    return {"via": entries} if entries else {}


def read_via(entries: Any, robot: Robot, count: int, where: str) -> tuple[Array, ...]:
    """Via points of a plan with `count` load cases; empty if there are none.

    Raises:
        PlanFileError: names the entry.
    """
    if not isinstance(entries, list) or len(entries) > _MOST:
        raise PlanFileError(f"{where}: via must be a list of at most {_MOST} configurations")
    q, legs = [], []
    for i, entry in enumerate(entries):
        here = f"{where}, via {i + 1}"
        section = section_at(ViaFile, entry, here)
        leg = count if section.to == "home" else _whole(section.to) - 1
        if not 0 <= leg < count and section.to != "home":
            raise PlanFileError(
                f"{here}: 'to' must be home or a load case from 1 to {count}, found {section.to!r}"
            )
        q.append(configuration_at(section, robot, here))
        legs.append(leg)
    order = np.argsort(legs, kind="stable")
    points = np.array(q).reshape(-1, len(robot.joints))
    return split_via(points[order], np.array(legs, dtype=np.int64)[order], count)


def split_via(points: Array, legs: IntArray, count: int) -> tuple[Array, ...]:
    """Points (K, n) by leg, 0 to `count`; empty if there are none."""
    if not len(points):
        return ()
    return tuple(points[legs == leg] for leg in range(count + 1))


def _whole(value: Any) -> int:
    return value if isinstance(value, int) and not isinstance(value, bool) else 0
