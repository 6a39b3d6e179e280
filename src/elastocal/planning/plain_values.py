"""Simplification: the same load cases with plainer joint values and loads.

In: a space and load cases of it. Out: load cases of the same information and margins, which
joints are free, and which is free together with the load.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.one_side import from_one_side
from elastocal.planning.symmetry import same_worth
from elastocal.study.experiment_space import LoadCaseSpace


class Plain(NamedTuple):
    """Load cases made plain."""

    cases: LoadCases
    free: tuple[str, ...]  # joints that change nothing: the user may set them as the cell requires
    turns_with_load: str  # joint that changes nothing if the load turns along; empty: none does


def simplify(space: LoadCaseSpace, cases: LoadCases) -> Plain:
    """The same experiments with plainer joint values, and with loads from one side.

    Whole turns are taken out where the limits allow, and joints that change neither information
    nor margins are put to their rest position. Where the same is true of a joint that turns
    together with the load, all loads come from one side.
    """
    robot, plain = space.arm.robot, without_whole_turns(space, cases)
    lower, upper = space.limits
    free = []
    for j, joint in enumerate(robot.joints):
        if lower[j] == upper[j]:
            continue  # held: nobody may set it
        rest = float(np.clip(0.0, lower[j], upper[j]))
        trial, other = (np.array(plain.q) for _ in range(2))
        trial[:, j] = rest
        other[:, j] = 0.6 * rest + 0.4 * upper[j]
        moved = [LoadCases(at, cases.wrench) for at in (trial, other)]
        if all(same_worth(space, plain, at, j) for at in moved):
            plain = moved[0]
            free.append(joint.name)
    turned, turns_with_load = from_one_side(space, plain, tuple(free))
    return Plain(turned, tuple(free), turns_with_load)


def without_whole_turns(space: LoadCaseSpace, cases: LoadCases) -> LoadCases:
    """The same load cases with whole turns of joints taken out where the limits allow."""
    q = np.array(cases.q)
    lower, upper = space.limits
    for j, joint in enumerate(space.arm.robot.joints):
        if not joint.prismatic:
            near = q[:, j] - 2.0 * np.pi * np.round(q[:, j] / (2.0 * np.pi))
            inside = (near >= lower[j]) & (near <= upper[j])
            q[:, j] = np.where(inside, near, q[:, j])
    return LoadCases(q, cases.wrench)
