"""Mistakes by which readings of markers do not fit to an arm, each with the readings mended.

In: readings beside the arm. Out: what may be wrong with them, and what is left if it is mended:
units, joints that count the other way, a zero elsewhere, markers exchanged, single experiments, a
tracker that was bumped.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.errors import Doubt
from elastocal.measuring.best_fit import best_fits
from elastocal.measuring.placement import Unloaded, left_over, residuals, settled
from elastocal.robot.controller_axes import Coupling
from elastocal.robot.conventions import Convention, conventions

_SCALES = (1e3, 1e-3, 25.4, 1.0 / 25.4, 10.0, 0.1)
_FEWEST = 4  # experiments before and after a bump
_SPLITS = 1000  # of many experiments, so many are tried first
_STILL = 5e-5  # m, by which a tracker may drift
_OUTLYING = 16.0  # times the median of the squares


@dataclass(frozen=True)
class Misreading:
    """A mistake, and what is left if it is mended.

    Attributes:
        kind: Which mistake.
        about: Names of joints, markers or experiments.
        readings: The readings without it.
        rms: Root mean square distance that is left [m].
        numbers: By how much, in SI units.
        beside: Names of pairs of joints, one of which moves with the other.
    """

    kind: str
    about: tuple[str, ...]
    readings: Unloaded
    rms: float
    numbers: dict[str, float]
    beside: tuple[str, ...] = ()

    @property
    def size(self) -> tuple[int, int]:
        """Its place among those that explain as much: the likelier kind, the fewest names."""
        return KINDS.index(self.kind), len(self.about) + len(self.beside)


KINDS = (
    *("scale", "joint-unit", "mirrored", "exchanged", "sign", "quarter", "controller"),
    *("experiments", "bumped", "zero", "markers"),
)
"""All kinds, the likeliest first."""


def units(few: Unloaded) -> Iterator[Misreading]:
    """Readings in another unit, or mirrored; joint values in the other unit of angles."""
    mirrored = replace(few, position=-few.position)  # all mirror images are turned ones of it
    yield Misreading("mirrored", (), mirrored, left_of(mirrored), {})
    for scale in _SCALES:
        other = replace(few, position=scale * few.position)
        yield Misreading("scale", (), other, left_of(other), {"scale": scale})
    turning = ~few.robot.prismatic
    for factor in (180.0 / np.pi, np.pi / 180.0):
        other = replace(few, q=np.where(turning, factor * few.q, few.q))
        yield Misreading("joint-unit", (), other, left_of(other), {"factor": factor})


def signs(few: Unloaded, table: Coupling) -> list[Misreading]:
    """Joints that count the other way or with another; zeros a quarter of a turn elsewhere."""
    shown, assumed = table.to_controller(few.q), Convention.of(table)
    tried = list(conventions(few.robot, assumed, range(len(assumed.names))))[1:]
    q = [convention.to_model(shown) for convention in tried]
    found = [_convention(convention.mistakes(assumed), few) for convention in tried]
    for i, joint in enumerate(few.robot.joints):
        for by in () if joint.prismatic else (0.5 * np.pi, -0.5 * np.pi, np.pi):
            q.append(few.q + by * np.eye(few.q.shape[1])[i])
            found.append(Misreading("quarter", (joint.name,), few, 0.0, {"by": by}))
    if not table.is_identity:
        q += [table.to_model(few.q), shown]
        whose = ("controller", "model")
        found += [Misreading("controller", (one,), few, 0.0, {}) for one in whose]
    rms = left_over(few, few.nominal(np.array(q)))
    return [
        replace(one, rms=value, readings=replace(few, q=values))
        for one, value, values in zip(found, rms.tolist(), q, strict=True)
    ]


def _convention(mistakes: Sequence[Doubt], few: Unloaded) -> Misreading:
    """Which joints count the other way, and which pairs are coupled otherwise."""
    turned = tuple(m.about[0] for m in mistakes if m.code == "counts-other-way")
    pairs = [m for m in mistakes if m.code == "coupled"]
    factors = {"/".join(m.about): m.numbers["factor"] for m in pairs}
    beside = tuple(name for m in pairs for name in m.about)
    return Misreading("sign", turned, few, 0.0, factors, beside)


def exchanged(few: Unloaded, markers: Sequence[str]) -> Iterator[Misreading]:
    """Markers that have each other's names."""
    count = len(markers)
    orders = list(permutations(range(count))) if count <= 4 else []
    for i, j in combinations(range(count), 2) if count > 4 else ():
        orders.append(tuple(j if k == i else i if k == j else k for k in range(count)))
    for order in orders:
        about = tuple(markers[i] for i in range(count) if order[i] != i)
        if about:
            other = replace(few, marker=np.array(order)[few.marker])
            yield Misreading("exchanged", about, other, left_of(other), {})


def zeros(few: Unloaded, *, markers: bool = False) -> Iterator[Misreading]:
    """The zero of one joint elsewhere, by as much as fits best; with free markers, if wanted."""
    for j, joint in enumerate(few.robot.joints):
        other = settled(few, markers=markers, joint=j)
        by = float(other.q[0, j] - few.q[0, j])
        numbers = {"by": by, "sliding": float(joint.prismatic)}
        yield Misreading("zero", (joint.name,), other, left_of(other), numbers)


def elsewhere(few: Unloaded, markers: Sequence[str], least: float) -> Iterator[Misreading]:
    """Markers that are elsewhere in the flange frame, by `least` at least [m]."""
    if len(few) < 3 * len(few.markers) + 6 or len(np.unique(few.case)) < 4:
        return
    other = settled(few, markers=True)
    apart = np.linalg.norm(other.markers - few.markers, axis=1)
    moved = tuple(m for m, by in zip(markers, apart.tolist(), strict=True) if by > least)
    if moved:
        yield Misreading("markers", moved, other, left_of(other), {"by": float(apart.max())})


def single(
    unloaded: Unloaded, names: Sequence[str], *, markers: bool = False
) -> Iterator[Misreading]:
    """Single experiments that fit to no other; with free markers, if wanted."""
    part, out = unloaded, list[int]()
    for _ in range(min(5, len(np.unique(unloaded.case)) // 4)):
        part = settled(part, markers=True) if markers else part
        square = np.sum(residuals(part, part.drawn) ** 2, axis=1)
        size = np.bincount(part.case, square) / np.maximum(np.bincount(part.case), 1)
        worst = int(size.argmax())
        if size[worst] < _OUTLYING * np.median(size[np.unique(part.case)]):
            break
        out.append(worst)
        part = part.chosen(np.flatnonzero(part.case != worst))
    if out:
        part = settled(part, markers=True) if markers else part
        named = tuple(names[i] for i in sorted(out))
        yield Misreading("experiments", named, part, left_of(part), {})


def bumped(unloaded: Unloaded, names: Sequence[str]) -> Iterator[Misreading]:
    """One station that stood elsewhere from some experiment on."""
    nominal = unloaded.drawn
    cases = np.array(list(dict.fromkeys(unloaded.case.tolist())))
    if len(np.unique(unloaded.station)) > 1 or len(cases) < 2 * _FEWEST:
        return
    place = np.empty(int(cases.max()) + 1, dtype=np.int64)
    place[cases] = np.arange(len(cases))
    when = place[unloaded.case]
    inside = np.arange(_FEWEST, len(cases) - _FEWEST + 1)
    some = inside[:: max(1, len(inside) // _SPLITS)]
    near = int(some[two_frames(unloaded.position, nominal, when, some).argmin()])
    some = inside[np.abs(inside - near) < max(1, len(inside) // _SPLITS)]
    left = two_frames(unloaded.position, nominal, when, some)
    best = int(some[left.argmin()])
    sides = (when < best, when >= best)
    frames = [best_fits(unloaded.position[side], nominal[None, side]) for side in sides]
    moved = [unloaded.position @ turn[0].T + shift[0] for turn, shift, _ in frames]
    by = float(np.sqrt(np.mean(np.sum((moved[1] - moved[0]) ** 2, axis=1))))
    rms = float(left.min())
    if by > max(rms, _STILL):
        name = names[int(cases[best])]
        yield Misreading("bumped", (name,), unloaded, rms, {"by": by})


def two_frames(points: Array, nominal: Array, when: IntArray, splits: IntArray) -> Array:
    """(S,) root mean square distances [m] with one best fit before, and one from a split on.

    From sums over the experiments before, so that all of them take no longer than a few.

    Args:
        points: (R, 3) as read.
        nominal: (R, 3) as they should be.
        when: (R,) which of N experiments each belongs to, in their order.
        splits: (S,) experiments from which on the other fit holds, from 1 to N - 1.
    """
    a, b = points - points.mean(axis=0), nominal - nominal.mean(axis=0)
    pairs = (b[:, :, None] * a[:, None, :]).reshape(-1, 9)
    squares = np.sum(a**2 + b**2, axis=1, keepdims=True)
    each = np.hstack([np.ones((len(a), 1)), a, b, pairs, squares])
    count = int(when.max()) + 1
    sums = np.stack([np.bincount(when, column, count) for column in each.T], axis=1)
    before: Array = np.cumsum(sums, axis=0).astype(float)
    first = before[splits - 1]
    left = _left(first) + _left(before[-1] - first)
    return np.asarray(np.sqrt(np.maximum(left, 0.0) / len(a)))


def _left(sums: Array) -> Array:
    """(S,) sums of squares that the best fit leaves, of sums (S, 17) as in `two_frames`.

    Source: Kabsch 1976: |a|² + |b|² less twice the singular values, the last by its sign.
    """
    count, a, b = sums[:, :1], sums[:, 1:4], sums[:, 4:7]
    pairs = sums[:, 7:16].reshape(-1, 3, 3) - b[:, :, None] * a[:, None, :] / count[:, :, None]
    square = sums[:, 16] - np.sum(a**2 + b**2, axis=1) / count[:, 0]
    values = np.linalg.svd(pairs, compute_uv=False)
    values[:, 2] *= np.sign(np.linalg.det(pairs))
    return np.asarray(square - 2.0 * values.sum(axis=1))


def left_of(readings: Unloaded) -> float:
    """Root mean square distance after the best fits [m]."""
    return float(left_over(readings, readings.drawn[None])[0])
