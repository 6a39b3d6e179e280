"""Numbers and poses as words of a URDF: every digit there is, so that they come back the same."""

from __future__ import annotations

from collections.abc import Iterable
from xml.sax.saxutils import quoteattr

import numpy as np

from elastocal.arrays import Array

_NOTHING = 1e-17  # m, rad


def element(tag: str, **attributes: object) -> str:
    """An element of nothing but attributes."""
    return f"<{tag}{_written(attributes)}/>"


def opened(tag: str, **attributes: object) -> str:
    """The tag with which an element begins."""
    return f"<{tag}{_written(attributes)}>"


def _written(attributes: dict[str, object]) -> str:
    return "".join(f" {key}={quoteattr(str(value))}" for key, value in attributes.items())


def words_of(values: Iterable[float]) -> str:
    """Numbers with spaces between, each the shortest that reads as it is."""
    return " ".join(repr(float(v) + 0.0) for v in values)


def pose_words(T: Array) -> dict[str, str]:
    """`xyz` and `rpy` of a pose (4, 4) [m, rad]; what is below all rounding is zero."""
    numbers = np.array([*T[:3, 3], *roll_pitch_yaw(T[:3, :3])])
    numbers[np.abs(numbers) < _NOTHING] = 0.0
    return {"xyz": words_of(numbers[:3]), "rpy": words_of(numbers[3:])}


def roll_pitch_yaw(rotation: Array) -> tuple[float, float, float]:
    """Angles with rotation = Rot_z(yaw) Rot_y(pitch) Rot_x(roll), exact also where it is upright.

    Source: specification of URDF; that the roll is taken of what the yaw leaves is ours: near a
    pitch of 90° each of both is ill determined, what they do together is not.
    """
    yaw = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
    c, s = np.cos(yaw), np.sin(yaw)
    rest = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ rotation
    roll = float(np.arctan2(-rest[1, 2], rest[1, 1]))
    pitch = float(np.arctan2(-rest[2, 0], rest[0, 0]))
    return roll, pitch, yaw
