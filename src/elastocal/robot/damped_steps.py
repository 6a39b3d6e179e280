"""Damped least squares: joint steps that move the tool as wanted, also near singularities.

Metres and radians are made comparable by a length that belongs to the arm in its configuration:
the root mean square lever arm of its turning joints.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, BoolArray

NEARLY_SINGULAR = 1e-3
"""Singular value over the largest one below which steps are damped."""


class Steps(NamedTuple):
    """Joint steps of N configurations."""

    step: Array
    """(N, n) step [rad or m], the shortest one if there are many."""
    damped: BoolArray
    """(N,) whether the step was damped: it then does not reach all that is wanted."""
    lost: Array
    """(N, 6) unit twist (velocity, turn) that the joints can hardly give to the tool."""


def damped_steps(jacobian: Array, wanted: Array, slides: BoolArray) -> Steps:
    """Steps with jacobian @ step = wanted, as far as possible.

    With jacobian = U diag(s) Vᵀ, the step is V diag(s / max(s, t)²) Uᵀ wanted, t a thousandth of
    the largest s: exact where s >= t, and fading to nothing where the arm is singular.

    Args:
        jacobian: (N, r, n): three rows of velocity and, if r is 6, three of turning.
        wanted: (N, r) displacement of the tool [m, rad].
        slides: (n,) which joints slide.

    Source: damped least squares with numerical filtering, A. Maciejewski & C. Klein (1988); the
    form of the damping is ours.
    """
    length = _lever_arm(jacobian, slides)
    rows = np.ones((len(jacobian), jacobian.shape[1]))
    rows[:, 3:] = length[:, None]
    columns = np.where(slides, length[:, None], 1.0)
    u, s, vt = np.linalg.svd(rows[:, :, None] * jacobian * columns[:, None, :], full_matrices=False)
    threshold = np.maximum(NEARLY_SINGULAR * s[:, :1], 1e-300)
    inverse = s / np.maximum(s, threshold) ** 2
    along = np.einsum("nri,nr->ni", u, rows * wanted)
    step = columns * np.einsum("nij,ni->nj", vt, inverse * along)
    lost = np.zeros((len(jacobian), 6))
    lost[:, : jacobian.shape[1]] = u[:, :, -1]
    return Steps(step, s[:, -1] < threshold[:, 0], lost)


def _lever_arm(jacobian: Array, slides: BoolArray) -> Array:
    """(N,) root mean square distance of the tool from the axes of the turning joints [m]."""
    if slides.all():
        return np.ones(len(jacobian))
    arms = np.linalg.norm(jacobian[:, :3, ~slides], axis=1)
    return np.maximum(np.sqrt(np.mean(arms**2, axis=1)), 1e-6)
