"""What the other experiments say of one that is left out, and how well they know it.

In: an `Identification`. Out: covariances of left-out residuals. No refit is made.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.identification.linearised import model_rows
from elastocal.identification.result import Identification
from elastocal.measuring.measurements import Measurements, chosen

# Growth of a standard error beyond which nothing is known without an experiment. It is far below
# what `influence` calls infinite: the rows here equal those of the fit to 1e-8 only, so smaller
# rests of information would be wrong.
_LOST = 1e3


def left_out_covariance(found: Identification, keep: BoolArray | None = None) -> Array:
    """Covariance in which left-out residuals are expected: noise and what the others leave open.

    Args:
        found: The identification.
        keep: (N,) experiments that are wanted; all without it.

    Returns:
        (R, 3, 3) of the readings of these experiments [m², rad²]; infinite where nothing is known
        of a compliance without the experiment.

    Source: ours; the fit without group g has the information M - M_g.
    """
    whole = found.measurements
    if found.left_out_covariance.size:
        given = found.left_out_covariance
        return given if keep is None else np.asarray(given[keep[whole.case]])
    data = whole if keep is None else chosen(whole, keep)
    weight = found.weight if keep is None else found.weight[keep[whole.case]]
    moving = [found.model.names.index(name) for name in found.fitted]
    information = found.information
    free = model_rows(found, data)[:, :, moving]
    noise = found.noise_factor**2
    told = np.linalg.solve(data.covariance, free).transpose(0, 2, 1)
    told = weight[:, None, None] / found.variance * told
    left = information - _summed(told @ free, data)
    scale = 1.0 / np.sqrt(np.diagonal(information))
    scaled = left * np.outer(scale, scale)
    lost: BoolArray = np.any(found.influence.error_ratio > _LOST, axis=1)
    lost = lost if keep is None else lost[keep]
    scaled[lost] = np.eye(len(scale))
    without = np.linalg.inv(scaled) * np.outer(scale, scale)
    expected = noise * data.covariance
    expected = expected + free @ without[data.case] @ free.transpose(0, 2, 1)
    expected[lost[data.case]] = np.inf
    return np.asarray(expected)


def _summed(values: Array, data: Measurements) -> Array:
    """(N, a, b) sums over the readings of each experiment of values (R, a, b)."""
    total = np.zeros((len(data.cases), *values.shape[1:]))
    np.add.at(total, data.case, values)
    return total
