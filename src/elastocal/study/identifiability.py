"""Which compliances the allowed experiments can tell apart, before anything is planned.

In: design space and prior. Out: nothing, or an error that names the joints.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.design.space import information
from elastocal.errors import Code, Doubt, IdentifiabilityError
from elastocal.matrices import confounded, rank_of
from elastocal.study.experiment_space import LoadCaseSpace
from elastocal.wording import worded
from elastocal.wording.identifiability import not_identifiable


def unidentifiable(names: tuple[str, ...], total: Array) -> tuple[Doubt, ...]:
    """The groups of compliances that `total`, (p, p), does not tell apart."""
    return tuple(group.doubt(names) for group in confounded(total))


def check_identifiable(space: LoadCaseSpace, prior: Array, rng: np.random.Generator) -> None:
    """Refuse a space whose experiments cannot identify every compliance, however many.

    Raises:
        IdentifiabilityError: names the joints and says what would help.
    """
    blocks = information(space.evaluate(space.sample(400, rng)).blocks)
    doubts = unidentifiable(space.unknowns.names, prior + blocks.sum(axis=0))
    if doubts:
        raise IdentifiabilityError(not_identifiable(doubts)).with_doubts(*doubts)


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
        if (rank_of(np.array(totals)) == p).any():
            needed = max(size, 1)
            break
    if distinct < needed:
        code: Code = "too-few-experiments" if count <= distinct else "too-few-configurations"
        unknown = np.diagonal(prior) == 0.0
        names = tuple(np.array(space.unknowns.names)[unknown].tolist())
        doubt = Doubt(code, names, (), {"count": distinct, "needed": needed})
        raise IdentifiabilityError(worded(doubt)).with_doubts(doubt)
