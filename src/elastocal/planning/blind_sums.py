"""Blind errors of many plans at once: information on a fit and on what it lacks adds up.

In: a study. Out: what load cases tell of the unknowns and of effects, and of sums of these the
largest blind error, of effects that some load cases of the study show.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InfeasibleError
from elastocal.fitting.power import seen_half
from elastocal.matrices import rank_of
from elastocal.planning.blind import UNSEEN
from elastocal.planning.blind_columns import WhiteRows, white_rows
from elastocal.study.study import Study

_CASES = 60  # random load cases: what they do not show together, none shows
_ANGLES = np.linspace(0.0, np.pi, 24, endpoint=False)
_STEPS = 5  # of Newton's method from the best of these
_FLAT = 1e-12  # of the information on unknowns, that it can be solved with
_HALF = cache(seen_half)


class _Told(NamedTuple):
    """What K plans tell of f unknowns and c columns of effects: parts of one matrix."""

    unknowns: Array  # (K, f, f)
    both: Array  # (K, f, c)
    single: Array  # (K, s) of effects of one column, with themselves
    planes: Array  # (K, g, 3, 3) of those about every axis of a plane, with themselves


@dataclass(frozen=True, eq=False)
class BlindSums:
    """What decides on blind errors, of f unknowns of a fit and c columns of effects.

    Attributes:
        study: The study.
        readings: How many a load case has.
        base: (f, f) what is known of the unknowns before.
        task: (r, f + c) what they move at the test poses; squares add up to the mean square.
        single: (s,) columns of effects of one column.
        planes: (g, 3) columns of effects about every axis of a plane; see `EffectFamily`.
        largest: (c,) sizes that are hard to believe.
        shown: (1, L) what many random load cases tell together.
        cases: How many these are.
    """

    study: Study
    readings: int
    base: Array
    task: Array
    single: IntArray
    planes: IntArray
    largest: Array
    shown: Array
    cases: int

    def __post_init__(self) -> None:
        freeze(self, "base", "task", "largest", "shown")
        freeze(self, "single", "planes", dtype=np.int64)

    def informations(self, cases: LoadCases, repeats: IntArray) -> Array:
        """(S, L) what each load case tells, measured (S,) `repeats` times; it adds up."""
        return self._flat(white_rows(self.study, cases, repeats))

    def worst(self, totals: Array, distinct: int, power: float = np.inf) -> Array:
        """(K,) largest blind error of plans of so many distinct load cases [m].

        Of a spring about any axis of a plane the axis counts that is seen least, three at 45° to
        the last, and all axes alike.

        Args:
            totals: (K, L) sums of `informations`.
            distinct: Number of load cases.
            power: If finite, the norm of so high a power of all blind errors in place of their
                largest: it falls with each of those that are nearly as large.

        Source: ours; 58 to 61 of docs/math.md by parts of one matrix.
        """
        left, single, planes = self._moved(totals, distinct)
        _, once, often = self._moved(self.shown, self.cases)
        leak = np.linalg.norm(left[:, :, self.single], axis=1)
        errors = [_errors(leak, single, once, self.largest[self.single])]
        if len(self.planes):
            shares = _in_planes(planes)
            moved = shares @ left[:, :, self.planes].transpose(0, 2, 3, 1)
            squares = _squares(planes, shares), _squares(often, shares)
            largest = self.largest[self.planes[:, :1]]
            found = _errors(np.linalg.norm(moved, axis=3), *squares, largest)
            errors.append(found.reshape(len(totals), -1))
        each = np.concatenate(errors, axis=1)
        most = each.max(axis=1, initial=0.0)
        if np.isinf(power):
            return np.asarray(most)
        share = each / (most[:, None] + 1e-300)
        return np.asarray(most * (share**power).sum(axis=1) ** (1.0 / power))

    def _moved(self, totals: Array, distinct: int) -> tuple[Array, Array, Array]:
        """What one of each column leaves (K, r, c) at the task, and non-centralities.

        These are over what the test of the means sees half of the time: (K, s) and (K, g, 3, 3).
        """
        told, f = self._parts(totals), len(self.base)
        unknowns = told.unknowns + self.base
        scale = 1.0 / np.sqrt(np.diagonal(unknowns, axis1=1, axis2=2) + 1e-300)[:, :, None]
        unknowns = unknowns * scale * scale.transpose(0, 2, 1) + _FLAT * np.eye(f)
        found = scale * np.linalg.solve(unknowns, scale * told.both)
        single = told.single - (told.both * found)[:, :, self.single].sum(axis=1)
        both, fits = (part[:, :, self.planes].transpose(0, 2, 3, 1) for part in (told.both, found))
        planes = told.planes - both @ fits.transpose(0, 1, 3, 2)
        known = rank_of(self.base) if self.base.any() else 0
        half = _HALF(int(self.readings * distinct + known - f))
        return self.task[:, :f] @ found - self.task[:, f:], single / half, planes / half

    def _flat(self, rows: WhiteRows) -> Array:
        """(S, L) what load cases of these rows tell, one after the other."""
        x, b = rows.fitted.transpose(0, 2, 1), rows.effects.transpose(0, 2, 1)
        own = b[:, self.planes]
        told = (
            x @ rows.fitted,
            x @ rows.effects,
            (b[:, self.single] ** 2).sum(axis=2),
            own @ own.transpose(0, 1, 3, 2),
        )
        return np.concatenate([part.reshape(len(x), -1) for part in told], axis=1)

    def _parts(self, totals: Array) -> _Told:
        """The parts of (K, L) sums."""
        f, c, g = len(self.base), len(self.largest), len(self.planes)
        ends = np.cumsum([f * f, f * c, len(self.single)])
        unknowns, both, single, planes = np.split(totals, ends, axis=1)
        return _Told(
            unknowns.reshape(-1, f, f),
            both.reshape(-1, f, c),
            single,
            planes.reshape(-1, g, 3, 3),
        )


def blind_sums(study: Study, otherwise: LoadCases) -> BlindSums:
    """What decides on blind errors of plans of a study whose test poses have load cases.

    Args:
        study: The study.
        otherwise: Load cases that tell what can be shown, if no random ones are found.
    """
    try:
        cases = study.space.load_cases(study.space.sample(_CASES, np.random.default_rng(0)))
    except InfeasibleError:
        cases = otherwise
    rows = white_rows(study, cases, np.ones(len(cases), dtype=np.int64))
    columns = [family.columns for family in rows.families]
    ends = np.cumsum(columns).tolist()
    planes = [end - 3 for end, family in zip(ends, rows.families, strict=True) if family.plane]
    own = np.array(planes, dtype=np.int64)[:, None] + np.arange(3)
    task = np.concatenate([np.concatenate(part, axis=2) for part in rows.task])
    made = BlindSums(
        study=study,
        readings=rows.fitted.shape[1],
        base=rows.prior,
        task=np.asarray(np.linalg.qr(task.reshape(-1, task.shape[2]), mode="r")),
        single=np.setdiff1d(np.arange(ends[-1]), own),
        planes=own,
        largest=np.repeat([family.largest for family in rows.families], columns),
        shown=np.zeros((1, 0)),
        cases=len(cases),
    )
    return replace(made, shown=made._flat(rows).sum(axis=0)[None])


def _errors(leak: Array, seen: Array, shown: Array, largest: Array) -> Array:
    """Blind errors by leaks and non-centralities over what is seen half of the time.

    What no load case shows is left out.
    """
    half, best = (1.0 / np.sqrt(np.maximum(one, 1e-300)) for one in (seen, shown))
    return np.where(largest < UNSEEN * best, 0.0, leak * np.minimum(half, largest))


def _squares(blocks: Array, shares: Array) -> Array:
    """(K, g, a) xᵀ B x of shares (K, g, a, 3) of columns."""
    return np.asarray(((shares @ blocks) * shares).sum(axis=3))


def _in_planes(blocks: Array) -> Array:
    """(K, g, 5, 3) shares of columns: of the axis seen least, three at 45° to the last, all alike.

    Source: ours; the square of what a spring about an axis moves is
    a + b cos 2φ + c sin 2φ + d cos 4φ + e sin 4φ.
    """
    parts = np.array([[0.5, 0.5, 0.0], [0.5, -0.5, 0.0], [0.0, 0.0, 0.5]])
    form = parts @ blocks @ parts.T
    b, c = 2.0 * form[:, :, 0, 1], 2.0 * form[:, :, 0, 2]
    d, e = 0.5 * (form[:, :, 1, 1] - form[:, :, 2, 2]), form[:, :, 1, 2]
    waves = np.array([f(k * _ANGLES) for k in (2, 4) for f in (np.cos, np.sin)])
    angle = _ANGLES[(np.stack([b, c, d, e], axis=2) @ waves).argmin(axis=2)]
    for _ in range(_STEPS):
        c2, s2, c4, s4 = (f(k * angle) for k in (2, 4) for f in (np.cos, np.sin))
        slope = 2.0 * (c * c2 - b * s2) + 4.0 * (e * c4 - d * s4)
        bend = -4.0 * (b * c2 + c * s2) - 16.0 * (d * c4 + e * s4)
        angle = angle - np.where(bend > 0.0, slope / np.where(bend > 0.0, bend, 1.0), 0.0)
    turned = angle[:, :, None] + 0.25 * np.pi * np.arange(4)
    c1, s1 = np.cos(turned), np.sin(turned)
    alike = np.broadcast_to([1.0, 1.0, 0.0], (*angle.shape, 1, 3))
    return np.concatenate([np.stack([c1**2, s1**2, c1 * s1], axis=3), alike], axis=2)
