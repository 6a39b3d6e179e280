"""To validate: configurations that tell whether a model holds where it was not fitted.

A model that is right where it was measured may be wrong elsewhere, and nothing that the fit has
seen shows it. In: a study, the load cases of a plan. Out: others, as far from those and from each
other as the cell allows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InfeasibleError
from elastocal.motion.margins import motions_free
from elastocal.motion.schedule import Schedule, schedule
from elastocal.motion.tour import best_order
from elastocal.motion.via_points import UnreachableError, detours
from elastocal.planning.assessment import assess
from elastocal.planning.near import distances
from elastocal.planning.plain_values import simplify
from elastocal.study.study import Study

_POOL = 3000  # random load cases to choose from
_TRIES = 10  # configurations to which no way leads are left out, so often


@dataclass(frozen=True)
class ToValidate:
    """Load cases to measure once, and to fit never.

    Attributes:
        load_cases: S load cases, in order of execution.
        apart: (S,) how far each is from the nearest that is fitted, or from another of these: the
            largest difference of a joint, or of the direction of the load [rad].
        via: S + 1 arrays (K, n), see `motion.Vias`.
        nearest: S names of the constraints that are nearest.
        schedule: How long they take.
    """

    load_cases: LoadCases
    apart: Array
    via: tuple[Array, ...]
    nearest: tuple[str, ...]
    schedule: Schedule

    def __post_init__(self) -> None:
        freeze(self, "apart")

    @property
    def repeats(self) -> IntArray:
        """(S,) each is measured once."""
        return np.ones(len(self.load_cases), dtype=np.int64)


def to_validate(study: Study, fitted: LoadCases, count: int, *, seed: int = 0) -> ToValidate:
    """Load cases to validate a model with that is fitted to others.

    Args:
        study: The study.
        fitted: The load cases of its plan.
        count: How many.
        seed: Of random load cases to choose from.

    Raises:
        InfeasibleError: so many cannot be reached; says how many can.

    Source: ours; each is the one of many random ones that is farthest from all before it.
    """
    space = study.space
    drawn = space.load_cases(space.sample(_POOL, np.random.default_rng([seed, 4])))
    pool = simplify(space, drawn).cases
    for _ in range(_TRIES):
        cases, apart = _farthest(study, fitted, pool, count)
        order = best_order(
            cases, study.pace, free=partial(motions_free, study.motion_space)
        ).sequence
        cases, apart = cases.chosen(order), apart[order]
        try:
            via = detours(study.motion_space, cases.q, seed=seed)
        except UnreachableError as error:
            kept = (pool.q != error.q).any(axis=1)
            pool = pool.chosen(kept)
            continue
        ones = np.ones(len(cases), dtype=np.int64)
        nearest = tuple(near.name for near in assess(study, cases, ones).nearest)
        return ToValidate(cases, apart, via, nearest, schedule(cases, ones, study.pace, via))
    raise InfeasibleError(f"no way leads to {count} configurations to validate with")


def _farthest(
    study: Study, fitted: LoadCases, pool: LoadCases, count: int
) -> tuple[LoadCases, Array]:
    """The load cases of a pool that are chosen one by one, and how far each is from the nearest."""
    away = _between(study, pool, fitted).min(axis=1)
    chosen: list[int] = []
    for _ in range(min(count, len(pool))):
        best = int(away.argmax())
        if away[best] <= 0.0:
            break
        chosen.append(best)
        one = pool.chosen(np.array([best]))
        away = np.minimum(away, _between(study, pool, one)[:, 0])
    if len(chosen) < count:
        raise InfeasibleError(
            f"there are {len(chosen)} configurations to validate with that are not those of the "
            f"plan, {count} are wanted"
        )
    cases = pool.chosen(np.array(chosen))
    others = _between(study, cases, cases) + np.diag(np.full(count, np.inf))
    first = _between(study, cases, fitted).min(axis=1)
    return cases, np.minimum(first, others.min(axis=1))


def _between(study: Study, one: LoadCases, other: LoadCases) -> Array:
    return distances(study.robot, one.q, one.wrench, other.q, other.wrench)
