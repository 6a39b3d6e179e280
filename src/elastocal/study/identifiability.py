"""Which compliances the allowed experiments can tell apart, before anything is planned.

In: design space and prior. Out: nothing, or an error that names the joints.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.design.space import information
from elastocal.errors import IdentifiabilityError
from elastocal.matrices import confounded, rank_of
from elastocal.study.experiment_space import LoadCaseSpace


def unidentifiable(names: tuple[str, ...], total: Array) -> list[str]:
    """One sentence for each group of compliances that `total`, (p, p), does not tell apart."""
    sentences = []
    for group in confounded(total):
        joints = " and ".join(names[i] for i in group.members)
        what = "a combination of them" if group.seen == 1 else f"{group.seen} combinations of them"
        sentences.append(
            f"{joints}: the experiments see only {what}"
            if group.seen
            else f"{joints}: no allowed experiment deflects a marker through this joint"
        )
    return sentences


def check_identifiable(space: LoadCaseSpace, prior: Array, rng: np.random.Generator) -> None:
    """Refuse a space whose experiments cannot identify every compliance, however many.

    Raises:
        IdentifiabilityError: names the joints and says what would help.
    """
    blocks = information(space.evaluate(space.sample(400, rng)).blocks)
    sentences = unidentifiable(space.arm.springs.names, prior + blocks.sum(axis=0))
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
        if (rank_of(np.array(totals)) == p).any():
            needed = max(size, 1)
            break
    if distinct < needed:
        what = "experiment" if count <= distinct else "configuration"
        raise IdentifiabilityError(
            f"{distinct} {what}{'s' if distinct > 1 else ''} cannot identify the {p} compliances "
            f"{', '.join(space.arm.springs.names)}: at least {needed} are needed"
        )
