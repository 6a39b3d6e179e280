"""Pool: random load cases that those of a plan may be given for.

In: a space, load cases of it as design points. Out: feasible design points, anywhere or near.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InfeasibleError
from elastocal.study.experiment_space import LoadCaseSpace

_SOME = 0.3  # of the coordinates of a load case are stirred, half of the time


def anywhere(space: LoadCaseSpace, count: int, rng: np.random.Generator) -> Array:
    """(N, d) random feasible design points; none where none are found."""
    try:
        return space.sample(count, rng)
    except InfeasibleError:
        return np.zeros((0, len(space.lower)))


def stirred(
    space: LoadCaseSpace, x: Array, count: int, scale: float, rng: np.random.Generator
) -> Array:
    """(N, d) feasible design points near those of x (S, d); some are moved in a few places.

    Args:
        space: Where they are feasible.
        x: Design points.
        count: How many are tried near each.
        scale: Share of the ranges by which they are moved.
        rng: Source of chance.
    """
    near = np.repeat(x, count, axis=0)
    moved = scale * (space.upper - space.lower) * rng.normal(size=near.shape)
    moved *= (rng.random(near.shape) < _SOME) | (rng.random((len(near), 1)) < 0.5)
    near = np.clip(near + moved, space.lower, space.upper)
    return near[space.feasible(near)]
