"""What a plan promises of its campaigns, and how far chance alone lets them be off.

In: the campaigns of a plan. Out: the errors and estimates expected, and what does not bear them
out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import Doubt
from elastocal.simulation.campaigns import Campaigns, MonteCarlo

PROMISED = 0.95
"""Share of the intervals in `Campaigns.coverage`, and of the ranges and ellipses here."""

_SAMPLE = 200_000
_INSIDE = 5.991464547107979  # 95 % quantile of χ² with two degrees of freedom
_RMS_OFF = 0.1  # share of the mean square below which nobody minds ...
_COVERAGE_OFF = 0.02  # ... and difference in coverage


@dataclass(frozen=True)
class Chance:
    """Ranges that hold statistics of K campaigns with 95 % each, if all is as predicted.

    Attributes:
        bias: Of `Campaigns.bias`.
        spread: Of `Campaigns.spread`.
        coverage: Of `Campaigns.coverage`.
    """

    bias: tuple[float, float]
    spread: tuple[float, float]
    coverage: tuple[float, float]


@dataclass(frozen=True)
class Cloud:
    """Two estimates of each of K campaigns over one another.

    Attributes:
        shift: (K, 2) estimates minus truth [rad/(N·m) or m/N].
        covariance: (2, 2) predicted.
    """

    shift: Array
    covariance: Array

    @property
    def inside(self) -> float:
        """Share of the estimates within the predicted 95 % ellipse."""
        solved = np.linalg.solve(self.covariance, self.shift.T)
        return float((np.sum(self.shift.T * solved, axis=0) <= _INSIDE).mean())

    @property
    def ellipse(self) -> Array:
        """(97, 2) outline of that ellipse."""
        turn = np.linspace(0.0, 2.0 * np.pi, 97)
        circle = np.array([np.cos(turn), np.sin(turn)])
        return np.asarray(np.sqrt(_INSIDE) * (_root(self.covariance) @ circle).T)


def chance(number: int) -> Chance:
    """What chance allows statistics of `number` campaigns.

    Source: means are normal, sums of squares χ² with one degree of freedom less, counts binomial.
    """
    from scipy.special import bdtrik, chdtri

    half = 1.96 / np.sqrt(number)
    fewest, most = np.ceil(bdtrik([0.025, 0.975], number, PROMISED)) / number
    low, high = np.sqrt(chdtri(number - 1, [0.975, 0.025]) / (number - 1))
    return Chance(
        (-float(half), float(half)),
        (float(low), float(high)),
        (float(fewest), float(most)),
    )


def predicted_total(plan: Campaigns) -> Array:
    """(S,) errors as `Campaigns.total`, drawn from what is predicted [m]."""
    normal = np.random.default_rng(0).standard_normal((_SAMPLE, len(plan.squares)))
    return np.asarray(np.sqrt(normal**2 @ plan.squares))


def doubts_of_campaigns(found: MonteCarlo) -> tuple[Doubt, ...]:
    """Predictions that the campaigns do not bear out."""
    doubts = []
    for plan in found.plans:
        count, ratio = len(plan.estimate), plan.rms / plan.rho0
        # The mean of K squares that are no less spread than one normal's scatters by √(2/K).
        if abs(ratio**2 - 1.0) > max(3.0 * np.sqrt(2.0 / count), _RMS_OFF):
            doubts.append(Doubt("unlike-predicted", (plan.name,), numbers={"ratio": ratio}))
        allowed = max(5.0 * np.sqrt(PROMISED * (1 - PROMISED) / count), _COVERAGE_OFF)
        covered = zip(found.springs, plan.coverage, strict=True)
        if off := tuple(name for name, c in covered if abs(c - PROMISED) > allowed):
            doubts.append(Doubt("not-covered", off, (plan.name,)))
    return tuple(doubts)


def worst_pair(plan: Campaigns) -> tuple[int, int]:
    """Positions of the two springs whose estimates are correlated most, in chain order."""
    scale = plan.predicted_error
    correlation = np.abs(np.tril(plan.covariance / np.outer(scale, scale), -1))
    later, earlier = np.unravel_index(int(np.argmax(correlation)), correlation.shape)
    return int(earlier), int(later)


def cloud(plan: Campaigns, pair: tuple[int, int]) -> Cloud:
    """The estimates of two springs."""
    chosen = list(pair)
    shift = (plan.estimate - plan.truth)[:, chosen]
    return Cloud(shift, plan.covariance[np.ix_(chosen, chosen)])


def _root(covariance: Array) -> Array:
    """L with L Lᵀ the covariance, of entries of any size."""
    scale = np.sqrt(np.diagonal(covariance))
    return np.asarray(np.linalg.cholesky(covariance / np.outer(scale, scale)) * scale[:, None])
