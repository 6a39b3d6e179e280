"""The fit to absolute readings: damped steps, weak priors on what readings cannot tell apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.calibration.arm_model import ArmModel, State, stepped
from elastocal.calibration.noise import Noise
from elastocal.calibration.parameters import Parameters, from_prior, normal_matrix, step_of
from elastocal.calibration.prediction import Predicted, predicted
from elastocal.errors import InputError
from elastocal.measuring.positions import Positions

_MOST_STEPS = 60
_AT_REST = 1e-9  # share of the sum of squares that a last step may promise to win


@dataclass(frozen=True)
class Solved:
    """A state at which the fit came to rest, with its errors and rows, in units of the readings."""

    state: State
    found: Predicted
    steps: int


def solved(
    model: ArmModel,
    positions: Positions,
    parameters: Parameters,
    start: State,
    noise: Noise,
) -> Solved:
    """Fit everything by damped least squares.

    Args:
        model: Arm with its geometric errors and compliances.
        positions: R readings.
        parameters: The unknowns, and what was known before.
        start: Where the fit starts.
        noise: Of the readings.

    Raises:
        InputError: the fit does not come to rest.

    Source: Levenberg (1944), Marquardt (1963); undamped steps drift along what is redundant.
    """
    state, damping = start, 1e-6
    found = predicted(model, positions, parameters, state)
    size = _size(model, parameters, state, found, noise)
    for step in range(1, _MOST_STEPS + 1):
        rows = noise.over(found.rows).reshape(-1, len(parameters))
        errors = noise.over(found.error[..., None]).reshape(-1)
        normal = normal_matrix(parameters, rows)
        gradient = rows.T @ errors - parameters.rows.T @ from_prior(parameters, model, state)
        gradient[parameters.held] = 0.0  # these do not move
        scale = np.sqrt(np.diagonal(normal))
        normal = normal / np.outer(scale, scale)
        while True:
            values = np.linalg.solve(normal + damping * np.eye(len(normal)), gradient / scale)
            if gradient / scale @ values <= _AT_REST * size:  # less than rounding takes or gives
                return Solved(state, found, step)
            tried = stepped(state, step_of(parameters, state, values / scale))
            there = predicted(model, positions, parameters, tried)
            now = _size(model, parameters, tried, there, noise)
            if now <= size * (1.0 + 1e-12):
                break
            damping *= 10.0
            if damping > 1e8:
                raise InputError("the fit to the positions does not come to rest")
        state, found, size = tried, there, now
        damping = max(damping / 10.0, 1e-12)
    raise InputError("the fit to the positions does not come to rest")


def _size(
    model: ArmModel, parameters: Parameters, state: State, found: Predicted, noise: Noise
) -> float:
    """What is minimised: squares of errors, and of distances from what was known, over noise."""
    errors = noise.over(found.error[..., None])
    return float((errors**2).sum() + (from_prior(parameters, model, state) ** 2).sum())
