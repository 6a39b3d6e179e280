"""True compensators: how stiff springs are that hold weight, and the energy that is in them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.regressor import Regressor
from elastocal.elastic.springs import joint_springs
from elastocal.robot.compensators import Compensator
from elastocal.robot.posture import Posture
from elastocal.study.absolute import AbsoluteStudy

_HOLDS = 0.5  # of the largest moment of the weights, at the largest lever
_DRAWN = 500  # random configurations


def energy(
    compensator: Compensator, stiffness: float, values: Array | NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """(N,) energy in a compensator at joint values (N,), which may be complex [J].

    Source: the distance of its ends, as points of a plane.
    """
    turned = compensator.crank * np.array([np.cos(values), np.sin(values)])
    angle = compensator.angle + np.pi  # in line, on opposite sides
    standing = compensator.reach * np.array([np.cos(angle), np.sin(angle)])
    apart = turned - standing[:, None]
    length = np.sqrt((apart * apart).sum(axis=0))
    return np.asarray(0.5 * stiffness * (length - compensator.rest) ** 2, dtype=np.complex128)


def drawn_stiffness(study: AbsoluteStudy, rng: np.random.Generator) -> dict[str, float]:
    """Stiffness of every compensator [N/m]: about what holds half of the weight at its joint."""
    robot, found = study.robot, {}
    limits = np.array([robot.lower, robot.upper])
    limits = np.where(np.isfinite(limits), limits, [[-np.pi], [np.pi]])
    q = rng.uniform(limits[0], limits[1], (_DRAWN, len(robot.joints)))
    load = study.payloads[0] if study.payloads else None
    arm = ElasticArm(robot, joint_springs(robot), study.tool, study.gravity, load, weighs=True)
    moments = Regressor(arm, Posture(robot, q), np.zeros((_DRAWN, 6))).generalised_force
    for one in study.compensators:
        moment = float(np.abs(moments[one.joint]).max())
        lever = max(float(np.abs(one.lever(q[:, one.joint])).max()), 1e-9)
        found[one.name] = _HOLDS * moment / lever * float(rng.uniform(0.7, 1.3))
    return found
