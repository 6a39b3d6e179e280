"""Section of virtual campaigns: the errors they leave, plans side by side, against prediction.

In: Monte Carlo, the plan's study for the predicted distribution. Out: sections.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from elastocal.arrays import Array
from elastocal.report.charts.calibration import (
    Statistic,
    band_of_chance,
    calibration_chart,
    spread_band,
)
from elastocal.report.charts.cloud import cloud_chart, share_inside
from elastocal.report.charts.histograms import Histogram, histogram_chart
from elastocal.report.contents import Contents
from elastocal.report.layout import two_widths
from elastocal.report.section import Part, Section
from elastocal.report.tables import Row, Table
from elastocal.simulation.monte_carlo import Campaigns, MonteCarlo
from elastocal.wording.numbers import compliance_unit, fixed, length, number, percent

_PROMISED = 0.95  # of the intervals in `Campaigns.coverage`
_SAMPLE = 200_000
_MOST_MARKS = 3  # plans with marks of their own


def monte_carlo_part(contents: Contents) -> Part | None:
    """The sections of the virtual campaigns."""
    found = contents.monte_carlo
    if found is None:
        return None
    sections = (
        Section("monte-carlo", "Virtual campaigns", _errors(contents, found)),
        Section("coverage", "Estimates", _estimates(contents, found)),
    )
    return Part("Monte Carlo", sections)


def monte_carlo_remarks(found: MonteCarlo | None) -> tuple[str, ...]:
    """Predictions that virtual campaigns do not bear out."""
    said: list[str] = []
    if found is None:
        return ()
    for plan in found.plans:
        # The mean of K squares that are no less spread than one normal's scatters by √(2/K).
        chance = 3.0 * np.sqrt(2.0 / len(plan.estimate))
        ratio = (plan.rms / plan.rho0) ** 2
        if abs(ratio - 1.0) > max(chance, 0.1):
            said.append(
                f"virtual campaigns of {plan.name}: the error found is "
                f"{number(plan.rms / plan.rho0)} times the predicted ρ₀"
            )
        off = 5.0 * np.sqrt(_PROMISED * (1 - _PROMISED) / len(plan.estimate))
        low = [
            n
            for n, c in zip(found.springs, plan.coverage, strict=True)
            if abs(c - _PROMISED) > max(off, 0.02)
        ]
        if low:
            said.append(
                f"virtual campaigns of {plan.name}: 95 % intervals of {', '.join(low)} do not "
                "cover the truth as often as promised"
            )
    return tuple(said)


def _errors(contents: Contents, found: MonteCarlo) -> dict[str, Any]:
    plans = [
        Histogram(p.name, p.total, p.rho0, predicted_errors(contents, found, p))
        for p in found.plans
    ]
    rows = tuple(_row(p) for p in found.plans)
    sizes = ("ρ₀ predicted", "RMS found", "Found / predicted", "Mean", "Median")
    heads = ("Plan", "Experiments", *sizes, "90 %", "95 %", "99 %")
    return {
        "number": found.number,
        "seed": found.seed,
        "linear": found.linear,
        "known": list(found.known),
        "poses": len(found.test_poses),
        "sigma": found.how.sigma,
        "chart": two_widths(lambda width: histogram_chart(plans, width)),
        "density": any(len(p.sample) for p in plans),
        "table": Table(heads, rows),
        "compared": _compared(found),
        "remarks": monte_carlo_remarks(found),
    }


def _row(plan: Campaigns) -> Row:
    total = plan.total
    quantiles = [length(float(np.quantile(total, q))) for q in (0.5, 0.9, 0.95, 0.99)]
    cells = (
        plan.name,
        str(plan.experiments),
        length(plan.rho0),
        length(plan.rms),
        number(plan.rms / plan.rho0),
        length(float(total.mean())),
        *quantiles,
    )
    return Row(cells)


def predicted_errors(contents: Contents, found: MonteCarlo, plan: Campaigns) -> Array:
    """Errors drawn from the predicted covariance; none without the regressors of the test poses."""
    if contents.plan is None or contents.plan.study.springs.names != found.springs:
        return np.zeros(0)
    poses = contents.plan.study.test_poses
    if len(poses) != len(plan.weight):
        return np.zeros(0)
    loss = sum(w * p.regressor.T @ p.regressor for w, p in zip(plan.weight, poses, strict=True))
    scale = plan.predicted_error
    root = np.linalg.cholesky(plan.covariance / np.outer(scale, scale)) * scale[:, None]
    sizes = np.maximum(np.linalg.eigvalsh(root.T @ loss @ root), 0.0)
    normal = np.random.default_rng(0).standard_normal((_SAMPLE, len(sizes)))
    return np.asarray(np.sqrt(normal**2 @ sizes))


def _compared(found: MonteCarlo) -> str:
    """The best plan against the others."""
    if len(found.plans) < 2:
        return ""
    ordered = sorted(found.plans, key=lambda plan: plan.rms)
    best = ordered[0]
    said = [
        f"{number(other.rms / best.rms, 2)} times as large with {other.name}"
        for other in ordered[1:4]
    ]
    return f"The error is smallest with {best.name}; it is " + ", ".join(said) + "."


def _estimates(contents: Contents, found: MonteCarlo) -> dict[str, Any]:
    shown = found.plans[:_MOST_MARKS]
    chance = band_of_chance(_PROMISED, found.number, _PROMISED)
    statistics = [
        Statistic(
            "bias [standard errors]",
            0.0,
            band_of_chance(0.0, found.number),
            np.array([p.bias for p in shown]),
        ),
        Statistic(
            "spread, found / predicted",
            1.0,
            spread_band(found.number),
            np.array([p.spread for p in shown]),
        ),
        Statistic(
            "coverage of 95 % intervals [%]",
            100.0 * _PROMISED,
            (100.0 * chance[0], 100.0 * chance[1]),
            100.0 * np.array([p.coverage for p in shown]),
        ),
    ]
    names = [p.name for p in shown]
    rows = tuple(
        Row((spring, *(percent_of(float(p.coverage[i])) for p in found.plans)))
        for i, spring in enumerate(found.springs)
    )
    tests = [(p.name, number(p.likelihood_ratio()[1], 2)) for p in found.plans]
    return {
        "chart": two_widths(lambda w: calibration_chart(statistics, found.springs, names, w)),
        "table": Table(("Coverage", *(p.name for p in found.plans)), rows),
        "clouds": _clouds(contents, found) if len(found.springs) > 1 else [],
        "tests": tests,
        "others": len(found.plans) - len(shown),
        "chance": [percent_of(v) for v in chance],
    }


def percent_of(share: float) -> str:
    """A share with one decimal."""
    return f"{fixed(100.0 * share, 1)} %"


def _unit(contents: Contents, spring: str) -> str:
    """Unit of a compliance shown in 10⁻⁹ of SI."""
    if contents.plan is None or spring not in contents.plan.study.springs.names:
        return "10⁻⁹ SI"
    springs = contents.plan.study.springs
    return compliance_unit(bool(springs.prismatic[springs.names.index(spring)]))[1]


def _clouds(contents: Contents, found: MonteCarlo) -> list[dict[str, Any]]:
    """The two compliances that the first plan tells apart worst, for every plan, same axes."""
    worst = found.plans[0]
    scale = worst.predicted_error
    correlation = np.abs(np.tril(worst.covariance / np.outer(scale, scale), -1))
    j, i = (int(v) for v in np.unravel_index(int(np.argmax(correlation)), correlation.shape))
    pair = [i, j]
    factor = np.array([1e9, 1e9])
    units = tuple(_unit(contents, found.springs[k]) for k in pair)
    shown = found.plans[:4]
    reach = np.max([3.4 * factor * p.predicted_error[pair] for p in shown], axis=0)
    made = []
    for plan in shown:
        shift = factor * (plan.estimate - plan.truth)[:, pair]
        covariance = plan.covariance[np.ix_(pair, pair)] * np.outer(factor, factor)
        names = (found.springs[i], found.springs[j])
        made.append(
            {
                "name": plan.name,
                "chart": cloud_chart(shift, covariance, names, (units[0], units[1]), reach),
                "inside": percent(share_inside(shift, covariance)),
            }
        )
    return made
