"""Simplification: the same load cases with plainer joint values.

In: a study and load cases. Out: load cases of the same information and margins, and which joints
are free.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import JointLimit
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.assessment import load_case_information, margins
from elastocal.study.study import Study


def simplify(study: Study, cases: LoadCases) -> tuple[LoadCases, tuple[str, ...]]:
    """The same experiments with plainer joint values.

    Whole turns are taken out where the limits allow, and joints that change neither information
    nor margins are put to their rest position: the user may set them as the cell requires.

    Returns:
        The load cases, and the names of the joints that are free.
    """
    robot, q = study.robot, np.array(cases.q)
    lower, upper = study.limits
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
        if _same(study, q, trial, cases.wrench, j) and _same(study, q, other, cases.wrench, j):
            q = trial
            free.append(joint.name)
    return LoadCases(q, cases.wrench), tuple(free)


def _same(study: Study, q: Array, other: Array, wrench: Array, joint: int) -> bool:
    """Whether two sets of configurations differ in nothing but the margins of one joint."""
    before, after = LoadCases(q, wrench), LoadCases(other, wrench)
    informations = load_case_information(study, before)
    change = np.abs(load_case_information(study, after) - informations).max()
    constraints, room_before = margins(study, before)
    _, room_after = margins(study, after)
    moved = np.abs(room_after - room_before)
    own = [isinstance(c, JointLimit) and c.joint == joint for c in constraints]
    moved[own] = 0.0
    return bool(change <= 1e-9 * np.abs(informations).max() and moved.max() <= 1e-9)
