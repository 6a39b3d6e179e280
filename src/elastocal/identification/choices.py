"""The choices of a fit, declared once: for values, files and the command line."""

from __future__ import annotations

from typing import Literal

Model = Literal["equilibrium", "linear"]
"""Deflections of the nonlinear equilibrium, or those of the regressor, as in the paper."""

Sigma = Literal["known", "estimated"]
"""Whether the noise is what is promised, or is found from the residuals."""

LossName = Literal["squares", "huber", "bisquare"]
"""How outlying readings count; the last two trust them less."""

Fitted = Literal["mixed", "joints"]
"""Whether the nuisance parameters of a study are fitted along, or the springs it asks for alone."""
