"""Validation: a model against experiments that were not used to make it.

In: elastic arm, compliance model, measurements. Out: deflections before and after the model, with
the intervals in which the model expects the readings to lie.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.arrays import Array, BoolArray, frozen
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.deflections import deflection_and_gradient
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt, InputError
from elastocal.fitting.chances import ratio_above
from elastocal.fitting.goodness import SURE, p_value_chi_square, quantile
from elastocal.identification.leave_one_out import left_out_covariance
from elastocal.identification.result import Identification
from elastocal.identification.shared_errors import SharedErrors, errors_in
from elastocal.measuring.measurements import Measurements, Quantity
from elastocal.measuring.whitening import noise_factors


@dataclass(frozen=True)
class Validation:
    """R readings against a model.

    Attributes:
        measurements: The readings.
        before: (R, 3) measured deflections: the error without a model [m, rad].
        after: (R, 3) measured minus predicted deflections: the error with it [m, rad].
        deviation: (R, 3) standard deviation with which the model expects `after`: noise of the
            reading and uncertainty of the compliances [m, rad].
        half_width: (R, 3) half widths of the prediction intervals [m, rad].
        confidence: Their confidence.
        chi_square: Kept aside: `after`, squared in units of the joint covariance of all readings,
            which share the error of the model. Left out in turn: that of the fit, over the noise
            found if it was estimated.
        dof: Degrees of freedom of it.
        noise_dof: Degrees of freedom of the noise found when the model was made; infinite if σ was
            known, zero where the errors are judged by the noise that they showed themselves.
        repeated: Experiments whose load case the identification had, too.
        kept_aside: Whether the readings took no part in making the model; False: every
            experiment was left out in turn.
    """

    measurements: Measurements = field(repr=False)
    before: Array
    after: Array
    deviation: Array
    half_width: Array
    confidence: float
    chi_square: float
    dof: int
    kept_aside: bool
    repeated: int = 0
    noise_dof: float = np.inf

    @property
    def inside(self) -> float:
        """Share of coordinates inside their prediction intervals; NaN if there are none."""
        inside = np.abs(self.after) <= self.half_width
        return float(inside[self.predicted].mean()) if self.coordinates else float("nan")

    @property
    def predicted(self) -> BoolArray:
        """(R,) readings of which the model, or the other experiments, say anything."""
        return np.asarray(np.isfinite(self.half_width).all(axis=1))

    @property
    def coordinates(self) -> int:
        """Coordinates that were predicted."""
        return 3 * int(self.predicted.sum())

    @property
    def p_value(self) -> float:
        """Probability of so large errors if model, noise and covariance are right.

        NaN where nothing is tested: errors over the noise that they themselves showed.

        Source: Seber & Lee, Linear Regression Analysis, section 5.3.
        """
        if np.isinf(self.noise_dof):
            return p_value_chi_square(self.chi_square, self.dof)
        if not (self.noise_dof > 0.0 and self.dof > 0):
            return float("nan")
        return ratio_above(self.chi_square / self.dof, self.dof, self.noise_dof)

    @property
    def tested(self) -> bool:
        """Whether anything judges the errors."""
        return bool(np.isfinite(self.p_value))

    @property
    def beyond_chance(self) -> bool:
        """Whether the errors are larger than noise and covariance explain."""
        return self.p_value < SURE

    def by_experiment(self, error: Array, kind: Quantity) -> Array:
        """(N,) root mean square over each experiment's readings of a kind of errors (R, 3)."""
        return self.measurements.by_experiment(error, kind)

    def sizes(self, kind: Quantity) -> tuple[Summary, Summary]:
        """Sizes of the errors of a kind before and after [its unit]."""
        own = kind.readings
        return summary(self.before[own]), summary(self.after[own])


def doubts_of_validation(validation: Validation) -> tuple[Doubt, ...]:
    """What should make one doubt the model."""
    data = validation.measurements
    worse: list[str] = []
    for kind in data.quantities:
        errors = (validation.by_experiment(e, kind) for e in (validation.after, validation.before))
        suffix = "" if kind.unit == "m" else f"/{kind.name}"
        worse += [f"{n}{suffix}" for n, a, b in zip(data.names, *errors, strict=True) if a > b]
    doubts = [Doubt("worse-with-model", tuple(worse))] if worse else []
    if validation.beyond_chance:
        told = ("chi_square", "dof", "p_value", "inside", "confidence")
        numbers = {name: getattr(validation, name) for name in told}
        doubts.append(Doubt("errors-unexplained", numbers=numbers))
    if validation.repeated:
        numbers = {"repeated": validation.repeated, "experiments": len(data.cases)}
        doubts.append(Doubt("same-load-cases", numbers=numbers))
    return tuple(doubts)


@dataclass(frozen=True)
class Summary:
    """Sizes of R errors of one kind [m, or rad].

    Attributes:
        rms: Root mean square.
        mean: Mean.
        largest: Largest.
    """

    rms: float
    mean: float
    largest: float


def summary(error: Array) -> Summary:
    """Sizes of errors (R, 3), all of one unit."""
    size = np.linalg.norm(error, axis=1)
    return Summary(float(np.sqrt(np.mean(size**2))), float(size.mean()), float(size.max()))


def validate(
    arm: ElasticArm,
    model: ComplianceModel,
    measurements: Measurements,
    *,
    confidence: float = 0.95,
    identified: LoadCases | None = None,
    errors: CaseErrors | None = None,
) -> Validation:
    """A model against readings that were not used to make it.

    Args:
        arm: Robot and gravity; its springs are replaced by those of the model.
        model: Compliances with covariance.
        measurements: The readings.
        confidence: Confidence of the prediction intervals.
        identified: Load cases that the model was made from, if they are known.
        errors: What errs from load case to load case besides; none if not given.

    Source: ours; the prediction covariance is G cov(k) Gᵀ + s² Σ, s the noise that was found when
    the model was made.
    """
    bent = replace(arm, springs=model.springs, tool=measurements.tool)
    modelled, gradient = deflection_and_gradient(bent, model.compliance, measurements.cases)
    count, targets = len(measurements.cases), len(measurements.tool.targets)
    own = (measurements.case, measurements.marker)
    after = measurements.deflection - modelled.reshape(count, targets, 3)[own]
    rows = gradient.reshape(count, targets, 3, -1)[own]
    spread = rows @ model.covariance @ rows.transpose(0, 2, 1)
    noise = model.noise**2 * measurements.covariance
    whitener = noise_factors(measurements.covariance)[1]
    shared = errors_in(measurements, whitener, errors, bent, model.compliance)
    if shared is not None:
        noise = noise + shared.own
    test = _joint(after, rows, model, whitener, shared), after.size, model.dof
    expected = spread + noise
    found = _judged(measurements, after, expected, model.dof, confidence, test, kept_aside=True)
    return replace(found, repeated=_repeated(measurements.cases, identified))


def _repeated(cases: LoadCases, before: LoadCases | None) -> int:
    """How many of N load cases are among those before, as well as a robot comes back to them."""
    if before is None or not len(before):
        return 0
    same = np.zeros(len(cases), dtype=bool)
    for q, wrench in zip(before.q, before.wrench, strict=True):
        near = np.abs(cases.q - q).max(axis=1) <= _SAME_PLACE
        size = max(float(np.linalg.norm(wrench)), 1e-300)
        same |= near & (np.linalg.norm(cases.wrench - wrench, axis=1) <= _SAME_LOAD * size)
    return int(same.sum())


_SAME_PLACE, _SAME_LOAD = 2e-3, 0.05  # joint values [rad, m], share of a load: one load case


def _joint(
    after: Array,
    rows: Array,
    model: ComplianceModel,
    whitener: Array,
    shared: SharedErrors | None,
) -> float:
    """Errors (R, 3) squared in units of all that is expected of them, all readings at once.

    That is noise, what readings share, and rows · covariance · rowsᵀ, rows (R, 3, p).

    Source: the matrix inversion lemma, for a covariance that may be singular.
    """
    white = (whitener @ rows).reshape(-1, rows.shape[2])
    left = np.einsum("rij,rj->ri", whitener, after).reshape(-1, 1)
    variance = np.full(len(left), model.noise**2)
    if shared is not None:
        white, left = shared.turned(white), shared.turned(left)
        variance = variance + shared.absolute
    quiet = left[:, 0] / variance
    pulled, told = white.T @ quiet, white.T @ (white / variance[:, None])
    covariance = model.covariance
    part = np.linalg.solve(np.eye(len(pulled)) + covariance @ told, covariance @ pulled)
    return float(left[:, 0] @ quiet - pulled @ part)


def leave_one_out(found: Identification, *, confidence: float = 0.95) -> Validation:
    """The identification against its own readings, each experiment left out in turn.

    Experiments without which a compliance is unknown are predicted with the full fit, and their
    interval is infinite: they do not count.

    Source: ours; left-out residuals in closed form, see `influence` and `left_out`.
    """
    expected, by_them = left_out_covariance(found), found.how.estimates_sigma
    # Left-out residuals depend on one another; together they say what the fit's χ² says: nothing
    # over the noise that was found from them.
    test = found.chi_square / found.noise_factor**2, found.dof, 0.0 if by_them else np.inf
    data, dof = found.measurements, found.model.dof
    return _judged(data, found.left_out, expected, dof, confidence, test, kept_aside=False)


def _judged(
    measurements: Measurements,
    after: Array,
    expected: Array,
    dof: float,
    confidence: float,
    test: tuple[float, int, float],
    *,
    kept_aside: bool,
) -> Validation:
    """Errors with the covariance in which they are expected."""
    if not 0.5 <= confidence < 1.0:
        raise InputError(f"the confidence must be from 0.5 to below 1, found {confidence:g}")
    deviation = np.sqrt(np.diagonal(expected, axis1=1, axis2=2))
    return Validation(
        measurements=measurements,
        before=measurements.deflection,
        after=frozen(after),
        deviation=frozen(deviation),
        half_width=frozen(quantile(0.5 + 0.5 * confidence, dof) * deviation),
        confidence=confidence,
        chi_square=test[0],
        dof=test[1],
        noise_dof=test[2],
        kept_aside=kept_aside,
    )
