"""What looks odd in absolute readings beside the arm: said, never guessed at or corrected."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.errors import Doubt
from elastocal.files.measurements.orientations import CONVENTIONS, from_angles
from elastocal.measuring.joint_torques import torque_check
from elastocal.measuring.misplacement import FITS, beside_arm
from elastocal.measuring.positions import Positions
from elastocal.measuring.turn_misfit import turn_misfit
from elastocal.robot.posture import forward_kinematics
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.study.absolute import AbsoluteStudy

_POSES = 100
_ODD = np.radians(0.5)
"""What no arm is off by, from pose to pose [rad, root mean square]."""
_GAIN = 5.0  # times as well another convention has to fit
INVERSE = "inverse"


def with_arm(found: Positions, study: AbsoluteStudy, angles: Array, convention: str) -> Positions:
    """The readings with how far they are from the arm, and what does not belong to it.

    Args:
        found: The readings.
        study: The arm as drawn.
        angles: (T, 3) angles as they were read, of the orientations in order; none if others.
        convention: What they were taken for.
    """
    apart, doubts = beside_arm(found, study.robot, study.coupling)
    turned = list(_turned(found, study, angles, convention)) if found.rotations.any() else []
    if apart > FITS:  # then joints do not belong, and orientations cannot
        turned = [doubt for doubt in turned if doubt.because]
    compared = torque_check(found, study.robot, study.gravity, study.payloads)
    torques = [] if compared is None else [compared.doubt]
    return replace(found, apart=apart, doubts=(*found.doubts, *doubts, *turned, *torques))


def _turned(
    found: Positions, study: AbsoluteStudy, angles: Array, convention: str
) -> Iterator[Doubt]:
    """Orientations that do not turn as the arm does, and the convention by which they would."""
    turns = np.flatnonzero(found.rotations)
    mine: BoolArray = found.station[turns] == found.station[turns[0]]
    chosen = np.flatnonzero(mine)[:_POSES]
    q = found.cases.q[found.case[turns[chosen]]]
    flange = forward_kinematics(study.robot, q)[:, :3, :3]
    read = from_rotation_vectors(found.value[turns[chosen]])
    now = turn_misfit(flange, read)
    if not now > _ODD:
        return
    others = {INVERSE: turn_misfit(flange, read.transpose(0, 2, 1))}
    for other in CONVENTIONS if len(angles) == len(turns) else ():
        if other != convention:
            turned = from_rotation_vectors(from_angles(angles[chosen], other))
            others[other] = turn_misfit(flange, turned)
    signs = {}
    for i, joint in enumerate(study.robot.joints):
        opposite = forward_kinematics(study.robot, q * (1.0 - 2.0 * np.eye(q.shape[1])[i]))
        signs[joint.name] = turn_misfit(opposite[:, :3, :3], read)
    best = min(others, key=lambda name: others[name])
    sign = min(signs, key=lambda name: signs[name])
    if _GAIN * others[best] < now and others[best] <= signs[sign]:
        numbers = {"off": now, "mended": others[best]}
        yield Doubt("probe-turned", (), (best,), numbers)
    elif _GAIN * signs[sign] < now:
        yield Doubt("probe-turned", (sign,), (), {"off": now, "mended": signs[sign]})
    else:
        yield Doubt("probe-turned", numbers={"off": now})
