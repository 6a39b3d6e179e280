"""Known poses: positions read off at the robot, against those of the model.

In: robot, coupling, two or more joint readings of the controller with the position it shows. Out:
how far the model is off and, if it is, which mistake of convention explains it best: a joint that
counts the other way, a zero elsewhere, a coupled joint, millimetres. It costs a user five minutes
and finds what would spoil a campaign.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.errors import InputError
from elastocal.robot.chain import Robot
from elastocal.robot.controller_axes import Coupling
from elastocal.robot.posture import Posture

FITS = 5e-3
"""Deviation [m] up to which a model fits. Real arms are off by up to some mm; a mistake of
convention moves them by centimetres and more."""


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
        for key in ("shown", "position", "point"):
            object.__setattr__(self, key, frozen(getattr(self, key)))


@dataclass(frozen=True)
class PoseCheck:
    """How well the model fits known poses.

    Attributes:
        deviations: (K, 3) position of the model minus the one shown [m].
        explanations: Mistakes that explain the deviations, the likeliest first; empty if it fits.
        left_over: Largest deviation after the first explanation [m].
        untold: Joints whose sign these poses do not tell.
    """

    deviations: Array
    explanations: tuple[str, ...]
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


def check_known_poses(robot: Robot, table: Coupling, poses: Sequence[KnownPose]) -> PoseCheck:
    """Compare the model with poses read off at the robot.

    Raises:
        InputError: fewer than two poses, or all with the same joint values.
    """
    refuse_too_few(poses)
    shown = np.array([pose.shown for pose in poses])
    deviations = _deviations(robot, table.to_model(shown), poses)
    largest = _largest(deviations)
    untold = tuple(
        name
        for i, name in enumerate(robot.joint_names)
        if _largest(_deviations(robot, _Parts.of(table).turned(i).to_model(shown), poses))
        <= max(FITS, largest)
    )
    if largest <= FITS:
        return PoseCheck(frozen(deviations), (), largest, untold)
    found = sorted(_attempts(robot, table, poses, shown), key=lambda attempt: attempt[0])
    best = found[0][0]
    near = [words for off, words in found if off <= max(FITS, 1.001 * best)] if best <= FITS else []
    return PoseCheck(frozen(deviations), tuple(near[:3]), best, untold)


def refuse_too_few(poses: Sequence[KnownPose]) -> None:
    """Raise unless there are at least two poses with different joint values.

    Raises:
        InputError: there are not.
    """
    if len(poses) < 2:
        raise InputError(f"check_poses needs at least two poses, found {len(poses)}")
    if not np.ptp([pose.shown for pose in poses], axis=0).any():
        raise InputError("check_poses have the same joint values; they must differ")


@dataclass(frozen=True)
class _Parts:
    """A coupling taken apart: (1 + K)(S q + o)."""

    names: tuple[str, ...]
    signs: Array
    offsets: Array
    mixing: Array

    @staticmethod
    def of(table: Coupling) -> _Parts:
        signs = np.where(np.diag(table.matrix) < 0.0, -1.0, 1.0)
        mixing: Array = table.matrix * signs
        offsets: Array = np.linalg.solve(mixing, table.offset).astype(float)
        return _Parts(table.joint_names, signs, offsets, mixing)

    def to_model(self, shown: Array) -> Array:
        own = np.linalg.solve(self.mixing, shown.T).T
        return np.asarray((own - self.offsets) * self.signs)

    def turned(self, i: int) -> _Parts:
        signs = self.signs.copy()
        signs[i] = -signs[i]
        return _Parts(self.names, signs, self.offsets, self.mixing)

    def moved(self, i: int, by: float) -> _Parts:
        offsets = self.offsets.copy()
        offsets[i] += by
        return _Parts(self.names, self.signs, offsets, self.mixing)

    def coupled(self, i: int, j: int, by: float) -> _Parts:
        mixing = self.mixing.copy()
        mixing[i, j] += by
        return _Parts(self.names, self.signs, self.offsets, mixing)


_Change = tuple[str, "tuple[str, int, int, float]"]


def _attempts(
    robot: Robot, table: Coupling, poses: Sequence[KnownPose], shown: Array
) -> Iterator[tuple[float, str]]:
    """(largest deviation [m], what was assumed), one mistake at a time; two if one is too few."""
    parts = _Parts.of(table)
    changes = _changes(robot, parts)

    def off(*made: _Change, values: Array = shown, scale: float = 1.0) -> Array:
        altered = parts
        for _, (kind, i, j, by) in made:
            if kind == "sign":
                altered = altered.turned(i)
            elif kind == "zero":
                altered = altered.moved(i, by)
            else:
                altered = altered.coupled(i, j, by)
        return _deviations(robot, altered.to_model(values), poses, scale)

    singles = [(_largest(off(change)), change[0]) for change in changes]
    singles.append((_largest(off(values=np.degrees(shown))), "the joint values are in radians"))
    for scale, words in (
        (1e3, "the positions are in metres, not in millimetres"),
        (25.4, "the positions are in inches"),
    ):
        singles.append((_largest(off(scale=scale)), words))
    plain = off()
    shift = -plain.mean(axis=0)
    shifted = f"its base frame is elsewhere, by [{' '.join(f'{1e3 * v:.1f}' for v in shift)}] mm"
    singles.append((_largest(plain + shift), shifted))
    yield from singles
    if min(singles)[0] <= FITS:
        return
    for change in changes:
        left = off(change)
        yield _largest(left - left.mean(axis=0)), f"{change[0]}; besides, its base is elsewhere"
    for a, b in combinations(changes, 2):
        if a[1][:2] != b[1][:2]:
            yield _largest(off(a, b)), f"{a[0]}; and {b[0]}"


def _changes(robot: Robot, parts: _Parts) -> list[_Change]:
    """Mistakes of convention, each with the key that mends it."""
    found: list[_Change] = []
    names = parts.names
    for i, joint in enumerate(robot.joints):
        sign = -int(parts.signs[i])
        words = f"{joint.name} counts the other way (signs: {{{joint.name}: {sign}}})"
        found.append((words, ("sign", i, i, 0.0)))
        if joint.prismatic:
            continue
        for degrees in (90.0, -90.0, 180.0):
            zero = np.degrees(parts.offsets[i]) + degrees
            words = (
                f"the zero of {joint.name} is {abs(degrees):g}° elsewhere "
                f"(offsets_deg: {{{joint.name}: {zero:g}}})"
            )
            found.append((words, ("zero", i, i, np.radians(degrees))))
    turning = np.flatnonzero(~robot.prismatic)
    for j, i in zip(turning[:-1].tolist(), turning[1:].tolist(), strict=True):
        for by in (1.0, -1.0):
            factor = float(parts.mixing[i, j] + by)
            words = (
                f"{names[i]} is coupled to {names[j]} "
                f"(couple: {{{names[i]}: {{{names[j]}: {factor:g}}}}})"
            )
            if factor == 0.0:
                words = f"{names[i]} is not coupled to {names[j]}"
            found.append((words, ("couple", i, j, by)))
    return found


def _deviations(robot: Robot, q: Array, poses: Sequence[KnownPose], scale: float = 1.0) -> Array:
    """(K, 3) position of the model minus the one shown [m]."""
    posture = Posture(robot, q)
    return np.array(
        [posture.point(p.point)[:, i] - scale * p.position for i, p in enumerate(poses)]
    )


def _largest(deviations: Array) -> float:
    return float(np.linalg.norm(deviations, axis=1).max())
