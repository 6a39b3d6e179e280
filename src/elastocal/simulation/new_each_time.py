"""What is new with every load case of a virtual robot, or every approach, drawn by chance.

In: sizes of errors of load cases. Out: compliances of joints that rub, deflections that no model
explains, and where the robot comes back to. Repeats share what their load case has.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.elastic.case_errors import CaseErrors


def rubbed(
    friction: float, compliance: Array, in_joints: BoolArray, count: int, rng: np.random.Generator
) -> Array:
    """(S, c) compliances with which springs (c,) give way in `count` load cases.

    A joint that stops short, or goes too far, by a share of its deflection is one that is as much
    stiffer, or softer; the equilibrium takes it from there.

    Source: ours.
    """
    off = friction * rng.standard_normal((count, len(compliance)))
    return np.asarray(compliance * np.where(in_joints, np.maximum(1.0 + off, 0.0), 1.0))


def unexplained(
    errors: CaseErrors, deflection: Array, places: int, rng: np.random.Generator
) -> Array:
    """(S, T, 3) what no model explains of deflections (S, T, 3): of points, and then of rotations.

    Normal in each coordinate: a share of the deflection, root mean square of the targets of a kind,
    and for points a length besides.

    Args:
        errors: Their sizes.
        deflection: The deflections [m, rad].
        places: How many of the T targets are points.
        rng: Source of chance.

    Source: as `shared_covariance`.
    """
    share, length = rng.standard_normal((2, *deflection.shape))
    length[:, places:] = 0.0
    found = errors.discrepancy_length * length
    size = np.empty(deflection.shape[:2])
    for part in (slice(0, places), slice(places, deflection.shape[1])):
        if part.start < part.stop:
            square = np.sum(deflection[:, part] ** 2, axis=2)
            size[:, part] = np.sqrt(square.mean(axis=1, keepdims=True))
    return np.asarray(found + errors.discrepancy * size[..., None] * share)


def come_back(
    repeatability: float, count: int, targets: int, places: int, rng: np.random.Generator
) -> Array:
    """(N, T, 3) how far points are off because the robot does not come back to where it was [m]."""
    moved = np.zeros((count, targets, 3))
    moved[:, :places] = repeatability * rng.standard_normal((count, 1, 3))
    return moved
