"""Symmetry: whether other load cases are worth the same, whatever is done with them.

In: a space, load cases and others in their place. Out: yes or no.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import JointLimit, room_at
from elastocal.elastic.load_cases import LoadCases
from elastocal.robot.posture import Posture
from elastocal.study.experiment_space import LoadCaseSpace

_SAME = 1e-9  # share of the information; margins [m, rad; share of the largest load]


def same_worth(space: LoadCaseSpace, cases: LoadCases, other: LoadCases, joint: int) -> bool:
    """Whether two sets of load cases differ in nothing but the margins of one joint.

    One by one: the same information, the same room to every constraint, the load as far from
    what is allowed.
    """
    informations = space.information(cases)
    change = np.abs(space.information(other) - informations).max()
    if change > _SAME * np.abs(informations).max():
        return False
    others = [c for c in space.constraints if not (isinstance(c, JointLimit) and c.joint == joint)]
    before, after = (
        np.vstack([room_at(others, Posture(space.arm.robot, at.q)), _load_room(space, at)])
        for at in (cases, other)
    )
    # A clearance that has nothing to be near leaves infinite room before and after.
    less = np.subtract(after, before, out=np.zeros_like(before), where=after != before)
    return bool(np.abs(less).max(initial=0.0) <= _SAME)


def _load_room(space: LoadCaseSpace, cases: LoadCases) -> Array:
    """(4, N) how far force and moment are from what is allowed: share of the largest, rad."""
    return np.array(
        [
            room
            for load, vectors in (
                (space.force, cases.wrench[:, :3]),
                (space.moment, cases.wrench[:, 3:]),
            )
            for room in (load.margin(vectors) / max(load.size, 1.0), load.direction_room(vectors))
        ]
    )
