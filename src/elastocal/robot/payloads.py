"""Payloads: what hangs on the flange by its weight, with how well that is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.errors import InputError


@dataclass(frozen=True)
class Payload:
    """A mass fixed to the flange.

    Attributes:
        name: What the user calls it.
        mass: Mass [kg].
        center: (3,) its centre in the flange frame [m].
        mass_error: Standard uncertainty of the mass [kg]; zero: known exactly.
        center_error: Standard uncertainty of each coordinate of the centre [m]; zero: known.
    """

    name: str
    mass: float
    center: Array
    mass_error: float = 0.0
    center_error: float = 0.0

    def __post_init__(self) -> None:
        freeze(self, center=np.reshape(self.center, 3))
        for what in ("mass", "mass_error", "center_error"):
            if not 0.0 <= getattr(self, what) < np.inf:
                raise InputError(
                    f"payload {self.name!r}: {what} must be finite and not negative, found "
                    f"{getattr(self, what)}"
                )
        if not np.isfinite(self.center).all():
            raise InputError(f"payload {self.name!r}: its centre must be three finite numbers")
