"""Simplification: the same load cases with plainer joint values.

In: a space and load cases of it. Out: load cases of the same information and margins, and which
joints are free.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import JointLimit, room_at
from elastocal.elastic.load_cases import LoadCases
from elastocal.robot.posture import Posture
from elastocal.study.experiment_space import LoadCaseSpace


def simplify(space: LoadCaseSpace, cases: LoadCases) -> tuple[LoadCases, tuple[str, ...]]:
    """The same experiments with plainer joint values.

    Whole turns are taken out where the limits allow, and joints that change neither information
    nor margins are put to their rest position: the user may set them as the cell requires.

    Returns:
        The load cases, and the names of the joints that are free.
    """
    robot, q = space.arm.robot, np.array(cases.q)
    lower, upper = space.limits
    for j, joint in enumerate(robot.joints):
        if not joint.prismatic:
            near = q[:, j] - 2.0 * np.pi * np.round(q[:, j] / (2.0 * np.pi))
            inside = (near >= lower[j]) & (near <= upper[j])
            q[:, j] = np.where(inside, near, q[:, j])
    free = []
    for j, joint in enumerate(robot.joints):
        rest = float(np.clip(0.0, lower[j], upper[j]))
        trial, other = q.copy(), q.copy()
        trial[:, j] = rest
        other[:, j] = 0.6 * rest + 0.4 * upper[j]
        if _same(space, q, trial, cases.wrench, j) and _same(space, q, other, cases.wrench, j):
            q = trial
            free.append(joint.name)
    return LoadCases(q, cases.wrench), tuple(free)


def _same(space: LoadCaseSpace, q: Array, other: Array, wrench: Array, joint: int) -> bool:
    """Whether two sets of configurations differ in nothing but the margins of one joint."""
    informations = space.information(LoadCases(q, wrench))
    change = np.abs(space.information(LoadCases(other, wrench)) - informations).max()
    others = [c for c in space.constraints if not (isinstance(c, JointLimit) and c.joint == joint)]
    before, after = (room_at(others, Posture(space.arm.robot, at)) for at in (q, other))
    moved = np.abs(after - before).max(initial=0.0)
    return bool(change <= 1e-9 * np.abs(informations).max() and moved <= 1e-9)
