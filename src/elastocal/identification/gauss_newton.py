"""Gauss-Newton on the equilibrium: compliances whose modelled deflections fit the measured ones.

In: elastic arm, readings of C campaigns under the same load cases. Out: estimates, rows and
residuals at them. Equilibrium and estimate are improved together: a step linearises both, so that
one pass over the load cases serves both. Campaigns are a batch axis: one is C = 1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.deflections import rotations
from elastocal.elastic.equilibrium import LOST, Linearisation, linearise, unbent
from elastocal.elastic.regressor import regressor
from elastocal.errors import InputError
from elastocal.fitting.least_squares import LinearFit, fits
from elastocal.fitting.robust import Loss, robust_scale
from elastocal.identification.problem import Problem, Solution, compliances, rows_of_unknowns

_CHUNK = 2048  # load cases evaluated at once: what stays in the cache
_MOST_STEPS = 60
_AT_REST = 1e-2, 1e-7  # step over standard errors and compliances: the next one is far smaller


def solve_linear(problem: Problem, loss: Loss) -> Solution:
    """Fit the free compliances by the linear model.

    Raises:
        InputError: a robust loss does not come to rest.

    Source: paper eq. (9); robust losses are ours.
    """
    start, model = np.zeros((len(problem.deflection), problem.unknowns)), _Linear(problem)
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
    model = _Bent(problem, compliances(problem, linear.compliance))
    return _iterate(problem, model, loss, linear.compliance)


class _Linear:
    """Deflections of the linear model."""

    direct = True  # one step of least squares is the solution

    def __init__(self, problem: Problem) -> None:
        arm, cases = problem.arm, problem.cases
        self.shrink = problem.shrink or 1.0
        self.gradient = np.empty((len(cases), 3 * len(arm.tool.targets), len(arm.springs)))
        for i in range(0, len(cases), _CHUNK):
            some = np.arange(i, min(i + _CHUNK, len(cases)))
            part = regressor(arm, cases.chosen(some))
            np.multiply(part, self.shrink, out=self.gradient[i : i + _CHUNK])

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
        self.two = self.arm.sags or self.cases.preloaded
        self.wrenches = [self.cases.second, self.cases.first][: 1 + self.two]
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
            if self.two:
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
    unknown = np.array(start)
    compliance = compliances(problem, unknown)
    # The last step of an iteration is small; estimates by the hundred need no more digits.
    refine = len(start) == 1 and model.direct and loss.tamer is None
    for iteration in range(1, _MOST_STEPS + 1):
        rows, values = _read(problem, *model.at(compliance))
        own = rows_of_unknowns(problem, rows)
        if problem.columns.size:
            more = unknown[:, -problem.columns.shape[2] :]
            values = values - np.einsum("rie,ce->cri", problem.white_columns, more)
        weight = _weights(problem, loss, values)
        found = _fit(problem, own, values, weight, unknown, refine=refine)
        unknown += found.estimate
        before, compliance = compliance, compliances(problem, unknown)
        model.advance(compliance - before)
        if model.lost or not np.isfinite(compliance).all():
            break
        direct = model.direct and loss.tamer is None
        if direct or _at_rest(found, unknown):
            u = problem.unknowns
            flat = own.reshape(len(own), -1, u).transpose(0, 2, 1)
            told = found.estimate.reshape(len(own), -1, u) @ flat
            residual = values - told.reshape(values.shape)
            return Solution(unknown, found, rows, residual, weight, iteration)
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
    """Steps of the unknowns, prior included."""
    if not (weight == 1.0).all():
        root = np.sqrt(weight)[..., None]
        rows, values = rows * root[..., None], values * root
    flat, right = rows.reshape(len(rows), -1, rows.shape[-1]), values.reshape(len(values), -1)
    shared = problem.shared
    if shared is not None or problem.variance != 1.0:
        scale = np.full(right.shape[1], problem.variance)
        if shared is not None:
            columns = flat.transpose(1, 0, 2)
            turned = shared.turned(columns.reshape(len(columns), -1)).reshape(columns.shape)
            flat, right = turned.transpose(1, 0, 2), shared.turned(right.T).T
            scale = scale + shared.absolute
        over = 1.0 / np.sqrt(scale)
        flat, right = flat * over[:, None], right * over
    if len(problem.extra_rows):
        extra = np.broadcast_to(problem.extra_rows, (len(flat), *problem.extra_rows.shape))
        flat = np.concatenate([flat, extra], axis=1)
        right = np.hstack([right, problem.extra_values - at @ problem.extra_rows.T])
    return fits(flat, right, bounds=problem.bounds, at=at, refine=refine)


def _weights(problem: Problem, loss: Loss, values: Array) -> Array:
    """(C, R) weights of residuals (C, R, 3) by their sizes over the noise."""
    if loss.tamer is None:
        return np.ones(values.shape[:2])
    size = np.linalg.norm(values, axis=2)
    if not problem.known_noise:
        size = size / np.array([[robust_scale(one, problem.dof)] for one in size])
    return loss.weight(size)
