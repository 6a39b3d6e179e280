"""Validation: a model against experiments that were not used to make it.

In: elastic arm, compliance model, measurements. Out: deflections before and after the model, with
the intervals in which the model expects the readings to lie.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.compliance_model import ComplianceModel
from elastocal.elastic_arm import ElasticArm
from elastocal.equilibrium import deflection_and_gradient
from elastocal.fitting.goodness import p_value_chi_square
from elastocal.identification import Identification
from elastocal.measurement import Measurements
from elastocal.uncertainty import quantile


@dataclass(frozen=True)
class Validation:
    """R readings against a model.

    Attributes:
        measurements: The readings.
        before: (R, 3) measured deflections: the error without a model [m].
        after: (R, 3) measured minus predicted deflections: the error with it [m].
        deviation: (R, 3) standard deviation with which the model expects `after`: noise of the
            reading and uncertainty of the compliances [m].
        half_width: (R, 3) half widths of the prediction intervals [m].
        confidence: Their confidence.
        chi_square: `after` in units of its covariance, reading by reading, squared and summed.
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
    kept_aside: bool

    @property
    def inside(self) -> float:
        """Share of coordinates inside their prediction intervals."""
        return float((np.abs(self.after) <= self.half_width).mean())

    @property
    def dof(self) -> int:
        """Coordinates read."""
        return int(self.after.size)

    @property
    def p_value(self) -> float:
        """Probability of so large errors if model, noise and covariance are right."""
        return p_value_chi_square(self.chi_square, self.dof)

    def by_experiment(self, error: Array) -> Array:
        """(N,) root mean square over the readings of each experiment of errors (R, 3) [m]."""
        case, count = self.measurements.case, len(self.measurements.cases)
        squares = np.bincount(case, np.sum(error**2, axis=1), count)
        return np.sqrt(squares / np.maximum(np.bincount(case, minlength=count), 1))


@dataclass(frozen=True)
class Summary:
    """Sizes of R errors [m].

    Attributes:
        rms: Root mean square.
        mean: Mean.
        largest: Largest.
    """

    rms: float
    mean: float
    largest: float


def summary(error: Array) -> Summary:
    """Sizes of errors (R, 3) [m]."""
    size = np.linalg.norm(error, axis=1)
    return Summary(float(np.sqrt(np.mean(size**2))), float(size.mean()), float(size.max()))


def validate(
    arm: ElasticArm, model: ComplianceModel, measurements: Measurements, *, confidence: float = 0.95
) -> Validation:
    """A model against readings that were not used to make it.

    Args:
        arm: Robot and gravity; its springs are replaced by those of the model.
        model: Compliances with covariance.
        measurements: The readings.
        confidence: Confidence of the prediction intervals.

    Source: ours; the prediction covariance is G cov(k) Gᵀ + Σ.
    """
    bent = ElasticArm(arm.robot, model.springs, measurements.tool, arm.gravity)
    modelled, gradient = deflection_and_gradient(bent, model.compliance, measurements.cases)
    count, markers = len(measurements.cases), len(measurements.tool.markers)
    own = (measurements.case, measurements.marker)
    after = measurements.deflection - modelled.reshape(count, markers, 3)[own]
    rows = gradient.reshape(count, markers, 3, -1)[own]
    spread = rows @ model.covariance @ rows.transpose(0, 2, 1)
    return _judged(measurements, after, spread, model.dof, confidence, kept_aside=True)


def leave_one_out(found: Identification, *, confidence: float = 0.95) -> Validation:
    """The identification against its own readings, each experiment left out in turn.

    Experiments without which a compliance is unknown are predicted with the full fit, and their
    interval is infinite.

    Source: ours; left-out residuals in closed form, see `influence`.
    """
    data = found.measurements
    arm = ElasticArm(found.arm.robot, found.model.springs, data.tool, found.arm.gravity)
    _, gradient = deflection_and_gradient(arm, found.model.compliance, data.cases)
    rows = gradient.reshape(len(data.cases), len(data.tool.markers), 3, -1)[data.case, data.marker]
    # Without the experiment the standard errors are larger by the ratios of its influence.
    growth = np.ones((len(data.cases), len(found.model.compliance)))
    growth[:, found.index] = found.influence.error_ratio
    scaled = rows * growth[data.case][:, None, :]
    with np.errstate(invalid="ignore"):
        spread = scaled @ found.model.covariance @ scaled.transpose(0, 2, 1)
    spread = np.where(np.isnan(spread), np.inf, spread)
    return _judged(data, found.left_out, spread, found.model.dof, confidence, kept_aside=False)


def _judged(
    measurements: Measurements,
    after: Array,
    spread: Array,
    dof: float,
    confidence: float,
    *,
    kept_aside: bool,
) -> Validation:
    """Errors with the covariance in which they are expected."""
    expected = spread + measurements.covariance
    deviation = np.sqrt(np.diagonal(expected, axis1=1, axis2=2))
    finite = np.isfinite(expected).all(axis=(1, 2))
    solved = np.linalg.solve(expected[finite], after[finite][..., None])[..., 0]
    return Validation(
        measurements=measurements,
        before=measurements.deflection,
        after=frozen(after),
        deviation=frozen(deviation),
        half_width=frozen(quantile(0.5 + 0.5 * confidence, dof) * deviation),
        confidence=confidence,
        chi_square=float(np.einsum("ri,ri->", after[finite], solved)),
        kept_aside=kept_aside,
    )
