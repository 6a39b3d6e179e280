"""Errors of load cases: what no spring explains, new with every load case or load.

In: an arm with its compliances, load cases. Out: covariances of their deflections, of absolute
size: no noise that is found in readings makes them larger or smaller.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.errors import InputError

Cell = Literal["same", "exact", "other"]
"""What measures the process force: the cell of the campaign, nothing (it is exact), another one."""


LOAD_GAIN = "load gain"
"""Name of the unknown by which all loads are wrong together."""


@dataclass(frozen=True)
class CaseErrors:
    """Standard uncertainties of what is new with a load case, with a load, or common to all loads.

    Attributes:
        friction: Of the rest that friction leaves in each joint, share of its deflection; one for
            all repeats of a load case.
        discrepancy: Of what no model explains, share of the deflection, per axis and marker; one
            for all repeats of a load case.
        discrepancy_length: The same that does not grow with the deflection [m].
        gain: Of the size of each load, as a share.
        tilt: Of the direction of each load, about each axis across it [rad].
        repeatability: Of where the robot comes back to, per axis [m]; zero if it does not move
            between the unloaded and the loaded reading.
        common_gain: Of the size of all loads together, as a share.
        common_tilt: Of the direction of all loads together, about each axis [rad].
        process_force: What measures the process force: with the same cell a common gain cancels.
    """

    friction: float = 0.0
    discrepancy: float = 0.0
    discrepancy_length: float = 0.0
    gain: float = 0.0
    tilt: float = 0.0
    repeatability: float = 0.0
    common_gain: float = 0.0
    common_tilt: float = 0.0
    process_force: Cell = "same"

    def __post_init__(self) -> None:
        for name, size in vars(self).items():
            if not isinstance(size, str) and not 0.0 <= size < np.inf:
                raise InputError(f"{name} must be zero or more and finite, found {size}")

    @property
    def scaled(self) -> bool:
        """Whether some are shares of deflections, or deflections of turned loads."""
        given = replace(self, discrepancy_length=0.0, repeatability=0.0)
        return given.any

    @property
    def any(self) -> bool:
        """Whether there are any."""
        return self.any_shared or self.any_own or self.any_common

    @property
    def any_shared(self) -> bool:
        """Whether repeats of a load case share an error."""
        return max(self.friction, self.discrepancy, self.discrepancy_length) > 0.0

    @property
    def any_own(self) -> bool:
        """Whether each experiment has an error of its own besides the instrument's."""
        return max(self.gain, self.tilt, self.repeatability) > 0.0

    @property
    def any_common(self) -> bool:
        """Whether all experiments share an error."""
        return max(self.common_gain, self.common_tilt) > 0.0


def shared_covariance(
    errors: CaseErrors, arm: ElasticArm, compliance: Array, cases: LoadCases
) -> Array:
    """Covariance of what all repeats of a load case share: friction and discrepancy.

    Args:
        errors: Their sizes.
        arm: Elastic arm with c springs and K markers; friction is in its joints.
        compliance: (c,) compliances [rad/(N·m) or m/N].
        cases: N load cases.

    Returns:
        (N, m, m) of the deflections, rotations included if the tool asks for them [m², rad²].

    Source: ours.
    """
    each = regressor(arm, cases) * compliance
    total = each.sum(axis=2)
    rubbed = errors.friction * each[:, :, arm.springs.joint >= 0]
    covariance = rubbed @ rubbed.transpose(0, 2, 1)
    for rows, length in _kinds(arm, total.shape[1]):
        square = np.mean(total[:, rows] ** 2, axis=1) * 3.0  # |d|², mean of the markers
        size = errors.discrepancy**2 * square + length * errors.discrepancy_length**2
        covariance[:, rows, rows] += size[:, None, None] * np.eye(rows.stop - rows.start)
    return np.asarray(covariance)


def own_covariance(
    errors: CaseErrors, arm: ElasticArm, compliance: Array, cases: LoadCases
) -> Array:
    """(N, m, m) covariance of what each experiment has of its own: load and way back [m², rad²].

    Args as those of `shared_covariance`.

    Source: ours; u_φ² G (|F|² I - F Fᵀ) Gᵀ with G the deflection for a unit force.
    """
    total = regressor(arm, cases) @ compliance
    covariance = np.zeros((*total.shape, total.shape[1]))
    for wrench in (cases.second, cases.first) if cases.preloaded else (cases.wrench,):
        load = LoadCases(cases.q, wrench)  # each of the loads errs by itself
        moved = [errors.gain * (regressor(arm, load) @ compliance)]
        if errors.tilt > 0.0:
            moved += [errors.tilt * turned for turned in _turned(arm, compliance, load)]
        for one in moved:
            covariance += one[:, :, None] * one[:, None, :]
    if errors.repeatability > 0.0:
        back = np.zeros((total.shape[1], 3))
        for rows, length in _kinds(arm, total.shape[1]):
            if length:
                back[rows] = np.tile(np.eye(3), ((rows.stop - rows.start) // 3, 1))
        covariance += errors.repeatability**2 * back @ back.T
    return np.asarray(covariance)


def common_columns(
    errors: CaseErrors, arm: ElasticArm, compliance: Array, cases: LoadCases
) -> tuple[tuple[str, ...], Array]:
    """What all experiments share: names, and (N, m, e) deflections for one standard uncertainty.

    Args as those of `shared_covariance`.

    Source: ours; a common gain g moves the readings by g A k.
    """
    names: list[str] = []
    columns: list[Array] = []
    if errors.common_gain > 0.0:
        names.append(LOAD_GAIN)
        columns.append(errors.common_gain * (regressor(arm, cases) @ compliance))
    if errors.common_tilt > 0.0:
        for axis, turned in zip("xyz", _turned(arm, compliance, cases), strict=True):
            names.append(f"load tilt {axis}")
            columns.append(errors.common_tilt * turned)
    if not columns:
        return (), np.zeros((len(cases), 3 * len(arm.tool.targets), 0))
    return tuple(names), np.stack(columns, axis=2)


def _turned(arm: ElasticArm, compliance: Array, cases: LoadCases) -> list[Array]:
    """(N, m) deflections by the loads that are added when all turn by one about x, y and z."""
    found = []
    for axis in np.eye(3):
        force, moment = cases.wrench[:, :3], cases.wrench[:, 3:]
        wrench = np.hstack([np.cross(axis, force), np.cross(axis, moment)])
        found.append(regressor(arm, replace(cases, wrench=wrench)) @ compliance)
    return found


def _kinds(arm: ElasticArm, rows: int) -> list[tuple[slice, float]]:
    """Rows of the positions, and of the rotation if there is one; 1 for what is a length."""
    positions = 3 * len(arm.tool.markers)
    kinds = [(slice(0, positions), 1.0)]
    return kinds if rows == positions else [*kinds, (slice(positions, rows), 0.0)]
