"""Sensitivity: how worthwhile it is to measure in a configuration, next to the best place.

In: the continuous design of a certificate. Out: tr(G M_x) of any load case over its largest value.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.design.criterion import InformationFunction
from elastocal.elastic.load_cases import LoadCases
from elastocal.matrices import rank_of
from elastocal.planning.aim import aim_of
from elastocal.study.study import Study


@dataclass(frozen=True)
class Sensitivity:
    """The sensitivity function at a continuous design.

    Attributes:
        gradient: (p, p) G, gradient of the criterion at the design.
        largest: Largest value of tr(G M_x) that is known.
    """

    gradient: Array
    largest: float


def sensitivity(
    study: Study, support: LoadCases, weights: Array, peak: LoadCases
) -> Sensitivity | None:
    """The sensitivity function at a continuous design; None where it has no gradient.

    Args:
        study: The study; its criterion must be the one of the design.
        support: S load cases of the design.
        weights: (S,) their weights, which sum to 1.
        peak: Load cases where the sensitivity is as large as anywhere.
    """
    aim = aim_of(study)
    criterion = aim.criterion
    if not isinstance(criterion, InformationFunction):
        return None
    each = aim.space.information(support)
    total = aim.base / aim.count + np.einsum("i,ijk->jk", weights, each)
    if rank_of(total) < len(total):
        return None
    gradient = criterion.gradient(total[None])[0]
    known = np.concatenate([each, aim.space.information(peak)])
    largest = float(np.einsum("ijk,jk->i", known, gradient).max())
    if not (np.isfinite(gradient).all() and largest > 0.0):
        return None
    return Sensitivity(frozen(gradient), largest)


def worth(study: Study, known: Sensitivity, cases: LoadCases) -> Array:
    """(N,) tr(G M_x) of load cases over its largest value: 1 where measuring is worth most.

    Source: equivalence theorem, docs/math.md; an experiment x raises the criterion at the rate
    tr(G M_x).
    """
    each = aim_of(study).space.information(cases)
    values = np.einsum("ijk,jk->i", each, known.gradient)
    return np.asarray(values / known.largest)
