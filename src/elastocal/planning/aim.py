"""Aim: what a search for plans is after.

In: a `Study`. Out: where load cases may be, with the rows that count, what plans are worth by
these, and what is known before. With errors of load cases it is the promise, else the criterion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.design.continuous import tolerance_of
from elastocal.design.criterion import Criterion
from elastocal.design.refinement import Goal
from elastocal.design.space import information
from elastocal.design.test_pose import TestPosePrecision
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.with_errors import WithErrors
from elastocal.study.criteria import RHO0, criterion_of, mean_test_pose
from elastocal.study.experiment_space import LoadCaseSpace
from elastocal.study.study import Study

_LOOSE = 1e-3  # promises and absolute plans; what is closer costs half of the time


@dataclass(frozen=True)
class Aim:
    """What plans are worth, and where their load cases may be.

    Attributes:
        space: Load cases of p unknowns, for as many readings of each as plans of the most load
            cases have on average.
        criterion: What is to be large.
        base: (p, p) information there is anyway.
        count: Number of experiments m.
        distinct: Most load cases.
        beyond: Mean square at the test poses that no plan makes smaller [m²].
        told: If it is what a plan promises: what is known of errors of load cases.
    """

    space: LoadCaseSpace
    criterion: Criterion
    base: Array
    count: int
    distinct: int
    beyond: float = 0.0
    told: WithErrors | None = None

    @property
    def promise(self) -> bool:
        """Whether it is what a plan promises, errors of load cases included."""
        return self.told is not None

    def goal(self, space: LoadCaseSpace | None = None, criterion: Criterion | None = None) -> Goal:
        """For the search, in a part of the space, with a floor."""
        readings = self.readings if self.shares else None
        return Goal(space or self.space, criterion or self.criterion, self.base, readings)

    def readings(self, x: Array, counts: IntArray) -> Array:
        """(B, s) readings that share errors, of the points (B, s, d) of plans with these repeats.

        Near ones share errors as repeats do.
        """
        if self.told is None:
            return counts.astype(float)
        return self.told.sharing(self.space.load_cases(x.reshape(-1, x.shape[2])), counts)

    def total(self, cases: LoadCases, repeats: IntArray) -> Array:
        """(p, p) information of load cases, each measured `repeats` times, and what is known."""
        return np.asarray(
            self.before(cases, repeats) + self.informations(cases, repeats).sum(axis=0)
        )

    def before(self, cases: LoadCases, repeats: IntArray) -> Array:
        """(p, p) what is known before load cases, each measured `repeats` times."""
        return self.base if self.told is None else self.told.told_before(cases, repeats)

    def informations(self, cases: LoadCases, repeats: IntArray) -> Array:
        """(S, p, p) what each of them adds to it."""
        if self.told is not None and cases.preloaded:  # points of the space have one load
            return self.told.informations(cases, repeats)
        x = self.space.points(cases)
        blocks = self.space.evaluate(x, self.readings(x[None], repeats[None]).ravel()).blocks
        return np.asarray(repeats.astype(float)[:, None, None] * information(blocks))

    @property
    def tolerance(self) -> float:
        """Relative gap between a bound on φ and the value of its design; half of it is in ρ0."""
        loose = self.promise or self.space.arm.weighs
        return _LOOSE if loose else tolerance_of(self.space.parameters)

    @property
    def shares(self) -> bool:
        """Whether repeats of a load case share an error."""
        return self.space.errors is not None and self.space.errors.sizes.any_shared

    def value(self, loss: float) -> float:
        """φ of a loss; the other way round than `loss`."""
        return float(1.0 / max(loss**2 - self.beyond, 1e-300))

    def loss(self, value: float) -> float:
        """What φ of `value` says in the unit of the criterion: of a promise ρ0 [m]."""
        with np.errstate(divide="ignore"):
            return float(np.sqrt(1.0 / np.float64(value) + self.beyond))


def aim_of(study: Study) -> Aim:
    """What plans of a study are to be good for."""
    if study.criterion == RHO0.name:
        return accuracy(study)
    e = study.experiments
    return Aim(study.space, criterion_of(study), study.prior, e.count, e.distinct)


def accuracy(study: Study) -> Aim:
    """ρ0, or with errors of load cases the promise, whatever a study plans for."""
    count, distinct = study.experiments.count, study.experiments.distinct
    if study.nuisance is None or not study.nuisance.errors.any:
        return Aim(study.space, mean_test_pose(study), study.prior, count, distinct)
    told = WithErrors(study, study.nuisance)
    return Aim(
        space=told.space.measured_together(count / distinct),
        criterion=TestPosePrecision(told.form),
        base=told.base,
        count=count,
        distinct=distinct,
        beyond=float(study.shares @ [told.other_cell(pose) for pose in study.test_poses]),
        told=told,
    )


def is_for_promise(study: Study) -> bool:
    """Whether plans are made for their promise: load cases have errors, and ρ0 is asked for."""
    known = study.nuisance is not None and study.nuisance.errors.any
    return known and study.criterion == RHO0.name
