"""The example robots in the language of every controller that can hold them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.constraints import Clearance
from elastocal.errors import InputError
from elastocal.programs.campaign_program import campaign_program
from elastocal.programs.robot_program import RobotProgram
from elastocal.programs.writers import WRITERS, Settings, export
from tests.programs.writers.campaigns import DIGEST, EXAMPLES
from tests.programs.writers.test_exports import check

STUDIES = sorted((EXAMPLES / "robots").glob("*/study.yaml"))
CANNOT = {  # which of the others cannot hold the robot, and why
    "arm-7r": ({"krl", "rapid", "fanuc", "urscript"}, "7 joints in its arm"),
    "gantry-5": ({"urscript"}, "sliding"),
    "rail-arm": ({"urscript"}, "external"),
    "scara-700": ({"urscript"}, "sliding"),
}


def program_of(path: Path) -> tuple[RobotProgram, Settings]:
    study = ec.read_study(path)  # the way between random configurations is not always free
    free = tuple(c for c in study.constraints if not isinstance(c, Clearance))
    study = replace(study, constraints=free)
    rng = np.random.default_rng(7)
    cases = study.space.load_cases(study.space.sample(3, rng))
    program = campaign_program(study, cases, np.array([1, 2, 1]), digest=DIGEST)
    return program, Settings(coupling=study.controller)


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.parent.name)
def test_example_robots(path: Path) -> None:
    program, settings = program_of(path)
    cannot, why = CANNOT.get(path.parent.name, (set(), ""))
    for controller in WRITERS:
        if controller in cannot:
            with pytest.raises(InputError, match=why):
                export(program, controller, settings)
        else:
            check(program, controller, settings)


def test_there_are_example_robots() -> None:
    assert len(STUDIES) >= 6
    assert set(CANNOT) <= {path.parent.name for path in STUDIES}
