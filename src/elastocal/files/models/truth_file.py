"""Truth files: a model file that is true of a virtual robot, with how its loads are wrong."""

from __future__ import annotations

from pathlib import Path

from elastocal.files.models.model_file import read_model, true_loads_in
from elastocal.files.models.true_loads import true_loads_section
from elastocal.files.models.writing import write_model
from elastocal.robot.chain import Robot
from elastocal.simulation.true_robot import TrueRobot


def write_truth(true: TrueRobot, path: str | Path, robot: Robot) -> None:
    """Write a model file, with the section `true_loads` if anything is said of these."""
    loads = {} if true.loads is None else {"true_loads": true_loads_section(true.loads)}
    write_model(true.model, path, robot, sections=loads)


def read_truth(path: str | Path, robot: Robot) -> TrueRobot:
    """What a file says is true; of what errs anew it says nothing.

    Raises:
        ModelFileError: not a model file, or not of this robot; names line and key.
    """
    return TrueRobot(read_model(path, robot), true_loads_in(path))
