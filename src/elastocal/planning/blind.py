"""Blind errors: what a plan cannot see of what its model lacks, and what that does to the task.

In: a study, load cases with repeats. Out: for each effect that the model may lack, what is left of
it at the task if it is as large as the test of fit misses half of the time.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.elastic.load_cases import LoadCases
from elastocal.fitting.power import critical_chi_square, power, seen_half
from elastocal.planning.blind_columns import BlindColumns, columns_of
from elastocal.planning.blind_effects import EffectFamily, EffectKind
from elastocal.study.study import Study

UNSEEN = 0.03  # of the size that is seen half of the time: less is not seen at all
_NOTHING = 1e-9  # of an error at the task [m]
_TRIED = 400  # values of a multiplier
_ALIKE = 1e-6  # of what effects do


@dataclass(frozen=True, eq=False)
class BlindEffect:
    """One thing that the model may lack; sizes in `unit`.

    Attributes:
        kind: What it is.
        carriers: Joints that it belongs to: places whose effects no reading and no task tells apart
            stand together.
        axis: (3,) its axis, base frame with all joints at zero (that of a tool: flange frame);
            empty if it has none, or is alike about every axis.
        unit: SI unit of its sizes.
        leak: What one of it leaves at the test poses [m].
        visibility: What one of it adds to the non-centrality of the test of fit.
        half: Size that the test sees half of the time; infinite if it sees none.
        largest: Size that is hard to believe.
        usual: Usual size, NaN where nobody knows it.
        seen: Probability that the test sees it at its `size`.
        usual_seen: Probability that the test sees the usual size.
    """

    kind: EffectKind
    carriers: tuple[str, ...]
    axis: Array
    unit: str
    leak: float
    visibility: float
    half: float
    largest: float
    usual: float
    seen: float
    usual_seen: float

    def __post_init__(self) -> None:
        freeze(self, "axis")

    @property
    def size(self) -> float:
        """The size that it is judged at: seen half of the time, or hard to believe."""
        return min(self.half, self.largest)

    @property
    def error(self) -> float:
        """Blind error: what it leaves at the test poses, if it is not seen [m]."""
        return self.leak * self.size

    @property
    def invisible(self) -> bool:
        """Whether no size is seen that can be believed."""
        return bool(self.largest < UNSEEN * self.half)


@dataclass(frozen=True)
class BlindErrors:
    """What a plan cannot see.

    Attributes:
        effects: Those that reach the task: the invisible ones first, each kind the worst first.
        dof: Degrees of freedom of the test of fit, that of the means of repeats.
        seen_half: Non-centrality that it sees half of the time.
        if_estimated: By how much larger things must be to be seen if the noise is estimated from
            repeats; infinite without any.
        together: Upper bound of what all springs of usual sizes together may leave at the test
            poses, seen half of the time [m]; NaN if no sizes are usual.
    """

    effects: tuple[BlindEffect, ...]
    dof: int
    seen_half: float
    if_estimated: float
    together: float

    @property
    def invisible(self) -> tuple[BlindEffect, ...]:
        """Those that no believable size makes visible."""
        return tuple(effect for effect in self.effects if effect.invisible)

    @property
    def visible(self) -> tuple[BlindEffect, ...]:
        """The others."""
        return tuple(effect for effect in self.effects if not effect.invisible)


def blind_errors(study: Study, cases: LoadCases, repeats: IntArray) -> BlindErrors | None:
    """What load cases, each measured `repeats` times, cannot see.

    The fit is the one that the study asks for, its nuisance at its priors: of an effect that is in
    it the leak is what its prior leaves.

    Returns:
        None if the load cases do not tell compliances apart, or no test pose has a load case; nor
            is it known of absolute readings.

    Source: ours; leak |L C Xᵀ b - b0|, visibility bᵀ Q b, docs/math.md.
    """
    told = None if study.experiments.weighs else columns_of(study, cases, repeats)
    if told is None:
        return None
    half = seen_half(told.dof)
    effects = [_effect(told, one, half) for one in _distinct(told, _all(told))]
    effects.sort(key=lambda effect: (not effect.invisible, -effect.error))
    estimated = float("inf")
    if told.noise_dof > 0.0:
        estimated = max(float(np.sqrt(seen_half(told.dof, told.noise_dof) / half)), 1.0)
    return BlindErrors(tuple(effects), told.dof, half, estimated, _together(told, half))


class _Combined(NamedTuple):
    """An effect as a combination (c,) of columns."""

    family: EffectFamily
    carriers: tuple[str, ...]
    axis: Array
    share: Array


def _all(told: BlindColumns) -> Iterator[_Combined]:
    """Each effect; of a plane the axis that the readings see least, that across it, and all alike.

    So nothing depends on which two axes span a plane.
    """
    first = 0
    for family in told.families:
        own = np.arange(first, first + family.columns)
        first += family.columns
        for axis, share in _in_plane(family, told.seen[np.ix_(own, own)]):
            combined = np.zeros(len(told.seen))
            combined[own] = share
            yield _Combined(family, (family.carrier,), axis, combined)


def _in_plane(family: EffectFamily, seen: Array) -> Iterator[tuple[Array, Array]]:
    """Axes, and shares of the columns, of the effects of a family, by the visibility of these."""
    if not family.plane:
        axes = family.axes if len(family.axes) else np.zeros((1, 0))
        yield from zip(axes, np.eye(family.columns), strict=True)
        return
    angle = least_seen(seen)
    for turned in (angle, angle + 0.5 * np.pi):
        c, s = np.cos(turned), np.sin(turned)
        yield c * family.axes[0] + s * family.axes[1], np.array([c * c, s * s, c * s])
    yield np.zeros(0), np.array([1.0, 1.0, 0.0])


def least_seen(seen: Array) -> float:
    """Angle φ at which x = (cos² φ, sin² φ, cos φ sin φ) has the least xᵀ `seen` x.

    Source: ours; with t = tan φ it is a ratio of polynomials, stationary at the roots of one.
    """
    scale = float(np.abs(seen).max())
    if scale == 0.0:
        return 0.0
    (a, ab, ac), (_, b, bc), (_, _, c) = (seen / scale).tolist()
    above = np.polynomial.Polynomial([a, 2.0 * ac, 2.0 * ab + c, 2.0 * bc, b])
    t = np.polynomial.Polynomial([0.0, 1.0])
    roots = (above.deriv() * (1.0 + t**2) - 4.0 * t * above).trim(1e-14).roots()
    angles = np.concatenate([np.arctan(roots.real), np.linspace(0.0, np.pi, 181)])
    x = np.array([np.cos(angles) ** 2, np.sin(angles) ** 2, np.cos(angles) * np.sin(angles)])
    return float(angles[np.argmin(np.einsum("in,ij,jn->n", x, seen / scale, x))])


def _distinct(told: BlindColumns, effects: Iterator[_Combined]) -> list[_Combined]:
    """The effects that reach the task; those that a fit does not tell apart as one."""
    kept: list[_Combined] = []
    known: list[Array] = []
    for one in effects:
        if np.linalg.norm(told.left @ one.share) * one.family.largest < _NOTHING:
            continue
        moved = told.moved @ one.share
        size = _ALIKE * float(np.linalg.norm(moved))
        same = [
            i
            for i, other in enumerate(known)
            if np.linalg.norm(other - moved) < size
            and _place(kept[i].family.kind) == _place(one.family.kind)
        ]
        if not same:
            kept.append(one)
            known.append(moved)
            continue
        first = kept[same[0]]
        carriers = dict.fromkeys((*first.carriers, *one.carriers))
        largest = max(first.family.largest, one.family.largest)  # either may be that large
        family = replace(first.family, largest=largest)
        kept[same[0]] = first._replace(family=family, carriers=tuple(carriers))
    return kept


def _place(kind: EffectKind) -> EffectKind:
    """What turns in an arm besides its joints goes by one name where nothing tells it apart."""
    return "bearing" if kind in ("foot", "link") else kind


def _effect(told: BlindColumns, one: _Combined, half: float) -> BlindEffect:
    family = one.family
    each = max(float(one.share @ told.seen @ one.share), 0.0)
    seen_from = float(np.sqrt(half / each)) if each > 0.0 else float("inf")
    size = min(seen_from, family.largest)
    usual = family.usual
    return BlindEffect(
        kind=family.kind,
        carriers=tuple(name for name in one.carriers if name),
        axis=one.axis,
        unit=family.unit,
        leak=float(np.linalg.norm(told.left @ one.share)),
        visibility=each,
        half=seen_from,
        largest=family.largest,
        usual=usual,
        seen=power(each * size**2, told.dof),
        usual_seen=usual if np.isnan(usual) else power(each * usual**2, told.dof),
    )


def _together(told: BlindColumns, half: float) -> float:
    """The worst that springs of usual sizes leave together [m]; NaN if no sizes are usual."""
    sizes = _usual(told)
    if not sizes.size:
        return float("nan")
    return worst_together(told.left @ sizes, sizes.T @ told.seen @ sizes, half)


def worst_together(left: Array, seen: Array, half: float) -> float:
    """At most what q effects leave together that are seen no more than half of the time [m].

    Args:
        left: (r, q) D, what each of its usual size leaves.
        seen: (q, q) Λ, non-centralities of these.
        half: λ½, that seen half of the time.

    Source: ours; max |Dx|² where xᵀΛx ≤ λ½ and |x|² ≤ χ²_q(95 %), at most the least over
    0 ≤ a ≤ 1 of the largest eigenvalue of D (aΛ/λ½ + (1 - a)/χ²)⁻¹ Dᵀ (S-procedure).
    """
    wide = np.eye(len(seen)) / critical_chi_square(len(seen))
    squares = []
    for a in (0.0, *(1.0 - np.geomspace(1.0, 1e-6, _TRIED))):
        root = np.linalg.cholesky(a * seen / half + (1.0 - a) * wide)
        squares.append(float(np.linalg.norm(np.linalg.solve(root, left.T), 2)) ** 2)
    return float(np.sqrt(min(squares)))


def _usual(told: BlindColumns) -> Array:
    """(c, q) usual sizes of the q springs besides the joints, as docs/typical.md has them."""
    links = {family.carrier for family in told.families if family.kind == "link"}
    shares, place = [], 0
    for family in told.families:
        own = slice(place, place + family.columns)
        place += family.columns
        alike = family.kind in ("foot", "bearing") and family.carrier not in links
        if np.isnan(family.usual) or not (alike or family.kind in _BESIDES):
            continue
        base = [[1.0, 1.0, 0.0]] if alike else np.eye(family.columns)
        for share in family.usual * np.asarray(base):
            combined = np.zeros(len(told.seen))
            combined[own] = share
            shares.append(combined)
    sizes = np.array(shares).T
    return sizes


_BESIDES = ("link", "foot-sliding", "tool-sliding")
