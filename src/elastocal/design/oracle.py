"""The oracle: where in the design space is the sensitivity largest?

s(x) = tr(G M_x) = |rows(x) V|² with G = V Vᵀ, climbed from many starts in lockstep.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.design.lockstep import Stages, Trial, minimise
from elastocal.design.space import DesignEvaluation, DesignSpace
from elastocal.matrices import square_root
from elastocal.stopping import stop_if_asked


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
    found = minimise(
        _Descent(space, root, level),
        x,
        space.lower,
        space.upper,
        stages=stages,
        tolerance=1e-9,
        parts=space.parts,
        mover=None if space.core is None else space.core.climbing(root, level),
    )
    feasible = restore(space, found.x)
    return feasible, sensitivity(space, feasible, root), found.origin


@dataclass(frozen=True)
class _Descent:
    """Minus the sensitivity, in units of `level`."""

    space: DesignSpace
    root: Array
    level: float

    def __call__(self, x: Array, _: IntArray) -> Trial:
        evaluation = self.space.evaluate(x)
        blocks = evaluation.blocks
        n, r, p = blocks.shape
        image = blocks.reshape(n * r, p) @ self.root
        value = -(image**2).reshape(n, -1).sum(axis=1) / self.level
        cotangent = (image @ (self.root.T * (-2.0 / self.level))).reshape(n, r, p)
        return Trial(
            value, evaluation.margins, lambda weights: evaluation.pull(cotangent, -weights)
        )


def sensitivity(space: DesignSpace, x: Array, root: Array) -> Array:
    """(N,) sensitivities |rows V|² of design points, −1 where infeasible; `root` is V."""
    evaluation = space.evaluate(x)
    value = ((evaluation.blocks @ root) ** 2).sum(axis=(1, 2))
    feasible = (evaluation.margins >= -1e-8).all(axis=1)
    return np.where(feasible, value, -1.0)


def restore(space: DesignSpace, x: Array, *, iterations: int = 30) -> Array:
    """Nearby feasible points: Gauss-Newton steps on all broken margins together, in the bounds.

    A point for which that fails is returned as far as it came.
    """
    stop_if_asked()
    restored = None if space.core is None else space.core.restored(x, iterations)
    if restored is not None:
        return restored
    x = np.clip(x, space.lower, space.upper)
    todo = np.arange(len(x))
    for _ in range(iterations):
        stop_if_asked()
        evaluation = space.evaluate(x[todo])
        outside = (evaluation.margins < 0.0).any(axis=1)
        if not outside.any():
            return x
        step = _correction(space, x[todo], evaluation)
        x[todo[outside]] = np.clip(x[todo] + step, space.lower, space.upper)[outside]
        todo = todo[outside]
    return x


def _correction(space: DesignSpace, x: Array, evaluation: DesignEvaluation) -> Array:
    """(N, d) shortest step that mends all broken margins to first order, bounds respected."""
    margins = evaluation.margins
    none = np.zeros_like(evaluation.blocks)
    jacobian = np.zeros((*margins.shape, x.shape[1]))
    for c in np.flatnonzero((margins < _NEARLY).any(axis=0)).tolist():
        chosen = np.zeros_like(margins)
        chosen[:, c] = margins[:, c] < _NEARLY
        jacobian[:, c] = evaluation.pull(none, chosen)
    # Of the variables at a bound, those that the worst margin pushes outward stay there.
    worst = jacobian[np.arange(len(x)), margins.argmin(axis=1)]
    pinned = ((x <= space.lower) & (worst < 0.0)) | ((x >= space.upper) & (worst > 0.0))
    jacobian = np.where(pinned[:, None, :], 0.0, jacobian)
    wanted = np.where(margins < _NEARLY, np.maximum(_INSIDE - margins, 0.0), 0.0)
    square = jacobian @ jacobian.transpose(0, 2, 1)
    size = np.trace(square, axis1=1, axis2=2)[:, None, None]
    square = square + (1e-9 * size + 1e-12) * np.eye(margins.shape[1])
    multipliers = np.linalg.solve(square, wanted[:, :, None])
    return (jacobian.transpose(0, 2, 1) @ multipliers)[:, :, 0]


_INSIDE = 1e-10
_NEARLY = 1e-9  # margins below this are held while others are mended
