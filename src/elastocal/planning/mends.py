"""Mends: what would make a plan promise more, each with its gain and its minutes.

In: a study that knows nuisance, its plan. Out: other ways to measure as often, each judged by the
promise of load cases that are chosen quickly: estimates, and careful plans do better.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from elastocal.arrays import IntArray, unset
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection
from elastocal.elastic.effects import without
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import joint_springs, merged
from elastocal.errors import InfeasibleError
from elastocal.motion.schedule import fastest
from elastocal.planning.more_markers import with_markers
from elastocal.planning.never_seen import ASLANT
from elastocal.planning.promise import promise
from elastocal.planning.quick_choice import chosen
from elastocal.study.left_rigid import left_rigid
from elastocal.study.study import Study
from elastocal.study.two_steps import with_nuisance

MendKind = Literal["configurations", "markers", "second-step", "aslant", "all"]
"""Other configurations in place of repeats; two more markers; further readings with a load from the
side, joints found that were taken as rigid; loads aslant, these joints found; all but the second
step together."""

_POOL = 300  # random load cases
_ASIDE = 4  # readings of a second step
_SIDEWAYS = 0.4  # of the load: a rope over a pulley
_WORTH = 0.05  # gain below which nothing is proposed


@dataclass(frozen=True)
class Mend:
    """One way to promise more.

    Attributes:
        kind: What is done.
        joints: Joints that are found along, taken as rigid before.
        promised: What the quick choice promises [m].
        minutes: How much longer the campaign takes at the cell, less if negative [min].
        markers: How many markers are read.
        readings: How many experiments are done, those of a second step alone.
    """

    kind: MendKind
    joints: tuple[str, ...]
    promised: float
    minutes: float
    markers: int
    readings: int


def mends(study: Study, cases: LoadCases, repeats: IntArray) -> tuple[Mend, ...]:
    """Ways that gain 5 % or more of what a plan promises, the best first.

    What promises less than another way and takes no less time is left out.

    Nothing is proposed where the study knows no nuisance, or counts earlier campaigns.

    Source: ours.
    """
    now = _promised(study, cases, repeats)
    others = (study.known, study.done, study.carried_out, study.earlier)
    own = study.prior[np.ix_(study.wanted, study.wanted)]
    if not np.isfinite(now) or any(others) or own.any():
        return ()
    found = [mend for mend in _all(study, cases, repeats) if mend.promised < (1.0 - _WORTH) * now]
    found.sort(key=lambda mend: (mend.promised, mend.minutes))
    return tuple(
        mend for i, mend in enumerate(found) if all(mend.minutes < m.minutes for m in found[:i])
    )


def _all(study: Study, cases: LoadCases, repeats: IntArray) -> Iterator[Mend]:
    count, before = int(repeats.sum()), _minutes(study, cases, repeats)
    rigid = tuple(
        name for d in left_rigid(study) if d.code == "rigid-at-test-pose" for name in d.about
    )

    def tried(kind: MendKind, other: Study, joints: tuple[str, ...] = (), *, s: int) -> Mend | None:
        share, rest = divmod(count, s)
        times = share + (np.arange(s) < rest)
        try:
            pool = other.space.load_cases(other.space.sample(_POOL, np.random.default_rng(0)))
        except InfeasibleError:
            return None
        picked = chosen(other, pool, times)
        minutes = _minutes(other, picked, times) - before
        markers = len(other.experiments.tool.markers)
        return Mend(kind, joints, _promised(other, picked, times), minutes, markers, count)

    more = with_markers(study)
    slanted = _aslant(_finding(study, rigid))
    made = []
    if len(cases) < count:
        made.append(tried("configurations", study, s=count))
    if more is not None:
        markers = len(more.experiments.tool.markers)
        made.append(Mend("markers", (), _promised(more, cases, repeats), 0.0, markers, count))
    if slanted is not None:
        made.append(tried("aslant", slanted, rigid, s=len(cases)))
        best = with_markers(slanted) or slanted
        made.append(tried("all", best, rigid, s=count))
    if rigid and isinstance(study.experiments.force, FixedVector):
        made.append(_second_step(study, cases, repeats, rigid))
    yield from (mend for mend in made if mend is not None)


def _finding(study: Study, joints: tuple[str, ...]) -> Study:
    """The study that identifies further joints."""
    if not joints or study.nuisance is None:
        return study
    springs = merged(study.springs, joint_springs(study.robot, joints))
    bare = replace(study, springs=springs, nuisance=None, prior=unset())
    return with_nuisance(bare, without(study.robot, study.nuisance, springs))


def _aslant(study: Study) -> Study | None:
    """The study with loads of the same size up to 45° off; None if they have no one direction."""
    force = study.experiments.force
    if not isinstance(force, FixedVector) or not force.size:
        return None
    cone = FreeDirection(force.size, force.value / force.size, ASLANT)
    return replace(study, experiments=replace(study.experiments, force=cone))


def _second_step(
    study: Study, cases: LoadCases, repeats: IntArray, joints: tuple[str, ...]
) -> Mend | None:
    """Some more readings, pulled from the side, with all of both campaigns found together."""
    other, rng = _finding(study, joints), np.random.default_rng(0)
    force = study.experiments.force.size
    try:
        q = study.space.load_cases(study.space.sample(_POOL, rng)).q
    except InfeasibleError:
        return None
    angle = rng.uniform(0.0, 2.0 * np.pi, len(q))
    pull = np.zeros((len(q), 6))
    pull[:, :2] = _SIDEWAYS * force * np.column_stack([np.cos(angle), np.sin(angle)])
    once = np.ones(_ASIDE, dtype=np.int64)
    picked = chosen(other, LoadCases(q, pull), once, beside=(cases, repeats))
    promised = _promised(other, cases.followed_by(picked), np.concatenate([repeats, once]))
    markers, minutes = len(study.experiments.tool.markers), _minutes(study, picked, once)
    return Mend("second-step", joints, promised, minutes, markers, _ASIDE)


def _promised(study: Study, cases: LoadCases, repeats: IntArray) -> float:
    """What load cases promise [m]; infinite if nothing."""
    found = promise(study, cases, repeats)
    return float("inf") if found is None else found.rho0


def _minutes(study: Study, cases: LoadCases, repeats: IntArray) -> float:
    """How long they take at the cell, in their best order [min]."""
    return fastest(cases, repeats, study.pace).total / 60.0
