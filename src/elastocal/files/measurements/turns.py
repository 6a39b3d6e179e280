"""Joint values that differ by whole turns: where the arm is, they are the same.

In: joint values as a controller shows them. Out: the rows of one experiment beside each other, and
values within the limits of the robot. A gearbox may know the difference; what bends does not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.measuring.measurements import Measurements
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot
from elastocal.wording.lists import experiments

_Read = TypeVar("_Read", Measurements, Positions)
_TURN = 2.0 * np.pi
_ROUNDING = 1e-9  # rad


def side_by_side(values: Array, codes: IntArray, robot: Robot) -> Array:
    """(R, n) joint values less the whole turns by which they are from the first of their group.

    Args:
        values: (R, n) joint values [rad or m].
        codes: (R,) group of every row.
        robot: Whose joints they are.
    """
    if alike(values, codes):
        return values
    first = values[first_rows(codes, int(codes.max(initial=-1)) + 1)[codes]]
    turns = np.round((values - first) / _TURN)
    turns[:, [joint.prismatic for joint in robot.joints]] = 0.0
    return np.asarray(values - _TURN * turns) if turns.any() else values


def first_rows(codes: IntArray, count: int) -> IntArray:
    """(count,) first row of each group, -1 of one without rows; `codes`, (R,), say which is whose.

    Without sorting, so that it takes no longer than to read them.
    """
    first = np.full(count, -1, dtype=np.int64)
    first[codes[::-1]] = np.arange(len(codes) - 1, -1, -1)  # what is written last stays
    return first


def alike(values: Array, codes: IntArray) -> bool:
    """Whether neighbours in a group have the same (R, k) values, and no group comes back."""
    same = codes[1:] == codes[:-1]
    if (np.diff(codes) < 0).any():
        return False
    return all(bool((~same | (v[1:] == v[:-1])).all()) for v in values.T)


def within_limits(found: _Read, robot: Robot) -> _Read:
    """The same readings, where a joint that is shown a whole turn outside its limits is inside.

    What is outside by less, or by more than a turn, stays as it is.
    """
    q = np.array(found.cases.q)
    for j, joint in enumerate(robot.joints):
        if not joint.prismatic:
            lower, upper = joint.lower - _ROUNDING, joint.upper + _ROUNDING
            turned = q[:, j] + _TURN * ((q[:, j] < lower) * 1.0 - (q[:, j] > upper) * 1.0)
            inside = (turned >= lower) & (turned <= upper)
            q[inside, j] = turned[inside]
    if np.array_equal(q, found.cases.q):
        return found
    said: tuple[str, ...] = tuple(_said(found, q, robot))
    cases = replace(found.cases, q=q)
    return replace(found, cases=cases, remarks=(*found.remarks, *said))


def _said(found: Measurements | Positions, q: Array, robot: Robot) -> Iterator[str]:
    for j, joint in enumerate(robot.joints):
        moved = np.flatnonzero(q[:, j] != found.cases.q[:, j])
        if len(moved):
            names = [found.names[i] for i in moved]
            shown, taken = (np.degrees(values[moved[0], j]) for values in (found.cases.q, q))
            yield (
                f"{experiments(names)}: {joint.name} is shown a whole turn outside its limits and "
                f"taken as inside, {shown:.6g}° as {taken:.6g}°"
            )
