"""How a virtual robot under absolute readings is unlike its drawing, as its model file says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.files.models.model_file import ModelFile, read_through
from elastocal.files.models.true_frames import displaced
from elastocal.files.yaml_lines import at
from elastocal.robot.chain import Robot

TRUE_COMPENSATORS = "true_compensators_N_per_mm"
"""The key of how stiff the compensators of a virtual robot are."""


def true_frames_in(path: str | Path, robot: Robot) -> Array | None:
    """(n + F + 1, 4, 4) where frames of a virtual robot are in those that are drawn [m].

    None if the file does not say.

    Raises:
        ModelFileError: not a model file, or not the frames of this robot; names line and key.
    """

    def frames(file: ModelFile, _: dict[str, Any]) -> Array | None:
        with at("true_frames"):
            return None if file.true_frames is None else displaced(file.true_frames, robot)

    return read_through(Path(path), frames)


def true_compensators_in(path: str | Path, names: list[str]) -> dict[str, float] | None:
    """How stiff the compensators of a virtual robot are [N/m], by name; None if it does not say.

    Raises:
        ModelFileError: not a model file, or not the compensators called so; names line and key.
    """

    def stiffness(file: ModelFile, _: dict[str, Any]) -> dict[str, float] | None:
        given = file.true_compensators_N_per_mm
        if given is None:
            return None
        with at(TRUE_COMPENSATORS):
            if set(given) != set(names):
                odd = sorted(set(given) ^ set(names))[0]
                wanted = ", ".join(names) or "none"
                raise InputError(
                    f"expected the compensators of the study, {wanted}; odd is {odd!r}"
                )
            return {name: 1e3 * size for name, size in given.items()}

    return read_through(Path(path), stiffness)
