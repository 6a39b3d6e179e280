"""What a mixed fit says of its nuisance parameters: found, and known before, side by side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.identification.result import Identification


@dataclass(frozen=True)
class NuisanceFound:
    """One nuisance parameter, or what all experiments share.

    Attributes:
        name: Its name.
        value: Estimate [unit].
        standard_error: Of the estimate [unit].
        mean: What was expected before [unit].
        deviation: Standard uncertainty of that [unit].
        unit: SI unit; empty for what is common to all loads: that is in prior uncertainties.
        held: Whether the bound at zero holds it.
        source: Where its size is from.
    """

    name: str
    value: float
    standard_error: float
    mean: float
    deviation: float
    unit: str
    held: bool
    source: str

    @property
    def relative(self) -> tuple[float, float]:
        """Estimate off what was expected, and its standard error, in prior uncertainties."""
        return (self.value - self.mean) / self.deviation, self.standard_error / self.deviation


def nuisance_found(found: Identification) -> tuple[NuisanceFound, ...]:
    """All of them, in the order of the fit; nothing if there was no nuisance."""
    nuisance = found.nuisance
    if nuisance is None or found.alone is None:
        return ()
    errors = np.sqrt(np.diagonal(found.unknown_covariance))
    before = len(found.alone.fitted)
    units = [kind.compliance for kind in nuisance.unknowns.kinds]
    told = []
    for i in range(before, len(found.fitted)):
        j = i - before
        shared = j >= len(units)
        told.append(
            NuisanceFound(
                name=found.fitted[i],
                value=float(found.unknown[i]),
                standard_error=float(errors[i]),
                mean=0.0 if shared else float(nuisance.mean[j]),
                deviation=1.0 if shared else float(nuisance.deviation[j]),
                unit="" if shared else units[j],
                held=found.fitted[i] in found.held,
                source="loads" if shared else nuisance.source[j],
            )
        )
    return tuple(told)
