"""Fit: how compliances are to be fitted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

from elastocal.errors import InputError
from elastocal.fitting.robust import LOSSES, Loss
from elastocal.identification.choices import Fitted, LossName, Model, Sigma


@dataclass(frozen=True)
class Fit:
    """How to fit.

    Attributes:
        model: "equilibrium": deflections of the nonlinear equilibrium; "linear": those of the
            regressor at the unloaded configuration, as in the paper.
        sigma: "known": the noise is what instrument or file say; "estimated": only up to a common
            factor, which is found from the residuals.
        loss: "squares", or "huber" or "bisquare", which trust outlying readings less.
        nonnegative: Whether compliances below zero are ruled out.
        confidence: Confidence of the intervals.
        fitted: "mixed": nuisance parameters along with the springs that are sought, if the study
            has any; "joints": these alone.
    """

    model: Model = "equilibrium"
    sigma: Sigma = "known"
    loss: LossName = "squares"
    nonnegative: bool = False
    confidence: float = 0.95
    fitted: Fitted = "mixed"

    def __post_init__(self) -> None:
        kinds = ("model", Model), ("sigma", Sigma), ("loss", LossName), ("fitted", Fitted)
        for name, choices in kinds:
            value, known = getattr(self, name), get_args(choices)
            if value not in known:
                raise InputError(f"{name} {value!r} is not known; expected {' or '.join(known)}")
        if not 0.5 <= self.confidence < 1.0:
            raise InputError(
                f"the confidence must be from 0.5 to below 1, found {self.confidence:g}"
            )

    @property
    def linear(self) -> bool:
        """Whether the model is the linear one."""
        return self.model == "linear"

    @property
    def estimates_sigma(self) -> bool:
        """Whether the noise is found from the residuals."""
        return self.sigma == "estimated"

    @property
    def weigher(self) -> Loss:
        """The loss by which readings count."""
        return LOSSES[self.loss]

    @property
    def robust(self) -> bool:
        """Whether outlying readings count less."""
        return self.weigher.tamer is not None
