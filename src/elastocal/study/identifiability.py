"""Which compliances the allowed experiments can tell apart, before anything is planned.

In: design space and prior. Out: nothing, or an error that names the joints.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.design.space import information
from elastocal.errors import IdentifiabilityError
from elastocal.study.experiment_space import LoadCaseSpace

_BLIND = 1e-18  # information below this share of the largest is rounding of zero
_SAME = 1e-10  # scaled eigenvalue below which a combination is not identified


def unidentifiable(names: tuple[str, ...], total: Array) -> list[str]:
    """One sentence for each compliance or combination that `total`, (p, p), leaves open."""
    diagonal = np.diagonal(total)
    seen = diagonal > _BLIND * max(float(diagonal.max(initial=0.0)), 1e-300)
    sentences = [
        f"{name}: no allowed experiment deflects a marker through this joint"
        for name, ok in zip(names, seen, strict=True)
        if not ok
    ]
    kept = np.flatnonzero(seen)
    if len(kept):
        scale = 1.0 / np.sqrt(diagonal[kept])
        values, vectors = np.linalg.eigh(total[np.ix_(kept, kept)] * np.outer(scale, scale))
        for vector in vectors[:, values < _SAME].T:
            involved = kept[np.abs(vector) > 1e-3 * np.abs(vector).max()]
            joints = " and ".join(names[i] for i in involved)
            sentences.append(f"{joints}: the experiments see only a combination of them")
    return sentences


def check_identifiable(space: LoadCaseSpace, prior: Array, rng: np.random.Generator) -> None:
    """Refuse a space whose experiments cannot identify every compliance, however many.

    Raises:
        IdentifiabilityError: names the joints and says what would help.
    """
    blocks = information(space.evaluate(space.sample(400, rng)).blocks)
    sentences = unidentifiable(space.springs.names, prior + blocks.sum(axis=0))
    if sentences:
        raise IdentifiabilityError(
            "not identifiable from the allowed experiments: "
            + "; ".join(sentences)
            + "; leave such joints out of `identify`, or allow other forces or markers"
        )


def check_count(
    space: LoadCaseSpace, prior: Array, count: int, distinct: int, rng: np.random.Generator
) -> None:
    """Refuse too few experiments, or too few distinct ones, for the unknowns.

    Raises:
        IdentifiabilityError: says how many are needed.
    """
    p = space.parameters
    blocks = information(space.evaluate(space.sample(40 * p, rng)).blocks)
    needed = p
    for size in range(0, p + 1):
        totals = [prior + blocks[rng.integers(0, len(blocks), size)].sum(axis=0) for _ in range(20)]
        if any(not unidentifiable(space.springs.names, total) for total in totals):
            needed = max(size, 1)
            break
    if distinct < needed:
        what = "experiment" if count <= distinct else "configuration"
        raise IdentifiabilityError(
            f"{distinct} {what}{'s' if distinct > 1 else ''} cannot identify the {p} compliances "
            f"{', '.join(space.springs.names)}: at least {needed} are needed"
        )
