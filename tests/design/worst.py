"""The worst of several criteria, member by member: what `WorstPose` does in one go."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.design.criterion import InformationFunction
from elastocal.design.power_mean import PowerMean


class Worst(PowerMean):
    """φ(M) = min_k φ_k(M), again an information function.

    The gradient mixes those of the members with weights of sum 1: every such mixture bounds the
    minimum from above. Source: ours.
    """

    def value(self, information: Array) -> Array:
        return np.min([member.value(information) for member in self.members], axis=0)

    def gradient(self, information: Array) -> Array:
        gradient, powers = self._mixture(information)
        return gradient / powers.sum(axis=0)[:, None, None]

    @property
    def smooth(self) -> InformationFunction:
        if len(self.members) == 1:
            return self.members[0].smooth
        return PowerMean(self.members, self.sharpness)
