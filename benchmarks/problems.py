"""The problems of the races: an arm, what is unknown, how many experiments.

Collision and floor are off in all of them, since no baseline has them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import kr270
import numpy as np

from elastocal.constraints import Clearance
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.springs import VirtualJoints, joint_springs
from elastocal.files.study.study_file import read_study
from elastocal.robot.chain import Robot
from elastocal.study.study import Study, test_pose, with_count

HERE = Path(__file__).parent
EXAMPLES = HERE.parent / "examples"

BEST_KNOWN = {
    "KR 270": kr270.BEST_KNOWN,
    "18 unknowns": {12: 1.84209},
    "42 unknowns": {12: 1.97087},
}
"""Smallest rho0 known [1e-3 mm], by problem and number of experiments."""

GIVE = {False: 3e-7, True: 3e-8}
"""What is known beforehand of a bearing: standard error [rad/(N·m), m/N if it slides]."""


@dataclass(frozen=True)
class Problem:
    """What is raced on.

    Attributes:
        name: What tables call it.
        study: The study, with its number of experiments.
        held: How many of the first design variables cannot matter and stay at zero: 1 where
            turning the first joint turns arm and load together.
        cap: Processor seconds that a baseline gets.
    """

    name: str
    study: Study
    held: int
    cap: float

    @property
    def best_known(self) -> float:
        """Smallest rho0 on record [1e-3 mm]; infinite if there is none."""
        return BEST_KNOWN.get(self.name, {}).get(self.study.experiments.count, np.inf)


def problems(scale: float = 1.0) -> list[Problem]:
    """All of them; `scale` stretches what baselines get."""
    three = read_study(EXAMPLES / "three-link" / "study.yaml")
    seven = without_clearances(read_study(EXAMPLES / "robots" / "arm-7r" / "study.yaml"))
    eighteen = read_study(HERE / "eighteen.yaml")
    return [
        *(Problem("three links", with_count(three, m), 1, 3.0 * scale) for m in (3, 12)),
        *(Problem("KR 270", kr270.study(m), 1, 5.0 * scale) for m in (2, 3, 4, 6, 12)),
        Problem("seven axes", with_count(seven, 12), 1, 8.0 * scale),
        Problem("18 unknowns", eighteen, 0, 12.0 * scale),
        Problem("42 unknowns", bearings(eighteen, 6), 0, 20.0 * scale),
    ]


def without_clearances(study: Study) -> Study:
    """The study with nothing watched for collisions."""
    kept = tuple(c for c in study.constraints if not isinstance(c, Clearance))
    return replace(study, constraints=kept)


def bearings(study: Study, joints: int) -> Study:
    """The study with six twists at each of so many joints as unknowns besides all compliances.

    Three slide and three turn, so that one of them is the compliance once more: only what is known
    of bearings beforehand tells them apart. 42 unknowns with 6 joints of 6.
    """
    springs = springs_with_bearings(study.robot, joints)
    task = study.test_poses[0]
    assert task.tool is not None
    assert task.case is not None
    arm = ElasticArm(study.robot, springs, task.tool)
    information = [
        0.0 if joint >= 0 else GIVE[slides] ** -2
        for joint, slides in zip(springs.joint.tolist(), springs.prismatic.tolist(), strict=True)
    ]
    return replace(
        study,
        springs=springs,
        test_poses=(test_pose(arm, task.case, 1.0, task.name),),
        prior=np.diag(information),
        experiments=replace(study.experiments, max_configurations=None),
    )


def springs_with_bearings(robot: Robot, joints: int) -> VirtualJoints:
    """All joint springs, and of the first joints six twists each in front of them."""
    own = joint_springs(robot)
    rows: list[tuple[str, int, np.ndarray, np.ndarray, bool, int]] = []
    for i, name in enumerate(own.names):
        body = int(own.body[i])
        frame = robot.links[body]
        for slides in (True, False) if i < joints else ():
            for k, axis in enumerate("xyz"):
                what = f"{name} {'along' if slides else 'about'} {axis}"
                rows.append((what, body, frame[:3, k], frame[:3, 3], slides, -1))
        rows.append((name, body, own.axis[i], own.origin[i], bool(own.prismatic[i]), i))
    names, body, axis, origin, slides, joint = zip(*rows, strict=True)
    return VirtualJoints(
        names, np.array(body), np.array(axis), np.array(origin), np.array(slides), np.array(joint)
    )
