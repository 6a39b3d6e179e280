"""Planning: study → first plans → continuous design with its bound → plan with its certificate.

In: a `Study`. Out: a `Plan`. Nothing is printed or written.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import NamedTuple, NoReturn

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.constraints import Constraint, room_at
from elastocal.constraints.watch import Watch, watch_of
from elastocal.design.criterion import Criterion, InformationFunction
from elastocal.design.exact import Effort, ExactDesign, exact_design, first_plans
from elastocal.design.refinement import Plans
from elastocal.design.twins import merged
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt, InfeasibleError
from elastocal.motion.margins import motions_free
from elastocal.motion.schedule import Schedule, schedule
from elastocal.motion.tour import best_order
from elastocal.motion.via_points import UnreachableError, detours, refuse_home
from elastocal.motion.within_reach import out_of_reach, reachable_limits
from elastocal.planning.aim import Aim, aim_of, is_for_promise
from elastocal.planning.assessment import Assessment, assess, broken, hardly_known, search_stopped
from elastocal.planning.blind import BlindErrors, blind_errors
from elastocal.planning.bracket import bracket
from elastocal.planning.carried import carried
from elastocal.planning.certificate import (
    Bound,
    Certificate,
    Progress,
    certificate,
    confirmed,
    lower_bound,
    with_floor,
)
from elastocal.planning.effort import effort_for, enough
from elastocal.planning.lost import AGAIN, away_from, others_lost, turned_into
from elastocal.planning.mends import Mend, mends
from elastocal.planning.needed import half_known, hardly_needed
from elastocal.planning.one_side import azimuth_range
from elastocal.planning.plain_values import Plain, simplify
from elastocal.planning.relieved import relieved, rests_on_one
from elastocal.planning.robust import not_held, refuse_unfit, withstanding
from elastocal.planning.spread import spread
from elastocal.planning.standing import Standing, asked_standing
from elastocal.planning.visibility import Visibility, visibility
from elastocal.robot.posture import Posture
from elastocal.stopping import Stop
from elastocal.study.identifiability import check_count, check_identifiable
from elastocal.study.left_rigid import left_rigid
from elastocal.study.study import Study
from elastocal.wording import worded


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
        turns_with_load: Joint that may be turned together with the load, by the same angle; empty
            if there is none. The loads come from one side of it if its limits allow.
        searches: Independent searches that were made for it; one where the first met the bound.
        apart: Share of φ by which the worst of them ended below the best.
        stopped_after: Generations of plans after which the search was stopped; None if it was
            finished.
        via: S + 1 arrays (K, n): configurations to pass on the way to each load case and at last
            home, where the straight motion is blocked [rad or m]; empty if none is.
        as_good: Where the plan stood that was to be as good as can be, before it was made robust;
            None if that is not asked for.
        bound: What its certificate rests on, to be proved.
    """

    load_cases: LoadCases
    repeats: IntArray
    assessment: Assessment
    certificate: Certificate
    criterion: str
    seed: int
    study: Study
    free_joints: tuple[str, ...] = ()
    turns_with_load: str = ""
    via: tuple[Array, ...] = ()
    searches: int = 1
    apart: float = 0.0
    stopped_after: int | None = None
    as_good: Standing | None = None
    bound: Bound | None = field(default=None, repr=False, compare=False)

    @property
    def count(self) -> int:
        """Number of experiments m."""
        return int(self.repeats.sum())

    @cached_property
    def doubts(self) -> tuple[Doubt, ...]:
        """What is weak: a search that was stopped; more left without one configuration than is
        allowed, or than need be; compliances that rest on one; joints taken as rigid that the task
        bends, which ρ0 leaves out; compliances that the experiments hardly tell, or that the task
        hardly needs; what is hardly watched; what is out of reach."""
        rigid = [d for d in left_rigid(self.study) if d.code == "rigid-at-test-pose"]
        hardly = hardly_known(self.study.springs, self.assessment.standard_error)
        watched = [d for d in self.watch.doubts if d.code in ("hardly-watched", "odd-size")]
        stopped = search_stopped(self.stopped_after)
        usual = (
            *half_known(self.study, self.assessment),
            *hardly_needed(self.study, self.assessment),
        )
        best = self.certificate.rho0_bound
        alone = carried(self.study, self.load_cases, self.repeats, self.assessment, best)
        held_up = rests_on_one(self.study, self.load_cases, self.repeats)
        out = out_of_reach(self.study.motion_space)
        blind = None if self.standing is None else self.standing.blind
        lost = not_held(self.study, self.assessment, self.certificate, blind)
        return (*stopped, *lost, *rigid, *hardly, *alone, *held_up, *usual, *watched, *out)

    @cached_property
    def blind(self) -> BlindErrors | None:
        """What it cannot see of what the model lacks; None if that is not known."""
        return blind_errors(self.study, self.load_cases, self.repeats)

    @cached_property
    def standing(self) -> Standing | None:
        """Where it stands, if it is to withstand something."""
        asked = self.study.experiments.robust is not None or self.as_good is not None
        if not asked or not self.assessment.identifiable:
            return None
        found = asked_standing(self.study, self.load_cases, self.repeats)
        return replace(found, minutes=self.schedule.total / 60.0)

    @property
    def for_promise(self) -> bool:
        """Whether it was made for what it promises, errors of load cases included."""
        return is_for_promise(self.study)

    @cached_property
    def mends(self) -> tuple[Mend, ...]:
        """What would make it promise more, by quick estimates."""
        return mends(self.study, self.load_cases, self.repeats)

    @cached_property
    def broken(self) -> tuple[Doubt, ...]:
        """What forbids to carry it out; nothing, if it was planned and not changed since."""
        return broken(self.study, self.assessment, self.load_cases.q, self.via)

    @property
    def watch(self) -> Watch:
        """What is watched for collisions."""
        return watch_of(self.study.constraints)

    @property
    def view(self) -> Visibility | None:
        """What the tracker sees at the load cases; None if the instrument is no tracker."""
        return visibility(self.study.space, self.load_cases.q)

    @property
    def load_range(self) -> float:
        """Over which angle about `turns_with_load` the loads spread [rad]; 0: from one side."""
        if not self.turns_with_load:
            return 0.0
        return azimuth_range(self.study.robot, self.load_cases, self.turns_with_load)

    @property
    def schedule(self) -> Schedule:
        """Times of moving, measuring and changing loads."""
        return schedule(self.load_cases, self.repeats, self.study.pace, self.via)


def plan(
    study: Study,
    *,
    seed: int = 0,
    effort: Effort | None = None,
    bound: Bound | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> Plan:
    """Best plan found for a study, with its certificate.

    A first plan comes at once, then the bound, then better plans. Stopped on the way, it is the
    best plan so far, finished as any other; without a certificate if the bound was not tried yet.

    Args:
        study: What to plan.
        seed: Same seed, same plan.
        effort: How long to search.
        bound: Bound computed before for the same study and count, to be used again.
        progress: Told what is going on, and how good the best plan so far is.
        stop: Asked often, from when there is a feasible plan, whether to end with the best so far.
            The plan is then not a matter of the seed alone.

    Raises:
        InfeasibleError: no load case satisfies the constraints, or no motion leads there.
        IdentifiabilityError: some compliances cannot be told apart.
        InputError: `robust` is asked for, which speaks of ρ0, with another criterion.
    """
    refuse_unfit(study)
    rng = np.random.default_rng(seed)
    m = study.experiments.count
    distinct = study.experiments.distinct
    refuse_home(study.motion_space)
    if not study.experiments.weighs:  # else what readings cannot tell rests on its prior
        check_identifiable(study.space, study.prior, rng)
        check_count(study.space, study.prior, m, distinct, rng)
    tell = progress or (lambda what, share: None)
    # Joint ranges that are out of reach are left out from the start.
    aim = aim_of(study)
    limits = reachable_limits(study.motion_space)
    aim = replace(aim, space=replace(aim.space, limits=limits))
    distinct = min(distinct, enough(aim))
    first = None if bound else _first(aim, distinct, seed, tell)
    bound = bound or lower_bound(
        study,
        rng,
        progress=partial(_told_beside, tell, study, aim, first),
        stop=None if first is None else stop,
    )
    if first is not None and bound.stopped:
        bound = replace(bound, target=first.criterion)
    effort = effort or effort_for(aim, distinct)
    search = partial(exact_design, count=m, distinct=distinct, rng=rng, effort=effort, stop=stop)
    found = _searched(study, aim, bound, first, search, seed, tell)
    bound = confirmed(study, bound, found.x, rng, stop=stop)
    cases, repeats = found.cases, found.repeats
    tell("exact plan", 1.0)
    worth = assess(study, cases, repeats)
    if worth.violations:
        raise InfeasibleError(
            f"no feasible plan was found: in the best, {worded(worth.violations[0])}"
        ).with_doubts(*worth.violations)
    return Plan(
        load_cases=cases,
        repeats=frozen(repeats, np.int64),
        assessment=worth,
        certificate=certificate(study, bound, worth, m),
        criterion=study.criterion,
        seed=seed,
        study=study,
        free_joints=found.plain.free,
        turns_with_load=found.plain.turns_with_load,
        via=found.via,
        searches=found.search.searches,
        apart=found.search.apart,
        stopped_after=found.generations if found.search.stopped else None,
        as_good=found.as_good,
        bound=bound,
    )


class _Outcome(NamedTuple):
    """What the search ends with."""

    x: Array  # (S, d) design points
    cases: LoadCases  # in order of execution
    repeats: IntArray
    plain: Plain
    via: tuple[Array, ...]
    search: ExactDesign  # before it was simplified
    generations: int  # of all searches
    as_good: Standing | None  # before it was made robust


class _First(NamedTuple):
    """Plans to have at once."""

    criterion: Criterion  # with a floor: nobody knows yet whether it needs one
    plans: Plans  # the best first


def _first(aim: Aim, distinct: int, seed: int, tell: Progress) -> _First | None:
    """Plans to have at once, by random numbers of their own; None if there are none so soon."""
    tell("first plans", 0.0)
    rng, criterion = np.random.default_rng([seed, 2]), aim.criterion
    try:
        x = aim.space.sample(_FIRST, rng)
        if isinstance(criterion, InformationFunction):
            criterion = with_floor(aim, criterion, x)
        goal = aim.goal(criterion=criterion)
        plans = first_plans(goal, aim.count, distinct, x, rng)
    except InfeasibleError:  # who searches for longer says what is in the way
        return None
    return None if plans is None else _First(criterion, plans)


_FIRST = 300  # random load cases that the first plans are made of


def _searched(
    study: Study,
    aim: Aim,
    bound: Bound,
    first: _First | None,
    search: Callable[..., ExactDesign],
    seed: int,
    tell: Progress,
) -> _Outcome:
    """The best plan found whose configurations can all be reached from home.

    Configurations to which no way leads are ruled out with what is near them, every time in a wider
    circle.
    """
    motions, space = study.motion_space, aim.space
    continuous = turned_into(space.limits, bound.design, study.robot) if bound.design else None
    generations = 0 if first is None else 1
    avoid: tuple[Constraint, ...] = ()
    blocked: UnreachableError | None = None
    for again in range(AGAIN + 1):
        reachable = replace(space, constraints=(*space.constraints, *avoid))
        goal = aim.goal(reachable, bound.target)
        try:
            found = search(
                goal,
                continuous=continuous,
                known=None if first is None else first.plans,
                progress=partial(_told, tell, study, aim, bound, again),
            )
        except InfeasibleError as error:
            _refuse(blocked or error, () if blocked else out_of_reach(motions))
        design, generations = found, generations + found.generations
        if aim.shares and not found.stopped:
            tell("load cases near to each other", 1.0)
            design = spread(aim, reachable, goal, found, np.random.default_rng([seed, 3]))
        plain = simplify(space, space.load_cases(design.x))
        single, as_good = merged(goal, design, _roomiest(study, plain.cases)), None
        if single is not design:
            plain = simplify(space, space.load_cases(single.x))
        if not found.stopped:
            tell("plans that can lose a configuration, or see more", 1.0)
            chance, best = np.random.default_rng([seed, 5]), bound.loss(aim.count)
            before = plain.cases, single.counts
            other = withstanding(study, aim, reachable, goal, design, before, best, chance)
            single, plain, as_good = other or (single, plain, None)
            freed = relieved(study, aim, reachable, goal, single, plain, chance)
            single, plain = freed or (single, plain)
        design = single
        cases = plain.cases
        order = best_order(cases, study.pace, free=partial(motions_free, motions)).sequence
        cases = cases.chosen(order)
        tell("ways between configurations", 1.0)
        try:
            via = detours(motions, cases.q, seed=seed)
        except UnreachableError as error:
            blocked = error
            if again < AGAIN:
                same = (*plain.free, plain.turns_with_load)
                lost = (error.q, *others_lost(motions, cases.q, error.q, seed))
                avoid += tuple(away_from(q, study.robot, same, again) for q in lost)
            continue
        repeats = design.counts[order]
        return _Outcome(design.x, cases, repeats, plain, via, found, generations, as_good)
    assert blocked is not None
    raise blocked


def _refuse(error: InfeasibleError, left_out: tuple[Doubt, ...]) -> NoReturn:
    """Raise the error with what was left out of the search for being out of reach."""
    if not left_out:
        raise error
    raise InfeasibleError("; ".join([str(error), *map(worded, left_out)])).with_doubts(
        *error.doubts, *left_out
    )


def _told_beside(
    tell: Progress, study: Study, aim: Aim, first: _First | None, what: str, share: float
) -> None:
    """What goes on beside the best of the first plans."""
    so_far = "" if first is None else bracket(study, aim, float(first.plans.value[0]), None)
    tell(f"{so_far}; {what}" if so_far else what, share)


def _told(
    tell: Progress, study: Study, aim: Aim, bound: Bound, again: int, share: float, value: float
) -> None:
    """How good the best plan of the search is, which has φ of `value`."""
    what = bracket(study, aim, value, bound) or "exact plan"
    if again:
        what += f", search {again + 1} of at most {AGAIN + 1} for want of ways"
    tell(what, 0.4 + 0.6 * share)


def _roomiest(study: Study, cases: LoadCases) -> IntArray:
    """(S,) load cases, those with the most room to their nearest constraints first."""
    constraints = (*study.joint_limits, *study.constraints)
    room = np.sort(room_at(constraints, Posture(study.robot, cases.q)), axis=0)
    return np.lexsort([np.arange(len(cases)), *-np.round(room[::-1], 6)])
