"""Compliances that only errors of the joint readings tell apart.

In: springs and readings, or a fit of them. Out: which compliances are known together alone. Columns
that are parallel differ by what joint readings are off, and a fit takes that for knowledge: its
estimates are biased, however small their standard errors. So the difference is measured by what
readings off by so much would make of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Code, Doubt, InputError
from elastocal.identification.linearised import linear_rows, linearised
from elastocal.identification.result import Identification
from elastocal.measuring.measurements import Measurements
from elastocal.measuring.whitening import noise_factors
from elastocal.wording import worded

READ = float(np.radians(0.005))
"""How far joint readings may be off [rad, m]."""
_BIASED, _HARDLY = 10.0, 100.0  # difference over what readings off make: bias of 10 %, of 1 %
_KINDS: tuple[tuple[Code, float, float], ...] = (
    ("parallel", -np.inf, _BIASED),
    ("nearly-parallel", _BIASED, _HARDLY),
)
_APART = 1e-3  # eigenvalue of scaled columns that no error of a joint makes
_INVOLVED = 0.1  # share of a compliance in a combination, of the largest
_ROUNDING = 1e-13  # of information of unit size
_STEP = 1e-5  # of a difference [rad, m]


def parallel(found: Identification) -> tuple[Doubt, ...]:
    """Fitted compliances that are known together alone, or hardly apart."""
    found = found.alone or found
    scale = 1.0 / np.sqrt(np.diagonal(found.information))
    if np.linalg.eigvalsh(found.information * np.outer(scale, scale))[0] > _APART:
        return ()
    fit = linearised(found)
    own = [found.model.names.index(name) for name in fit.names]
    arm = replace(found.arm, springs=found.model.springs, tool=found.measurements.tool)
    flat = fit.rows.reshape(-1, len(fit.names))
    prior = fit.information - flat.T @ flat
    return tuple(_doubts(arm, found.measurements, own, fit.names, fit.rows, prior, fit.white))


def refuse_parallel(arm: ElasticArm, data: Measurements) -> None:
    """Raise if only errors of the joint readings tell compliances apart: no fit comes to rest then.

    Raises:
        InputError: they do; names the compliances.
    """
    bent = replace(arm, tool=data.tool)
    whitener = noise_factors(data.covariance)[1]
    count = len(arm.springs)

    def white(columns: Array) -> Array:
        return np.asarray(whitener @ columns)

    rows = white(linear_rows(bent, data))
    nothing = np.zeros((count, count))
    names = arm.springs.names
    for doubt in _doubts(bent, data, range(count), names, rows, nothing, white):
        if doubt.code == "parallel":
            raise InputError(
                f"{data.source or 'the measurements'}: the fit does not come to rest, for "
                f"{worded(doubt)}"
            ).with_doubts(doubt)


def _doubts(
    arm: ElasticArm,
    data: Measurements,
    own: Sequence[int],
    names: Sequence[str],
    rows: Array,
    prior: Array,
    white: Callable[[Array], Array],
) -> Iterator[Doubt]:
    """What is known together alone of the springs `own` of an arm, with rows (R, 3, f).

    Source: ours; errors in variables shrink an estimate along an eigenvector of (XᵀX, D) by
    1 / (1 + 1/μ), D the mean of dXᵀdX.
    """
    flat = rows.reshape(-1, len(names))
    read = np.linalg.norm(flat, axis=0)
    # What is known before counts: no reading need move a spring that is.
    size = np.sqrt(read**2 + np.maximum(np.diagonal(prior), 0.0))
    if not (len(names) and (size > 0.0).all()):
        return
    scaled = flat / size
    outer = np.outer(size, size)
    information = scaled.T @ scaled + prior / outer
    spread = _by_readings(arm, data, own, white) / outer
    root = np.linalg.cholesky(information + _ROUNDING * np.eye(len(names)))
    half = np.linalg.solve(root, np.linalg.solve(root, spread).T)
    shares, vectors = np.linalg.eigh(0.5 * (half + half.T))
    values = 1.0 / np.maximum(shares, 1e-300)
    directions = np.linalg.solve(root.T, vectors)
    directions = directions / np.abs(directions).max(axis=0)
    for code, low, high in _KINDS:
        weak = (low <= values) & (values < high)
        if not weak.any():
            continue
        involved = np.abs(directions[:, weak]).max(axis=1) > _INVOLVED
        members = np.flatnonzero(involved).tolist()
        seen = np.maximum(read[members], 1e-300)
        alike = flat[:, members] / seen
        known = np.linalg.eigh(alike.T @ alike)[1][:, -1] * seen
        known = known / known[np.argmax(np.abs(known))]
        numbers = {names[j]: float(k) for j, k in zip(members, known, strict=True)}
        numbers |= {"ratio": float(values[weak].min()), "seen": float(len(members) - weak.sum())}
        yield Doubt(code, tuple(names[j] for j in members), (), numbers)


def _by_readings(
    arm: ElasticArm, data: Measurements, own: Sequence[int], white: Callable[[Array], Array]
) -> Array:
    """(f, f) mean of dXᵀdX where every joint is read by `READ` off, rows over the noise."""
    q, wrench = data.cases.q, data.cases.wrench
    total = np.zeros((len(own), len(own)))
    for step in _STEP * np.eye(q.shape[1]):
        ahead, back = (
            linear_rows(arm, replace(data, cases=LoadCases(at, wrench)))
            for at in (q + step, q - step)
        )
        slope = white((ahead - back)[:, :, own]).reshape(-1, len(own)) / (2.0 * _STEP)
        total += slope.T @ slope
    return np.asarray(READ**2 * total)
