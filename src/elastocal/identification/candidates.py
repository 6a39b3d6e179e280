"""What the model lacks: each candidate once in the fit, judged by what it would predict.

In: an identification. Out: the candidates with their chance and the error of experiments left out,
and those that are surely missing. No refit is made: a column c more in a fit with residual e,
information M and rows X has the estimate (cᵀQc)⁻¹ cᵀe, with Q = I - X M⁻¹ Xᵀ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.errors import Code, Doubt
from elastocal.fitting.chances import chi_square_above, ratio_above
from elastocal.fitting.goodness import SURE
from elastocal.fitting.influence import shifts
from elastocal.identification.candidate_columns import SPRINGS, Candidate, candidates
from elastocal.identification.doubts import SELDOM
from elastocal.identification.growth import growth
from elastocal.identification.linearised import Linearised, linearised
from elastocal.identification.result import Identification

_GAIN, _MORE = 0.05, 0.10  # shares of the left-out error that a missing thing takes away
_SEEN = 1e-3  # information of a column beside the fit, as a share of its own
_FAR = 4.5  # residual over the noise that is no normal one
_FEW = 10.0  # degrees of freedom from which residuals tell their noise themselves
_NEAREST = 5  # candidates whose predictions are worked out, whatever chance says of them
_ROUNDS = 3  # things that may be missing together
_LEFT = 0.5  # share of the configurations that must be predictable from the others


@dataclass(frozen=True, eq=False)
class Tested:
    """A candidate that was put into the fit.

    Attributes:
        candidate: What it is.
        p_value: Probability that chance makes the best of all candidates as good.
        before: Error of the configurations left out in turn, root mean square [m]; without it.
        left_out: The same with it; NaN if they cannot be left out, or chance does as much.
        gain: Share of the left-out error over the noise that it takes away.
        share: Share of the residual variance that it takes away.
        size: (d,) its estimates [rad/(N·m), m/N, m or rad].
        change: (f,) what becomes of the fitted compliances, as a share of what they were.
        most: Which of them changes most, in standard errors.
        physical: Whether it can be: a spring is not below zero.
    """

    candidate: Candidate
    p_value: float
    before: float
    left_out: float
    gain: float
    share: float
    size: Array
    change: Array
    most: int
    physical: bool


@dataclass(frozen=True)
class Lacks:
    """Candidates for what a model lacks.

    Attributes:
        fitted: Names of the f fitted springs.
        tested: All candidates that the readings can tell, the best first.
        missing: Those that are surely missing, each with the ones before in the fit.
    """

    fitted: tuple[str, ...]
    tested: tuple[Tested, ...]
    missing: tuple[Tested, ...]

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """What is missing, or may be."""
        if self.missing:
            return tuple(self._doubt("model-lacks", one) for one in self.missing)
        likely = [one for one in self.tested if one.physical and one.p_value < SELDOM]
        if not likely:
            return ()
        return (self._doubt("model-may-lack", min(likely, key=lambda one: one.p_value)),)

    def _doubt(self, code: Code, one: Tested) -> Doubt:
        numbers = {
            "share": one.share,
            "change": float(one.change[one.most]),
            "p_value": one.p_value,
            **dict(zip(("size", "y", "z"), one.size.tolist(), strict=False)),
        }
        if np.isfinite(one.left_out):
            numbers |= {"before": one.before, "after": one.left_out}
        if one in self.missing[1:]:
            numbers["besides"] = 1.0
        what = one.candidate
        because = (what.kind, *([what.carrier, what.axis] if what.carrier else []))
        return Doubt(code, (self.fitted[one.most],), because, numbers)


def what_is_missing(found: Identification) -> Lacks:
    """What the model lacks.

    A candidate is missing if the best of all would be as good by chance in less than one of 1000
    right models, and the error of configurations left out in turn falls by 5 % or, where residuals
    grow with the load or some are far out, 10 %. Each is sought with those before it in the fit.

    Source: ours; score tests, see Seber & Lee, Linear Regression Analysis, ch. 4.
    """
    fit, columns = linearised(found), candidates(found)
    names = fit.names
    if not names:
        return Lacks((), (), ())
    white = [(c, fit.white(values)) for c, values in columns]
    known = not (found.how.estimates_sigma or found.how.robust)
    trend = growth(found)
    least = _MORE if trend is not None and trend.p_value < SELDOM else _GAIN
    if np.abs(fit.residual).max(initial=0.0) > _FAR * np.sqrt(np.mean(fit.residual**2)):
        least = _MORE
    compliance = found.model.of(fit.names)
    first = each_added(fit, white, compliance, known=known)
    missing: list[Tested] = []
    now = first
    while len(missing) < _ROUNDS and (best := _surely(now, least)) is not None:
        missing.append(best)
        compliance = compliance * (1.0 + best.change)
        columns_of_it = next(values for c, values in white if c == best.candidate)
        fit = added(fit, columns_of_it)
        white = [(c, values) for c, values in white if c != best.candidate]
        now = each_added(fit, white, compliance, known=known)
    return Lacks(names, tuple(sorted(first, key=_error)), tuple(missing))


def _error(one: Tested) -> float:
    return one.left_out if np.isfinite(one.left_out) else np.inf


def _surely(all_: Sequence[Tested], least: float) -> Tested | None:
    """The missing one that predicts best, if any is."""
    sure = [t for t in all_ if t.physical and t.p_value < SURE and t.gain >= least]
    return min(sure, key=_error, default=None)


def each_added(
    fit: Linearised,
    columns: Sequence[tuple[Candidate, Array]],
    compliance: Array,
    *,
    known: bool,
) -> list[Tested]:
    """Each candidate once in the fit; those that the readings cannot tell are left out.

    Args:
        fit: The fit at its estimate.
        columns: Candidates with their columns (R, 3, d) over the noise.
        compliance: (f,) what was fitted; unknowns added since have none.
        known: Whether the noise is what was promised. It judges where few degrees of freedom are
            left, if it explains what is left; else the scatter of the residuals does: a noise that
            is a little larger than promised would make things missing.
    """
    made = [(c, found) for c, values in columns if (found := _entered(fit, values)) is not None]
    square = float(np.sum(fit.residual**2))
    free = fit.residual.size - float(np.sum(fit.covariance * _own(fit)))
    chances = [_chance(square, free, found[1], known=known) for _, found in made]
    order = np.argsort(chances, kind="stable")
    before = _left_out(fit) if len(made) else np.zeros((0, 3))
    error = np.sqrt(np.diagonal(fit.covariance))[: len(compliance)]
    results = []
    for place, i in enumerate(order.tolist()):
        candidate, (basis, pull, size, moved) = made[i]
        p = min(1.0, len(made) * chances[i])
        one, other, gain = np.nan, np.nan, -np.inf
        if place < _NEAREST or p < SELDOM:  # the others are no better than chance
            one, other, gain = _predicted(fit, before, _with(fit, basis, pull))
        change = moved[: len(compliance)]
        results.append(
            Tested(
                candidate=candidate,
                p_value=p,
                before=one,
                left_out=other,
                gain=gain,
                share=float(pull @ pull) / max(square, 1e-300),
                size=size,
                change=change / np.where(compliance == 0.0, np.inf, compliance),
                most=int(np.argmax(np.abs(change / error))),
                physical=candidate.kind not in SPRINGS or bool((size >= 0.0).all()),
            )
        )
    return results


def _chance(square: float, free: float, pull: Array, *, known: bool) -> float:
    """Probability that chance takes as much of the residuals, of a sum of squares and freedom."""
    taken, d = float(pull @ pull), len(pull)
    left, dof = max(square - taken, 1e-300), free - d
    if not dof > 0.0:
        return 1.0
    if known and dof < _FEW and chi_square_above(left, dof) >= SURE:
        return chi_square_above(taken, d)
    return ratio_above((taken / d) / (left / dof), d, dof)


def _predicted(fit: Linearised, before: Array, more: Linearised) -> tuple[float, float, float]:
    """Errors [m] of configurations left out of a fit, and of one with more; the share saved.

    Those that one of both cannot do without do not count; nothing can be said if most are.
    """
    after = _left_out(more)
    both = np.asarray(np.isfinite(before + after).all(axis=1))
    if both.mean() < _LEFT:
        return np.nan, np.nan, -np.inf
    one, other = _rms(before[both]), _rms(after[both])
    gain = 1.0 - other / one if one > 0.0 else -np.inf
    return _length(fit, before, both), _length(fit, after, both), gain


def _own(fit: Linearised) -> Array:
    """(f, f) what the readings say, without a prior."""
    flat = fit.rows.reshape(-1, fit.rows.shape[2])
    return np.asarray(flat.T @ flat)


def _entered(fit: Linearised, columns: Array) -> tuple[Array, Array, Array, Array] | None:
    """Columns (R, 3, d) beside a fit; None if they say nothing that it does not.

    Returns:
        Basis (R, 3, d) of what they add, with unit information; (d,) estimates in it; (d,)
        estimates of the columns; (f,) how they move what was fitted.
    """
    flat = fit.rows.reshape(-1, fit.rows.shape[2])
    c = columns.reshape(len(flat), -1)
    scale = np.sqrt(np.sum(c**2, axis=0))
    if not (scale > 0.0).all():
        return None
    c = c / scale
    shared = fit.covariance @ (flat.T @ c)
    beside = c - flat @ shared
    values, vectors = np.linalg.eigh(c.T @ beside)
    seen = values > _SEEN
    if not seen.any():
        return None
    root = vectors[:, seen] / np.sqrt(values[seen])
    basis = beside @ root
    pull = (fit.residual.ravel() @ c) @ root
    size = root @ pull
    return basis.reshape(*columns.shape[:2], -1), pull, size / scale, -shared @ size


def _with(fit: Linearised, basis: Array, pull: Array) -> Linearised:
    """The fit with a basis of unit information beside it, at its new estimate."""
    f, d = len(fit.information), len(pull)
    information = np.zeros((f + d, f + d))
    information[:f, :f], information[f:, f:] = fit.information, np.eye(d)
    flat = fit.rows.reshape(-1, f).T @ basis.reshape(-1, d)
    information[:f, f:], information[f:, :f] = flat, flat.T
    return replace(
        fit,
        rows=np.concatenate([fit.rows, basis], axis=2),
        residual=fit.residual - basis @ pull,
        information=information,
    )


def added(fit: Linearised, columns: Array) -> Linearised:
    """The fit with columns (R, 3, d) over the noise in it."""
    found = _entered(fit, columns)
    return fit if found is None else _with(fit, found[0], found[1])


def _left_out(fit: Linearised) -> Array:
    """(R, 3) residuals over the noise when their configuration is left out; NaN if it cannot be."""
    count = int(fit.group.max(initial=0)) + 1
    shift = shifts(fit.rows, fit.residual, fit.group, count, fit.information)
    return np.asarray(fit.residual - np.einsum("rip,rp->ri", fit.rows, shift[fit.group]))


def _rms(errors: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(errors**2, axis=1))))


def _length(fit: Linearised, errors: Array, which: BoolArray) -> float:
    """Root mean square of errors (R, 3) over the noise as lengths [m], of positions alone."""
    own = which & fit.position
    if not own.any():
        return float("nan")
    if fit.shared is not None:  # turned coordinates are those of several readings
        return _rms(errors[own]) * float(np.sqrt(np.mean(fit.noise[own] ** 2) * 3.0))
    return _rms(np.einsum("rij,rj->ri", fit.noise[own], errors[own]))
