"""Observability indices O2 and O4: searched and reported, never certified.

Both compare singular values with each other and are not concave, so no dual bound exists; their
type, a plain `Criterion`, says so. O1, O3 and O5 are matrix means.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.design.criterion import Criterion


class SingularValueRatio(Criterion):
    """σ_min^a / σ_max of the stacked regressor: a = 1 is O2 inverted, a = 2 is O4.

    Source: paper Table 1, with the repairs described in docs/validation.md.
    """

    def __init__(self, power: int) -> None:
        self.power = power

    def value(self, information: Array) -> Array:
        values = np.maximum(np.linalg.eigvalsh(information), 0.0)
        largest = values[:, -1]
        ratio = values[:, 0] ** (self.power / 2.0) / np.sqrt(np.where(largest > 0, largest, 1.0))
        return np.where(largest > 0.0, ratio, 0.0)

    def gradient(self, information: Array) -> Array:
        values, vectors = np.linalg.eigh(information)
        low, high = vectors[:, :, 0], vectors[:, :, -1]
        tiny = np.finfo(float).tiny
        smallest, largest = np.maximum(values[:, 0], tiny), np.maximum(values[:, -1], tiny)
        value = self.value(information)[:, None, None]
        rise = low[:, :, None] * low[:, None, :] * (self.power / 2.0 / smallest)[:, None, None]
        fall = high[:, :, None] * high[:, None, :] * (0.5 / largest)[:, None, None]
        return value * (rise - fall)
