"""Gauss-Newton on the equilibrium: compliances whose modelled deflections fit the measured ones.

In: elastic arm, measurements. Out: estimate, rows and residuals at it. Equilibrium and estimate are
improved together: a step linearises both, so that one pass over the load cases serves both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic_arm import ElasticArm
from elastocal.elastostatics import regressor
from elastocal.equilibrium import linearise, markers_at
from elastocal.errors import InputError
from elastocal.least_squares import LinearFit, fit
from elastocal.load_case import LoadCases
from elastocal.measurement import Measurements
from elastocal.robust import Bisquare, Huber, Loss, Squares, robust_scale

_MOST_STEPS = 60
_AT_REST = 1e-7  # step over the size of the compliances, and over the standard errors


@dataclass(frozen=True)
class Problem:
    """What is to be fitted.

    Attributes:
        arm: Robot with all springs that bend, identified or not.
        free: (p,) positions of the identified ones.
        start: Compliances of all springs; those of the free ones do not count.
        measurements: R readings.
        extra_rows: (E, p) further rows, such as a prior's.
        extra_values: (E,) their values.
        nonnegative: Whether compliances below zero are ruled out.
        known_noise: Whether the covariances are true and not only right up to a factor.
    """

    arm: ElasticArm
    free: IntArray
    start: Array
    measurements: Measurements
    extra_rows: Array
    extra_values: Array
    nonnegative: bool
    known_noise: bool


@dataclass(frozen=True)
class Solution:
    """Where the iteration came to rest.

    Attributes:
        compliance: (p,) free compliances.
        fit: The last linear fit; its triangle is that of the whole problem.
        rows: (R, 3, c) rows of all springs over the noise.
        residual: (R, 3) residuals over the noise.
        whitener: (R, 3, 3) factors that divided them.
        weight: (R,) robust weights.
        scale: Noise over the promised one, as the weights saw it.
        iterations: Steps taken.
    """

    compliance: Array
    fit: LinearFit
    rows: Array
    residual: Array
    whitener: Array
    weight: Array
    scale: float
    iterations: int


def solve(problem: Problem, model: str, loss: Loss) -> Solution:
    """Fit the free compliances.

    Args:
        problem: What is to be fitted.
        model: "linear" or "equilibrium".
        loss: How readings count.

    Raises:
        InputError: the iteration does not come to rest.

    Source: paper eq. (9) for the linear model; the iteration is ours.
    """
    whitener = whitening(problem.measurements.covariance)
    start = np.array(problem.start)
    found = _iterate(problem, _Linear(problem), whitener, Squares(), start)
    stages: list[tuple[type[_Linear] | type[_Bent], Loss]] = []
    if isinstance(loss, Bisquare):  # not convex: it needs a start that is robust already
        stages.append((_Linear, Huber()))
    if not isinstance(loss, Squares):
        stages.append((_Linear, loss))
    if model == "equilibrium":
        stages.append((_Bent, loss))
    for kind, chosen in stages:
        start[problem.free] = found.compliance
        found = _iterate(problem, kind(problem), whitener, chosen, start)
    return found


def whitening(covariance: Array) -> Array:
    """(R, 3, 3) W with WᵀW = covariance⁻¹, for covariances (R, 3, 3)."""
    if len(covariance) and (covariance == covariance[0]).all():
        one = np.linalg.inv(np.linalg.cholesky(covariance[0]))
        return np.broadcast_to(one, covariance.shape)
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))


class _Linear:
    """Deflections of the linear model."""

    def __init__(self, problem: Problem) -> None:
        arm, cases = problem.arm, problem.measurements.cases
        self.gradient = regressor(arm.robot, arm.springs, arm.tool, cases)

    def at(self, compliance: Array) -> tuple[Array, Array]:
        """(N, 3K) deflections and (N, 3K, c) gradients."""
        return self.gradient @ compliance, self.gradient

    def advance(self, step: Array) -> None:
        """Nothing moves."""


class _Bent:
    """Deflections of the equilibrium, linearised where the last step led.

    Attributes:
        states: Displacements (N, c) under load and, if the arm sags, without.
    """

    def __init__(self, problem: Problem) -> None:
        self.arm, cases = problem.arm, problem.measurements.cases
        self.q = cases.q
        flat = np.zeros((len(cases), len(self.arm.springs)))
        idle = LoadCases(cases.q, np.zeros_like(cases.wrench))
        self.wrenches = [cases.wrench] + ([idle.wrench] if self.arm.sags else [])
        self.states = [flat for _ in self.wrenches]
        self.unloaded = markers_at(self.arm, cases.q, flat)
        self.moves: list[tuple[Array, Array]] = []

    def at(self, compliance: Array) -> tuple[Array, Array]:
        """(N, 3K) deflections and (N, 3K, c) gradients, to first order about the states."""
        found = []
        self.moves = []
        for wrench, state in zip(self.wrenches, self.states, strict=True):
            here = linearise(self.arm, compliance, self.q, wrench, state)
            self.moves.append((here.step, here.slope))
            moved = here.markers + np.einsum("nmp,np->nm", here.velocity, here.step)
            found.append((moved, here.velocity @ here.slope))
        if len(found) == 1:
            return found[0][0] - self.unloaded, found[0][1]
        return found[0][0] - found[1][0], found[0][1] - found[1][1]

    def advance(self, step: Array) -> None:
        """Move the states to first order for a step (c,) of the compliances."""
        self.states = [
            state + newton + slope @ step
            for state, (newton, slope) in zip(self.states, self.moves, strict=True)
        ]


def _iterate(
    problem: Problem,
    model: _Linear | _Bent,
    whitener: Array,
    loss: Loss,
    start: Array,
) -> Solution:
    """Gauss-Newton with weights that follow the residuals."""
    compliance, free = np.array(start), problem.free
    for iteration in range(1, _MOST_STEPS + 1):
        modelled, gradient = model.at(compliance)
        rows, values = _read(problem.measurements, whitener, modelled, gradient)
        weight, scale = _weighed(problem, loss, values)
        found = _fit(problem, rows[:, :, free], values, weight, compliance[free])
        step = np.zeros_like(compliance)
        step[free] = found.estimate
        model.advance(step)
        compliance += step
        if not np.isfinite(compliance).all():
            break
        direct = isinstance(model, _Linear) and isinstance(loss, Squares)
        if direct or _at_rest(step[free], compliance[free], found):
            residual = values - rows[:, :, free] @ found.estimate
            return Solution(
                compliance[free], found, rows, residual, whitener, weight, scale, iteration
            )
    raise InputError(
        f"the fit to {problem.measurements.source or 'the measurements'} does not come to rest: "
        "the loads are too large for these compliances, or most readings are wrong; look at the "
        "linear model first"
    )


def _at_rest(step: Array, compliance: Array, found: LinearFit) -> bool:
    with np.errstate(invalid="ignore"):
        in_errors = float(np.linalg.norm(found.triangle @ step))
    relative = float(np.abs(step).max() / max(np.abs(compliance).max(), 1e-300))
    return in_errors <= _AT_REST * np.sqrt(len(step)) or relative <= 1e-14


def _read(
    measurements: Measurements, whitener: Array, modelled: Array, gradient: Array
) -> tuple[Array, Array]:
    """Rows (R, 3, c) of the readings and what the model leaves of them (R, 3), over the noise."""
    count, markers = len(measurements.cases), len(measurements.tool.markers)
    own = (measurements.case, measurements.marker)
    open_ = measurements.deflection - modelled.reshape(count, markers, 3)[own]
    rows = gradient.reshape(count, markers, 3, -1)[own]
    return whitener @ rows, np.einsum("rij,rj->ri", whitener, open_)


def _fit(problem: Problem, rows: Array, values: Array, weight: Array, at: Array) -> LinearFit:
    """Step of the free compliances, prior included."""
    p = len(at)
    if not (weight == 1.0).all():
        root = np.sqrt(weight)[:, None]
        rows, values = rows * root[..., None], values * root
    flat, right = rows.reshape(-1, p), values.reshape(-1)
    if len(problem.extra_values):
        flat = np.concatenate([flat, problem.extra_rows])
        right = np.concatenate([right, problem.extra_values - problem.extra_rows @ at])
    return fit(flat, right, lower=-at if problem.nonnegative else None)


def _weighed(problem: Problem, loss: Loss, values: Array) -> tuple[Array, float]:
    """Weights (R,) of residuals (R, 3), and the scale they are judged by."""
    size = np.linalg.norm(values, axis=1)
    if isinstance(loss, Squares):
        return np.ones_like(size), 1.0
    scale = 1.0 if problem.known_noise else robust_scale(size)
    return loss.weight(size / scale), scale
