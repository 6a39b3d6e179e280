"""What is weak in an identification, in sentences.

In: an `Identification`. Out: remarks. A strong result has none.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from elastocal.arrays import Array
from elastocal.fitting.goodness import p_value_chi_square
from elastocal.identification.leave_one_out import left_out_covariance
from elastocal.identification.result import Identification

_SURE = 1e-3  # probability below which chance is ruled out
_CLOSE = 0.95  # correlation above which two compliances are hard to tell apart
_CARRIES = 3.0  # growth of a standard error that makes an experiment indispensable
_FAR = 4.5  # residual over its own standard deviation that calls for a look
_FEW = 5  # degrees of freedom below which an estimated σ means little
_MOST = 5  # names listed before the rest is counted


def weaknesses(found: Identification) -> tuple[str, ...]:
    """Sentences on what should make one doubt the result."""
    return tuple(
        [
            *_signs(found),
            *_noise(found),
            *_intervals(found),
            *_carried(found),
            *_correlated(found),
            *_outlying(found),
            *_nonlinear(found),
        ]
    )


def _signs(found: Identification) -> Iterator[str]:
    negative = [n for n, k in zip(found.identified, found.compliance, strict=True) if k < 0.0]
    if len(negative) == len(found.identified) > 1:
        yield (
            "all compliances are negative: loaded and unloaded are probably swapped, or the force "
            "has the wrong sign"
        )
    elif negative:
        yield (
            f"{_listed(negative)}: negative, which no spring can be; look at signs and joint "
            "values, or rule it out with a bound at zero"
        )
    if found.held:
        yield (
            f"{_listed(list(found.held))}: held at zero by the bound; the covariance of the "
            "others takes that as exact"
        )


def _noise(found: Identification) -> Iterator[str]:
    if found.how.sigma == "known" and found.dof > 0 and found.how.loss == "squares":
        p = p_value_chi_square(found.chi_square, found.dof)
        if p < _SURE:
            yield (
                f"the residuals scatter {_short(found.scale)} times as much as σ promises (χ² = "
                f"{found.chi_square:.4g} with {found.dof} degrees of freedom): the noise is larger "
                "or the model lacks something; the intervals are too narrow, estimate σ"
            )
        elif p > 1.0 - _SURE:
            yield (
                f"the residuals scatter only {_short(found.scale)} times as much as σ promises: σ "
                "is too pessimistic, or the readings were smoothed or repeated"
            )
    if found.how.sigma == "estimated" and found.dof < _FEW:
        yield f"σ is estimated from {found.dof} degrees of freedom only: the intervals are wide"
    lack = found.lack_of_fit
    if lack is not None and lack.p_value < _SURE:
        yield (
            f"repeats agree with one another ({_short(lack.pure_scale)} of the promised noise) far "
            f"better than with the model ({_short(lack.fit_scale)}): this is model error, not "
            "noise; no number of repeats will cure it"
        )


def _intervals(found: Identification) -> Iterator[str]:
    low, high = found.interval.T
    open_ = [
        name
        for name, a, b, k in zip(found.identified, low, high, found.compliance, strict=True)
        if a < 0.0 < b and name not in found.held and k >= 0.0
    ]
    if open_:
        yield (
            f"{_listed(open_)}: the interval contains zero, so the data do not show that "
            f"{'this spring bends' if len(open_) == 1 else 'these springs bend'} at all"
        )


def _carried(found: Identification) -> Iterator[str]:
    """Load cases without which compliances are lost or much worse known."""
    ratio = found.configuration_influence.error_ratio
    if len(ratio) < 2:
        return
    most = np.argmax(ratio, axis=0)
    for g in np.unique(most).tolist():
        joints = [j for j in np.flatnonzero(most == g).tolist() if ratio[g, j] >= _CARRIES]
        if not joints:
            continue
        names = [found.measurements.names[i] for i in np.flatnonzero(found.configuration == g)]
        several = len(names) > 1
        what, it = ("the repeated experiments", "them") if several else ("experiment", "it")
        worst = float(ratio[g, joints].max())
        grows = (
            f"without {it} nothing is known of these joints"
            if np.isinf(worst)
            else f"without {it} the standard errors are up to {_short(worst)} times as large"
        )
        yield (
            f"{_listed([found.identified[j] for j in joints])}: carried by {what} "
            f"{_listed(names)}; {grows}, and no other load case checks {it}"
        )


def _correlated(found: Identification) -> Iterator[str]:
    correlation = found.correlation
    for i in range(len(correlation)):
        for j in range(i):
            if abs(correlation[i, j]) > _CLOSE:
                yield (
                    f"{found.identified[j]} and {found.identified[i]}: correlated by "
                    f"{correlation[i, j]:.3f}; their combination is known better than either"
                )


def _outlying(found: Identification) -> Iterator[str]:
    data = found.measurements
    if found.how.loss != "squares":
        low = np.flatnonzero(found.weight < 0.5)
        if len(low):
            gone = int((found.weight[low] < 0.01).sum())
            yield (
                f"{len(low)} of {len(data)} readings count less than half"
                + (f", {gone} of them not at all" if gone else "")
                + f": {_listed([_reading(found, r) for r in low.tolist()])}"
            )
        return
    limit = max(_FAR, np.sqrt(2.0 * np.log(3.0 * len(data)) + 6.0))
    size = _far_out(found, limit)
    far = np.flatnonzero(size > limit)
    if len(far):
        far = far[np.argsort(-size[far])]
        names = [_reading(found, r) for r in far.tolist()]
        yield (
            f"{_listed(names)}: more than {_short(size[far].min())} σ from "
            "what the other experiments say; look at it, or use a robust loss"
        )


def _far_out(found: Identification, limit: float) -> Array:
    """(R,) left-out residuals over their standard deviation; zero for those surely below `limit`.

    The noise alone is less than that deviation, and quickly had.
    """
    data = found.measurements
    noise = np.sqrt(np.diagonal(data.covariance, axis1=1, axis2=2))
    if found.how.sigma == "estimated":
        noise = noise * found.scale
    size = np.zeros(len(data))
    suspect = np.zeros(len(data.cases), dtype=bool)
    suspect[data.case[(np.abs(found.left_out) > limit * noise).any(axis=1)]] = True
    if suspect.any():
        expected = left_out_covariance(found, suspect)
        deviation = np.sqrt(np.diagonal(expected, axis1=1, axis2=2))
        there = suspect[data.case]
        size[there] = (np.abs(found.left_out[there]) / deviation).max(axis=1)
    return size


def _nonlinear(found: Identification) -> Iterator[str]:
    if found.how.model != "linear" and len(found.linear):
        return
    # The fit of the paper: say so where the deflections are large enough to matter.
    size = float(np.linalg.norm(found.measurements.deflection, axis=1).max(initial=0.0))
    if size > 2e-3:
        yield (
            f"linear model with deflections up to {1e3 * size:.2g} mm: its estimates are biased "
            "at second order; the model of the equilibrium is not"
        )


def _reading(found: Identification, reading: int) -> str:
    data = found.measurements
    name = data.names[data.case[reading]]
    marker = data.tool.marker_names[data.marker[reading]]
    return name if len(data.tool.markers) == 1 else f"{name}/{marker}"


def _short(value: float) -> str:
    """Two digits, without an exponent as long as people would write none."""
    return f"{float(f'{value:.2g}'):g}"


def _listed(names: list[str]) -> str:
    shown = ", ".join(names[:_MOST])
    return shown if len(names) <= _MOST else f"{shown} and {len(names) - _MOST} more"
