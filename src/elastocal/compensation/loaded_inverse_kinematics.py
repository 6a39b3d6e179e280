"""Loaded inverse kinematics: the joints of an arm that holds its tool at a target while it bends.

The springs of actuated joints do not matter to the search: wherever they are bent to, the joints
are what they are. Their displacement is taken off afterwards.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.equilibrium import Equilibrium, efforts, equilibrium
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import subset
from elastocal.robot.damped_steps import damped_steps
from elastocal.robot.posture import Posture, jacobian
from elastocal.robot.rotations import rotation_vectors

_MOST_STEPS = 50
_AT_REST = 1e-12  # joint step at which the search has come to rest [rad or m]
_LONGEST = 10.0  # joint step beyond which it is lost [rad or m]


class Bent(NamedTuple):
    """Where the search for the bent arm ended."""

    bent: Array
    """(N, n) actuated joints with their springs bent."""
    displacement: Array
    """(N, p') displacements of the springs that are in no joint."""
    at_rest: BoolArray
    iterations: IntArray
    damped: BoolArray
    lost: Array
    """(N, 6) unit twist that the joints cannot give to the tool where damped."""


def loaded_arm_at(
    arm: ElasticArm, compliance: Array, cases: LoadCases, target: Array, start: Array
) -> tuple[Array, Bent]:
    """Joint values at which the loaded arm has its TCP at targets, exact for any deflection.

    Args:
        arm: Elastic arm with p springs.
        compliance: (p,) their compliances.
        cases: N load cases, of which the wrenches count.
        target: (N, 4, 4) poses of the TCP, axes of the flange [m].
        start: (N, n) joints with their springs bent, near those looked for.

    Returns:
        (N, n) joint values, and where the search for the bent arm ended.

    Source: paper eq. (14); the split into joint springs and others is ours.
    """
    own = arm.springs.joint >= 0
    others = [name for name, is_own in zip(arm.springs.names, own, strict=True) if not is_own]
    frame = replace(arm, springs=subset(arm.springs, others))
    found = bent_arm(frame, compliance[~own], LoadCases(start, cases.wrench), target)
    displacement = np.zeros((len(cases), len(arm.springs)))
    displacement[:, ~own] = found.displacement
    effort = efforts(arm, found.bent, cases.wrench, displacement)
    q = found.bent.copy()
    q[:, arm.springs.joint[own]] -= (compliance * effort)[:, own]
    return q, found


def bent_arm(frame: ElasticArm, compliance: Array, start: LoadCases, target: Array) -> Bent:
    """Joints at which the arm with springs only in links and base holds its TCP at the target.

    A nearly singular arm may never get there: then where it came nearest.
    """
    count, rows = len(start), task_rows(frame)
    bent, displacement = start.q.copy(), np.zeros((count, len(frame.springs)))
    nearest, least = (bent.copy(), displacement.copy()), np.full(count, np.inf)
    at_rest, damped = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    iterations, lost = np.zeros(count, dtype=np.int64), np.zeros((count, 6))
    open_ = np.arange(count)
    for _ in range(_MOST_STEPS):
        if not len(open_):
            break
        rest = equilibrium(frame, compliance, LoadCases(bent[open_], start.wrench[open_]))
        displacement[open_[rest.stable]] = rest.displacement[rest.stable]
        open_ = open_[rest.stable]
        columns = jacobian(
            frame.chain, frame.bent(bent[open_], displacement[open_]), frame.tool.tcp
        )
        pose = tcp_poses(frame, bent[open_], displacement[open_])
        error = _twists(pose, target[open_])[:, :rows]
        steps = damped_steps(columns[:, :rows, frame.actuated], error, frame.robot.prismatic)
        largest = np.abs(error).max(axis=1)
        nearer = open_[largest < least[open_]]
        nearest[0][nearer], nearest[1][nearer] = bent[nearer], displacement[nearer]
        least[open_] = np.minimum(least[open_], largest)
        # At the target no step is needed, singular or not.
        hindered = steps.damped & (largest > _AT_REST)
        damped[open_[hindered]], lost[open_[hindered]] = True, steps.lost[hindered]
        size = np.abs(steps.step).max(axis=1)
        done = size <= _AT_REST
        at_rest[open_[done]] = True
        bent[open_[~done]] += steps.step[~done]
        iterations[open_[~done]] += 1
        open_ = open_[~done & (size < _LONGEST)]
    open_ = open_[damped[open_]]
    bent[open_], displacement[open_] = nearest[0][open_], nearest[1][open_]
    at_rest[open_] = True
    return Bent(bent, displacement, at_rest, iterations, damped, lost)


def task_rows(arm: ElasticArm) -> int:
    """Rows of the tool's pose that are restored: all six, or position with few joints."""
    return 6 if len(arm.robot.joints) >= 6 else 3


def stable(rest: Equilibrium) -> Array:
    """(N, p) displacements, NaN where there is no stable equilibrium."""
    return np.asarray(np.where(rest.stable[:, None], rest.displacement, np.nan))


def tcp_poses(arm: ElasticArm, q: Array, displacement: Array) -> Array:
    """(N, 4, 4) pose of the TCP, axes of the flange, with springs bent by (N, p) [m]."""
    posture = Posture(arm.chain, arm.bent(q, displacement))
    poses = np.zeros((len(q), 4, 4))
    poses[:, :3, :] = posture.bodies[-1].transpose(2, 1, 0)
    poses[:, :3, 3] = posture.point(arm.tool.tcp).T
    poses[:, 3, 3] = 1.0
    return poses


def _twists(pose: Array, target: Array) -> Array:
    """(N, 6) displacement and turn [m, rad] that take poses to targets, in the base frame."""
    turn = rotation_vectors(target[:, :3, :3] @ pose[:, :3, :3].transpose(0, 2, 1))
    return np.hstack([target[:, :3, 3] - pose[:, :3, 3], turn])
