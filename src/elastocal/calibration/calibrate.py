"""The arrow from absolute readings to a calibrated robot, with what is known of every number."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.calibration.arm_model import ArmModel, State
from elastocal.calibration.beginning import begin
from elastocal.calibration.fit import Solved, solved
from elastocal.calibration.noise import Noise, found_noise, instrument_alone
from elastocal.calibration.parameters import Parameters, normal_matrix
from elastocal.calibration.prediction import predicted
from elastocal.calibration.redundancy import Redundancy, redundancy_of
from elastocal.fitting.goodness import quantile
from elastocal.fitting.robust import LOSSES, Loss, Squares
from elastocal.measuring.positions import Positions

CONFIDENCE = 0.95
"""Of the intervals of a calibration."""
_ROUNDS = 8
_STILL = 1e-2  # share by which the noise found may change in the last round


@dataclass(frozen=True)
class Calibration:
    """A calibrated robot.

    Attributes:
        model: The arm as drawn, and what may be unlike it.
        positions: R readings it was fitted to.
        parameters: The U unknowns.
        state: Their values.
        noise: What the readings scatter by.
        error: (R, 3) reading minus model [m, rad], frames of the stations.
        left_out: (R, 3) the same of poses left out of the fit in turn, to first order.
        covariance: (U, U) of the unknowns, the prior included.
        redundancy: What the readings tell, and what only the prior holds.
        dof: Degrees of freedom of the noise found.
        loss: Name of the loss by which readings counted.
    """

    model: ArmModel
    positions: Positions
    parameters: Parameters
    state: State
    noise: Noise
    error: Array
    left_out: Array
    covariance: Array
    redundancy: Redundancy
    dof: float
    loss: str = "squares"

    def __post_init__(self) -> None:
        freeze(self, "error", "left_out", "covariance")

    @property
    def standard_error(self) -> Array:
        """(U,) of the unknowns, given the prior."""
        return np.sqrt(np.diagonal(self.covariance))

    @property
    def width(self) -> float:
        """Half of a 95 % interval over the standard error."""
        return quantile(0.5 + 0.5 * CONFIDENCE, self.dof)


def calibrate(
    model: ArmModel,
    positions: Positions,
    parameters: Parameters,
    *,
    loss: Loss | None = None,
    start: State | None = None,
) -> Calibration:
    """Fit everything that is unknown, and the noise, to absolute readings.

    Args:
        model: The arm as drawn, and what may be unlike it.
        positions: The readings.
        parameters: The unknowns, and what was known before.
        loss: How outlying readings count; squares if None.
        start: Where to start; from nothing if None.

    Raises:
        InputError: joints and positions do not belong together, or the fit comes not to rest.

    Source: ours.
    """
    loss = loss or Squares()
    known = {b: all(parameters.held[parameters.of(b)]) for b in ("base", "tool")}
    if start is None:
        start = begin(model, positions, base_known=known["base"], tool_known=known["tool"])
    state = start
    # What the drawing leaves counts as noise first: trusted as the instrument, readings would pull
    # the arm far along what they cannot tell.
    error = predicted(model, positions, parameters, state).error
    noise, fit = found_noise(instrument_alone(positions), error, 0.0), None
    usual = usual_share(loss)
    for _ in range(_ROUNDS):
        fit = solved(model, positions, parameters, state, noise)
        before, state = noise, fit.state
        rows = noise.over(fit.found.rows)
        root = _root(parameters, rows)
        bounded = noise.weight[:, None] * fit.found.error / np.sqrt(usual)
        noise = found_noise(noise, bounded, _told(rows, root), fit.found.rows @ root)
        if loss.tamer is not None:
            size = np.linalg.norm(in_full(noise).over(fit.found.error[..., None])[..., 0], axis=1)
            noise = replace(noise, weight=loss.weight(size))
        if _same(before, noise):
            break
    assert fit is not None
    found = _judged(model, positions, parameters, fit, noise)
    return replace(found, loss=next(name for name, own in LOSSES.items() if own == loss))


def values_of(found: Calibration) -> Array:
    """(U,) values of the unknowns; zero for bases and probes, which are more than numbers."""
    p, state = found.parameters, found.state
    values = np.zeros(len(p))
    for m, k in np.argwhere(p.targets).tolist():
        if k < state.markers.shape[1]:
            values[p.marker(m, k)] = state.markers[m, k]
    first, many = p.arm, p.inner
    inner = (state.geometry, state.compliance, state.compensator)
    values[first : first + many] = np.concatenate(inner)
    for n, i in enumerate(p.hung):
        values[first + many + 4 * n : first + many + 4 * n + 4] = state.payload[i]
    return values


def in_full(noise: Noise) -> Noise:
    """The noise with all readings counting in full."""
    return replace(noise, weight=np.ones(len(noise.weight)))


def _same(one: Noise, other: Noise) -> bool:
    """Whether two noises are alike, and so are the weights."""
    for name in ("shared", "own", "turned", "weight"):
        a, b = getattr(one, name), getattr(other, name)
        if (np.abs(a - b) > _STILL * np.maximum(np.abs(a), np.abs(b))).any():
            return False
    return True


def _judged(
    model: ArmModel, positions: Positions, parameters: Parameters, fit: Solved, noise: Noise
) -> Calibration:
    """The calibration with its covariance, its redundancy, and what leaving poses out does."""
    rows = noise.over(fit.found.rows)
    redundancy = redundancy_of(parameters, rows.reshape(-1, len(parameters)))
    root = _root(parameters, rows)
    covariance = root @ root.T
    poses = len(positions.cases) if (noise.shared > 0.0).any() else len(positions)
    dof = 3.0 * poses - _told(rows, root)
    left = left_out_errors(noise, fit.found.error, fit.found.rows, rows, covariance)
    return Calibration(
        model,
        positions,
        parameters,
        fit.state,
        noise,
        fit.found.error,
        left,
        covariance,
        redundancy,
        max(dof, 1.0),
    )


def usual_share(loss: Loss) -> float:
    """What weights leave of the sum of squares of errors times weights where the noise is normal.

    Source: Huber's proposal 2 (1964); the integral over sizes of residuals in three dimensions.
    """
    size = np.linspace(0.0, 10.0, 2001)
    density = size**2 * np.exp(-(size**2) / 2.0)
    return float(((loss.weight(size) * size) ** 2 * density).sum() / (3.0 * density.sum()))


def _told(rows: Array, root: Array) -> float:
    """How many numbers rows over the noise, (R, 3, U), tell of the unknowns beside what was known.

    Source: textbook; the trace of the matrix that takes readings to fitted values.
    """
    return float(((rows @ root) ** 2).sum())


def _root(parameters: Parameters, rows: Array) -> Array:
    """(U, U) a root of the covariance of the unknowns, by rows over the noise (R, 3, U).

    What is held has none.
    """
    information = normal_matrix(parameters, rows.reshape(-1, len(parameters)))
    scale = 1.0 / np.sqrt(np.diagonal(information))
    lower = np.linalg.cholesky(information * np.outer(scale, scale))
    root = np.linalg.inv(lower).T * scale[:, None]
    root[parameters.held] = 0.0
    return np.asarray(root)


def left_out_errors(
    noise: Noise, error: Array, plain: Array, rows: Array, covariance: Array
) -> Array:
    """(R, 3) errors of the readings of each pose, if the pose is left out of the fit.

    Args:
        noise: Of the readings.
        error: (R, 3) errors of the fit to all.
        plain: (R, 3, U) rows of the readings.
        rows: (R, 3, U) the same over the noise.
        covariance: (U, U) of the unknowns.

    Source: textbook; exact for a linear model.
    """
    p = noise.positions
    white = noise.over(error[..., None])[..., 0]
    change = np.zeros((len(p.cases), rows.shape[2]))
    for poses, r in p.by_size():
        n, k = r.shape
        own = rows[r].reshape(n, 3 * k, -1)
        gain = own @ covariance
        rest = np.eye(3 * k) - gain @ own.transpose(0, 2, 1)
        alone = np.linalg.solve(rest + 1e-12 * np.eye(3 * k), white[r].reshape(n, 3 * k, 1))
        change[poses] = np.einsum("nki,nk->ni", gain, alone[..., 0])
    return np.asarray(error + np.einsum("rci,ri->rc", plain, change[p.case]))
