"""Springs of an arm: virtual joints, each a unit twist carried by one body of the chain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, freeze, frozen
from elastocal.errors import InputError
from elastocal.robot.chain import Robot
from elastocal.robot.compensators import LeverShare
from elastocal.robot.joint_kinds import JointKind, kind_of


@dataclass(frozen=True)
class VirtualJoints:
    """p unit twists, each carried by one body of the chain.

    Attributes:
        names: p names.
        body: (p,) number of the body of the chain that carries the twist: 0 is the base.
        axis: (p, 3) axis in the frame of that body.
        origin: (p, 3) point on the axis in the frame of that body [m].
        prismatic: (p,) True for a linear spring [m/N], False for an angular one [rad/(N·m)].
        joint: (p,) actuated joint whose axis the twist shares, -1 where it shares none.
        stiff: (p,) True for a displacement that no load makes, as an error of the geometry: its
            column is v_j alone, not v_j y_j.
        only: (p,) the one marker that it moves, -1 where it moves all.
        by: p compensators whose lever is in the column of such a displacement, None where there is
            none: it is what the compensator turns its joint at the largest lever.
    """

    names: tuple[str, ...]
    body: IntArray
    axis: Array
    origin: Array
    prismatic: BoolArray
    joint: IntArray = field(default_factory=lambda: frozen([], np.int64))
    stiff: BoolArray = field(default_factory=lambda: frozen([], np.bool_))
    only: IntArray = field(default_factory=lambda: frozen([], np.int64))
    by: tuple[LeverShare | None, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "body", dtype=np.int64)
        if np.any(np.diff(self.body) < 0):
            raise InputError("virtual joints must be given in chain order, base first")
        freeze(self, "axis", "origin")
        freeze(self, "prismatic", dtype=np.bool_)
        joint = self.joint if np.size(self.joint) else np.full(len(self.names), -1)
        freeze(self, joint=joint, dtype=np.int64)
        stiff = self.stiff if np.size(self.stiff) else np.zeros(len(self.names))
        freeze(self, stiff=stiff, dtype=np.bool_)
        only = self.only if np.size(self.only) else np.full(len(self.names), -1)
        freeze(self, only=only, dtype=np.int64)
        if not self.by:
            object.__setattr__(self, "by", (None,) * len(self.names))

    @property
    def kinds(self) -> tuple[JointKind, ...]:
        """What goes with each spring: names and units."""
        return tuple(kind_of(slides) for slides in self.prismatic.tolist())

    @property
    def units(self) -> tuple[str, ...]:
        """SI unit of each unknown: of a compliance, or of a displacement that no load makes."""
        pairs = zip(self.kinds, self.stiff.tolist(), strict=True)
        return tuple(kind.unit if stiff else kind.compliance for kind, stiff in pairs)

    @property
    def of_joints(self) -> tuple[str, ...]:
        """Names of those that sit in joints."""
        return tuple(n for n, joint in zip(self.names, self.joint, strict=True) if joint >= 0)

    def __len__(self) -> int:
        return len(self.names)


def joint_springs(robot: Robot, names: Sequence[str] | None = None) -> VirtualJoints:
    """Springs in the actuated joints called `names` (all joints if None), in chain order.

    Raises:
        InputError: a name is not a joint of the robot.
    """
    wanted = sorted(robot.index(robot.joint_names if names is None else names))
    return VirtualJoints(
        names=tuple(robot.joint_names[i] for i in wanted),
        body=robot.place[wanted],
        axis=robot.links[robot.place[wanted], :3, 2],
        origin=robot.links[robot.place[wanted], :3, 3],
        prismatic=robot.prismatic[wanted],
        joint=np.array(wanted),
    )


def merged(first: VirtualJoints, second: VirtualJoints) -> VirtualJoints:
    """The springs of both, in chain order.

    Raises:
        InputError: a name is in both.
    """
    twice = sorted(set(first.names) & set(second.names))
    if twice:
        raise InputError(f"spring {twice[0]!r} is given twice")
    body, joint = np.append(first.body, second.body), np.append(first.joint, second.joint)
    order = np.lexsort((joint >= 0, body))  # on one body the springs of no joint come first
    names = (*first.names, *second.names)
    return VirtualJoints(
        names=tuple(names[i] for i in order),
        body=body[order],
        axis=np.concatenate([first.axis, second.axis])[order],
        origin=np.concatenate([first.origin, second.origin])[order],
        prismatic=np.append(first.prismatic, second.prismatic)[order],
        joint=joint[order],
        stiff=np.append(first.stiff, second.stiff)[order],
        only=np.append(first.only, second.only)[order],
        by=tuple((*first.by, *second.by)[i] for i in order),
    )


def subset(springs: VirtualJoints, names: Sequence[str]) -> VirtualJoints:
    """Those of `springs` whose names are in `names`, in chain order."""
    kept = [i for i, name in enumerate(springs.names) if name in names]
    return VirtualJoints(
        names=tuple(springs.names[i] for i in kept),
        body=springs.body[kept],
        axis=springs.axis[kept],
        origin=springs.origin[kept],
        prismatic=springs.prismatic[kept],
        joint=springs.joint[kept],
        stiff=springs.stiff[kept],
        only=springs.only[kept],
        by=tuple(springs.by[i] for i in kept),
    )
