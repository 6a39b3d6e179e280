"""Planning: study → feasible candidates → continuous design → plan with its certificate.

In: a `Study`. Out: a `Plan`. Nothing is printed or written.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.assessment import Assessment, assess, load_case_information, margins
from elastocal.criteria import criterion_of
from elastocal.design.continuous import ContinuousDesign, continuous_design
from elastocal.design.criterion import Criterion, InformationFunction, weakest
from elastocal.design.exact import Effort, exact_design
from elastocal.design.oracle import climb
from elastocal.design.space import information
from elastocal.design.worst import floored
from elastocal.identifiability import check_count, check_identifiable
from elastocal.load_case import LoadCases
from elastocal.study import Study

Progress = Callable[[str, float], None]
"""(what is going on, share done between 0 and 1) -> None."""

SINGULAR = 1e-5  # scaled eigenvalue below which an optimum counts as singular
FLOOR = 1e-4  # share of the loss that a floor adds
_ALIKE = 0.03  # relative distance of information matrices that are shown as one
_OPEN = 0.1  # gap between value and bound that only a singular optimum leaves


@dataclass(frozen=True)
class Certificate:
    """How far any plan can be from the best of all plans with as many experiments.

    Attributes:
        criterion: Name of the criterion it speaks of.
        kind: "numerical": the bound rests on a multistart search; "none": no bound exists.
        lower_bound: No plan has a smaller loss 1/√φ: ρ0 [m] for test-pose criteria.
        efficiency: φ of the plan over the bound: 0.9 means that at best 10 % of the experiments
            could be saved.
        fresh_starts: Fresh random starts that failed to refute the bound.
        attained: How many of them reached the same maximum.
        support: Load cases of the continuous design behind the bound, those of nearly the same
            information taken together.
        weights: (S,) their weights.
        peak: The load case where the sensitivity is largest.
        peak_ratio: Sensitivity there over the mean over the support: 1 at an optimum.
        floored: Whether a floor kept the unknowns that the criterion ignores identifiable.
    """

    criterion: str
    kind: str
    lower_bound: float = 0.0
    efficiency: float = float("nan")
    fresh_starts: int = 0
    attained: int = 0
    support: LoadCases | None = None
    weights: Array | None = None
    peak: LoadCases | None = None
    peak_ratio: float = float("nan")
    floored: bool = False


@dataclass(frozen=True)
class Plan:
    """Experiments to do, what they are worth, and the proof.

    Attributes:
        load_cases: S distinct load cases, in order of execution.
        repeats: (S,) how often each is measured.
        assessment: What the plan is worth.
        certificate: How far it can be from the best.
        criterion: Name of the criterion it was planned for.
        seed: Seed of the search.
        study: The study it was made from.
        free_joints: Joints whose values do not matter: set them as the cell requires.
    """

    load_cases: LoadCases
    repeats: IntArray
    assessment: Assessment
    certificate: Certificate
    criterion: str
    seed: int
    study: Study
    free_joints: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        """Number of experiments m."""
        return int(self.repeats.sum())


def plan(
    study: Study,
    *,
    seed: int = 0,
    effort: Effort | None = None,
    bound: Bound | None = None,
    progress: Progress | None = None,
) -> Plan:
    """Best plan found for a study, with its certificate.

    Args:
        study: What to plan.
        seed: Same seed, same plan.
        effort: How long to search.
        bound: Bound computed before for the same study and count, to be used again.
        progress: Told what is going on.

    Raises:
        InfeasibleError: no load case satisfies the constraints.
        IdentifiabilityError: some compliances cannot be told apart.
    """
    rng = np.random.default_rng(seed)
    space, m = study.space, study.experiments.count
    distinct = min(m, study.experiments.max_configurations or m)
    check_identifiable(space, study.prior, rng)
    check_count(space, study.prior, m, distinct, rng)
    tell = progress or (lambda what, share: None)
    bound = bound or lower_bound(study, rng, progress=tell)
    design = exact_design(
        space,
        bound.target,
        m,
        min(distinct, _enough(len(study.springs))),
        rng,
        base=study.prior,
        continuous=bound.design,
        effort=effort,
        progress=lambda what, share: tell(what, 0.4 + 0.6 * share),
    )
    bound = confirmed(study, bound, design.x, rng)
    cases, free = simplify(study, space.load_cases(design.x))
    tell("exact plan", 1.0)
    return Plan(
        load_cases=cases,
        repeats=frozen(design.counts, np.int64),
        assessment=assess(study, cases, design.counts),
        certificate=certificate(study, bound, cases, design.counts),
        criterion=study.criterion,
        seed=seed,
        study=study,
        free_joints=free,
    )


def simplify(study: Study, cases: LoadCases) -> tuple[LoadCases, tuple[str, ...]]:
    """The same experiments with plainer joint values.

    Whole turns are taken out where the limits allow, and joints that change neither information
    nor margins are put to their rest position: the user may set them as the cell requires.

    Returns:
        The load cases, and the names of the joints that are free.
    """
    robot, q = study.robot, np.array(cases.q)
    lower, upper = study.limits
    for j, joint in enumerate(robot.joints):
        if not joint.prismatic:
            near = q[:, j] - 2.0 * np.pi * np.round(q[:, j] / (2.0 * np.pi))
            inside = (near >= lower[j]) & (near <= upper[j])
            q[:, j] = np.where(inside, near, q[:, j])
    free = []
    for j, joint in enumerate(robot.joints):
        rest = float(np.clip(0.0, lower[j], upper[j]))
        trial, other = q.copy(), q.copy()
        trial[:, j] = rest
        other[:, j] = 0.6 * rest + 0.4 * upper[j]
        if _same(study, q, trial, cases.wrench, j) and _same(study, q, other, cases.wrench, j):
            q = trial
            free.append(joint.name)
    return LoadCases(q, cases.wrench), tuple(free)


def _same(study: Study, q: Array, other: Array, wrench: Array, joint: int) -> bool:
    """Whether two sets of configurations differ in nothing but the margins of one joint."""
    before, after = LoadCases(q, wrench), LoadCases(other, wrench)
    informations = load_case_information(study, before)
    change = np.abs(load_case_information(study, after) - informations).max()
    _, room_before = margins(study, before)
    _, room_after = margins(study, after)
    moved = np.abs(room_after - room_before)
    moved[2 * joint : 2 * joint + 2] = 0.0
    return bool(change <= 1e-9 * np.abs(informations).max() and moved.max() <= 1e-9)


@dataclass(frozen=True)
class Bound:
    """What is known of the best plan before any plan is made.

    Attributes:
        criterion: The criterion.
        target: What the search optimises: the criterion, with a floor if its optimum is singular.
        design: The continuous design; None for a criterion without certificate.
    """

    criterion: Criterion
    target: Criterion
    design: ContinuousDesign | None

    @property
    def floored(self) -> bool:
        """Whether the search has a floor under the unknowns the criterion ignores."""
        return self.target is not self.criterion


def lower_bound(
    study: Study,
    rng: np.random.Generator,
    *,
    known: Array | None = None,
    progress: Progress | None = None,
) -> Bound:
    """Bound on every plan with as many experiments as the study has.

    Args:
        study: The study.
        rng: Source of candidates and fresh starts.
        known: (K, d) feasible design points to begin with.
        progress: Told the gap as it closes.
    """
    criterion = criterion_of(study)
    if not isinstance(criterion, InformationFunction):
        return Bound(criterion, criterion, None)
    base = study.prior / study.experiments.count
    space = study.space
    gaps: list[float] = []

    def tell(what: str, gap: float) -> None:
        gaps.append(gap)
        if progress is not None:
            closed = -np.log10(max(min(gaps), 1e-6)) / 6.0
            progress(f"{what}, gap {gap:.0e}", 0.4 * float(np.clip(closed, 0.0, 1.0)))

    design = continuous_design(space, criterion, rng, base=base, known=known, progress=tell)
    if design.gap < _OPEN and weakest(design.total) > SINGULAR:
        return Bound(criterion, criterion, design)
    blocks = information(space.evaluate(space.sample(500, rng)).blocks)
    target = floored(criterion, base + blocks.mean(axis=0), FLOOR)
    design = continuous_design(
        space, target, rng, certified=criterion, base=base, known=known, progress=tell
    )
    return Bound(criterion, target, design)


def confirmed(study: Study, bound: Bound, x: Array, rng: np.random.Generator) -> Bound:
    """The bound, after climbing from the points `x` of a plan has failed to refute it.

    If it is refuted, a new one is computed that knows where the climb ended.
    """
    for _ in range(3):
        if bound.design is None:
            return bound
        dual = bound.design.certificate
        found, s, _ = climb(study.space, x, dual.gradient, ((150, len(x)),))
        if s.max() <= dual.largest * (1.0 + 5e-6):
            break
        bound = lower_bound(study, rng, known=found[s > 0.0])
    return bound


def certificate(study: Study, bound: Bound, cases: LoadCases, repeats: IntArray) -> Certificate:
    """What `bound` says of a plan."""
    if bound.design is None:
        return Certificate(study.criterion, "none")
    design, m, space = bound.design, int(repeats.sum()), study.space
    information_matrix = assess(study, cases, repeats).information
    value = float(bound.criterion.value(information_matrix[None])[0])
    dual = design.certificate
    level = float(np.einsum("i,ijk,jk->", design.weights, design.informations, dual.gradient))
    x, weights = _merged(design)
    support, _ = simplify(study, space.load_cases(x))
    peak, _ = simplify(study, space.load_cases(dual.x_largest[None]))
    return Certificate(
        criterion=study.criterion,
        kind="numerical",
        lower_bound=float(1.0 / np.sqrt(m * dual.upper)),
        efficiency=value / (m * dual.upper),
        fresh_starts=dual.starts,
        attained=dual.attained,
        support=support,
        weights=frozen(weights),
        peak=peak,
        peak_ratio=dual.largest / level,
        floored=bound.floored,
    )


def _merged(design: ContinuousDesign) -> tuple[Array, Array]:
    """Support and weights with points of nearly the same information taken together."""
    flat = design.informations.reshape(len(design.x), -1)
    kept: list[int] = []
    weights: list[float] = []
    for i in np.argsort(-design.weights, kind="stable"):
        distance = np.linalg.norm(flat[kept] - flat[i], axis=1) / np.linalg.norm(flat[i])
        near = np.flatnonzero(distance < _ALIKE)
        if len(near):
            weights[near[0]] += float(design.weights[i])
        else:
            kept.append(int(i))
            weights.append(float(design.weights[i]))
    order = [i for i in np.argsort(weights)[::-1] if weights[i] > 1e-3 * max(weights)]
    return design.x[np.array(kept)[order]], np.array(weights)[order]


def _enough(parameters: int) -> int:
    """Distinct load cases to search with: more would cost time and gain next to nothing."""
    return max(6, parameters + 1)
