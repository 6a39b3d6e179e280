"""What a user would write today without elastocal: multistart with IPOPT or with SLSQP.

Both polish one plan at a time from many starts. They get every advantage we know of:

* IPOPT (CasADi, MUMPS): exact gradients and Hessians of a model built from the robot's data, the
  logarithm of the objective, an explicit LDLᵀ factorisation instead of a generic solve, and for
  many configurations a lifted form whose Hessian is sparse. Compiling the expressions with gcc
  was tried: up to twice as fast a start, for 10 to 45 s of compilation.
* SLSQP (SciPy): exact gradients from elastocal's own kernel.
* Starts: uniformly random feasible plans, or the start recipes of elastocal's search ("bred":
  screened random plans, best plans with one configuration replaced, rounded continuous designs
  with repeats), so that solver and search strategy can be told apart.

The first joint turns plan and load together, so that it cannot matter, and is kept at zero.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import casadi as ca
import numpy as np
from casadi_arm import log_trace, lower_part, pose_function, symmetric
from kr270 import MICRO
from scipy.optimize import minimize

from elastocal.arrays import Array, IntArray
from elastocal.design.approximate import interior_point, optimal_weights
from elastocal.design.rounding import apportion
from elastocal.design.space import information
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.assessment import assess
from elastocal.study.criteria import mean_test_pose
from elastocal.study.study import Study

FEASIBLE = 1e-6
"""Violation of a constraint that is forgiven to a baseline [rad, m]; ours gets 1e-8."""

LIFT_FROM = 8
"""Number of configurations from which the lifted form of the problem is faster."""


class Polished(NamedTuple):
    """Where a local solver ended."""

    q: Array  # (s, n) configurations
    repeats: IntArray  # (s,)
    rho0: float  # as the solver's own model has it [1e-3 mm]; inf if infeasible


class Polish(Protocol):
    """A local solver: moves the configurations of one plan to a local optimum.

    Attributes:
        construction: Seconds it took to set up, reported apart from the search.
    """

    construction: float

    def __call__(self, q: Array, repeats: IntArray) -> Polished:
        """Polish a plan of configurations (s, n) with repeats (s,)."""


# --- CasADi and IPOPT ---------------------------------------------------------------------------


class IpoptPolish:
    """IPOPT on a CasADi model with exact Hessian; s configurations, repeats as parameters."""

    def __init__(self, study: Study, configurations: int) -> None:
        begun = time.perf_counter()
        self.study, self.s = study, configurations
        self.pose = pose_function(study)
        self.lifted = configurations >= LIFT_FROM
        self.lower, self.upper = np.array(study.limits)[:, 1:]
        self.scale = _rho0_scale(study)
        x = ca.SX.sym("x", len(self.lower), configurations)
        repeats = ca.SX.sym("c", configurations)
        total, margins = ca.SX(self.p, self.p), []
        for i in range(configurations):
            rows, margin = self.pose(x[:, i])
            total += repeats[i] * (rows.T @ rows)
            margins.append(margin)
        total /= ca.sum1(repeats)
        variables, constraints, matrix = ca.vec(x), ca.vertcat(*margins), total
        if self.lifted:
            entries = ca.SX.sym("m", self.p * (self.p + 1) // 2)
            matrix = symmetric(entries, self.p)
            variables = ca.vertcat(variables, entries)
            constraints = ca.vertcat(constraints, lower_part(total) - entries)
        loss = log_trace(matrix, _unit_test_poses(study))
        problem: dict[str, Any] = {"x": variables, "p": repeats, "f": loss, "g": constraints}
        self.solver = ca.nlpsol("plan", "ipopt", problem, _IPOPT)
        self.information = ca.Function("information", [x, repeats], [lower_part(total)])
        self.construction = time.perf_counter() - begun

    @property
    def p(self) -> int:
        """Number of compliances."""
        return len(self.study.springs)

    def __call__(self, q: Array, repeats: IntArray) -> Polished:
        start, entries = q[:, 1:].ravel(), self.p * (self.p + 1) // 2 if self.lifted else 0
        lower, upper = np.tile(self.lower, self.s), np.tile(self.upper, self.s)
        margins = len(self.study.constraints) * self.s
        least, most = np.zeros(margins), np.full(margins, np.inf)
        if self.lifted:
            free = np.full(entries, np.inf)
            start = np.append(start, self.information(q[:, 1:].T, repeats).full())
            lower, upper = np.append(lower, -free), np.append(upper, free)
            least, most = np.append(least, np.zeros(entries)), np.append(most, np.zeros(entries))
        found = self.solver(x0=start, p=repeats, lbx=lower, ubx=upper, lbg=least, ubg=most)
        x = found["x"].full().ravel()[: len(self.lower) * self.s].reshape(self.s, -1)
        x = np.clip(x, self.lower, self.upper)
        constraint, loss = found["g"].full().ravel(), float(found["f"])
        violation = -constraint[:margins].min(initial=0.0)
        unlifted = np.abs(constraint[margins:]).max(initial=0.0)
        feasible = violation <= FEASIBLE and unlifted < 1e-8 and np.isfinite(loss)
        rho0 = self.scale * np.exp(loss / 2.0) / np.sqrt(repeats.sum()) if feasible else np.inf
        return Polished(np.hstack([np.zeros((self.s, 1)), x]), repeats, float(rho0))


_IPOPT: dict[str, Any] = {
    "print_time": False,
    "error_on_fail": False,
    "show_eval_warnings": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": 1e-6,
    "ipopt.acceptable_tol": 1e-4,
    "ipopt.acceptable_iter": 5,
    "ipopt.max_iter": 200,
}


def _unit_test_poses(study: Study) -> Array:
    """Rows of all test poses, (r, p), scaled to norm 1; rows of zeros left out."""
    weights = np.array([pose.weight for pose in study.test_poses])
    rows = np.concatenate(
        [
            np.sqrt(weight) * np.array(pose.regressor)
            for weight, pose in zip(weights / weights.sum(), study.test_poses, strict=True)
        ]
    )
    rows = rows[np.abs(rows).sum(axis=1) > 0.0]
    return np.asarray(rows / np.linalg.norm(rows))


def _rho0_scale(study: Study) -> float:
    """rho0 [1e-3 mm] of a plan over exp(loss / 2)/√m, with loads and test poses scaled to 1."""
    largest = float(np.sqrt(np.trace(mean_test_pose(study).weight)))
    return MICRO * study.sigma * largest / study.experiments.force.size


# --- SciPy SLSQP --------------------------------------------------------------------------------


class SlsqpPolish:
    """SLSQP with exact gradients of objective and constraints from elastocal's kernel."""

    def __init__(self, study: Study, configurations: int) -> None:
        begun = time.perf_counter()
        self.space, self.s = study.space, configurations
        self.criterion = mean_test_pose(study)
        limits = np.array(study.limits)[:, 1:]
        self.bounds = np.tile(limits.T, (configurations, 1))
        self.construction = time.perf_counter() - begun

    def __call__(self, q: Array, repeats: IntArray) -> Polished:
        model = _Model(self, repeats)
        constraint = {"type": "ineq", "fun": model.margins, "jac": model.margin_slopes}
        found = minimize(
            model.loss,
            q[:, 1:].ravel(),
            jac=model.slope,
            method="SLSQP",
            bounds=self.bounds,
            constraints=[constraint] if model.margins(q[:, 1:].ravel()).size else [],
            options={"maxiter": 200, "ftol": 1e-9},
        )
        x = np.clip(found.x, *self.bounds.T)
        feasible = np.isfinite(found.fun) and model.margins(x).min(initial=0.0) >= -FEASIBLE
        rho0 = MICRO * np.exp(model.loss(x) / 2.0) if feasible else np.inf
        return Polished(model.configurations(x), repeats, float(rho0))


class _Model:
    """Objective and constraints of one plan; one evaluation serves all four callbacks."""

    def __init__(self, owner: SlsqpPolish, repeats: IntArray) -> None:
        self.space, self.criterion, self.s = owner.space, owner.criterion, owner.s
        self.repeats = repeats
        self.known: bytes = b""

    def configurations(self, x: Array) -> Array:
        return np.hstack([np.zeros((self.s, 1)), x.reshape(self.s, -1)])

    def loss(self, x: Array) -> float:
        self._at(x)
        return self._loss

    def slope(self, x: Array) -> Array:
        self._at(x)
        return self._slope

    def margins(self, x: Array) -> Array:
        self._at(x)
        return self._margins

    def margin_slopes(self, x: Array) -> Array:
        self._at(x)
        return self._margin_slopes

    def _at(self, x: Array) -> None:
        """Evaluate: the configurations once for the objective, once more per constraint."""
        if x.tobytes() == self.known:
            return
        self.known, s = x.tobytes(), self.s
        kinds = len(self.space.constraints)
        evaluation = self.space.evaluate(np.tile(self.configurations(x), (1 + kinds, 1)))
        blocks = evaluation.blocks[:s]
        total = np.einsum("i,ijk->jk", self.repeats, information(blocks))[None]
        value = max(float(self.criterion.value(total)[0]), 1e-300)
        gradient = self.criterion.gradient(total)[0] * (-2.0 / value)
        block_cotangent = np.zeros_like(evaluation.blocks)
        block_cotangent[:s] = (blocks @ gradient) * self.repeats[:, None, None]
        margin_cotangent = np.zeros_like(evaluation.margins)
        for kind in range(kinds):
            margin_cotangent[(kind + 1) * s : (kind + 2) * s, kind] = 1.0
        pulled = evaluation.pull(block_cotangent, margin_cotangent)[:, 1:]
        self._loss = -float(np.log(value))
        self._slope = pulled[:s].ravel()
        self._margins = evaluation.margins[:s].T.ravel()
        slopes = np.zeros((kinds * s, s, pulled.shape[1]))
        slopes[np.arange(kinds * s), np.tile(np.arange(s), kinds)] = pulled[s:]
        self._margin_slopes = slopes.reshape(kinds * s, -1)


# --- Where to start -----------------------------------------------------------------------------


@dataclass
class RandomStarts:
    """Uniformly random feasible plans of m configurations."""

    study: Study
    rng: np.random.Generator
    configurations: int = field(init=False)

    def __post_init__(self) -> None:
        self.configurations = self.study.experiments.count
        self.pool = _pool(self.study, self.rng)

    def next(self, best: list[Polished]) -> tuple[Array, IntArray]:
        """Configurations (s, n) and repeats (s,) to start from, given the best plans so far."""
        chosen = self.rng.integers(0, len(self.pool), self.configurations)
        return self.pool[chosen], np.ones(self.configurations, dtype=np.int64)


@dataclass
class BredStarts:
    """The start recipes of elastocal's search, one plan at a time.

    At most 6 configurations, with repeats where m is larger. After 16 fresh starts three of four
    are one of the best plans with one configuration replaced or one repeat moved. A fresh start is
    the best of 50 random plans; from m = 6 two of three are a rounded continuous design on the
    random candidates.
    """

    study: Study
    rng: np.random.Generator
    configurations: int = field(init=False)

    def __post_init__(self) -> None:
        m = self.study.experiments.count
        self.configurations = min(m, 6)
        self.pool = _pool(self.study, self.rng)
        self.criterion = mean_test_pose(self.study)
        self.informations = information(self.study.space.evaluate(self.pool).blocks)
        self.base = np.zeros(self.informations.shape[1:])
        self.design = None
        if m >= 6:
            self.design = optimal_weights(
                self.criterion, self.informations, self.base, tolerance=1e-3
            )
        self.made = 0

    def next(self, best: list[Polished]) -> tuple[Array, IntArray]:
        """Configurations (s, n) and repeats (s,) to start from, given the best plans so far."""
        self.made += 1
        if best and self.made > 16 and self.made % 4:
            return self._mutated(best[self.rng.integers(len(best))])
        if self.design is not None and self.rng.random() < 2.0 / 3.0:
            return self._rounded()
        return self._screened()

    def _screened(self, tries: int = 50) -> tuple[Array, IntArray]:
        s = self.configurations
        chosen = self.rng.integers(0, len(self.pool), (tries, s))
        repeats = np.ones((tries, s), dtype=np.int64)
        repeats += self.rng.multinomial(
            self.study.experiments.count - s, np.full(s, 1.0 / s), size=tries
        )
        totals = np.einsum("ts,tsij->tij", repeats, self.informations[chosen])
        first = int(self.criterion.value(totals).argmax())
        return self.pool[chosen[first]], repeats[first]

    def _rounded(self) -> tuple[Array, IntArray]:
        assert self.design is not None
        support, weights = self.design
        size = min(self.configurations, len(support))
        part = self.rng.choice(support, size, replace=False, p=weights / weights.sum())
        share = interior_point(self.criterion, self.informations[part], self.base, 1e-3)
        repeats = np.zeros(self.configurations, dtype=np.int64)
        repeats[:size] = apportion(share, self.study.experiments.count)
        return self.pool[part[np.arange(self.configurations) % size]], repeats

    def _mutated(self, parent: Polished) -> tuple[Array, IntArray]:
        q, repeats = parent.q.copy(), parent.repeats.copy()
        source = self.rng.choice(np.flatnonzero(repeats))
        if self.study.experiments.count > self.configurations and self.rng.random() < 0.5:
            goal = self.rng.integers(self.configurations)
            if repeats[goal] == 0:
                q[goal] = q[source]
            repeats[source] -= 1
            repeats[goal] += 1
        else:
            q[source] = self.rng.choice(self.pool)
        return q, repeats


def _pool(study: Study, rng: np.random.Generator) -> Array:
    """Random feasible configurations with the first joint at zero."""
    pool = study.space.sample(2000, rng)
    pool[:, 0] = 0.0
    return pool


# --- Multistart ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Improvement:
    """A plan that was better than all before it."""

    seconds: float
    rho0: float  # [1e-3 mm]
    q: Array
    repeats: IntArray


METHODS: dict[str, tuple[Callable[[Study, int], Polish], Callable[..., Any]]] = {
    "CasADi + IPOPT, random starts": (IpoptPolish, RandomStarts),
    "CasADi + IPOPT, bred starts": (IpoptPolish, BredStarts),
    "SciPy SLSQP, random starts": (SlsqpPolish, RandomStarts),
    "SciPy SLSQP, bred starts": (SlsqpPolish, BredStarts),
}


class Search(NamedTuple):
    """What a multistart did."""

    trace: list[Improvement]
    construction: float  # seconds before the clock of the trace began
    starts: int
    seconds: float


def multistart(method: str, study: Study, seed: int, *, cap: float, goal: float) -> Search:
    """Polish starts until rho0 reaches `goal` [1e-3 mm] or `cap` seconds are over.

    The clock starts when the solver is ready and includes sampling, starts and polishing.
    """
    make_polish, make_starts = METHODS[method]
    count = study.experiments.count
    polish = make_polish(study, count if make_starts is RandomStarts else min(count, 6))
    begun = time.perf_counter()
    starts = make_starts(study, np.random.default_rng(seed))
    trace: list[Improvement] = []
    best: list[Polished] = []
    made = 0
    while time.perf_counter() - begun < cap:
        found = polish(*starts.next(best))
        made += 1
        now = time.perf_counter() - begun
        if np.isfinite(found.rho0) and now <= cap:
            if not trace or found.rho0 < trace[-1].rho0:
                trace.append(Improvement(now, found.rho0, found.q, found.repeats))
            if all(abs(found.rho0 / plan.rho0 - 1.0) > 1e-7 for plan in best):
                best = sorted([*best, found], key=lambda plan: plan.rho0)[:24]
        if trace and trace[-1].rho0 <= goal:
            break
    return Search(trace, polish.construction, made, time.perf_counter() - begun)


def verify(study: Study, trace: list[Improvement]) -> None:
    """Every plan of a trace is feasible and worth what was claimed, by elastocal's `assess`.

    Raises:
        AssertionError: the baseline's model and elastocal's disagree.
    """
    for step in trace:
        wrench = np.append(study.experiments.force.value, np.zeros(3))
        cases = LoadCases(step.q, np.tile(wrench, (len(step.q), 1)))
        judged = assess(study, cases, step.repeats)
        assert not judged.violations, judged.violations
        deviation = MICRO * judged.rho0 / step.rho0 - 1.0
        assert abs(deviation) < 1e-6, f"rho0 claimed {step.rho0}, assessed {deviation:+.1e} off"
