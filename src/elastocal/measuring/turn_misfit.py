"""How well orientations of a probe fit to the turns of an arm, whatever the frames of both."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.robot.rotations import rotation_vectors

_HALF = np.radians(170.0)
"""Turns beyond it are left out: near half a turn the axis may be its opposite."""


def turn_misfit(flange: Array, turned: Array) -> float:
    """Root mean square of what is left of turns from pose to pose after the best rotation [rad].

    With T = B F C for fixed B and C, T' Tᵀ is F' Fᵀ turned by B: their vectors differ by B alone.

    Args:
        flange: (N, 3, 3) orientations of the flange in the base frame.
        turned: (N, 3, 3) orientations of the probe as read by one station.

    Returns:
        NaN with fewer than three turns.

    Source: Park & Martin, IEEE Trans. Robotics and Automation 10 (1994) 717, for B alone.
    """
    own = rotation_vectors(turned[1:] @ turned[:-1].transpose(0, 2, 1))
    wanted = rotation_vectors(flange[1:] @ flange[:-1].transpose(0, 2, 1))
    size = np.maximum(np.linalg.norm(own, axis=1), np.linalg.norm(wanted, axis=1))
    own, wanted = own[size < _HALF], wanted[size < _HALF]
    if len(own) < 3:
        return float("nan")
    left, _, right = np.linalg.svd(wanted.T @ own)
    rotation = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    return float(np.sqrt(np.mean(np.sum((own @ rotation.T - wanted) ** 2, axis=1))))
