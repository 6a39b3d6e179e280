"""What a calibration lacks: one thing more that explains what the fit leaves.

In: a calibration. Out: of all geometric errors and springs in joints that it did not seek, the one
that the errors speak for most, if chance hardly does as much, with those that do nearly the same.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.calibration.arm_model import ArmModel, State
from elastocal.calibration.calibrate import Calibration
from elastocal.calibration.parameters import COMPLIANCE, parameters_of
from elastocal.calibration.prediction import predicted
from elastocal.elastic.springs import joint_springs
from elastocal.elastic.unknowns import each_spring, joined
from elastocal.fitting.chances import ratio_above
from elastocal.robot.geometry import geometric_errors

BY_CHANCE = 1e-3
"""Chance that the best of all candidates explains as much, below which it is named; ours."""
_NEW = (
    1e-4  # share of a column that unknowns of the fit do not make, from which on it is a candidate
)
_ALIKE = 0.98  # correlation of what is new in two columns that do nearly the same


@dataclass(frozen=True)
class Lack:
    """One thing more that explains what a fit leaves.

    Attributes:
        name: What it is called in `identify`: a joint, or a geometric error.
        block: Its block, as `Parameters.block` has it.
        value: Its size [rad, m, rad/(N·m) or m/N].
        error: Standard error of it.
        unit: SI unit.
        chance: Probability that the best of all candidates does as much by chance.
        alike: Names of those that do nearly the same.
    """

    name: str
    block: str
    value: float
    error: float
    unit: str
    chance: float
    alike: tuple[str, ...] = ()


def lacking(found: Calibration) -> Lack | None:
    """What the calibration lacks most; None if nothing that is known of explains what it leaves.

    A spring that would give way against its load is none.

    Source: ours; the score test of each candidate, with Bonferroni's bound for the best of them.
    """
    wider, state = _wider(found.model, found.state)
    p = parameters_of(wider, found.positions)
    new = np.array([name not in found.parameters.names for name in p.names])
    if not new.any():
        return None
    rows = found.noise.over(predicted(wider, found.positions, p, state).rows)
    rows = rows.reshape(-1, len(p))
    error = found.noise.over(found.error[..., None]).reshape(-1)
    own = rows[:, [p.names.index(name) for name in found.parameters.names]]
    more = rows[:, new]
    shared = own.T @ more
    inside = more.T @ more - shared.T @ found.covariance @ shared
    size, left = (more**2).sum(axis=0), np.diagonal(inside)
    slope = more.T @ error
    value = slope / np.maximum(left, 1e-300)
    names = [name for name, is_new in zip(p.names, new, strict=True) if is_new]
    soft = np.array([p.block[p.names.index(name)] == COMPLIANCE for name in names])
    fits: BoolArray = (left > _NEW * size) & (size > 0.0) & (~soft | (value > 0.0))
    if not fits.any():
        return None
    squares = np.where(fits, slope * value, 0.0)
    best = int(squares.argmax())
    rest = max(1.0 - float(squares[best]) / float(error @ error), 1e-3)  # of the noise
    several = _apart(inside, fits)
    chance = min(several * ratio_above(float(squares[best]) / rest, 1.0, found.dof), 1.0)
    if chance > BY_CHANCE:
        return None
    close = np.abs(inside[best]) > _ALIKE * np.sqrt(left[best] * np.maximum(left, 0.0))
    others = np.flatnonzero(close & fits & (np.arange(len(names)) != best))
    u = p.names.index(names[best])
    return Lack(
        names[best],
        p.block[u],
        float(value[best]),
        float(np.sqrt(rest / left[best])),
        p.kinds[u].compliance if soft[best] else p.kinds[u].unit,
        chance,
        tuple(names[i] for i in others.tolist()),
    )


def _wider(model: ArmModel, state: State) -> tuple[ArmModel, State]:
    """The model with all geometric errors and a spring in every joint, and the same state of it."""
    robot = model.robot
    errors = geometric_errors(robot)
    geometry = np.zeros(len(errors))
    for name, value in zip(model.errors.names, state.geometry.tolist(), strict=True):
        geometry[errors.names.index(name)] = value
    there = {*model.compliances.names, *model.compliances.springs.names}
    more = joint_springs(robot, [name for name in robot.joint_names if name not in there])
    compliances = joined(model.compliances, each_spring(more))
    soft = np.append(state.compliance, np.zeros(len(more)))
    wider = replace(model, errors=errors, compliances=compliances)
    return wider, replace(state, geometry=geometry, compliance=soft)


def _apart(inside: Array, fits: BoolArray) -> int:
    """How many of the candidates are unlike each other."""
    some = np.flatnonzero(fits)
    scale = 1.0 / np.sqrt(np.diagonal(inside)[some])
    alike = np.abs(inside[np.ix_(some, some)] * np.outer(scale, scale)) > _ALIKE
    return int((~np.tril(alike, -1).any(axis=1)).sum())
