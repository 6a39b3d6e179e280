"""What the other experiments say of one that is left out, and how well they know it.

In: an `Identification`. Out: covariances of left-out residuals. No refit is made.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.identification.linearised import model_rows
from elastocal.identification.result import Identification
from elastocal.measuring.measurements import chosen

# Growth of a standard error beyond which nothing is known without an experiment. It is far below
# what `influence` calls infinite: the rows here equal those of the fit to 1e-8 only, so smaller
# rests of information would be wrong.
_LOST = 1e3


def left_out_covariance(
    found: Identification, keep: BoolArray | None = None, *, load_cases: bool = False
) -> Array:
    """Covariance in which left-out residuals are expected: noise and what the others leave open.

    Args:
        found: The identification.
        keep: (N,) experiments that are wanted; all without it.
        load_cases: Whether all repeats of a load case are left out with an experiment; else they
            stay, if they share no error with it.

    Returns:
        (R, 3, 3) of the readings of these experiments [m², rad²]; infinite where nothing is known
        of a compliance without the experiment.

    Source: ours; the fit without group g has the information M - M_g.
    """
    whole = found.measurements
    given = (found.without_load_case if load_cases else found.without_experiment).covariance
    if given.size:
        return given if keep is None else np.asarray(given[keep[whole.case]])
    group, influence = np.arange(len(whole.cases)), found.influence
    if load_cases:
        group, influence = found.configuration, found.configuration_influence
    asked = np.ones(len(group), dtype=bool) if keep is None else keep
    with_them = np.isin(group, group[asked])
    data = whole if with_them.all() else chosen(whole, with_them)
    _, own = np.unique(group[with_them], return_inverse=True)
    weight = found.weight[with_them[whole.case]]
    moving = [found.model.names.index(name) for name in found.fitted]
    information = found.information
    free = model_rows(found, data)[:, :, moving]
    noise = found.noise_factor**2
    told = np.linalg.solve(data.covariance, free).transpose(0, 2, 1)
    told = weight[:, None, None] / found.variance * told
    left = information - _summed(told @ free, own[data.case])
    scale = 1.0 / np.sqrt(np.diagonal(information))
    scaled = left * np.outer(scale, scale)
    lost: BoolArray = np.any(influence.error_ratio > _LOST, axis=1)[np.unique(group[with_them])]
    scaled[lost] = np.eye(len(scale))
    without = np.linalg.inv(scaled) * np.outer(scale, scale)
    expected = noise * data.covariance
    expected = expected + free @ without[own[data.case]] @ free.transpose(0, 2, 1)
    expected[lost[own[data.case]]] = np.inf
    return np.asarray(expected[asked[with_them][data.case]])


def _summed(values: Array, group: IntArray) -> Array:
    """(G, a, b) sums over each group of values (R, a, b)."""
    total = np.zeros((int(group.max()) + 1, *values.shape[1:]))
    np.add.at(total, group, values)
    return total
