"""Gauss-Newton on the equilibrium: compliances whose modelled deflections fit the measured ones.

In: elastic arm, measurements. Out: estimate, rows and residuals at it. Equilibrium and estimate are
improved together: a step linearises both, so that one pass over the load cases serves both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.equilibrium import linearise, markers_at
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.errors import InputError
from elastocal.fitting.least_squares import LinearFit, fit
from elastocal.fitting.robust import Loss, robust_scale
from elastocal.measuring.measurements import Measurements
from elastocal.measuring.whitening import noise_factors

_CHUNK = 2048  # load cases evaluated at once: what stays in the cache
_MOST_STEPS = 60
_AT_REST = 1e-2, 1e-6  # step over standard errors and compliances: the next one is far smaller


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
        noise: (R, 3, 3) lower triangular factors of the covariances that divided them [m].
        weight: (R,) robust weights.
        scale: Noise over the promised one, as the weights saw it.
        iterations: Steps taken.
    """

    compliance: Array
    fit: LinearFit
    rows: Array
    residual: Array
    noise: Array
    weight: Array
    scale: float
    iterations: int


def solve_linear(problem: Problem, loss: Loss) -> Solution:
    """Fit the free compliances by the linear model.

    Raises:
        InputError: a robust loss does not come to rest.

    Source: paper eq. (9); robust losses are ours.
    """
    factors = noise_factors(problem.measurements.covariance)
    start, model = np.array(problem.start), _Linear(problem)
    for stage in _stages(loss):
        found = _iterate(problem, model, factors, stage, start)
        start[problem.free] = found.compliance
    return found


def _stages(loss: Loss) -> list[Loss]:
    """The losses of which each starts from the fit of the one before."""
    return [loss] if loss.tamer is None else [*_stages(loss.tamer), loss]


def solve_equilibrium(problem: Problem, linear: Solution, loss: Loss) -> Solution:
    """Fit the free compliances by the equilibrium under load, from the linear fit.

    Raises:
        InputError: the iteration does not come to rest.

    Source: ours.
    """
    start = np.array(problem.start)
    start[problem.free] = linear.compliance
    factors = noise_factors(problem.measurements.covariance)
    return _iterate(problem, _Bent(problem), factors, loss, start)


class _Linear:
    """Deflections of the linear model."""

    def __init__(self, problem: Problem) -> None:
        arm, cases = problem.arm, problem.measurements.cases
        parts = [
            regressor(arm, LoadCases(cases.q[s], cases.wrench[s]))
            for s in (slice(i, i + _CHUNK) for i in range(0, len(cases), _CHUNK))
        ]
        self.gradient = np.concatenate(parts)

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
    noise: tuple[Array, Array],
    loss: Loss,
    start: Array,
) -> Solution:
    """Gauss-Newton with weights that follow the residuals."""
    compliance, free = np.array(start), problem.free
    for iteration in range(1, _MOST_STEPS + 1):
        modelled, gradient = model.at(compliance)
        rows, values = _read(problem.measurements, noise[1], modelled, gradient)
        weight, scale = _weighed(problem, loss, values)
        found = _fit(problem, rows[:, :, free], values, weight, compliance[free])
        step = np.zeros_like(compliance)
        step[free] = found.estimate
        model.advance(step)
        compliance += step
        if not np.isfinite(compliance).all():
            break
        direct = isinstance(model, _Linear) and loss.tamer is None
        if direct or _at_rest(step[free], compliance[free], found):
            residual = values - rows[:, :, free] @ found.estimate
            return Solution(
                compliance[free], found, rows, residual, noise[0], weight, scale, iteration
            )
    why = "the loads are too large for these compliances, or most readings are wrong"
    advice = "look at the linear model first"
    if loss.tamer is not None:
        why = "the readings may be too few, or too many of them wrong, to tell which are wrong"
        advice = "look at least squares, or at a tamer loss, first"
    raise InputError(
        f"the fit to {problem.measurements.source or 'the measurements'} does not come to rest: "
        f"{why}; {advice}"
    )


def degrees_of_freedom(problem: Problem) -> int:
    """Coordinates read and rows of a prior, less unknowns."""
    return 3 * len(problem.measurements) + len(problem.extra_values) - len(problem.free)


def _at_rest(step: Array, compliance: Array, found: LinearFit) -> bool:
    with np.errstate(invalid="ignore"):
        in_errors = float(np.linalg.norm(found.triangle @ step))
    relative = float(np.abs(step).max() / max(np.abs(compliance).max(), 1e-300))
    return (in_errors <= _AT_REST[0] and relative <= _AT_REST[1]) or relative <= 1e-14


def _read(
    measurements: Measurements, whitener: Array, modelled: Array, gradient: Array
) -> tuple[Array, Array]:
    """Rows (R, 3, c) of the readings and what the model leaves of them (R, 3), over the noise."""
    own = measurements.case * len(measurements.tool.markers) + measurements.marker
    rows, deflection = gradient.reshape(-1, 3, gradient.shape[-1]), modelled.reshape(-1, 3)
    if len(own) != len(rows) or (own != np.arange(len(own))).any():
        rows, deflection = rows[own], deflection[own]
    open_ = measurements.deflection - deflection
    one = whitener[0]
    if whitener.strides[0] == 0 and (one == one[0, 0] * np.eye(3)).all():
        return rows * one[0, 0], open_ * one[0, 0]  # the same number for all: the usual case
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
    if loss.tamer is None:
        return np.ones_like(size), 1.0
    scale = 1.0 if problem.known_noise else robust_scale(size, degrees_of_freedom(problem))
    return loss.weight(size / scale), scale
