"""Visibility: which marker the tracker sees in which configuration, and what is in the way.

In: a space with a laser tracker, configurations. Out: a value for tables; the constraints
themselves are in `constraints/view.py` and `constraints/line_of_sight.py`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray, freeze
from elastocal.constraints import AcceptanceCone
from elastocal.constraints.view import ViewConstraint
from elastocal.measuring.instrument import tracker_of
from elastocal.planning.assessment import TOLERANCE
from elastocal.robot.posture import Posture
from elastocal.study.experiment_space import LoadCaseSpace


@dataclass(frozen=True)
class Visibility:
    """K markers in N configurations, as a tracker sees them.

    Attributes:
        markers: K names.
        seen: (K, N) whether every constraint on the beam holds.
        range: (K, N) length of the beam [m].
        incidence: (K, N) angle between the axis of the reflector and the beam [rad]; NaN for a
            marker without axis.
        broken: K lists of N names of what is broken worst; empty where the marker is seen.
    """

    markers: tuple[str, ...]
    seen: BoolArray
    range: Array
    incidence: Array
    broken: tuple[tuple[str, ...], ...]

    def __post_init__(self) -> None:
        freeze(self, "seen", dtype=np.bool_)
        freeze(self, "range", "incidence")


def visibility(space: LoadCaseSpace, q: Array) -> Visibility | None:
    """What a tracker sees in N configurations (N, n); None if the instrument is no tracker."""
    tracker, tool = tracker_of(space.instrument), space.arm.tool
    if tracker is None:
        return None
    posture = Posture(space.arm.robot, q)
    shape = len(tool.markers), posture.count
    seen, angle = np.ones(shape, dtype=bool), np.full(shape, np.nan)
    length = np.array(
        [
            np.linalg.norm(posture.point(marker) - tracker.position[:, None], axis=0)
            for marker in tool.markers
        ]
    ).reshape(shape)
    broken = []
    for k, marker in enumerate(tool.marker_names):
        worst, names = np.full(posture.count, -TOLERANCE), [""] * posture.count
        for constraint in space.constraints:
            if not isinstance(constraint, ViewConstraint) or constraint.marker != marker:
                continue
            room = constraint.room(posture)
            if isinstance(constraint, AcceptanceCone):
                angle[k] = constraint.limit - room
            called = constraint.names_at(posture) if (room < worst).any() else names
            names = [
                c if r < w else n for c, r, w, n in zip(called, room, worst, names, strict=True)
            ]
            worst = np.minimum(worst, room)
        seen[k] = worst >= -TOLERANCE
        broken.append(tuple(names))
    return Visibility(tool.marker_names, seen, length, angle, tuple(broken))
