"""Gauss-Newton on the equilibrium: compliances whose modelled deflections fit the measured ones.

In: elastic arm, readings of C campaigns under the same load cases. Out: estimates, rows and
residuals at them. Equilibrium and estimate are improved together: a step linearises both, so that
one pass over the load cases serves both. Campaigns are a batch axis: one is C = 1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.deflections import rotations
from elastocal.elastic.equilibrium import LOST, Linearisation, linearise, unbent
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.errors import InputError
from elastocal.fitting.least_squares import LinearFit, fits, one_of
from elastocal.fitting.robust import Loss, robust_scale
from elastocal.measuring.whitening import noise_factors

_CHUNK = 2048  # load cases evaluated at once: what stays in the cache
_MOST_STEPS = 60
_AT_REST = 1e-2, 1e-7  # step over standard errors and compliances: the next one is far smaller


@dataclass(frozen=True)
class Problem:
    """What is to be fitted: C campaigns that differ in what was read.

    Attributes:
        arm: Robot with all c springs that bend, identified or not, and the tool with T targets.
        free: (p,) positions of the fitted ones.
        start: (c,) compliances of all springs; those of the free ones do not count.
        cases: N load cases.
        marker: (R,) target of each reading among the N · T of all load cases.
        deflection: (C, R, 3) deflections read [m, rad].
        covariance: (R, 3, 3) of each [m², rad²].
        extra_rows: (E, p) further rows, such as a prior's.
        extra_values: (C or 1, E) their values.
        nonnegative: Whether compliances below zero are ruled out.
        known_noise: Whether the covariances are true and not only right up to a factor.
        variance: That factor, as far as it is found yet: what the further rows are weighed against.
        source: Where the readings come from, empty if nobody said.
    """

    arm: ElasticArm
    free: IntArray
    start: Array
    cases: LoadCases
    marker: IntArray
    deflection: Array
    covariance: Array
    extra_rows: Array
    extra_values: Array
    nonnegative: bool = False
    known_noise: bool = True
    variance: float = 1.0
    source: str = ""

    @property
    def dof(self) -> int:
        """Coordinates read and rows of a prior, less unknowns."""
        return 3 * len(self.marker) + len(self.extra_rows) - len(self.free)

    @cached_property
    def noise(self) -> tuple[Array, Array]:
        """Lower triangular factors of the covariances [m], and their inverses, (R, 3, 3) each."""
        try:
            return noise_factors(self.covariance)
        except np.linalg.LinAlgError:
            raise InputError(
                f"{self.source or 'the measurements'}: the covariance of a reading is not positive "
                "definite; its uncertainties are too small, or do not fit together"
            ) from None

    @cached_property
    def shrink(self) -> float | None:
        """One over the noise, if it is the same number for all coordinates: the usual case."""
        whitener = self.noise[1]
        one = whitener[0]
        same = whitener.strides[0] == 0 and (one == one[0, 0] * np.eye(3)).all()
        return float(one[0, 0]) if same else None


@dataclass(frozen=True)
class Solution:
    """Where the iteration came to rest.

    Attributes:
        compliance: (C, p) free compliances.
        fit: The last linear fits; their triangles are those of the whole problem.
        rows: (B, R, 3, c) rows of all springs over the noise, B = 1 if all campaigns share them.
        residual: (C, R, 3) residuals over the noise.
        weight: (C, R) robust weights.
        iterations: Steps taken.
    """

    compliance: Array
    fit: LinearFit
    rows: Array
    residual: Array
    weight: Array
    iterations: int

    def of(self, i: int) -> Solution:
        """The i-th campaign alone, its arrays without the first axis."""
        return Solution(
            self.compliance[i],
            self.fit.of(i),
            one_of(self.rows, i),
            self.residual[i],
            self.weight[i],
            self.iterations,
        )


def free_rows(problem: Problem, found: Solution) -> Array:
    """(R, 3, f) rows of the fitted springs over the noise."""
    every = len(problem.free) == found.rows.shape[-1]
    return found.rows if every else found.rows[..., problem.free]


def solve_linear(problem: Problem, loss: Loss) -> Solution:
    """Fit the free compliances by the linear model.

    Raises:
        InputError: a robust loss does not come to rest.

    Source: paper eq. (9); robust losses are ours.
    """
    start, model = np.zeros((len(problem.deflection), len(problem.free))), _Linear(problem)
    for stage in _stages(loss):
        solution = _iterate(problem, model, stage, start)
        start = solution.compliance
    return solution


def _stages(loss: Loss) -> Iterator[Loss]:
    """The losses of which each starts from the fit of the one before."""
    if loss.tamer is not None:
        yield from _stages(loss.tamer)
    yield loss


def solve_equilibrium(problem: Problem, linear: Solution, loss: Loss) -> Solution:
    """Fit the free compliances by the equilibrium under load, from the linear fit.

    Raises:
        InputError: the iteration does not come to rest.

    Source: ours.
    """
    model = _Bent(problem, _of_all(problem, linear.compliance))
    return _iterate(problem, model, loss, linear.compliance)


def _of_all(problem: Problem, free: Array) -> Array:
    """(C, c) compliances of all springs for those of the free ones (C, p)."""
    compliance = np.tile(problem.start, (len(free), 1))
    compliance[:, problem.free] = free
    return compliance


class _Linear:
    """Deflections of the linear model."""

    direct = True  # one step of least squares is the solution

    def __init__(self, problem: Problem) -> None:
        arm, cases = problem.arm, problem.cases
        self.shrink = problem.shrink or 1.0
        self.gradient = np.empty((len(cases), 3 * len(arm.tool.targets), len(arm.springs)))
        for s in (slice(i, i + _CHUNK) for i in range(0, len(cases), _CHUNK)):
            part = regressor(arm, LoadCases(cases.q[s], cases.wrench[s]))
            np.multiply(part, self.shrink, out=self.gradient[s])

    def at(self, compliance: Array) -> tuple[Array, Array]:
        """(C, N, 3T) deflections and (1, N, 3T, c) gradients for compliances (C, c).

        Both over the noise, if that is one number.
        """
        deflection = self.gradient.reshape(-1, compliance.shape[1]) @ compliance.T
        return deflection.T.reshape(len(compliance), *self.gradient.shape[:2]), self.gradient[None]

    def advance(self, step: Array) -> None:
        """Nothing moves."""

    @property
    def lost(self) -> bool:
        """Never."""
        return False


class _Bent:
    """Deflections of the equilibrium, linearised where the last step led.

    All is kept as (C N, ...): the load cases of a campaign, one after the other, then the next.

    Attributes:
        states: Displacements (C N, c) under load and, if the arm sags, without.
        steps: The Newton steps (C N, c) of each that lead to the equilibrium.
        slopes: The derivatives (C N, c, c) of each in the compliances.
    """

    direct = False

    def __init__(self, problem: Problem, compliance: Array) -> None:
        self.arm, self.cases, self.shrink = problem.arm, problem.cases, problem.shrink or 1.0
        idle = np.zeros_like(self.cases.wrench)
        self.wrenches = [self.cases.wrench] + ([idle] if self.arm.sags else [])
        self.states = []
        for wrench in self.wrenches:  # from where the linear model leads
            self.unloaded, effort = unbent(self.arm, self.cases.q, wrench)
            self.states.append((compliance[:, None] * effort).reshape(-1, effort.shape[1]))
        count, c = self.states[0].shape
        self.steps = [np.empty((count, c)) for _ in self.states]
        self.slopes = [np.empty((count, c, c)) for _ in self.states]
        self.deflection = np.empty((count, 3 * len(self.arm.tool.targets)))
        self.gradient = np.empty((*self.deflection.shape, c))

    def at(self, compliance: Array) -> tuple[Array, Array]:
        """(C, N, 3T) deflections and (C, N, 3T, c) gradients, to first order about the states.

        Both over the noise, if that is one number. The arrays are those of the last time,
        overwritten.
        """
        cases = len(self.cases)
        for start in range(0, len(self.deflection), _CHUNK):
            s = slice(start, start + _CHUNK)
            campaign, case = np.divmod(np.arange(*s.indices(len(self.deflection))), cases)
            q, moves = self.cases.q[case], []
            for i, wrench in enumerate(self.wrenches):
                each, state = compliance[campaign], self.states[i][s]
                moves.append(linearise(self.arm, each, q, wrench[case], state))
                self.steps[i][s], self.slopes[i][s] = moves[i].step, moves[i].slope
            parts = [(move.velocity, move) for move in moves]
            ahead, slope = _first_order(parts[:1])
            deflection = moves[0].markers + ahead
            if self.arm.sags:
                back, less = _first_order(parts[1:])
                deflection, slope = deflection - (moves[1].markers + back), slope - less
            else:
                deflection = deflection - self.unloaded[case]
            m = deflection.shape[1]
            self.deflection[s, :m], self.gradient[s, :m] = deflection, slope
            if self.arm.tool.rotation:
                vectors, turning = rotations(self.arm, q, moves)
                ahead, slope = _first_order(list(zip(turning, moves, strict=True)))
                self.deflection[s, m:], self.gradient[s, m:] = vectors + ahead, slope
            self.deflection[s] *= self.shrink
            self.gradient[s] *= self.shrink
        apart = len(compliance), cases, self.deflection.shape[1]
        return self.deflection.reshape(apart), self.gradient.reshape(*apart, -1)

    def advance(self, step: Array) -> None:
        """Move the states to first order for steps (C, c) of the compliances."""
        apart = len(step), len(self.cases), *2 * step.shape[1:]
        for state, ahead, slope in zip(self.states, self.steps, self.slopes, strict=True):
            state += ahead
            state += (slope.reshape(apart) @ step[:, None, :, None]).reshape(state.shape)

    @property
    def lost(self) -> bool:
        """Whether an arm is bent so far that steps seem small beside it."""
        return not all((np.abs(state) < LOST).all() for state in self.states)


def _first_order(parts: Sequence[tuple[Array, Linearisation]]) -> tuple[Array, Array]:
    """What rows (N, m, c) make of steps and slopes: (N, m) and (N, m, c), summed over the parts."""
    ahead = sum(np.einsum("nmp,np->nm", rows, move.step) for rows, move in parts)
    slope = sum(np.einsum("nmp,npq->nmq", rows, move.slope) for rows, move in parts)
    return np.asarray(ahead), np.asarray(slope)


def _iterate(problem: Problem, model: _Linear | _Bent, loss: Loss, start: Array) -> Solution:
    """Gauss-Newton with weights that follow the residuals, from free compliances (C, p)."""
    free = problem.free
    compliance = _of_all(problem, start)
    # The last step of an iteration is small; estimates by the hundred need no more digits.
    refine = len(start) == 1 and model.direct and loss.tamer is None
    for iteration in range(1, _MOST_STEPS + 1):
        rows, values = _read(problem, *model.at(compliance))
        weight = _weights(problem, loss, values)
        own = rows if len(free) == rows.shape[-1] else rows[..., free]
        found = _fit(problem, own, values, weight, compliance[:, free], refine=refine)
        step = np.zeros_like(compliance)
        step[:, free] = found.estimate
        model.advance(step)
        compliance += step
        if model.lost or not np.isfinite(compliance).all():
            break
        direct = model.direct and loss.tamer is None
        if direct or _at_rest(found, compliance[:, free]):
            flat = own.reshape(len(own), -1, len(free)).transpose(0, 2, 1)
            told = found.estimate.reshape(len(own), -1, len(free)) @ flat
            residual = values - told.reshape(values.shape)
            return Solution(compliance[:, free], found, rows, residual, weight, iteration)
    why = "the loads are too large for these compliances, or most readings are wrong"
    advice = "look at the linear model first"
    if loss.tamer is not None:
        why = "the readings may be too few, or too many of them wrong, to tell which are wrong"
        advice = "look at least squares, or at a tamer loss, first"
    raise InputError(
        f"the fit to {problem.source or 'the measurements'} does not come to rest: {why}; {advice}"
    )


def _at_rest(found: LinearFit, compliance: Array) -> bool:
    """Whether all campaigns are where steps no longer matter."""
    step = found.estimate
    with np.errstate(invalid="ignore"):
        in_errors = np.linalg.norm(found.triangle @ step[..., None], axis=(1, 2))
    relative = np.abs(step).max(axis=1) / np.maximum(np.abs(compliance).max(axis=1), 1e-300)
    small = (in_errors <= _AT_REST[0]) & (relative <= _AT_REST[1])
    return bool((small | (relative <= 1e-14)).all())


def _read(problem: Problem, modelled: Array, gradient: Array) -> tuple[Array, Array]:
    """Rows (B, R, 3, c) of the readings and what the model leaves (C, R, 3), over the noise."""
    own, whitener = problem.marker, problem.noise[1]
    rows = gradient.reshape(len(gradient), -1, 3, gradient.shape[-1])
    deflection = modelled.reshape(len(modelled), -1, 3)
    if len(own) != rows.shape[1] or (own != np.arange(len(own))).any():
        rows, deflection = rows[:, own], deflection[:, own]
    if problem.shrink is not None:
        return rows, problem.deflection * problem.shrink - deflection
    open_ = problem.deflection - deflection
    return whitener @ rows, np.einsum("rij,crj->cri", whitener, open_)


def _fit(
    problem: Problem, rows: Array, values: Array, weight: Array, at: Array, *, refine: bool
) -> LinearFit:
    """Steps of the free compliances, prior included."""
    if not (weight == 1.0).all():
        root = np.sqrt(weight)[..., None]
        rows, values = rows * root[..., None], values * root
    if problem.variance != 1.0:
        root = problem.variance**-0.5
        rows, values = rows * root, values * root
    flat, right = rows.reshape(len(rows), -1, rows.shape[-1]), values.reshape(len(values), -1)
    if len(problem.extra_rows):
        extra = np.broadcast_to(problem.extra_rows, (len(flat), *problem.extra_rows.shape))
        flat = np.concatenate([flat, extra], axis=1)
        right = np.hstack([right, problem.extra_values - at @ problem.extra_rows.T])
    return fits(flat, right, lower=-at if problem.nonnegative else None, refine=refine)


def _weights(problem: Problem, loss: Loss, values: Array) -> Array:
    """(C, R) weights of residuals (C, R, 3) by their sizes over the noise."""
    if loss.tamer is None:
        return np.ones(values.shape[:2])
    size = np.linalg.norm(values, axis=2)
    if not problem.known_noise:
        size = size / np.array([[robust_scale(one, problem.dof)] for one in size])
    return loss.weight(size)
