"""What else explains the readings: another convention of the joint values, or what the model lacks.

In: an identification, how the controller counts as assumed. Out: both searches as one value.
"""

from __future__ import annotations

from dataclasses import dataclass

from elastocal.errors import Doubt
from elastocal.identification.candidates import Lacks, what_is_missing
from elastocal.identification.convention_search import OtherConvention, other_convention
from elastocal.identification.result import Identification
from elastocal.robot.controller_axes import Coupling


@dataclass(frozen=True)
class Searched:
    """What else explains the readings of an identification.

    Attributes:
        convention: The convention by which the same springs fit clearly better, if any.
        lacks: What the model lacks; None with wrong joint values, by which nothing can be told.
    """

    convention: OtherConvention | None
    lacks: Lacks | None

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """What was found."""
        if self.convention is not None:
            return (self.convention.doubt,)
        return () if self.lacks is None else self.lacks.doubts


def searched(found: Identification, table: Coupling) -> Searched:
    """Look for what else explains the readings.

    Args:
        found: The identification; its fit without nuisance, which would hide what is looked for.
        table: What the controller shows for the joint values of the model, as assumed.
    """
    found = found.alone or found
    convention = other_convention(found, table)
    return Searched(convention, what_is_missing(found) if convention is None else None)
