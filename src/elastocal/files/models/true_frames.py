"""How the frames of a virtual robot stand in its drawing, as a section of a model."""

from __future__ import annotations

from typing import Any

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.files.sections import Section
from elastocal.files.values import MillimetreVector, Vector
from elastocal.robot.chain import Robot
from elastocal.robot.rotations import from_rotation_vectors, rotation_vectors

FLANGE = "flange"
_FARTHEST = 0.1  # m, rad


class TrueFrameFile(Section):
    """A shift and a turn, in the frame as drawn."""

    shift_mm: MillimetreVector
    turn_mrad: Vector


def displaced(frames: dict[str, TrueFrameFile], robot: Robot) -> Array:
    """(n + F + 1, 4, 4) where frames are in those that are drawn [m].

    Raises:
        InputError: not the frames of this robot, or farther off than an arm can be.
    """
    wanted = _names(robot)
    if set(frames) != set(wanted):
        odd = sorted(set(frames) ^ set(wanted))[0]
        raise InputError(f"expected one frame for each of {', '.join(wanted)}; found odd {odd!r}")
    found = np.tile(np.eye(4), (len(wanted), 1, 1))
    for i, name in enumerate(wanted):
        shift, turn = np.array(frames[name].shift_mm), 1e-3 * np.array(frames[name].turn_mrad)
        if max(np.abs(shift).max(), np.abs(turn).max()) > _FARTHEST:
            raise InputError(
                f"{name}: expected a frame at most 100 mm and 100 mrad from where it is drawn"
            )
        found[i, :3, :3], found[i, :3, 3] = from_rotation_vectors(turn[None])[0], shift
    return found


def true_frames_section(moved: Array, robot: Robot) -> dict[str, Any]:
    """The section of frames (n + F + 1, 4, 4)."""
    turns = 1e3 * rotation_vectors(moved[:, :3, :3])
    shifts = 1e3 * moved[:, :3, 3]
    return {
        name: {"shift_mm": shift, "turn_mrad": turn}
        for name, shift, turn in zip(_names(robot), shifts.tolist(), turns.tolist(), strict=True)
    }


def _names(robot: Robot) -> list[str]:
    """Of the joints that move, then the flange."""
    return [*(joint.name for joint in robot.moving), FLANGE]
