"""The oracle: where in the design space is the sensitivity largest?

s(x) = tr(G M_x) = |rows(x) V|² with G = V Vᵀ, climbed from many starts in lockstep.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.design.lockstep import Stages, Step, minimise
from elastocal.design.space import DesignSpace


def climb(
    space: DesignSpace, x: Array, gradient: Array, stages: Stages
) -> tuple[Array, Array, IntArray]:
    """Local maxima of the sensitivity.

    Args:
        space: Where to search.
        x: (N, d) starts.
        gradient: (p, p) gradient G of a criterion.
        stages: (evaluations, how many climbs to go on with) in turn.

    Returns:
        Feasible points (K, d), their sensitivities (K,) and the starts they come from (K,).
    """
    root = square_root(gradient)
    level = max(float(((space.evaluate(x).blocks @ root) ** 2).sum(axis=(1, 2)).max()), 1e-200)

    def problem(points: Array, _: IntArray) -> Step:
        evaluation = space.evaluate(points)
        blocks = evaluation.blocks
        n, r, p = blocks.shape
        image = blocks.reshape(n * r, p) @ root
        value = -(image**2).reshape(n, -1).sum(axis=1) / level
        cotangent = (image @ (root.T * (-2.0 / level))).reshape(n, r, p)
        return Step(value, evaluation.margins, lambda weights: evaluation.pull(cotangent, -weights))

    found = minimise(problem, x, space.lower, space.upper, stages=stages, tolerance=1e-9)
    feasible = restore(space, found.x)
    return feasible, sensitivity(space, feasible, root), found.origin


def sensitivity(space: DesignSpace, x: Array, root: Array) -> Array:
    """(N,) sensitivities |rows V|² of design points, −1 where infeasible; `root` is V."""
    evaluation = space.evaluate(x)
    value = ((evaluation.blocks @ root) ** 2).sum(axis=(1, 2))
    feasible = (evaluation.margins >= -1e-8).all(axis=1)
    return np.where(feasible, value, -1.0)


def square_root(gradient: Array) -> Array:
    """V with V Vᵀ = G, (p, rank)."""
    values, vectors = np.linalg.eigh((gradient + gradient.T) / 2.0)
    keep = values > 1e-14 * max(values[-1], 0.0)
    return vectors[:, keep] * np.sqrt(values[keep])


def restore(space: DesignSpace, x: Array, *, iterations: int = 30) -> Array:
    """Nearby feasible points: Newton steps on the worst margin, within the bounds."""
    x = np.clip(x, space.lower, space.upper)
    todo = np.arange(len(x))
    for _ in range(iterations):
        evaluation = space.evaluate(x[todo])
        if not evaluation.margins.shape[1]:
            return x
        worst = evaluation.margins.argmin(axis=1)
        depth = evaluation.margins[np.arange(len(todo)), worst]
        outside = depth < 0.0
        if not outside.any():
            return x
        chosen = np.zeros_like(evaluation.margins)
        chosen[np.arange(len(todo)), worst] = 1.0
        slope = evaluation.pull(np.zeros_like(evaluation.blocks), chosen)
        moving = x[todo]
        inward = np.where((moving <= space.lower) & (slope < 0.0), 0.0, slope)
        inward = np.where((moving >= space.upper) & (slope > 0.0), 0.0, inward)
        length = np.maximum((inward**2).sum(axis=1), 1e-12)
        step = ((_INSIDE - depth) / length)[:, None] * inward
        x[todo[outside]] = np.clip(moving + step, space.lower, space.upper)[outside]
        todo = todo[outside]
    return x


_INSIDE = 1e-10
