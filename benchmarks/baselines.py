"""What a user would write today without elastocal.

Local solvers, which polish one plan at a time from many starts:

* IPOPT (CasADi, MUMPS): exact gradients and Hessians of a model built from the robot's data, the
  logarithm of the objective, an explicit LDLᵀ factorisation instead of a generic solve, and for
  many configurations a lifted form whose Hessian is sparse. Beyond 20 unknowns the Hessian is
  IPOPT's own limited-memory one: the exact one takes minutes to construct. Compiling the
  expressions with gcc was tried: up to twice as fast a start, for 10 to 45 s of compilation.
* SLSQP (SciPy): exact gradients from elastocal's own compiled kernel, or differences of its values.

Starts: uniformly random feasible plans, the recipes of elastocal's search ("bred": screened random
plans, best plans with one configuration replaced, rounded continuous designs with repeats), or
Fedorov's exchange over a pool of random candidates. And whole methods that polish nothing:

* the best weights on a pool of candidates as a cone program (cvxpy, Clarabel), rounded, as
  FIGAROH makes its campaigns; pools of 500, 1000, 2000, ... candidates;
* coordinate exchange by pyoptex with a metric of our own, which knows what has changed.

Where turning the first joint turns plan and load together, that joint is kept at zero.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import casadi as ca
import numpy as np
from casadi_arm import log_trace, lower_part, pose_function, symmetric
from kr270 import MICRO
from problems import Problem
from scipy.optimize import minimize

from elastocal.arrays import Array, IntArray
from elastocal.design.approximate import interior_point, optimal_weights
from elastocal.design.rounding import apportion
from elastocal.design.space import information
from elastocal.planning.assessment import assess
from elastocal.study.criteria import mean_test_pose

FEASIBLE = 1e-6
"""Violation of a constraint that is forgiven to a baseline [rad, m]; ours gets 1e-8."""

LIFT_FROM = 8
"""Number of configurations from which the lifted form of the problem is faster."""

EXACT = 20
"""Most unknowns for which IPOPT gets an exact Hessian."""

LEVELS = 21
"""Values of each variable that pyoptex tries."""


class Polished(NamedTuple):
    """Where a solver ended."""

    x: Array  # (s, d) design points
    repeats: IntArray  # (s,)
    rho0: float  # as the solver's own model has it [1e-3 mm]; inf if infeasible


class Polish(Protocol):
    """A local solver: moves the points of one plan to a local optimum.

    Attributes:
        construction: Seconds it took to set up, reported apart from the search.
    """

    construction: float

    def __call__(self, x: Array, repeats: IntArray) -> Polished:
        """Polish a plan of design points (s, d) with repeats (s,)."""


def configurations(problem: Problem) -> int:
    """Points of a plan: as many as experiments, unless the study allows fewer."""
    e = problem.study.experiments
    return min(e.count, e.max_configurations or e.count)


# --- CasADi and IPOPT ---------------------------------------------------------------------------


class IpoptPolish:
    """IPOPT on a CasADi model; s points, repeats as parameters."""

    def __init__(self, problem: Problem, points: int) -> None:
        begun = time.process_time()
        study, self.held, self.s = problem.study, problem.held, points
        space, p = study.space, len(study.springs)
        self.p = p
        self.lower, self.upper = space.lower[self.held :], space.upper[self.held :]
        pose = pose_function(study, self.held)
        pool = space.sample(200, np.random.default_rng(0))
        size = np.einsum("njj->j", information(space.evaluate(pool).blocks)) / len(pool)
        self.scale = np.sqrt(size)
        exact = p <= EXACT
        self.lifted = exact and points >= LIFT_FROM
        x, repeats = ca.SX.sym("x", len(self.lower), points), ca.SX.sym("c", points)
        prior = study.prior / np.outer(self.scale, self.scale)
        total, margins, zeros = ca.SX(ca.sparsify(ca.DM(prior))), [], []
        for i in range(points):
            rows, margin, zero = pose(x[:, i])
            rows = rows @ ca.diag(ca.DM(1.0 / (study.sigma * self.scale)))
            total += repeats[i] * (rows.T @ rows)
            margins.append(margin)
            zeros.append(zero)
        variables, matrix = ca.vec(x), total
        constraints = ca.vertcat(*margins, *zeros)
        if self.lifted:
            entries = ca.SX.sym("m", p * (p + 1) // 2)
            matrix = symmetric(entries, p)
            variables = ca.vertcat(variables, entries)
            constraints = ca.vertcat(constraints, lower_part(total) - entries)
        asked = _asked(problem) / self.scale
        self.largest = float(np.linalg.norm(asked))
        loss = log_trace(matrix, asked / self.largest)
        told: dict[str, Any] = {"x": variables, "p": repeats, "f": loss, "g": constraints}
        options = _IPOPT | {"ipopt.max_cpu_time": problem.cap}
        if not exact:
            options["ipopt.hessian_approximation"] = "limited-memory"
        self.solver = ca.nlpsol("plan", "ipopt", told, options)
        self.margins, self.zeros = ca.vertcat(*margins).numel(), ca.vertcat(*zeros).numel()
        self.information = ca.Function("information", [x, repeats], [lower_part(total)])
        self.construction = time.process_time() - begun

    def __call__(self, x: Array, repeats: IntArray) -> Polished:
        s, held = self.s, self.held
        start, entries = x[:, held:].ravel(), self.p * (self.p + 1) // 2 if self.lifted else 0
        lower, upper = np.tile(self.lower, s), np.tile(self.upper, s)
        margins, zeros = self.margins, np.zeros(self.zeros)
        least, most = (
            np.append(np.zeros(margins), zeros),
            np.append(np.full(margins, np.inf), zeros),
        )
        if self.lifted:
            free = np.full(entries, np.inf)
            start = np.append(start, self.information(x[:, held:].T, repeats).full())
            lower, upper = np.append(lower, -free), np.append(upper, free)
            least, most = np.append(least, np.zeros(entries)), np.append(most, np.zeros(entries))
        found = self.solver(x0=start, p=repeats, lbx=lower, ubx=upper, lbg=least, ubg=most)
        moved = found["x"].full().ravel()[: len(self.lower) * s].reshape(s, -1)
        moved = np.clip(moved, self.lower, self.upper)
        constraint, loss = found["g"].full().ravel(), float(found["f"])
        violation = -constraint[:margins].min(initial=0.0)
        unlifted = np.abs(constraint[margins:]).max(initial=0.0)
        feasible = violation <= FEASIBLE and unlifted < 1e-8 and np.isfinite(loss)
        rho0 = MICRO * self.largest * np.exp(loss / 2.0) if feasible else np.inf
        return Polished(np.hstack([np.zeros((s, held)), moved]), repeats, float(rho0))


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


def _asked(problem: Problem) -> Array:
    """Rows of all test poses, (r, p); rows of zeros left out."""
    rows = np.concatenate(
        [
            np.sqrt(share) * np.array(pose.regressor)
            for share, pose in zip(problem.study.shares, problem.study.test_poses, strict=True)
        ]
    )
    return np.asarray(rows[np.abs(rows).sum(axis=1) > 0.0])


# --- SciPy SLSQP --------------------------------------------------------------------------------


class SlsqpPolish:
    """SLSQP with exact gradients of objective and constraints from elastocal's kernel."""

    exact = True

    def __init__(self, problem: Problem, points: int) -> None:
        begun = time.process_time()
        self.study, self.held, self.s = problem.study, problem.held, points
        self.space = problem.study.space
        self.criterion = mean_test_pose(problem.study)
        self.bounds = np.tile(
            np.transpose([self.space.lower, self.space.upper])[self.held :], (points, 1)
        )
        self.construction = time.process_time() - begun

    def __call__(self, x: Array, repeats: IntArray) -> Polished:
        model = _Model(self, repeats)
        start = x[:, self.held :].ravel()
        constraint = {"type": "ineq", "fun": model.margins}
        if self.exact:
            constraint["jac"] = model.margin_slopes
        found = minimize(
            model.loss,
            start,
            jac=model.slope if self.exact else None,
            method="SLSQP",
            bounds=self.bounds,
            constraints=[constraint] if model.margins(start).size else [],
            options={"maxiter": 200, "ftol": 1e-9},
        )
        end = np.clip(found.x, *self.bounds.T)
        feasible = np.isfinite(found.fun) and model.margins(end).min(initial=0.0) >= -FEASIBLE
        rho0 = MICRO * np.exp(model.loss(end) / 2.0) if feasible else np.inf
        return Polished(model.points(end), repeats, float(rho0))


class DifferencesPolish(SlsqpPolish):
    """SLSQP with differences of the values of elastocal's kernel."""

    exact = False


class _Model:
    """Objective and constraints of one plan; one evaluation serves value and gradient."""

    def __init__(self, owner: SlsqpPolish, repeats: IntArray) -> None:
        self.owner, self.repeats = owner, repeats.astype(float)
        self.space, self.s = owner.space, owner.s
        self.known: bytes = b""

    def points(self, x: Array) -> Array:
        return np.hstack([np.zeros((self.s, self.owner.held)), x.reshape(self.s, -1)])

    def loss(self, x: Array) -> float:
        blocks = self.space.evaluate(self.points(x)).blocks
        return -float(np.log(self._value(blocks)[0]))

    def margins(self, x: Array) -> Array:
        return np.asarray(self.space.evaluate(self.points(x)).margins.T.ravel())

    def slope(self, x: Array) -> Array:
        self._at(x)
        return self._slope

    def margin_slopes(self, x: Array) -> Array:
        self._at(x)
        return self._margin_slopes

    def _value(self, blocks: Array) -> tuple[float, Array]:
        each = information(blocks)
        total = self.owner.study.prior + np.einsum("i,ijk->jk", self.repeats, each)
        value, gradient = self.owner.criterion.both(total[None])
        return max(float(value[0]), 1e-300), gradient[0]

    def _at(self, x: Array) -> None:
        """Evaluate: the points once for the objective, once more per constraint."""
        if x.tobytes() == self.known:
            return
        self.known, s = x.tobytes(), self.s
        kinds = len(self.space.constraints) + self._cones
        evaluation = self.space.evaluate(np.tile(self.points(x), (1 + kinds, 1)))
        blocks = evaluation.blocks[:s]
        value, gradient = self._value(blocks)
        block_cotangent = np.zeros_like(evaluation.blocks)
        block_cotangent[:s] = (blocks @ (gradient * (-2.0 / value))) * self.repeats[:, None, None]
        margin_cotangent = np.zeros((len(evaluation.blocks), kinds))
        for kind in range(kinds):
            margin_cotangent[(kind + 1) * s : (kind + 2) * s, kind] = 1.0
        pulled = evaluation.pull(block_cotangent, margin_cotangent)[:, self.owner.held :]
        self._slope = pulled[:s].ravel()
        slopes = np.zeros((kinds * s, s, pulled.shape[1]))
        slopes[np.arange(kinds * s), np.tile(np.arange(s), kinds)] = pulled[s:]
        self._margin_slopes = slopes.reshape(kinds * s, s * pulled.shape[1])

    @property
    def _cones(self) -> int:
        return int(getattr(self.space.force, "is_cone", False))


class NoPolish(SlsqpPolish):
    """Says what a plan is worth and leaves it as it is."""

    def __call__(self, x: Array, repeats: IntArray) -> Polished:
        model = _Model(self, repeats)
        free = x[:, self.held :].ravel()
        feasible = model.margins(free).min(initial=0.0) >= -FEASIBLE
        return Polished(
            x, repeats, MICRO * float(np.exp(model.loss(free) / 2.0)) if feasible else np.inf
        )


# --- Where to start -----------------------------------------------------------------------------


class RandomStarts:
    """Uniformly random feasible plans, the repeats spread evenly."""

    pool_size = 2000
    grows = 0.0  # how many times as long the next start takes at least, where that is known

    def __init__(self, problem: Problem, points: int, rng: np.random.Generator) -> None:
        self.problem, self.study, self.rng, self.points = problem, problem.study, rng, points
        self.criterion = mean_test_pose(self.study)
        self.pool = self.drawn(self.pool_size) if self.pool_size else None

    def drawn(self, count: int) -> Array:
        """Random feasible points, with the first joint at zero if it cannot matter."""
        pool = self.study.space.sample(count, self.rng)
        pool[:, : self.problem.held] = 0.0
        return pool

    def informations(self, points: Array) -> Array:
        """(N, p, p) of design points."""
        return information(self.study.space.evaluate(points).blocks)

    def even(self) -> IntArray:
        """Repeats of the points of a plan."""
        m, s = self.study.experiments.count, self.points
        return np.full(s, m // s) + (np.arange(s) < m % s)

    def next(self, best: list[Polished]) -> tuple[Array, IntArray]:
        """Points (s, d) and repeats (s,) to start from, given the best plans so far."""
        return self.pool[self.rng.integers(0, len(self.pool), self.points)], self.even()


class ExchangeStarts(RandomStarts):
    """Fedorov's exchange: points of the pool in place of those of a plan while that helps."""

    def __init__(self, problem: Problem, points: int, rng: np.random.Generator) -> None:
        super().__init__(problem, points, rng)
        self.each = self.informations(self.pool)

    def next(self, best: list[Polished]) -> tuple[Array, IntArray]:
        """See `RandomStarts`."""
        chosen, repeats = self.rng.integers(0, len(self.pool), self.points), self.even()
        value, better = 0.0, True
        while better:
            better = False
            for i in range(self.points):
                rest = self.study.prior + np.einsum("i,ijk->jk", repeats, self.each[chosen])
                rest = rest - repeats[i] * self.each[chosen[i]]
                values = self.criterion.value(rest + repeats[i] * self.each)
                if values.max() > value * (1.0 + 1e-6):
                    chosen[i], value, better = int(values.argmax()), float(values.max()), True
        return self.pool[chosen], repeats


class BredStarts(RandomStarts):
    """The start recipes of elastocal's search, one plan at a time.

    At most 6 points, with repeats where m is larger. After 16 fresh starts three of four are one of
    the best plans with one point replaced or one repeat moved. A fresh start is the best of 50
    random plans; from m = 6 two of three are a rounded continuous design on the candidates.
    """

    def __init__(self, problem: Problem, points: int, rng: np.random.Generator) -> None:
        super().__init__(problem, points, rng)
        m = self.study.experiments.count
        self.each = self.informations(self.pool)
        self.base = self.study.prior / m
        self.design = None
        if m >= 6:
            self.design = optimal_weights(self.criterion, self.each, self.base, tolerance=1e-3)
        self.made = 0

    def next(self, best: list[Polished]) -> tuple[Array, IntArray]:
        """See `RandomStarts`."""
        self.made += 1
        if best and self.made > 16 and self.made % 4:
            return self._mutated(best[self.rng.integers(len(best))])
        if self.design is not None and self.rng.random() < 2.0 / 3.0:
            return self._rounded()
        return self._screened()

    def _screened(self, tries: int = 50) -> tuple[Array, IntArray]:
        s = self.points
        chosen = self.rng.integers(0, len(self.pool), (tries, s))
        repeats = np.ones((tries, s), dtype=np.int64)
        repeats += self.rng.multinomial(
            self.study.experiments.count - s, np.full(s, 1.0 / s), size=tries
        )
        totals = self.study.prior + np.einsum("ts,tsij->tij", repeats, self.each[chosen])
        first = int(self.criterion.value(totals).argmax())
        return self.pool[chosen[first]], repeats[first]

    def _rounded(self) -> tuple[Array, IntArray]:
        assert self.design is not None
        support, weights = self.design
        size = min(self.points, len(support))
        part = self.rng.choice(support, size, replace=False, p=weights / weights.sum())
        share = interior_point(self.criterion, self.each[part], self.base, 1e-3)
        repeats = np.zeros(self.points, dtype=np.int64)
        repeats[:size] = apportion(share, self.study.experiments.count)
        return self.pool[part[np.arange(self.points) % size]], repeats

    def _mutated(self, parent: Polished) -> tuple[Array, IntArray]:
        x, repeats = parent.x.copy(), parent.repeats.copy()
        source = self.rng.choice(np.flatnonzero(repeats))
        if self.study.experiments.count > self.points and self.rng.random() < 0.5:
            goal = self.rng.integers(self.points)
            if repeats[goal] == 0:
                x[goal] = x[source]
            repeats[source] -= 1
            repeats[goal] += 1
        else:
            x[source] = self.rng.choice(self.pool)
        return x, repeats


class ConeStarts(RandomStarts):
    """The best weights on a pool as a cone program, rounded; each pool is twice the last."""

    pool_size, grows = 500, 2.0

    def next(self, best: list[Polished]) -> tuple[Array, IntArray]:
        """See `RandomStarts`."""
        import cvxpy as cp

        pool, m = self.pool, self.study.experiments.count
        self.pool = self.drawn(2 * len(pool))
        each = self.informations(pool)
        prior, size = self.study.prior / m, len(each[0])
        # In units in which the mean over the pool is the identity: else the solver gives up.
        unit = np.linalg.inv(np.linalg.cholesky(prior + each.mean(axis=0)))
        flat = (unit @ each @ unit.T).reshape(len(pool), -1)
        weights = cp.Variable(len(pool), nonneg=True)
        total = unit @ prior @ unit.T + cp.reshape(flat.T @ weights, (size, size), order="C")
        asked = unit @ _asked(self.problem).T
        loss = cp.matrix_frac(asked / np.linalg.norm(asked), total)
        cp.Problem(cp.Minimize(loss), [cp.sum(weights) == 1]).solve(solver=cp.CLARABEL)
        heaviest = np.argsort(-weights.value)[: self.points]
        share = np.maximum(weights.value[heaviest], 1e-12)
        return pool[heaviest], apportion(share / share.sum(), m)


class OptexStarts(RandomStarts):
    """One try of pyoptex's coordinate exchange, from a start of its own."""

    pool_size = 0

    def __init__(self, problem: Problem, points: int, rng: np.random.Generator) -> None:
        super().__init__(problem, points, rng)
        from pyoptex._seed import set_seed
        from pyoptex.doe.fixed_structure import utils, wrapper
        from pyoptex.doe.fixed_structure.init import initialize_feasible

        set_seed(int(rng.integers(2**31)))
        space, held = self.study.space, problem.held
        self.lower, self.upper = space.lower, space.upper
        free = len(self.study.robot.joints)  # from there on a direction, which must not be zero
        ranges = np.transpose([self.lower, self.upper])[held:].tolist()
        factors = [
            utils.Factor(str(i), None, "cont", low, high, np.linspace(low, high, LEVELS))
            for i, (low, high) in enumerate(ranges)
        ]

        def refused(rows: Array) -> Array:
            x = self.of(np.asarray(rows))
            nowhere = (x[:, free:] == 0.0).all(axis=1) if free < x.shape[1] else np.array([False])
            return ~space.feasible(x) | nowhere

        self.metric = _Metric(self)
        ones = lambda rows: np.ones((len(rows), 1))  # noqa: E731
        functions = utils.FunctionSet(self.metric, ones, refused, refused, initialize_feasible)
        self.parameters = wrapper.create_parameters(factors, functions, points)
        self.design = wrapper.create_fixed_structure_design
        self.deadline = time.process_time() + 0.98 * problem.cap

    def of(self, rows: Array) -> Array:
        """Design points of pyoptex's rows, whose variables go from -1 to 1."""
        held = self.problem.held
        middle, half = (self.upper + self.lower) / 2.0, (self.upper - self.lower) / 2.0
        return np.hstack(
            [
                np.zeros((len(rows), held)),
                (middle + half * np.pad(rows, ((0, 0), (held, 0))))[:, held:],
            ]
        )

    def next(self, best: list[Polished]) -> tuple[Array, IntArray]:
        """See `RandomStarts`."""
        self.metric.best = 0.0
        with suppress(KeyboardInterrupt):
            self.design(self.parameters, n_tries=1)
        return self.metric.plan, self.even()


class _Metric:
    """φ of a plan for pyoptex; only points that have changed are looked at again."""

    def __init__(self, owner: OptexStarts) -> None:
        self.owner, self.repeats = owner, owner.even().astype(float)
        self.rows = np.full((owner.points, 0), np.nan)
        self.best = 0.0

    def preinit(self, *_: Any) -> None:
        pass

    init = preinit

    def call(self, Y: Array, X: Array, params: Any) -> float:
        rows, owner = np.asarray(Y), self.owner
        if self.rows.shape != rows.shape:
            self.rows = np.full(rows.shape, np.nan)
            self.each = np.zeros((len(rows), *owner.study.prior.shape))
        changed = np.flatnonzero((self.rows != rows).any(axis=1))
        if len(changed):
            self.rows[changed] = rows[changed]
            self.each[changed] = owner.informations(owner.of(rows[changed]))
        total = owner.study.prior + np.tensordot(self.repeats, self.each, 1)
        value = float(owner.criterion.value(total[None])[0])
        if value > self.best:
            self.best, self.plan = value, owner.of(rows)
        if time.process_time() > owner.deadline:
            raise KeyboardInterrupt
        return value


# --- Multistart ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Improvement:
    """A plan that was better than all before it."""

    seconds: float
    rho0: float  # [1e-3 mm]
    x: Array
    repeats: IntArray


METHODS: dict[str, tuple[Callable[[Problem, int], Polish], type[RandomStarts]]] = {
    "CasADi + IPOPT, random starts": (IpoptPolish, RandomStarts),
    "CasADi + IPOPT, bred starts": (IpoptPolish, BredStarts),
    "SciPy SLSQP, exact gradients": (SlsqpPolish, RandomStarts),
    "SciPy SLSQP, differences": (DifferencesPolish, RandomStarts),
    "exchange of candidates, SLSQP": (SlsqpPolish, ExchangeStarts),
    "pyoptex, own metric": (NoPolish, OptexStarts),
    "cone program on candidates": (NoPolish, ConeStarts),
}


class Search(NamedTuple):
    """What a multistart did."""

    trace: list[Improvement]
    construction: float  # seconds before the clock of the trace began
    starts: int
    seconds: float


def multistart(method: str, problem: Problem, seed: int, *, goal: float = 0.0) -> Search:
    """Polish starts until rho0 reaches `goal` [1e-3 mm] or the cap of the problem is over.

    Processor seconds. The clock starts when the solver is ready and includes sampling, starts and
    polishing. A plan that is ready after the cap does not count.
    """
    make_polish, make_starts = METHODS[method]
    points = configurations(problem)
    if make_starts is BredStarts:
        points = min(points, max(6, len(problem.study.springs) + 1))
    polish = make_polish(problem, points)
    begun = time.process_time()
    starts = make_starts(problem, points, np.random.default_rng(seed))
    trace: list[Improvement] = []
    best: list[Polished] = []
    made = 0
    now = last = 0.0
    while now < problem.cap - make_starts.grows * last:
        found = polish(*starts.next(best))
        made, last = made + 1, -now
        now = time.process_time() - begun
        last += now
        if np.isfinite(found.rho0) and now <= 1.02 * problem.cap:
            if not trace or found.rho0 < trace[-1].rho0:
                trace.append(Improvement(now, found.rho0, found.x, found.repeats))
            if all(abs(found.rho0 / plan.rho0 - 1.0) > 1e-7 for plan in best):
                best = sorted([*best, found], key=lambda plan: plan.rho0)[:24]
        if trace and trace[-1].rho0 <= goal:
            break
    return Search(trace, polish.construction, made, time.process_time() - begun)


def verify(problem: Problem, trace: list[Improvement]) -> None:
    """Every plan of a trace is feasible and worth what was claimed, by elastocal's `assess`.

    Raises:
        AssertionError: the baseline's model and elastocal's disagree.
    """
    for step in trace:
        used = step.repeats > 0
        cases = problem.study.space.load_cases(step.x[used])
        judged = assess(problem.study, cases, step.repeats[used])
        assert not judged.violations, judged.violations
        deviation = MICRO * judged.rho0 / step.rho0 - 1.0
        assert abs(deviation) < 1e-5, f"rho0 claimed {step.rho0}, assessed {deviation:+.1e} off"
