"""Exact designs: m experiments at no more than s distinct points, found by search.

The search keeps an elite of plans and breeds from it (breeding.py). For small m replacing points of
elite plans finds the best known plans most often; for large m rounding does. It can be stopped at
any time from when there is a feasible plan: the best so far is polished as at the end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.design.breeding import APART, ELITE, Breeder
from elastocal.design.continuous import MANY, ContinuousDesign
from elastocal.design.refinement import TINY, Goal, Plans, refine
from elastocal.errors import InfeasibleError
from elastocal.stopping import Stop, Stopped, stoppable


@dataclass(frozen=True)
class ExactDesign:
    """Design points with integer repeats.

    Attributes:
        x: (S, d) distinct design points.
        counts: (S,) repeats, all positive.
        value: φ of base plus the sum of the informations.
        searches: Independent evolutions that were made.
        apart: Share of φ by which the best of the worst of them is below the best of all.
        generations: Generations of plans that were made.
        stopped: Whether the search was stopped before its end.
    """

    x: Array
    counts: IntArray
    value: float
    searches: int = 1
    apart: float = 0.0
    generations: int = 0
    stopped: bool = False


@dataclass(frozen=True)
class Effort:
    """How long to search.

    Attributes:
        batch: Plans per generation.
        generations: Most generations.
        patience: Generations without gain after which to stop.
        islands: Independent evolutions; near-equal optima make one alone miss the best at times.
        stages: (evaluations, share kept) of the refinement inside a generation.
    """

    batch: int = 96
    generations: int = 12
    patience: int = 4
    islands: int = 2
    stages: tuple[tuple[int, float], ...] = ((30, 0.33), (40, 0.4), (60, 1.0))


_RANDOM = 2000  # points that plans are made of
_FIRST = 24, ((30, 0.33), (40, 1.0))  # plans made in a hurry, and how they are refined


def first_plans(
    goal: Goal, count: int, distinct: int, x: Array, rng: np.random.Generator
) -> Plans | None:
    """Feasible plans made in a hurry, the best first; None if there are none.

    Args:
        goal: What plans are worth.
        count: Number of experiments m.
        distinct: Most distinct points s ≤ m.
        x: (N, d) random feasible points to make them of.
        rng: Source of all randomness.
    """
    breeder = Breeder(goal.smooth, count, distinct, rng, None)
    breeder.draw(x)
    usual = goal.base + count * breeder.flat.mean(axis=0).reshape(goal.base.shape)
    breeder.goal = breeder.goal.near(usual[None])
    batch, stages = _FIRST
    made = breeder.checked(breeder.evolve(breeder.afresh(batch), stages)).feasible
    return made if len(made) else None


def exact_design(
    goal: Goal,
    count: int,
    distinct: int,
    rng: np.random.Generator,
    *,
    continuous: ContinuousDesign | None = None,
    known: Plans | None = None,
    effort: Effort | None = None,
    progress: Callable[[float, float], None] | None = None,
    stop: Stop | None = None,
) -> ExactDesign:
    """A plan of `count` experiments at no more than `distinct` points.

    Args:
        goal: What plans are worth.
        count: Number of experiments m.
        distinct: Most distinct points s ≤ m.
        rng: Source of all randomness.
        continuous: Best continuous design, to round and to know when to stop.
        known: Plans found before, which the first evolution breeds from, too.
        effort: How long to search.
        progress: Told the share that is done, and φ of the best plan so far.
        stop: Asked, from when there is a feasible plan, whether to end with the best so far.

    Raises:
        InfeasibleError: no plan satisfies the constraints.
    """
    if effort is None:
        effort = _effort_for(goal.space.parameters, distinct, rounding=continuous is not None)
    breeder = Breeder(goal.smooth, count, distinct, rng, continuous)
    given = [] if known is None else [breeder.checked(breeder.valued(known))]
    elites: list[Plans] = []  # of every evolution
    generations, stopped = 0, False

    def enough() -> bool:
        feasible = any(elite.value[0] > 0.0 for elite in (*given, *elites))
        return feasible and stop is not None and stop()

    try:
        with stoppable(enough):
            breeder.draw(goal.space.sample(_RANDOM, rng))
            for island in range(effort.islands):
                for share, elite in _generations(breeder, effort, given if island == 0 else []):
                    elites[island:] = [elite]
                    generations += 1
                    if progress is not None:
                        highest = max(float(elite.value[0]) for elite in elites)
                        progress((island + share) / effort.islands, highest)
                if breeder.cannot_improve(elites[island].value[0]):
                    break
    except Stopped:
        stopped = True
    ends = [float(elite.value[0]) for elite in (elites[:-1] if stopped else elites)]
    apart = 1.0 - min(ends) / max(*ends, TINY) if len(ends) > 1 else 0.0
    elite = reduce(Plans.join, elites or given).best(ELITE, apart=APART)
    while True:
        final = refine(breeder.goal, elite.best(6), stages=((300, 6),), tolerance=1e-13)
        last = elite.join(final)
        if not last.value.max() > 0.0:
            raise InfeasibleError(
                f"no feasible plan of {count} experiments at {distinct} points was found; "
                "the constraints may leave too little room"
            )
        before, elite = breeder.goal, breeder.checked(last)
        if breeder.goal is before:
            break
    last.value = goal.values(last.x, last.counts)
    best = _tidy(_by_what_decides(goal, last.best(1)))
    return replace(
        best,
        searches=max(len(ends), 1),
        apart=apart,
        generations=generations,
        stopped=stopped,
    )


def _effort_for(parameters: int, distinct: int, *, rounding: bool) -> Effort:
    """How long to search a plan at so many distinct points for so many unknowns."""
    # With many unknowns gains come late, and searches end in different places: with 18, of ten
    # seeds with two searches of 12 generations five ended .07 to .39 % above the best ρ0.
    late = Effort(generations=30, patience=8) if parameters > MANY else Effort()
    # Rounding the continuous design does most of the work where there is room for its support.
    if rounding and distinct > parameters:
        return replace(late, islands=1)
    # Seven axes at four points: one search of two ends .13 % above the best, in ρ0.
    return replace(late, islands=4 if parameters >= _SEVERAL else 2)


_SEVERAL = 6  # unknowns from which on searches end in different places


def _by_what_decides(goal: Goal, plan: Plans) -> Plans:
    """A plan refined by those alone, of very many members, that decide at it.

    The search has taken up others on its way, and what is smooth mixes them in.
    """
    whole = goal.smooth
    narrow, wider = whole, whole.near(goal.totals(plan.x, plan.counts)[0])
    while wider is not narrow:
        narrow = wider
        finer = refine(narrow, plan, stages=((300, 1),), tolerance=1e-13)
        both = plan.join(finer)
        both.value = goal.values(both.x, both.counts)
        plan = both.best(1)
        wider = narrow.near(goal.totals(finer.x, finer.counts)[0])
    return plan


def _generations(
    breeder: Breeder, effort: Effort, given: Sequence[Plans]
) -> Iterator[tuple[float, Plans]]:
    """One evolution from nothing, or from plans that are given.

    After every generation: the share of it that is done, and the elite.
    """
    elite = reduce(Plans.join, given, breeder.evolve(breeder.first(effort.batch), effort.stages))
    elite = breeder.checked(elite.best(ELITE, apart=APART))
    yield 0.0, elite
    idle = 0
    for generation in range(1, effort.generations):
        children = breeder.evolve(breeder.children(elite, effort.batch), effort.stages)
        merged = breeder.checked(elite.join(children).best(ELITE, apart=APART))
        gain = merged.value[0] / max(elite.value[0], TINY) - 1.0
        elite, idle = merged, idle + 1 if gain < 1e-5 else 0
        yield generation / effort.generations, elite
        if idle >= effort.patience or breeder.cannot_improve(elite.value[0]):
            break


def _tidy(plan: Plans) -> ExactDesign:
    """Drop unused points, take equal ones together; most repeated first."""
    x: list[Array] = []
    counts: list[int] = []
    for point, count in zip(plan.x[0], plan.counts[0], strict=True):
        same = [i for i, known in enumerate(x) if np.allclose(known, point, rtol=0, atol=1e-6)]
        if count and same:
            counts[same[0]] += int(count)
        elif count:
            x.append(point)
            counts.append(int(count))
    order = np.argsort(-np.array(counts), kind="stable")
    return ExactDesign(np.array(x)[order], np.array(counts)[order], float(plan.value[0]))
