"""The best fit of points that were read and points as they should be: a rotation and a shift.

In: the same points in two frames. Out: where one frame stands in the other, how far the points
are then apart, and how certain the rotation is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.errors import InputError

_ON_A_LINE = 1e-4
"""Extent across a line, relative to that along it, below which no turn about it is seen."""
_APART = 1e-6  # m; points nearer than this are one


@dataclass(frozen=True)
class BestFit:
    """Nominal points are about `rotation` @ points + `shift`.

    Attributes:
        rotation: (3, 3) from the frame of the points to that of the nominal ones.
        shift: (3,) where the origin of the first frame is in the second [m].
        rms: Root mean square distance that is left [m].
    """

    rotation: Array
    shift: Array
    rms: float

    def __post_init__(self) -> None:
        freeze(self, "rotation", "shift")

    def applied(self, points: Array) -> Array:
        """(..., 3) points in the frame of the nominal ones [m]."""
        return np.asarray(points @ self.rotation.T + self.shift)


def best_fit(points: Array, nominal: Array) -> BestFit:
    """The rotation and the shift after which points are nearest to nominal ones; scale is 1.

    Args:
        points: (N, 3) as they were read [m].
        nominal: (N, 3) the same points as they should be [m].

    Raises:
        InputError: fewer than three distinct points, or all on a line.

    Source: Kabsch, Acta Crystallographica A32 (1976) 922, by singular values.
    """
    points, nominal = np.asarray(points, dtype=float), np.asarray(nominal, dtype=float)
    for found in (points, nominal):
        if wrong := unseen_turn(found):
            raise InputError(f"a best fit needs three points that are not on a line; found {wrong}")
    rotation, shift, rms = best_fits(points, nominal[None])
    return BestFit(rotation[0], shift[0], float(rms[0]))


def best_fits(points: Array, nominal: Array) -> tuple[Array, Array, Array]:
    """Rotations (V, 3, 3), shifts (V, 3) and what is left (V,) [m] for V sets of nominal points.

    Args:
        points: (N, 3) as they were read, or (V, N, 3) [m].
        nominal: (V, N, 3) as they should be [m]; nothing is refused.
    """
    middle, wanted = points.mean(axis=-2, keepdims=True), nominal.mean(axis=-2, keepdims=True)
    own, other = points - middle, nominal - wanted
    left, _, right = np.linalg.svd(np.swapaxes(other, -1, -2) @ own)
    left[..., -1] *= np.sign(np.linalg.det(left @ right))[..., None]  # a rotation, no reflection
    rotation = left @ right
    apart = own @ np.swapaxes(rotation, -1, -2) - other
    shift = wanted[..., 0, :] - np.einsum("...ij,...j->...i", rotation, middle[..., 0, :])
    return rotation, shift, np.sqrt(np.mean(np.sum(apart**2, axis=-1), axis=-1))


def unseen_turn(points: Array) -> str:
    """Why points (N, 3) leave a turn open, empty if they do not."""
    apart = points - points.mean(axis=0)
    *_, across, along = np.linalg.eigvalsh(apart.T @ apart) if len(points) else (0.0, 0.0)
    if across > max(_ON_A_LINE**2 * along, 1e-14):
        return ""
    distinct = len(np.unique(np.round(points / _APART), axis=0))
    if distinct < 3:
        return f"{distinct} distinct point{'s' if distinct != 1 else ''}"
    return f"{distinct} points on one line"


def turn_errors(fit: BestFit, points: Array, nominal: Array, group: IntArray) -> Array:
    """(3, 3) covariance of the rotation, as a small turn in the nominal frame [rad²].

    What is left after the fit is what errs, by one vector for all points of a group, as all markers
    are off together in one configuration: so few groups are little evidence.

    Args:
        fit: The best fit.
        points: (N, 3) points [m].
        nominal: (N, 3) nominal ones [m].
        group: (N,) group of each point.

    Source: ours; normal equations of a small turn with errors that groups share, their variance
    from the residuals with two vectors, shift and turn, less than there are groups.
    """
    there = fit.applied(points)
    arm = there - there.mean(axis=0)
    normal = _about(arm)
    used, number = np.unique(group, return_inverse=True)
    sums = np.stack([np.bincount(np.reshape(number, -1), arm[:, k]) for k in range(3)], axis=1)
    apart = np.mean(np.sum((there - nominal) ** 2, axis=1)) / 3.0
    variance = apart * len(used) / max(len(used) - 2.0, 0.5)
    inverse = np.linalg.inv(normal)
    return np.asarray(variance * inverse @ _about(np.asarray(sums, dtype=float)) @ inverse)


def _about(arm: Array) -> Array:
    """(3, 3) sum of |a|² - a aᵀ over arms (N, 3): what turns move, squared."""
    return np.asarray(np.sum(arm**2) * np.eye(3) - arm.T @ arm)
