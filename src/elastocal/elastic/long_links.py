"""Long links: which joints of an arm carry one, told by the distances between its axes."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture

_LONG = 0.5  # share of the longest link from which on a link is long
_PARALLEL = 1e-6  # sine of the angle between axes


def long_links(robot: Robot) -> BoolArray:
    """(n,) which joints carry a long link: upper arm and forearm of most arms.

    Sliding joints carry none: what lies beyond them is not known to turn.
    """
    lengths = link_lengths(robot)
    return np.asarray((lengths > 0.0) & (lengths >= _LONG * lengths.max(initial=0.0)))


def link_lengths(robot: Robot) -> Array:
    """(n,) length of the link that each turning joint carries [m]; zero for the last one.

    It is the distance to the next axis, and the way along that one to where the link after it
    begins: a forearm may turn about itself. Neither depends on the configuration.

    Source: ours; the lengths a and d of Denavit and Hartenberg, that of the wrist left out.
    """
    m, found = robot.last, np.zeros(len(robot.joints))
    posture = Posture(robot, np.zeros((1, len(robot.joints))))
    z, o = posture.all_axes[:, :m, 0].T, posture.all_origins[:, :m, 0].T
    sliding = robot.sliding[:m]
    for joint, i in enumerate(robot.place.tolist()):
        if i + 1 >= m or sliding[i]:
            continue
        across, here = _normal(z[i], o[i], z[i + 1], o[i + 1])
        along = 0.0
        if i + 2 < m and here is not None and not sliding[i + 1]:
            _, there = _normal(z[i + 2], o[i + 2], z[i + 1], o[i + 1])
            along = 0.0 if there is None else abs(there - here)
        found[joint] = np.hypot(across, along)
    return found


def _normal(z: Array, o: Array, other: Array, at: Array) -> tuple[float, float | None]:
    """Distance of two lines, and where on the other one it is; None where they are parallel."""
    normal, between = np.cross(z, other), at - o
    size = float(np.linalg.norm(normal))
    if size < _PARALLEL:
        return float(np.linalg.norm(between - (between @ z) * z)), None
    place = float(np.cross(between, z) @ normal) / size**2
    return abs(float(between @ normal)) / size, place
