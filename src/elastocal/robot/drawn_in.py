"""Frames of a chain drawn in: as near to the arm as their axes allow."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray

_FAR_OUT = 2.0  # a chain this many times as long as the shortest runs out and back


def drawn_in(links: Array, turning: BoolArray) -> tuple[Array, Array]:
    """The links with their frames moved along the axes where they run far out and back, the shifts.

    Any point of an axis serves as origin. Where two axes are almost parallel, as calibrated tables
    have them, the foot of their common normal is hundreds of metres away; a robot is not.

    Source: ours; the origins of least squared distance between neighbours, a linear problem since
    every distance is fixed to one body.
    """
    n = len(turning)
    ends, pulls = links[:, :3, 3], np.zeros((n + 1, 3, n))
    for i in range(n):
        pulls[i, :, i], pulls[i + 1, 2, i] = links[i, :3, 2], -1.0
    some = pulls[:, :, turning].reshape(3 * n + 3, -1)
    shifts = np.zeros(n)
    shifts[turning] = np.linalg.lstsq(some, -ends.ravel(), rcond=None)[0]
    drawn_in = ends + pulls @ shifts
    if _length(ends) <= _FAR_OUT * _length(drawn_in):
        return links, np.zeros(n)
    moved = links.copy()
    moved[:, :3, 3] = drawn_in
    return moved, shifts


def _length(steps: Array) -> float:
    """Sum of the lengths of (K, 3) steps [m]."""
    return float(np.linalg.norm(steps, axis=1).sum())
