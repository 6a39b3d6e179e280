"""What an earlier mixed fit knows of springs and nuisance parameters that are fitted once more.

In: its model, springs, nuisance parameters. Out: rows over both. What they did to its compliances
they do again: taken apart from them, two campaigns would look like two independent ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.compliance_model import ComplianceModel, refuse_other_springs, unit_rows
from elastocal.elastic.unknowns import Unknowns


@dataclass(frozen=True)
class KnownTogether:
    """What is known of j springs and t nuisance parameters at once, with unit noise.

    Attributes:
        springs: Names of the j springs.
        told: (t,) places of the parameters among all.
        rows: (j + t, j + t) rows over these springs, then these parameters.
        values: (j + t,) their values.
    """

    springs: tuple[str, ...]
    told: IntArray
    rows: Array
    values: Array


def known_together(
    model: ComplianceModel, names: Sequence[str], unknowns: Unknowns
) -> KnownTogether | None:
    """What a model knows of the springs called `names` and of `unknowns`; None if of one kind only.

    Parameters of which it lacks a spring, or knows one exactly, do not count.

    Raises:
        InputError: it has another spring of the same name.
    """
    there = np.array([name in model.uncertain for name in unknowns.springs.names], dtype=bool)
    told = np.flatnonzero(~(unknowns.make[~there] != 0.0).any(axis=0))
    own = tuple(name for name in names if name in model.uncertain)
    if not len(told) or not own:
        return None
    refuse_other_springs(model, unknowns.springs)
    made = np.flatnonzero((unknowns.make[:, told] != 0.0).any(axis=1))
    springs = [*own, *(unknowns.springs.names[i] for i in made)]
    index = [model.names.index(name) for name in springs]
    j = len(own)
    back = np.zeros((j + len(told), len(springs)))
    back[:j, :j] = np.eye(j)
    back[j:, j:] = np.linalg.pinv(unknowns.make[np.ix_(made, told)])
    rows = unit_rows(back @ model.covariance[np.ix_(index, index)] @ back.T)
    return KnownTogether(own, told, rows, rows @ (back @ model.compliance[index]))
