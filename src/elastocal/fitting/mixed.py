"""Mixed estimation: noise of a size that is not known beside what is known in absolute size.

In: rows of a linear model, each with the share of the noise that grows with the instrument's and
the variance that does not: of priors, of errors of load cases. Out: the instrument's noise, the
covariance of the estimate, and on how many degrees of freedom each combination of it rests.

    y = X θ + e,   e_r ~ N(0, s² a_r + u_r),   W = 1 / (s² a + u),   P = W - W X C Xᵀ W
    C = (Xᵀ W X)⁻¹,   Σ a W² r² = tr(P A)                      restricted maximum likelihood of s²
    ν = s⁴ tr(P A P A),   D = s² dC/ds²,   C_A = C + 4/ν (D₂ - D C⁻¹ D)
    var(cᵀθ) = cᵀ C_A c on ν (cᵀ C_A c / cᵀ D c)² degrees of freedom

A prior is rows with a = 0, u = 1. Without it, and with u = 0 everywhere, all this is the textbook:
s² = |r|² / (R - p), ν = R - p, D = C = C_A. What is absolute is never scaled by the noise found.

Source: Theil & Goldberger 1961 (mixed estimation); Patterson & Thompson 1971 (likelihood);
Kenward & Roger 1997 (covariance, degrees of freedom).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.fitting.least_squares import column_norms, inverse_root
from elastocal.matrices import freedom_of

_MOST_ROUNDS = 200
_AT_REST = 1e-10  # change of log s² at which it rests
_SLOW = 0.8  # a step over the last one, from which they go on for long
_NEAR = 0.5  # two places between which the score is nearly straight
_ROUNDED = 1e-6  # two places whose scores differ by rounding
_FARTHEST = 3.0  # that in one round at most
_NO_NOISE = 1e-12  # s² over that promised at which it has vanished


@dataclass(frozen=True)
class Rows:
    """R rows of p unknowns with values, each with its noise; and what is left of many more.

    Attributes:
        rows: (R, p).
        values: (R,).
        own: (R,) what the unknown s² is multiplied by: 1 for readings over their noise, 0 for
            what is known in absolute size.
        absolute: (R,) variance besides.
        rest: Sum of squares of values that no unknown moves, with `own` 1 and nothing besides.
        rest_dof: How many they are.
    """

    rows: Array
    values: Array
    own: Array
    absolute: Array
    rest: float = 0.0
    rest_dof: int = 0

    def weight(self, variance: float) -> Array:
        """(R,) one over the variances, the instrument's being `variance`."""
        return 1.0 / (variance * self.own + self.absolute)

    @property
    def pure_dof(self) -> int:
        """Coordinates that show the instrument's noise alone, whatever the unknowns are."""
        pure = (self.own > 0.0) & (self.absolute == 0.0)
        rows = self.rows[pure]
        norms = column_norms(self.rows)
        rank = int(np.linalg.matrix_rank(rows / norms)) if len(rows) else 0
        return self.rest_dof + len(rows) - rank


@dataclass(frozen=True)
class Spread:
    """Covariance of p estimates, and how far it rests on noise that was found.

    Attributes:
        covariance: (p, p).
        by_noise: (p, p) D, the part that grows with s²; zero if s² is known.
        dof: ν, degrees of freedom of s²; infinite if it is known.
        variance: s², over the promised one.
    """

    covariance: Array
    by_noise: Array
    dof: float
    variance: float


def condensed(rows: Rows) -> Rows:
    """The same with as few rows as unknowns for all readings without an absolute part.

    Source: QR; what is below the triangle no unknown moves.
    """
    pure = (rows.own == 1.0) & (rows.absolute == 0.0)
    p = rows.rows.shape[1]
    if pure.sum() <= p + 1:
        return rows
    scale = column_norms(rows.rows[pure])
    both = np.column_stack([rows.rows[pure] / scale, rows.values[pure]])
    triangle = np.asarray(np.linalg.qr(both, mode="r"))
    rest = float(triangle[p, p] ** 2)
    few = int(pure.sum()) - p
    return replace(
        rows,
        rows=np.concatenate([triangle[:p, :p] * scale, rows.rows[~pure]]),
        values=np.append(triangle[:p, p], rows.values[~pure]),
        own=np.append(np.ones(p), rows.own[~pure]),
        absolute=np.append(np.zeros(p), rows.absolute[~pure]),
        rest=rows.rest + rest,
        rest_dof=rows.rest_dof + few,
    )


def estimate(rows: Rows, variance: float) -> tuple[Array, Array]:
    """(p,) estimates and their (p, p) covariance C, the instrument's variance being known."""
    root = np.sqrt(rows.weight(variance))
    scale = column_norms(rows.rows * root[:, None])
    both = np.column_stack([rows.rows * (root[:, None] / scale), rows.values * root])
    triangle = np.asarray(np.linalg.qr(both, mode="r"))
    p = rows.rows.shape[1]
    inverse = inverse_root(triangle[:p, :p]) / scale[:, None]
    found = inverse @ triangle[:p, p]
    return found, np.asarray(inverse @ inverse.T)


def noise_variance(rows: Rows, start: float = 1.0) -> float:
    """s², the instrument's variance over the promised one; 0 if nothing is left for it.

    Fisher's scoring in log s² from `start`, with steps of a factor e³ at most; steps that shrink
    slowly are made as long as all of them together; between two scores of different signs by
    halves, and at last by secants.
    """
    rows = condensed(rows)
    path = _Path(start)
    for _ in range(_MOST_ROUNDS):
        variance = path.variance
        found, covariance = estimate(rows, variance)
        weight = rows.weight(variance)
        residual = rows.values - rows.rows @ found
        seen = float(np.sum(rows.own * (weight * residual) ** 2)) + rows.rest / variance**2
        expected, information = _traces(rows, variance, covariance)
        if not information > 0.0:
            return 0.0
        step = (seen - expected) / (information * variance)
        # From far above the score is flat: the fixed point takes over, in the same direction.
        if seen > 0.0 and abs(step) > 1.0:
            step = float(np.log(seen / max(expected, 1e-300)))
        step = path.advance(step, (seen - expected) * variance)
        if abs(step) <= _AT_REST:
            break
        if path.variance < _NO_NOISE:
            return 0.0
    return path.variance


class _Path:
    """The way of log s² to where its score is zero."""

    def __init__(self, start: float) -> None:
        self.place = float(np.log(start))
        self._low, self._high = -np.inf, np.inf  # between them the score falls through zero
        self._last, self._before = 0.0, (np.nan, np.nan)

    @property
    def variance(self) -> float:
        """s² there."""
        return float(np.exp(self.place))

    def advance(self, step: float, score: float) -> float:
        """Go on, where scoring steps by `step`; the step that is made."""
        here = self.place
        if step > 0.0:
            self._low = here
        else:
            self._high = here
        other, its_score = self._before
        if np.isfinite(self._low) and np.isfinite(self._high):
            if abs(here - other) > _ROUNDED and (score - its_score) / (here - other) < 0.0:
                step = -score * (here - other) / (score - its_score)
            near = self._high - self._low < _NEAR and self._low < here + step < self._high
            if not near and abs(step) > _ROUNDED:
                step = 0.5 * (self._low + self._high) - here
        elif self._last and (ratio := step / self._last) > _SLOW:
            step = step / (1.0 - ratio) if ratio < 1.0 else 2.0 * step
        step = float(np.clip(step, -_FARTHEST, _FARTHEST))
        self._last, self._before = step, (here, score)
        self.place = here + step
        return step


def squares_and_shares(rows: Rows, variance: float) -> tuple[float, float]:
    """Squares of all rows over their noise, rᵀ W r, and its shares in them, s² tr(P A).

    The squares are χ² with R - p degrees of freedom if s² is the `variance`.
    """
    rows = condensed(rows)
    found, covariance = estimate(rows, variance)
    residual = rows.values - rows.rows @ found
    square = float(np.sum(rows.weight(variance) * residual**2)) + rows.rest / variance
    return square, variance * _traces(rows, variance, covariance)[0]


def _traces(rows: Rows, variance: float, covariance: Array) -> tuple[float, float]:
    """tr(P A) and tr(P A P A)."""
    weight = rows.weight(variance)
    half, full = _informations(rows, weight)
    first = float(np.sum(rows.own * weight)) - float(np.sum(covariance * half))
    moved = covariance @ half
    second = float(np.sum((rows.own * weight) ** 2)) - 2.0 * float(np.sum(covariance * full))
    second += float(np.sum(moved * moved.T))
    return first + rows.rest_dof / variance, second + rows.rest_dof / variance**2


def _informations(rows: Rows, weight: Array) -> tuple[Array, Array]:
    """(p, p) Xᵀ W A W X and Xᵀ W A W A W X."""
    first = rows.own * weight**2
    second = rows.own**2 * weight**3
    x = rows.rows
    return np.asarray((x * first[:, None]).T @ x), np.asarray((x * second[:, None]).T @ x)


def spread_known(rows: Rows, variance: float = 1.0) -> Spread:
    """Covariance of the estimate if s² is known."""
    _, covariance = estimate(rows, variance)
    return Spread(frozen(covariance), frozen(np.zeros_like(covariance)), np.inf, variance)


def spread_found(rows: Rows, variance: float) -> Spread:
    """Covariance of the estimate where s² was found, with what that adds."""
    rows = condensed(rows)
    _, covariance = estimate(rows, variance)
    weight = rows.weight(variance)
    half, full = _informations(rows, weight)
    _, information = _traces(rows, variance, covariance)
    dof = variance**2 * information
    by_noise = variance * covariance @ half @ covariance
    bias = variance**2 * covariance @ (full - half @ covariance @ half) @ covariance
    adjusted = covariance + 4.0 / dof * bias
    return Spread(
        frozen(0.5 * (adjusted + adjusted.T)),
        frozen(0.5 * (by_noise + by_noise.T)),
        float(dof),
        variance,
    )


def freedom(spread: Spread, combinations: Array) -> Array:
    """(K,) degrees of freedom of combinations (K, p) of the estimates."""
    return freedom_of(spread.covariance, spread.by_noise, spread.dof, combinations)
