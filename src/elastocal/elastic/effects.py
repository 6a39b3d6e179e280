"""Effects: what gives way in an arm besides its joints, as unknowns at the right place.

In: a robot, a standard uncertainty of each effect. Out: unknowns with priors. Nobody writes an
axis: foot, tilt of a joint and tool say where they are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, BoolArray, freeze
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.long_links import long_links
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import VirtualJoints, joint_springs, subset
from elastocal.elastic.unknowns import Unknowns, each_spring, joined
from elastocal.errors import InputError
from elastocal.robot.chain import Robot, T_body_joint, Tool

FOOT_TURNING, FOOT_SLIDING, TOOL_SLIDING = "foot turning", "foot sliding", "tool sliding"
"""Names of effects; the tilt of a joint is called as `tilt_of` says."""


def tilt_of(joint: str) -> str:
    """Name of the effect that a joint gives way across its axis."""
    return f"tilt {joint}"


class Size(NamedTuple):
    """How large an effect is: standard uncertainty [rad/(N·m) or m/N], and where it is from."""

    deviation: float
    source: str


@dataclass(frozen=True)
class Effects:
    """Unknowns with priors that are centred on zero.

    Attributes:
        unknowns: The u unknowns.
        deviation: (u,) prior standard uncertainties [rad/(N·m) or m/N].
        signed: (u,) which of them may be below zero.
        source: u sentences: where the size of each is from.
    """

    unknowns: Unknowns
    deviation: Array
    signed: BoolArray
    source: tuple[str, ...]

    def __post_init__(self) -> None:
        freeze(self, "deviation")
        freeze(self, "signed", dtype=np.bool_)


def effects_of(robot: Robot, sizes: Mapping[str, Size]) -> Effects:
    """The effects called so, each of its size; those of size zero are left out.

    A bearing or a foot tilts alike in every direction: one unknown, two springs. What lies between
    long links does not: a symmetric tensor across the axis, three unknowns of which the third, n12,
    has a prior 1/√2 as wide, so that nothing depends on which two axes are chosen. What has the
    same columns in every configuration is one unknown.

    Args:
        robot: The robot.
        sizes: Sizes by the names of the effects.

    Raises:
        InputError: there is no such effect; a joint that slides, or follows, cannot tilt.

    Source: ours.
    """
    found = [_effect(robot, name, size) for name, size in sizes.items() if size.deviation > 0.0]
    if not found:
        none = np.zeros(0)
        return Effects(each_spring(joint_springs(robot, ())), none, none > 0.0, ())
    return _merged(
        robot,
        Effects(
            reduce(joined, (one.unknowns for one in found)),
            np.concatenate([one.deviation for one in found]),
            np.concatenate([one.signed for one in found]),
            sum((one.source for one in found), ()),
        ),
    )


def besides(robot: Robot, effects: Effects, springs: VirtualJoints) -> Effects:
    """The effects without those that some of `springs` already are, alone or together.

    An effect that is identified is no nuisance: its columns are combinations of theirs in every
    configuration, as far as random ones and random loads tell. Nor is what couples it to another
    axis: who identifies a spring about an axis says that the axis is one of the tensor's own.
    """
    kept = _others(robot, effects.unknowns, springs, effects.signed)
    return Effects(
        _part(effects.unknowns, kept, [effects.unknowns.names[u] for u in kept]),
        effects.deviation[kept],
        effects.signed[kept],
        tuple(effects.source[u] for u in kept),
    )


def without(robot: Robot, nuisance: Nuisance, springs: VirtualJoints) -> Nuisance:
    """The nuisance without what some of `springs` already are, as those of an earlier campaign."""
    kept = _others(robot, nuisance.unknowns, springs, nuisance.signed)
    if len(kept) == len(nuisance.unknowns):
        return nuisance
    return replace(
        nuisance,
        unknowns=_part(nuisance.unknowns, kept, [nuisance.names[u] for u in kept]),
        mean=nuisance.mean[kept],
        deviation=nuisance.deviation[kept],
        signed=nuisance.signed[kept],
        source=tuple(nuisance.source[u] for u in kept),
    )


def _others(
    robot: Robot, unknowns: Unknowns, springs: VirtualJoints, signed: BoolArray
) -> list[int]:
    """Positions of the unknowns that no combination of `springs` is, nor couples anything that is.

    What couples two axes, `signed` (u,), is nothing without both.
    """
    there, columns = _columns(robot, each_spring(springs)), _columns(robot, unknowns)
    left = columns - there @ np.linalg.lstsq(there, columns, rcond=None)[0]
    size, rest = (np.linalg.norm(table, axis=0) for table in (columns, left))
    gone: BoolArray = np.atleast_1d(rest <= _COMBINED * size)
    halved = signed & _coupled(unknowns)[:, gone].any(axis=1)
    return np.flatnonzero(~gone & ~halved).tolist()


def _coupled(unknowns: Unknowns) -> BoolArray:
    """(u, u) which unknowns make some spring together: those of one tensor."""
    made = (unknowns.make != 0.0).astype(np.int64)
    return np.asarray(made.T @ made > 0, dtype=np.bool_)


def _effect(robot: Robot, name: str, size: Size) -> Effects:
    tilting = {tilt_of(joint): j for j, joint in enumerate(robot.joint_names)}
    if name == FOOT_TURNING:
        springs = _springs(name, "xy", 0, np.eye(3)[:2], np.zeros(3))
        return _priors(Unknowns((name,), springs, np.ones((2, 1))), size)
    if name == FOOT_SLIDING:
        return _sliding(name, 0, np.eye(4), size)
    if name == TOOL_SLIDING:
        return _sliding(name, robot.last, robot.links[-1], size)
    if name not in tilting:
        known = ", ".join((FOOT_TURNING, FOOT_SLIDING, TOOL_SLIDING, *tilting))
        raise InputError(f"there is no effect {name!r}; there are {known}")
    joint = tilting[name]
    if robot.prismatic[joint]:
        raise InputError(f"joint {robot.joint_names[joint]!r} slides: its tilt is not modelled")
    body = int(robot.place[joint]) + 1
    origin = T_body_joint(robot, body)[:3, 3]
    if not long_links(robot)[joint]:
        springs = _springs(name, "xy", body, np.eye(3)[:2], origin)
        return _priors(Unknowns((name,), springs, np.ones((2, 1))), size)
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [np.sqrt(0.5), np.sqrt(0.5), 0.0]])
    springs = _springs(name, ("x", "y", "between"), body, axes, origin)
    # Compliances n1 - n12, n2 - n12 and 2 n12 about these axes add up to the tensor of the three.
    make = np.array([[1.0, 0.0, -1.0], [0.0, 1.0, -1.0], [0.0, 0.0, 2.0]])
    names = (f"{name} x", f"{name} y", f"{name} xy")
    return _priors(Unknowns(names, springs, make), size, np.array([1.0, 1.0, np.sqrt(0.5)]))


def _springs(
    name: str,
    ends: Sequence[str],
    body: int,
    axes: Array,
    origin: Array,
    *,
    slides: bool = False,
) -> VirtualJoints:
    count = len(ends)
    return VirtualJoints(
        tuple(f"{name} about {end}" if not slides else f"{name} {end}" for end in ends),
        np.full(count, body),
        axes,
        np.tile(origin, (count, 1)),
        np.full(count, slides),
    )


def _sliding(name: str, body: int, frame: Array, size: Size) -> Effects:
    """Along each axis of a frame (4, 4) in a body."""
    springs = _springs(name, "xyz", body, frame[:3, :3].T, frame[:3, 3], slides=True)
    return _priors(Unknowns(springs.names, springs, np.eye(3)), size)


def _priors(unknowns: Unknowns, size: Size, shares: Array | None = None) -> Effects:
    count = len(unknowns)
    shares = np.ones(count) if shares is None else shares
    signed = shares < 1.0  # what couples two axes
    return Effects(unknowns, size.deviation * shares, signed, (size.source,) * count)


_SAME = 1e-10  # of the square of an angle between columns
_COMBINED = 1e-6  # share of a column that is rounding
_CASES = 40  # random load cases


def _merged(robot: Robot, effects: Effects) -> Effects:
    """Unknowns that no experiment tells apart as one: their variances add up.

    They are found at random configurations and loads. Springs of the first of them stay.
    """
    columns = _columns(robot, effects.unknowns)
    length = np.linalg.norm(columns, axis=0)
    unit = columns / np.where(length > 0.0, length, 1.0)
    kept: list[int] = []
    tensor = np.any(_coupled(effects.unknowns)[:, effects.signed], axis=1)  # stays whole
    names = list(effects.unknowns.names)
    source, variance = list(effects.source), effects.deviation**2
    for u in range(len(names)):
        same = [v for v in kept if unit[:, u] @ unit[:, v] > 1.0 - _SAME]
        if not same or tensor[u]:
            kept.append(u)
            continue
        first = same[0]
        variance[first] += variance[u] * (length[u] / length[first]) ** 2
        names[first] += f" and {names[u]}"
        source[first] += f"; {source[u]}"
    return Effects(
        _part(effects.unknowns, kept, [names[u] for u in kept]),
        np.sqrt(variance[kept]),
        effects.signed[kept],
        tuple(source[u] for u in kept),
    )


def _part(unknowns: Unknowns, kept: list[int], names: list[str]) -> Unknowns:
    """Some of the unknowns, under other names, with the springs they make."""
    make = unknowns.make[:, kept]
    used = np.flatnonzero(make.any(axis=1))
    left = subset(unknowns.springs, [unknowns.springs.names[s] for s in used])
    return Unknowns(tuple(names), left, make[used])


def _columns(robot: Robot, unknowns: Unknowns) -> Array:
    """(R, u) columns at a few random configurations and loads."""
    rng = np.random.default_rng(0)
    point = rng.uniform(-0.5, 0.5, 3)
    tool = Tool("any", point, point[None], ("M",), rotation=True)
    q = rng.uniform(-2.0, 2.0, (_CASES, len(robot.joints)))
    cases = LoadCases(q, rng.normal(size=(_CASES, 6)))
    rows = regressor(ElasticArm(robot, unknowns.springs, tool), cases)
    return unknowns.columns(rows).reshape(rows.shape[0] * rows.shape[1], len(unknowns))
