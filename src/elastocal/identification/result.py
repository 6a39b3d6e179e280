"""Identification: compliances found from measurements, and how far to trust them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.nuisance import Nuisance
from elastocal.fitting.goodness import LackOfFit, quantile, quantiles
from elastocal.fitting.influence import Influence
from elastocal.fitting.least_squares import column_norms
from elastocal.identification.fit import Fit
from elastocal.identification.influences import LeftWithout
from elastocal.measuring.measurements import Measurements, Quantity


@dataclass(frozen=True)
class NoiseFound:
    """Noise of the readings of one kind.

    Attributes:
        kind: Positions or rotations.
        scale: Estimated noise over the promised one.
        dof: Degrees of freedom of that: coordinates, less the share of the unknowns they tell.
    """

    kind: Quantity
    scale: float
    dof: float


@dataclass(frozen=True)
class Identification:
    """Compliances found from measurements, and how far to trust them.

    Attributes:
        model: All compliances, those that were known beforehand included, with their covariance.
        identified: Names of the p identified ones, in chain order.
        fitted: Names of the f unknowns: these, those known beforehand, but not exactly, nuisance
            parameters, and what all experiments share.
        how: How they were fitted.
        linear: (p,) estimates of the linear model, from the same readings.
        scale: Estimated noise over that of instrument or file; 1 means: as promised.
        noise_of_kinds: The same of positions and of rotations, each from its own residuals.
        chi_square: Sum of the squared residuals over their variances, promised ones.
        dof: Degrees of freedom: coordinates read, less unknowns.
        pure_dof: Those that show the instrument's noise and nothing else, where it was found.
        lack_of_fit: What repeats say of the model; None without repeats.
        residual: (R, 3) measured minus modelled deflections [m, rad].
        weight: (R,) weights that a robust loss gave to the readings, 1 at most.
        influence: Of every experiment.
        configuration_influence: Of every distinct load case.
        without_experiment: What is left of every reading when its experiment is left out.
        without_load_case: The same when all repeats of its load case are.
        held: Names held at zero by `nonnegative`.
        unknown: (f,) estimates of all that was fitted.
        unknown_covariance: (f, f) their covariance.
        unbounded: (p,) estimates of those that are sought without that bound.
        triangle: (f, f) upper triangular R with RᵀR the information.
        variance: What the promised variances of the readings count for in it.
        iterations: Gauss-Newton steps.
        measurements: What was fitted.
        arm: The robot with all springs of the model and the measured tool.
        nuisance: What was fitted along besides; None for nothing.
        alone: The fit without it.
    """

    model: ComplianceModel
    identified: tuple[str, ...]
    fitted: tuple[str, ...]
    how: Fit
    linear: Array
    scale: float
    noise_of_kinds: tuple[NoiseFound, ...]
    chi_square: float
    dof: int
    pure_dof: int
    lack_of_fit: LackOfFit | None
    residual: Array
    weight: Array
    influence: Influence
    configuration_influence: Influence
    without_experiment: LeftWithout
    without_load_case: LeftWithout
    held: tuple[str, ...]
    unknown: Array
    unknown_covariance: Array
    unbounded: Array
    triangle: Array
    variance: float
    iterations: int
    measurements: Measurements = field(repr=False)
    arm: ElasticArm = field(repr=False)
    nuisance: Nuisance | None = None
    alone: Identification | None = field(default=None, repr=False)

    @property
    def index(self) -> list[int]:
        """Positions of the identified springs in `model`."""
        return [self.model.names.index(name) for name in self.identified]

    @property
    def compliance(self) -> Array:
        """(p,) identified compliances [rad/(N·m) or m/N]."""
        return self.model.compliance[self.index]

    @property
    def standard_error(self) -> Array:
        """(p,) their standard errors."""
        return self.model.standard_error[self.index]

    @property
    def freedom(self) -> Array:
        """(p,) degrees of freedom behind each standard error."""
        return self.model.freedom(np.eye(len(self.model.springs))[self.index])

    @property
    def left_out(self) -> Array:
        """(R, 3) residuals of every reading when its experiment is left out [m, rad]."""
        return self.without_experiment.residual

    @property
    def width(self) -> float:
        """Half width of a confidence interval in standard errors, where all of it rests on σ."""
        return quantile(0.5 + 0.5 * self.how.confidence, self.model.dof)

    @property
    def interval(self) -> Array:
        """(p, 2) confidence intervals [rad/(N·m) or m/N]; of what is held at zero, one-sided.

        Where compliances below zero are ruled out, so are they in the intervals.

        Source: a limit on what cannot be below zero, from the estimate without the bound.
        """
        confidence, dof = self.how.confidence, self.freedom
        half = quantiles(0.5 + 0.5 * confidence, dof) * self.standard_error
        found = np.asarray(self.compliance[:, None] + np.outer(half, [-1.0, 1.0]))
        held = [name in self.held for name in self.identified]
        limit = quantiles(confidence, dof) * self.standard_error
        if self.how.nonnegative or self.nuisance is not None:
            found[:, 0] = np.maximum(found[:, 0], 0.0)
        found[held, 1] = (np.maximum(self.unbounded, 0.0) + limit)[held]
        return found

    @property
    def information(self) -> Array:
        """(f, f) inverse covariance for the noise there is, prior and weights included."""
        return np.asarray(self.triangle.T @ self.triangle)

    @property
    def configuration(self) -> IntArray:
        """(N,) distinct load case of every experiment."""
        return self.measurements.cases.distinct

    @property
    def singular_values(self) -> Array:
        """(p,) of the scaled rows, largest first: how well the combinations are seen."""
        return self._decomposed[0]

    @property
    def combinations(self) -> Array:
        """(p, p) the combinations, in units of the columns' norms; one in each row."""
        return self._decomposed[1]

    @cached_property
    def _decomposed(self) -> tuple[Array, Array]:
        own = self._own_triangle
        _, values, vectors = np.linalg.svd(own / column_norms(own))
        return values, vectors

    @property
    def _own_triangle(self) -> Array:
        """(p, p) of the identified ones, whatever the others are: those come first in the QR."""
        others = [i for i, name in enumerate(self.fitted) if name not in self.identified]
        if not others:
            return self.triangle
        own = [self.fitted.index(name) for name in self.identified]
        whole = np.asarray(np.linalg.qr(self.triangle[:, others + own], mode="r"))
        return whole[len(others) :, len(others) :]

    @property
    def noise_factor(self) -> float:
        """What promised standard deviations are multiplied by: `scale` if σ was estimated."""
        return self.scale if self.how.estimates_sigma else 1.0

    @property
    def relative_error(self) -> Array:
        """(p,) standard errors over the compliances; zero for those held at zero."""
        held = np.array([name in self.held for name in self.identified], dtype=bool)
        return np.where(
            held, 0.0, self.standard_error / np.maximum(np.abs(self.compliance), 1e-300)
        )

    @property
    def linear_shift(self) -> Array:
        """(p,) how far the linear model would be off the estimates, in standard errors."""
        off = np.abs(self.linear - self.compliance)
        return np.asarray(off / np.maximum(self.standard_error, 1e-300))

    @property
    def correlation(self) -> Array:
        """(p, p) correlation of the identified compliances."""
        covariance = self.model.covariance[np.ix_(self.index, self.index)]
        error = np.sqrt(np.diagonal(covariance))
        scale = np.where(error > 0.0, 1.0 / np.where(error > 0.0, error, 1.0), 0.0)
        return np.asarray(covariance * np.outer(scale, scale))
