"""The largest of a quadratic form over the directions of a cone."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array

_AROUND = 48  # directions on the edge that the search for the largest begins with
_NEWTON = 12  # steps of that search


def largest_in_cone(form: Array, axis: Array, half_angle: float) -> tuple[Array, Array]:
    """Largest uᵀ Q u over |u| ≤ 1 within an angle of an axis, of forms (N, 3, 3).

    It is the largest eigenvalue if its eigenvector is in the cone, or against it; else the largest
    on the edge of the cone, a trigonometric polynomial of degree 2 with at most two maxima.

    Args:
        form: (N, 3, 3) symmetric and non-negative definite.
        axis: (3,) unit vector.
        half_angle: Of the cone, below π/2 [rad].

    Returns:
        (N,) values and (N, 3) unit vectors u.
    """
    values, vectors = np.linalg.eigh(form)
    top = vectors[:, :, -1] * np.where(vectors[:, :, -1] @ axis < 0.0, -1.0, 1.0)[:, None]
    frame = np.concatenate([axis[None], np.linalg.svd(axis[None])[2][1:]])
    sine, cosine = np.sin(half_angle), np.cos(half_angle)
    seen = frame @ form @ frame.T
    middle = 0.5 * (seen[:, 1, 1] + seen[:, 2, 2]) * sine**2 + seen[:, 0, 0] * cosine**2
    once = 2.0 * sine * cosine * seen[:, 0, 1:]
    twice = sine**2 * np.stack([0.5 * (seen[:, 1, 1] - seen[:, 2, 2]), seen[:, 1, 2]], axis=1)

    def edge(angle: Array, order: int = 0) -> Array:
        """Derivatives of the form on the edge, at (N, K) angles."""
        first, second = angle + order * np.pi / 2.0, 2.0 * angle + order * np.pi / 2.0
        found = once[:, :1] * np.cos(first) + once[:, 1:] * np.sin(first)
        found += 2.0**order * (twice[:, :1] * np.cos(second) + twice[:, 1:] * np.sin(second))
        return np.asarray(found + middle[:, None] if order == 0 else found)

    turn = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    around = edge(np.broadcast_to(turn, (len(form), _AROUND)))
    summit = np.maximum(np.roll(around, 1, axis=1), np.roll(around, -1, axis=1)) <= around
    best = turn[np.argsort(-np.where(summit, around, -np.inf), axis=1)[:, :2]]
    for _ in range(_NEWTON):
        bend = np.minimum(edge(best, 2), -1e-300)
        best = best + np.clip(-edge(best, 1) / bend, -np.pi / _AROUND, np.pi / _AROUND)
    each = np.arange(len(form))
    found = edge(best)
    higher = found.argmax(axis=1)
    angle, found = best[each, higher], found[each, higher]
    way = sine * np.stack([np.cos(angle), np.sin(angle)], axis=1) @ frame[1:] + cosine * axis
    inside = top @ axis >= cosine
    return np.where(inside, values[:, -1], found), np.where(inside[:, None], top, way)
