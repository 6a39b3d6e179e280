"""What is weak in an identification. A strong result has no doubts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.errors import Doubt
from elastocal.fitting.goodness import SURE, p_value_chi_square, p_value_ratio
from elastocal.identification.growth import growth
from elastocal.identification.leave_one_out import left_out_covariance
from elastocal.identification.parallel import parallel
from elastocal.identification.result import Identification

SELDOM = 0.05
"""Probability below which chance is said; below `SURE` it is ruled out."""
_CLOSE = 0.95  # correlation above which two compliances are hard to tell apart
_SHARES = 0.4  # correlation with a nuisance parameter that takes a good part of a compliance
_CARRIES = 3.0  # growth of a standard error that makes an experiment indispensable
_NOISY = 1.5  # noise over the promised one; robust scales have no exact distribution
_EXPLAINED = 0.9  # share of the deflections that springs explain where nothing is missing
_NOTES = ("model-may-lack", "nearly-parallel", "noise-beside-errors", "shared-with-nuisance")
_VAGUE = 0.3  # standard error over a compliance that is not worth much
_SOFT = {"rad/(N·m)": 1e-3, "m/N": 1e-4}  # no joint of an arm is softer
_FAR = 4.5  # residual over its own standard deviation that calls for a look
_FEW = 5  # degrees of freedom below which an estimated σ means little
_LARGE = 2e-3  # deflection above which the linear model is too coarse [m]


def doubts(found: Identification) -> tuple[Doubt, ...]:
    """What should make one doubt the result; nothing if it is strong.

    Signs and sizes are judged on the fit without nuisance: there nothing hides them.
    """
    alone = found.alone or found
    return (
        *_of_joints(found, (*_signs(alone), *_sizes(alone))),
        *_told_apart(found),
        *_noise(found),
        *_of_joints(found, (*_explained(alone), *_growing(alone))),
        *_intervals(found),
        *_carried(found),
        *_correlated(found),
        *parallel(alone),
        *_by_chance(found),
        *_outlying(found),
        *_nonlinear(found),
    )


def _of_joints(found: Identification, judged: tuple[Doubt, ...]) -> Iterator[Doubt]:
    """Doubts of the fit of the joints alone, which is another one if there is nuisance."""
    for doubt in judged:
        other = found.alone is not None
        yield replace(doubt, numbers={**doubt.numbers, "alone": 1.0}) if other else doubt


def is_weak(doubt: Doubt) -> bool:
    """Whether a doubt makes a result weak: what chance may do is said, but no more."""
    if doubt.code in _NOTES:
        return False
    return not doubt.numbers.get("p_value", 0.0) >= SURE


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
        free = dict(zip(found.identified, found.unbounded.tolist(), strict=True))
        numbers = {name: free[name] for name in held}
        yield Doubt("held-at-zero", held, numbers=numbers, unit=_unit(found, held))


def _told_apart(found: Identification) -> Iterator[Doubt]:
    """Compliances that nuisance parameters may have: the two are known better together."""
    if found.nuisance is None:
        return
    error = np.sqrt(np.diagonal(found.unknown_covariance))
    correlation = found.unknown_covariance / np.outer(error, error)
    besides = found.nuisance.names
    together: list[tuple[str, str]] = []
    for name in found.identified:
        row = correlation[found.fitted.index(name)]
        alike = {n: float(r) for n, r in zip(found.fitted, row, strict=True) if n in besides}
        alike = {n: r for n, r in alike.items() if r < -_SHARES}
        if alike:
            most = min(alike, key=lambda n: alike[n])
            together.append((name, most))
    if together:
        ours, theirs = zip(*together, strict=True)
        yield Doubt("shared-with-nuisance", ours, theirs)


def _unit(found: Identification, names: tuple[str, ...]) -> str:
    """Unit of the compliances of these springs; none if they differ."""
    kinds = dict(zip(found.model.names, found.model.springs.kinds, strict=True))
    units = {kinds[name].compliance for name in names}
    return units.pop() if len(units) == 1 else ""


def _sizes(found: Identification) -> Iterator[Doubt]:
    """Compliances softer than any joint is."""
    kinds = [found.model.springs.kinds[i].compliance for i in found.index]
    for unit, most in _SOFT.items():
        sizes = {
            name: float(k)
            for name, k, kind in zip(found.identified, found.compliance, kinds, strict=True)
            if kind == unit and abs(k) > most
        }
        if sizes:
            yield Doubt("softer-than-any", tuple(sizes), numbers={**sizes, "most": most}, unit=unit)


def _noise(found: Identification) -> Iterator[Doubt]:
    if found.nuisance is not None:
        if not found.how.estimates_sigma:
            yield from _more_than_stated(found)
        elif not found.pure_dof:
            yield Doubt("noise-beside-errors", numbers={"dof": found.model.dof})
        return
    yield from _scatter(found)
    if found.how.estimates_sigma and found.dof < _FEW:
        yield Doubt("few-degrees-of-freedom", numbers={"dof": found.dof})
    yield from _unlike(found)
    lack = found.lack_of_fit
    if lack is not None and lack.beyond_chance:
        scales = {"pure_scale": lack.pure_scale, "fit_scale": lack.fit_scale}
        yield Doubt("model-error", numbers=scales)


def _scatter(found: Identification) -> Iterator[Doubt]:
    """Residuals against the promised noise, whether the intervals rest on it or not."""
    if not (found.dof > 0 and np.isfinite(found.scale)):
        return
    numbers = {"scale": found.scale, "chi_square": found.chi_square, "dof": float(found.dof)}
    if found.how.estimates_sigma:
        numbers["estimated"] = 1.0
    if found.how.robust:
        if found.scale > _NOISY:
            yield Doubt("noisier-than-promised", numbers=numbers)
        return
    p = p_value_chi_square(found.chi_square, found.dof)
    if p < SELDOM:
        yield Doubt("noisier-than-promised", numbers={**numbers, "p_value": p})
    elif p > 1.0 - SURE:
        yield Doubt("quieter-than-promised", numbers=numbers)


def _explained(found: Identification) -> Iterator[Doubt]:
    """Deflections of which the springs explain little."""
    data = found.measurements
    for kind in data.quantities:
        own = kind.readings
        whole, left = (
            float(np.sqrt(np.mean(np.sum(values[own] ** 2, axis=1))))
            for values in (data.deflection, found.residual)
        )
        if whole > 0.0 and left > (1.0 - _EXPLAINED) * whole:
            noise = float(np.sqrt(np.einsum("rii->", data.covariance[own]) / own.sum()))
            numbers = {"whole": whole, "left": left, "noise": noise}
            yield Doubt("explains-little", (kind.name,), numbers=numbers, unit=kind.unit)


def _growing(found: Identification) -> Iterator[Doubt]:
    """Residuals that are the larger the larger the load."""
    trend = growth(found)
    if trend is not None and trend.p_value < SELDOM:
        yield Doubt("grows-with-load", numbers=vars(trend))


def _more_than_stated(found: Identification) -> Iterator[Doubt]:
    """Residuals larger than noise, priors and errors of load cases together make them."""
    p = p_value_chi_square(found.chi_square, found.dof)
    if p < SELDOM:
        numbers = {"scale": float(np.sqrt(found.chi_square / found.dof)), "p_value": p}
        yield Doubt("more-than-stated", numbers=numbers)


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
        if a <= 0.0 < b and name not in found.held and k >= 0.0
    )
    if names:
        yield Doubt("zero-in-interval", names)
    shares = zip(found.identified, found.relative_error.tolist(), found.compliance, strict=True)
    vague = {n: e for n, e, k in shares if e > _VAGUE and k > 0.0 and n not in names}
    if vague:
        yield Doubt("hardly-known-compliance", tuple(vague), numbers=vague)


def _carried(found: Identification) -> Iterator[Doubt]:
    """Single experiments without which compliances are lost or much worse known.

    Few load cases with repeats are what a good plan has; each of them carries something.
    """
    ratio = found.configuration_influence.error_ratio
    if len(ratio) < 2:
        return
    most, alone = np.argmax(ratio, axis=0), np.bincount(found.configuration) == 1
    for g in np.unique(most).tolist():
        joints = [j for j in np.flatnonzero(most == g).tolist() if ratio[g, j] >= _CARRIES]
        if joints and alone[g]:
            experiment = int(np.flatnonzero(found.configuration == g)[0])
            yield Doubt(
                "carried",
                tuple(found.identified[j] for j in joints),
                (found.measurements.names[experiment],),
                {"error_ratio": float(ratio[g, joints].max())},
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
    if lack is not None and lack.fit_dof > 0 and SURE <= lack.p_value < SELDOM:
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
