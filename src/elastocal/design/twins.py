"""Twins: design points of the same information, taken together.

In: an exact design, its points in the order in which they are to be kept. Out: a design that asks
for nothing twice.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.design.exact import ExactDesign
from elastocal.design.refinement import Goal, Plans, refine
from elastocal.design.space import information
from elastocal.matrices import SINGULAR

ALIKE = 1e-3
"""Twins: their informations differ nowhere by more than this share of the mean over a design.

Measuring one of them in place of the other changes no criterion by more than this share. Points
that a search means to be the same differ by 1e-5 at most, others by more than a tenth.
"""

_LOST = 1e-12  # share of the criterion below which nothing is lost: rounding
_ALLOWED = 1e-9  # share that taking twins together may cost after all


def twins(informations: Array, counts: IntArray, base: Array | float = 0.0) -> list[list[int]]:
    """S points with informations (S, p, p), measured `counts` times, those of the same together.

    Differences are seen relative to the mean information with its share of `base`, (p, p), that is
    there before, direction by direction: so neither the units of the unknowns nor how well they
    are seen matters, and what only rounding sees does not count beside what is known. Singles are
    groups of one; groups and their members in the order of the points.

    Source: ours; if -δM̄ ≤ M_i - M_j ≤ δM̄ with M̄ so, a design that measures j in place of i is worth
    1 ± δ n_i/m times as much by every monotone criterion of degree 1.
    """
    m = counts.sum()
    mean = base / m + np.einsum("s,sij->ij", counts / m, informations)
    diagonal = np.diagonal(mean)
    scale = np.where(diagonal > 0.0, 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0)), 0.0)
    values, vectors = np.linalg.eigh(mean * np.outer(scale, scale))
    seen = values > SINGULAR  # what the mean does not see, no point sees
    white = scale[:, None] * vectors[:, seen] / np.sqrt(values[seen])
    each = (white.T @ informations @ white).reshape(len(informations), -1)
    groups: list[list[int]] = []
    for i in range(len(each)):
        first = [group[0] for group in groups]
        near = np.flatnonzero(np.linalg.norm(each[first] - each[i], axis=1) <= ALIKE)
        if len(near):
            groups[near[0]].append(i)
        else:
            groups.append([i])
    return groups


def merged(goal: Goal, design: ExactDesign, order: IntArray) -> ExactDesign:
    """The design with twins taken together, their repeats added; most repeated first.

    Where a search has left twins a little apart, the point that is kept is refined: the design is
    not worth less than before. Should it be, it stays as it is.

    Args:
        goal: What designs are worth.
        design: S points with repeats.
        order: (S,) its points, those to be kept rather than their twins first.
    """
    x, counts = design.x[order], design.counts[order]
    each = information(goal.space.evaluate(x, counts.astype(float)).blocks)
    groups = twins(each, counts, goal.base)
    if len(groups) == len(x):
        return design
    kept = x[[group[0] for group in groups]]
    repeats = np.array([counts[group].sum() for group in groups])
    plans = Plans(kept[None], repeats[None])
    plans.value = goal.values(plans.x, plans.counts)
    if plans.value[0] < design.value * (1.0 - _LOST):
        smooth = goal.smooth.near(goal.totals(plans.x, plans.counts)[0])
        plans = plans.join(refine(smooth, plans, stages=((300, 1),), tolerance=1e-13))
        plans.value = goal.values(plans.x, plans.counts)
        plans = plans.best(1)
    if plans.value[0] < design.value * (1.0 - _ALLOWED):
        return design
    by_repeats = np.argsort(-plans.counts[0], kind="stable")
    single = ExactDesign(plans.x[0][by_repeats], repeats[by_repeats], float(plans.value[0]))
    return merged(goal, single, np.arange(len(repeats)))  # what was refined may be twins now
