"""What is weak in an identification. A strong result has no doubts."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.errors import Doubt
from elastocal.fitting.goodness import SURE, p_value_chi_square, p_value_ratio
from elastocal.identification.leave_one_out import left_out_covariance
from elastocal.identification.result import Identification

_CLOSE = 0.95  # correlation above which two compliances are hard to tell apart
_CARRIES = 3.0  # growth of a standard error that makes an experiment indispensable
_SELDOM = 0.01  # probability below which an all-clear beside it would be read as a mistake
_FAR = 4.5  # residual over its own standard deviation that calls for a look
_FEW = 5  # degrees of freedom below which an estimated σ means little
_LARGE = 2e-3  # deflection above which the linear model is too coarse [m]


def doubts(found: Identification) -> tuple[Doubt, ...]:
    """What should make one doubt the result; nothing if it is strong."""
    return (
        *_signs(found),
        *_noise(found),
        *_intervals(found),
        *_carried(found),
        *_correlated(found),
        *_by_chance(found),
        *_outlying(found),
        *_nonlinear(found),
    )


def _signs(found: Identification) -> Iterator[Doubt]:
    negative = found.compliance < 0.0
    names = tuple(n for n, below in zip(found.identified, negative, strict=True) if below)
    if len(names) == len(found.identified) > 1:
        yield Doubt("all-negative", names)
    elif names:
        yield Doubt("negative", names)
    held = tuple(n for n in found.held if n in found.identified)
    if len(held) == len(found.identified) > 1:
        yield Doubt("all-held-at-zero", held)
    elif held:
        yield Doubt("held-at-zero", held)


def _noise(found: Identification) -> Iterator[Doubt]:
    numbers = {"scale": found.scale, "chi_square": found.chi_square, "dof": found.dof}
    if found.dof > 0 and not (found.how.estimates_sigma or found.how.robust):
        p = p_value_chi_square(found.chi_square, found.dof)
        if p < SURE:
            yield Doubt("noisier-than-promised", numbers=numbers)
        elif p > 1.0 - SURE:
            yield Doubt("quieter-than-promised", numbers=numbers)
    if found.how.estimates_sigma and found.dof < _FEW:
        yield Doubt("few-degrees-of-freedom", numbers={"dof": found.dof})
    yield from _unlike(found)
    lack = found.lack_of_fit
    if lack is not None and lack.beyond_chance:
        scales = {"pure_scale": lack.pure_scale, "fit_scale": lack.fit_scale}
        yield Doubt("model-error", numbers=scales)


def _unlike(found: Identification) -> Iterator[Doubt]:
    """Positions and rotations whose noises are not in the ratio that was promised."""
    if len(found.noise_of_kinds) < 2 or found.how.robust:
        return
    one, other = found.noise_of_kinds
    if p_value_ratio(one.scale, one.dof, other.scale, other.dof) < SURE:
        yield Doubt("unlike-noise", numbers={"positions": one.scale, "rotations": other.scale})


def _intervals(found: Identification) -> Iterator[Doubt]:
    low, high = found.interval.T
    names = tuple(
        name
        for name, a, b, k in zip(found.identified, low, high, found.compliance, strict=True)
        if a < 0.0 < b and name not in found.held and k >= 0.0
    )
    if names:
        yield Doubt("zero-in-interval", names)


def _carried(found: Identification) -> Iterator[Doubt]:
    """Load cases without which compliances are lost or much worse known."""
    ratio = found.configuration_influence.error_ratio
    if len(ratio) < 2:
        return
    most = np.argmax(ratio, axis=0)
    first = np.unique(found.configuration, return_index=True)[1]
    for g in np.unique(most).tolist():
        joints = [j for j in np.flatnonzero(most == g).tolist() if ratio[g, j] >= _CARRIES]
        if joints:
            experiments = np.flatnonzero(found.configuration == g)
            place = 1 + int(np.sum(first < first[g]))  # as in the run sheet: in order of execution
            yield Doubt(
                "carried",
                tuple(found.identified[j] for j in joints),
                tuple(found.measurements.names[i] for i in experiments),
                {"error_ratio": float(ratio[g, joints].max()), "configuration": place},
            )


def _correlated(found: Identification) -> Iterator[Doubt]:
    correlation = found.correlation
    for i in range(len(correlation)):
        for j in range(i):
            if abs(correlation[i, j]) > _CLOSE:
                pair = (found.identified[j], found.identified[i])
                yield Doubt("correlated", pair, numbers={"correlation": float(correlation[i, j])})


def _by_chance(found: Identification) -> Iterator[Doubt]:
    """Repeats that differ from the model as they seldom do by chance, but may."""
    lack = found.lack_of_fit
    if lack is not None and lack.fit_dof > 0 and SURE <= lack.p_value < _SELDOM:
        yield Doubt("by-chance", numbers={"p_value": float(lack.p_value)})


def _outlying(found: Identification) -> Iterator[Doubt]:
    data = found.measurements
    if found.how.robust:
        low = np.flatnonzero(found.weight < 0.5)
        if len(low):
            unused = int((found.weight[low] < 0.01).sum())
            numbers = {"readings": len(data), "unused": unused}
            yield Doubt("counts-less", _readings(found, low), numbers=numbers)
        return
    limit = max(_FAR, np.sqrt(2.0 * np.log(3.0 * len(data)) + 6.0))
    size = _far_out(found, limit)
    far = np.flatnonzero(size > limit)
    if len(far):
        far = far[np.argsort(-size[far])]
        deviations = {"deviations": float(size[far].min())}
        yield Doubt("outlying", _readings(found, far), numbers=deviations)


def _far_out(found: Identification, limit: float) -> Array:
    """(R,) left-out residuals over their standard deviation; zero for those surely below `limit`.

    The noise alone is less than that deviation, and quickly had.
    """
    data = found.measurements
    noise = found.noise_factor * data.deviation
    size = np.zeros(len(data))
    suspect = np.zeros(len(data.cases), dtype=bool)
    suspect[data.case[(np.abs(found.left_out) > limit * noise).any(axis=1)]] = True
    if suspect.any():
        expected = left_out_covariance(found, suspect)
        deviation = np.sqrt(np.diagonal(expected, axis1=1, axis2=2))
        there = suspect[data.case]
        size[there] = (np.abs(found.left_out[there]) / deviation).max(axis=1)
    return size


def _nonlinear(found: Identification) -> Iterator[Doubt]:
    if not found.how.linear:
        return
    # The fit of the paper: say so where the deflections are large enough to matter.
    data = found.measurements
    size = float(data.length[~data.rotations].max(initial=0.0))
    if size > _LARGE:
        yield Doubt("linear-model", numbers={"deflection": size})


def _readings(found: Identification, readings: IntArray) -> tuple[str, ...]:
    """Names of readings: of the experiment, and of what was read if there are several targets."""
    data = found.measurements
    names = [data.names[i] for i in data.case[readings]]
    if len(data.tool.targets) == 1:
        return tuple(names)
    targets = [data.tool.targets[m] for m in data.marker[readings]]
    return tuple(f"{name}/{target}" for name, target in zip(names, targets, strict=True))
