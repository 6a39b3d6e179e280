"""Symmetries of a statement: other values of the joints at which all that counts is the same.

A wrist has two ways to the same pose, and an arm built to a plane a mirror image. Such maps
x → ± x + (0 or π) are looked for by chance. They are proved by coefficients: a map changes no more
than the signs of those of a series, and what it makes of the rows must be the rows, turned or
mirrored.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, freeze
from elastocal.proof.dropped import same_at
from elastocal.proof.reference import ArmAt
from elastocal.proof.roots import circles
from elastocal.proof.series import FiniteSeries
from elastocal.proof.statement import InCone, Statement, SteadyLoad

_FEW = 4  # points by chance that a map is tried at first
_MANY = 1000  # and those that pass
_MOST = 20000  # maps that are tried
_PROVED = 1e-11  # share of the size of a function that coefficients may differ by in all
_FIXED = 1e-12  # what a limit may be off its image [rad]


@dataclass(frozen=True)
class Symmetry:
    """A map x → signs · x + shifts that leaves d and the constraints as they are.

    Attributes:
        signs: (n,) 1 or -1.
        shifts: (n,) 0 or π [rad].
    """

    signs: Array
    shifts: Array

    def __post_init__(self) -> None:
        freeze(self, "signs", "shifts")

    def at(self, x: Array) -> Array:
        """(N, n) images of points."""
        return x * self.signs + self.shifts


def symmetries(
    statement: Statement, rows: FiniteSeries, constraints: tuple[FiniteSeries, ...]
) -> tuple[Symmetry, ...]:
    """All symmetries of a statement with its whole root, but for the one that does nothing.

    Args:
        statement: With its mix and what is held; nothing is halved.
        rows: Its rows.
        constraints: Its constraints.
    """
    tried = _candidates(statement)
    found, rng = [], np.random.default_rng(0)
    low, high = statement.root
    few = low + (high - low) * rng.uniform(size=(_FEW, len(low)))
    many = low + (high - low) * rng.uniform(size=(_MANY, len(low)))
    proof = _Proof(statement, rows, constraints)
    for one in tried:
        of = proof.constraints(one)
        if of is None or not same_at(statement, few, one.at(few), of):
            continue
        if same_at(statement, many, one.at(many), of) and proof.rows(one):
            found.append(one)
    return tuple(found)


def _candidates(s: Statement) -> list[Symmetry]:
    """Maps that take the root and the limits to themselves."""
    n, active = len(s.joints), set(s.active.tolist())
    round_ = circles(s)
    turning = [i for i in range(n) if not s.joints.slides[i] and i in active]
    # What a joint value mixes has one sign, or its image would be no sign times itself.
    group = np.arange(n)
    for i in range(1, n):
        if s.mix[i, i - 1] != 0.0:
            group[i] = group[i - 1]
    flat = {one.variable for one in s.held if one.because == "flat"}
    numbers = sorted({int(group[i]) for i in turning})
    free = [i for i in turning if round_[i]]
    if 2 ** (len(numbers) + len(free)) > _MOST:
        free = []
    found = []
    for ways in product((1.0, -1.0), repeat=len(numbers)):
        signs = np.ones(n)
        for number, way in zip(numbers, ways, strict=True):
            signs[group == number] = way
        signs[s.joints.slides] = 1.0
        if not _keeps_ends(s, signs, round_, flat):
            continue
        for half_turns in product((0.0, np.pi), repeat=len(free)):
            shifts = np.zeros(n)
            shifts[free] = half_turns
            moved = np.mod(s.mix @ shifts + 1.0, 2.0 * np.pi) - 1.0  # of q: 0 or π
            if not (s.limited & (np.abs(moved) > 1.0)).any():
                found.append(Symmetry(signs, shifts))
    return found[1:]  # the first does nothing


def _keeps_ends(s: Statement, signs: Array, round_: BoolArray, flat: set[int]) -> bool:
    """Whether mirrored variables have ranges that are their own image."""
    for i in np.flatnonzero(signs < 0.0).tolist():
        if i in flat or round_[i]:
            continue
        sums = [s.root[:, i].sum()]
        if s.limited[i]:
            sums.append(s.joints.lower[i] + s.joints.upper[i])
        if np.abs(sums).max() > _FIXED:
            return False
    return True


class _Proof:
    """Coefficients of the rows and of the constraints, and what maps make of them."""

    def __init__(
        self, statement: Statement, rows: FiniteSeries, constraints: tuple[FiniteSeries, ...]
    ) -> None:
        self._s, self._series, self._constraints = statement, rows, constraints

    def constraints(self, one: Symmetry) -> IntArray | None:
        """(C,) which constraint each becomes; None if one becomes none of them."""
        found = []
        for series in self._constraints:
            image = _image(series, one)
            same = [k for k, other in enumerate(self._constraints) if _same(image, series, other)]
            if not same:
                return None
            found.append(same[0])
        return np.array(found, dtype=np.int64)

    def rows(self, one: Symmetry) -> bool:
        """Whether the rows become the rows, those of each marker turned or mirrored in space."""
        s, series = self._s, self._series
        k = 1 if s.directions is None else s.directions.shape[1]
        flat = series.coefficients.reshape(-1, series.coefficients.shape[-1]).T
        image = _image(series, one).reshape(flat.T.shape).T
        r = s.seen.shape[1]
        before, after = (a.reshape(-1, 3, r, k, a.shape[-1]) for a in (flat, image))
        allowed = _PROVED * series.size
        if isinstance(s.load, SteadyLoad):
            off = sum(_apart(a, b) for a, b in zip(before, after, strict=True))
            return off <= allowed
        return any(self._mirrored(before, after, P) <= allowed for P in self._mirrors(one))

    def _mirrored(self, before: Array, after: Array, P: Array) -> float:
        """How far the rows are off those that P makes of rows and forces."""
        load = self._s.load
        if isinstance(load, SteadyLoad):
            return np.inf
        if isinstance(load, InCone):
            if min(np.linalg.norm(P @ load.axis - w * load.axis) for w in (1.0, -1.0)) > _FIXED:
                return np.inf
            Q = P
        else:
            Q = load.basis.T @ P @ load.basis
            if np.abs(Q @ Q.T - np.eye(len(Q))).max() > _FIXED:
                return np.inf
        off = 0.0
        for block in range(len(before)):
            turn = P
            if self._s.sigma_turn is not None and block == len(before) - 1:
                turn = np.linalg.det(P) * P
            made = np.einsum("ij,jrkm,lk->irlm", turn, before[block], Q)
            off += _total(made - after[block])
        return off

    def _mirrors(self, one: Symmetry) -> list[Array]:
        """Rotations and mirrors that take the points of the arm to where the map has them."""
        s, rng = self._s, np.random.default_rng(1)
        low, high = s.root
        x = low + (high - low) * rng.uniform(size=(30, len(low)))
        clouds = []
        for at in (x, one.at(x)):
            arm = ArmAt(s, at)
            points = np.concatenate([arm.point(p) for p in (*s.markers, s.load.point)])
            clouds.append(points - points.mean(axis=0))
        left, size, right = np.linalg.svd(clouds[1].T @ clouds[0])
        found = [left @ right]
        if size[2] <= 1e-9 * size[0]:  # all in a plane: across it nothing is known
            found.append(left @ np.diag([1.0, 1.0, -1.0]) @ right)
        return found


def _image(series: FiniteSeries, one: Symmetry) -> Array:
    """Coefficients of the function of the images of x."""
    found = np.array(series.coefficients)
    for axis, variable in enumerate(series.variables.tolist()):
        if series.slides[axis]:
            continue
        terms = np.ones(found.shape[axis])
        for k in range(1, len(terms) // 2 + 1):
            terms[2 * k - 1 : 2 * k + 1] = np.round(np.cos(k * one.shifts[variable]))
            terms[2 * k] *= one.signs[variable]
        found *= terms.reshape(-1, *[1] * (found.ndim - 1 - axis))
    return found


def _same(image: Array, of: FiniteSeries, other: FiniteSeries) -> bool:
    """Whether coefficients are those of another function."""
    if image.shape != other.coefficients.shape or (of.variables != other.variables).any():
        return False
    return _total(image - other.coefficients) <= _PROVED * max(of.size, other.size)


def _total(coefficients: Array) -> float:
    """The most that a function of these coefficients can be."""
    return float(np.abs(coefficients).sum())


def _apart(before: Array, after: Array) -> float:
    """How far three rows are off others at least, turned or mirrored in space."""
    a, b = before.reshape(3, -1), after.reshape(3, -1)
    left, _, right = np.linalg.svd(b @ a.T)
    return _total(left @ right @ a - b)
