"""Known poses: positions read off at the robot, against those of the model.

In: robot, coupling, two or more joint readings of the controller with the position it shows. Out:
how far the model is off and, if it is, which mistake of convention explains it best: a joint that
counts the other way, a zero elsewhere, a coupled joint, millimetres. It costs a user five minutes
and finds what would spoil a campaign.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain, combinations
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, freeze, frozen
from elastocal.errors import Doubt, InputError
from elastocal.robot.chain import Robot
from elastocal.robot.controller_axes import Coupling
from elastocal.robot.conventions import Convention, conventions
from elastocal.robot.posture import Posture
from elastocal.wording.poses import misfit

FITS = 5e-3
"""Deviation [m] up to which a model fits. Real arms are off by up to some mm; a mistake of
convention moves them by centimetres and more."""

_QUARTER = 0.5 * np.pi  # zeros are elsewhere by quarters of a turn [rad]


@dataclass(frozen=True)
class KnownPose:
    """Joint values and a position, both as the controller shows them.

    Attributes:
        name: What the user calls it.
        shown: (n,) joint values of the controller [rad or m].
        position: (3,) position shown, in the base frame [m].
        point: (3,) whose position it is, in the flange frame [m].
    """

    name: str
    shown: Array
    position: Array
    point: Array = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        freeze(self, "shown", "position", "point")


@dataclass(frozen=True)
class PoseCheck:
    """How well the model fits known poses.

    Attributes:
        deviations: (K, 3) position of the model minus the one shown [m].
        explanations: Mistakes that explain the deviations, the likeliest first, each alone or
            some made together, as few as explain them; empty if it fits.
        left_over: Largest deviation after the first explanation [m].
        untold: Joints whose sign these poses do not tell: with the other one the model is at the
            same places. Asked of a model that fits alone; others may hide it.
    """

    deviations: Array
    explanations: tuple[tuple[Doubt, ...], ...]
    left_over: float
    untold: tuple[str, ...]

    @property
    def largest(self) -> float:
        """Largest distance between model and controller [m]."""
        return float(np.linalg.norm(self.deviations, axis=1).max())

    @property
    def fits(self) -> bool:
        """Whether the model is that of the controller."""
        return self.largest <= FITS

    @property
    def doubt(self) -> Doubt:
        """How far off the model is, and how far if the likeliest mistake is mended."""
        return Doubt("poses-differ", numbers={"off": self.largest, "mended": self.left_over})


def check_known_poses(robot: Robot, table: Coupling, poses: Sequence[KnownPose]) -> PoseCheck:
    """Compare the model with poses read off at the robot.

    Raises:
        InputError: fewer than two poses, or all with the same joint values.
    """
    refuse_too_few(poses)
    shown = np.array([pose.shown for pose in poses])
    assumed = Convention.of(table)
    deviations = _deviations(robot, assumed.to_model(shown), poses)
    largest = _largest(deviations)
    if largest <= FITS:
        untold = _untold(robot, assumed, poses, shown)
        return PoseCheck(frozen(deviations), (), largest, untold)
    found = sorted(_attempts(robot, table, poses, shown), key=lambda attempt: attempt[0])
    best = found[0][0]
    near = [mistakes for off, mistakes in found if off <= max(FITS, 1.001 * best)]
    fewest = min(map(len, near))
    explanations = [mistakes for mistakes in near if len(mistakes) == fewest]
    return PoseCheck(frozen(deviations), tuple(explanations[:3]) if best <= FITS else (), best, ())


def _untold(
    robot: Robot, assumed: Convention, poses: Sequence[KnownPose], shown: Array
) -> tuple[str, ...]:
    """Joints whose sign alters nothing by more than what fits."""
    each = [assumed, *(assumed.turned([i]) for i in range(len(assumed.names)))]
    now, *others = _places(robot, [c.to_model(shown) for c in each], poses)
    moved = [_largest(other - now) for other in others]
    return tuple(name for name, by in zip(assumed.names, moved, strict=True) if by <= FITS)


def refuse_misfit(found: PoseCheck) -> None:
    """Raise unless the model is that of the controller.

    Raises:
        InputError: it is not; names the mistakes that would explain it.
    """
    if not found.fits:
        raise InputError(misfit(found.doubt, found.explanations)).with_doubts(
            found.doubt, *chain.from_iterable(found.explanations)
        )


def refuse_too_few(poses: Sequence[KnownPose]) -> None:
    """Raise unless there are at least two poses with different joint values.

    Raises:
        InputError: there are not.
    """
    if len(poses) < 2:
        raise InputError(f"check_poses needs at least two poses, found {len(poses)}")
    if not np.ptp([pose.shown for pose in poses], axis=0).any():
        raise InputError("check_poses have the same joint values; they must differ")


class _Change(NamedTuple):
    """A mistake of convention, and how it alters a coupling."""

    mistake: Doubt
    kind: str
    joints: tuple[int, int]
    by: float

    def of(self, parts: Convention) -> Convention:
        i, j = self.joints
        if self.kind == "sign":
            return parts.turned([i])
        if self.kind == "zero":
            return parts.moved(i, self.by)
        return parts.coupled(i, j, self.by)


def _attempts(
    robot: Robot, table: Coupling, poses: Sequence[KnownPose], shown: Array
) -> Iterator[tuple[float, tuple[Doubt, ...]]]:
    """(largest deviation [m], what was assumed): one mistake at a time; all signs and couplings
    together, and any two, if one is too few."""
    parts = Convention.of(table)
    changes = _changes(robot, parts)

    def off(*made: _Change, values: Array = shown, scale: float = 1.0) -> Array:
        altered = parts
        for change in made:
            altered = change.of(altered)
        return _deviations(robot, altered.to_model(values), poses, scale)

    singles = [(_largest(off(change)), (change.mistake,)) for change in changes]
    singles += [
        (_largest(off(values=np.degrees(shown))), (Doubt("in-radians"),)),
        (_largest(off(scale=1e3)), (Doubt("in-metres"),)),
        (_largest(off(scale=25.4)), (Doubt("in-inches"),)),
    ]
    plain = off()
    shift = -plain.mean(axis=0)
    numbers = dict(zip("xyz", shift.tolist(), strict=True))
    singles.append((_largest(plain + shift), (Doubt("base-elsewhere", numbers=numbers),)))
    yield from singles
    if min(size for size, _ in singles) <= FITS:
        return
    for change in changes:
        left = off(change)
        yield _largest(left - left.mean(axis=0)), (change.mistake, Doubt("base-elsewhere"))
    all_of_them = list(conventions(robot, parts, range(len(parts.names))))
    places = _places(robot, [c.to_model(shown) for c in all_of_them], poses)
    told = np.array([pose.position for pose in poses])
    for other, place in zip(all_of_them, places, strict=True):
        left, mistakes = place - told, other.mistakes(parts)
        if mistakes:
            yield _largest(left), mistakes
            yield _largest(left - left.mean(axis=0)), (*mistakes, Doubt("base-elsewhere"))
    for a, b in combinations(changes, 2):
        if (a.kind, a.joints[0]) != (b.kind, b.joints[0]):
            yield _largest(off(a, b)), (a.mistake, b.mistake)


def _changes(robot: Robot, parts: Convention) -> list[_Change]:
    """Mistakes of convention, each with the value that mends it."""
    found: list[_Change] = []
    names = parts.names
    for i, joint in enumerate(robot.joints):
        sign = {"sign": -int(parts.signs[i])}
        mistake = Doubt("counts-other-way", (joint.name,), numbers=sign)
        found.append(_Change(mistake, "sign", (i, i), 0.0))
        if joint.prismatic:
            continue
        for by in (_QUARTER, -_QUARTER, 2.0 * _QUARTER):
            zero = {"by": by, "offset": float(parts.offsets[i]) + by}
            mistake = Doubt("zero-elsewhere", (joint.name,), numbers=zero)
            found.append(_Change(mistake, "zero", (i, i), by))
    turning = np.flatnonzero(~robot.prismatic)
    for j, i in zip(turning[:-1].tolist(), turning[1:].tolist(), strict=True):
        for by in (1.0, -1.0):
            factor = {"factor": float(parts.mixing[i, j]) + by}
            mistake = Doubt("coupled", (names[i], names[j]), numbers=factor)
            found.append(_Change(mistake, "couple", (i, j), by))
    return found


def _deviations(robot: Robot, q: Array, poses: Sequence[KnownPose], scale: float = 1.0) -> Array:
    """(K, 3) position of the model minus the one shown [m]."""
    return _places(robot, [q], poses)[0] - scale * np.array([pose.position for pose in poses])


def _places(robot: Robot, each: Sequence[Array], poses: Sequence[KnownPose]) -> Array:
    """(V, K, 3) where the points of K poses are in configurations (K, n) of V conventions [m]."""
    posture = Posture(robot, np.concatenate(each))
    places = np.array([posture.point(pose.point) for pose in poses])  # (K, 3, V K)
    count = len(poses)
    return np.array([places[i, :, i::count].T for i in range(count)]).transpose(1, 0, 2)


def _largest(deviations: Array) -> float:
    return float(np.linalg.norm(deviations, axis=1).max())
