"""Robustness: what a plan is to be besides good, where something is lost or the model lacks it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from elastocal.errors import InputError


@dataclass(frozen=True)
class Robustness:
    """What a plan is to withstand.

    Attributes:
        loss: How many times the best ρ0, or promise, may be left without any one configuration;
            None: that is not limited.
        blind: Largest blind error [m], of what some load case shows; None: not limited.
        within: How many times the best ρ0, or promise, it may have; for that the blind error is as
            small as can be, and where `loss` is not limited what is left after a loss, too. None:
            ρ0 is as small as can be.
    """

    loss: float | None = None
    blind: float | None = None
    within: float | None = None

    def __post_init__(self) -> None:
        for name, least, what in (
            ("loss", 1.0, "how many times the best ρ0 may be left without any one configuration"),
            ("within", 1.0, "how many times the best ρ0 a robust plan may have"),
            ("blind", 0.0, "the largest blind error"),
        ):
            size = getattr(self, name)
            if size is not None and not least < size < math.inf:
                raise InputError(
                    f"robust, {name} is {what}: it must be above {least:g} and finite, "
                    f"found {size:g}"
                )
        if self.within is not None and self.blind is not None:
            raise InputError(
                "robust: give either blind, which is held for as little ρ0 as can be, or within, "
                "for which the blind error is as small as can be"
            )
        if self.loss is None and not self.sees:
            raise InputError("robust: give loss, blind or within")

    @property
    def sees(self) -> bool:
        """Whether blind errors count."""
        return self.blind is not None or self.within is not None
