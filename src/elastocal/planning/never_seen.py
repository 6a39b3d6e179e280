"""Never seen: effects that no plan of a study can show, for want of another load.

In: a study. Out: what many random load cases together do not show, and what they would not show
either if their loads were aslant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InfeasibleError
from elastocal.planning.blind import BlindEffect, BlindErrors, blind_errors
from elastocal.planning.more_markers import with_markers
from elastocal.robot.rotations import frame_about
from elastocal.study.study import Study

_CASES = 60  # random load cases
_SMALL = 0.01  # of the worst, and of σ: less is not said
ASLANT = float(np.radians(45.0))
"""By how much loads are turned to see what another direction would show [rad]."""


@dataclass(frozen=True)
class NeverSeen:
    """What no plan can show.

    Attributes:
        effects: What many random load cases do not show, the worst first.
        aslant: Those of them that the same configurations do not show either with loads of the same
            size, turned by 45° each to another side.
        markers: Those of these that two more markers do not show either.
    """

    effects: tuple[BlindEffect, ...] = ()
    aslant: tuple[BlindEffect, ...] = ()
    markers: tuple[BlindEffect, ...] = ()


def never_seen(study: Study, rng: np.random.Generator) -> NeverSeen:
    """What no plan of a study can show; nothing where no load case is feasible."""
    try:
        cases = study.space.load_cases(study.space.sample(_CASES, rng))
    except InfeasibleError:
        return NeverSeen()
    repeats = np.ones(len(cases), dtype=np.int64)
    found = blind_errors(study, cases, repeats)
    if found is None or not found.invisible:
        return NeverSeen()
    least = _SMALL * max(found.invisible[0].error, study.sigma)
    unseen = tuple(e for e in found.invisible if e.error > least)
    aslant = LoadCases(cases.q, turned(cases.wrench, rng))
    left = _still(unseen, blind_errors(study, aslant, repeats))
    more = with_markers(study)
    if not left or more is None:
        return NeverSeen(unseen, left, left)
    return NeverSeen(unseen, left, _still(left, blind_errors(more, aslant, repeats)))


def _still(effects: tuple[BlindEffect, ...], other: BlindErrors | None) -> tuple[BlindEffect, ...]:
    """Those of the effects that others do not show either."""
    left = set() if other is None else {(e.kind, e.carriers) for e in other.invisible}
    return tuple(e for e in effects if (e.kind, e.carriers) in left)


def turned(wrench: Array, rng: np.random.Generator) -> Array:
    """(N, 6) wrenches whose force is turned by `ASLANT`, each to another side by chance."""
    made = wrench.copy()
    for i, angle in enumerate(rng.uniform(0.0, 2.0 * np.pi, len(wrench)).tolist()):
        size = float(np.linalg.norm(wrench[i, :3]))
        if size > 0.0:
            side = np.array([np.cos(angle), np.sin(angle), 0.0]) * np.sin(ASLANT)
            side[2] = np.cos(ASLANT)
            made[i, :3] = size * frame_about(wrench[i, :3] / size) @ side
    return made
