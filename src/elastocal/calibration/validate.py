"""A calibrated robot on readings that it was not made from: as it stands, or set up anew."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, BoolArray, freeze
from elastocal.calibration.beginning import begin
from elastocal.calibration.calibrate import Calibration, calibrate
from elastocal.calibration.calibrated_robot import CalibratedRobot, put_away
from elastocal.calibration.parameters import parameters_of
from elastocal.calibration.prediction import predicted
from elastocal.errors import InputError
from elastocal.measuring.positions import Positions, chosen_poses


@dataclass(frozen=True)
class Check:
    """A calibrated robot on other readings.

    Attributes:
        positions: R readings it was not fitted to.
        error: (R, 3) reading minus model [m, rad], frames of the stations.
        covariance: (R, 3, 3) that such an error is expected to have.
        set_up: Names of the poses that base and tool were found from; empty for the old ones.
    """

    positions: Positions
    error: Array
    covariance: Array
    set_up: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "error", "covariance")

    @property
    def points(self) -> BoolArray:
        """(R,) readings that are positions."""
        return ~self.positions.rotations

    @property
    def rms(self) -> float:
        """Root mean square length of the errors of positions [m]."""
        return rms_of(self.error[self.points])

    @property
    def largest(self) -> float:
        """Length of the largest error of a position [m]."""
        return float(np.linalg.norm(self.error[self.points], axis=1).max(initial=0.0))

    @property
    def expected(self) -> float:
        """What that was expected to be [m]."""
        return float(np.sqrt(np.einsum("rii->r", self.covariance[self.points]).mean()))


def rms_of(errors: Array) -> float:
    """Root mean square length of errors (R, 3)."""
    return float(np.sqrt((errors**2).sum(axis=1).mean())) if len(errors) else 0.0


def check(robot: CalibratedRobot, positions: Positions) -> Check:
    """A calibrated robot, where it stands, on other readings.

    Raises:
        InputError: a station or mounting of the readings is not one of the calibration.
    """
    there = _renumbered(robot, positions)
    found = predicted(robot.model, there, robot.parameters, robot.state)
    spread = found.rows @ robot.covariance @ found.rows.transpose(0, 2, 1)
    point, turned = (
        np.array([getattr(noise, of) for noise in robot.noise])[there.station]
        for of in ("model", "turned")
    )
    own = np.where(there.rotations, turned, point) ** 2
    return Check(positions, found.error, spread + there.covariance + own[:, None, None] * np.eye(3))


def check_set_up(robot: CalibratedRobot, positions: Positions, rows: int) -> Check:
    """A calibrated robot on another series, with base and tool from some of its poses.

    Args:
        robot: Its geometry and compliances count as they were found, with their covariance.
        positions: Readings of the other series.
        rows: Number of poses to find base and tool from, spread evenly over the series.

    Raises:
        InputError: there are no more poses than that, or too few.
    """
    count = len(positions.cases)
    if not 0 < rows < count:
        raise InputError(
            f"base and tool are to be found from {rows} poses, and "
            f"{positions.source or 'the readings'} have {count}; expected fewer, so that some are "
            "left to check"
        )
    keep = np.zeros(count, dtype=bool)
    keep[np.round(np.linspace(0, count - 1, rows)).astype(int)] = True
    some = chosen_poses(positions, keep)
    found = check(put_away(set_up(robot, some)), chosen_poses(positions, ~keep))
    return replace(found, set_up=some.names)


def set_up(robot: CalibratedRobot, positions: Positions) -> Calibration:
    """A calibrated robot with other bases and tools, from readings of its own.

    What is known of the arm is prior information, and these readings change it as far as they can.
    """
    model, old, state = robot.model, robot.parameters, robot.state
    fresh = parameters_of(model, positions)
    many = old.inner
    known = np.arange(old.arm, old.arm + many)
    rows = np.array(fresh.rows)
    information = np.linalg.inv(robot.covariance[np.ix_(known, known)])
    root = np.linalg.cholesky((information + information.T) / 2.0).T
    rows[:many, fresh.arm : fresh.arm + many] = root
    mean = np.concatenate([state.geometry, state.compliance, state.compensator])
    start = begin(model, positions)
    start = replace(
        start,
        geometry=state.geometry,
        compliance=state.compliance,
        compensator=state.compensator,
    )
    return calibrate(model, positions, replace(fresh, rows=rows, mean=mean), start=start)


def _renumbered(robot: CalibratedRobot, other: Positions) -> Positions:
    """Readings with the stations, mountings and payloads numbered as those of a calibration."""
    names = {
        "stations": robot.stations,
        "mountings": robot.mountings,
        "payloads": tuple(payload.name for payload in robot.model.payloads),
    }
    numbers = {}
    for what in ("stations", "mountings", "payloads"):
        known, given = names[what], getattr(other, what)
        missing = [name for name in given if name not in known]
        if missing and len(given) == len(known) == 1 and what != "payloads":
            missing, given = [], known  # one of each: a name more or less is no other station
        if missing:
            raise InputError(
                f"{other.source or 'the readings'}: {what[:-1]} {missing[0]!r} is not one of the "
                f"calibration ({', '.join(known) or 'none'}); find base and tool anew from some "
                "of the poses"
            )
        numbers[what] = np.array([known.index(name) for name in given], dtype=np.int64)
    payload = np.append(numbers["payloads"], -1)[other.payload]
    return replace(
        other,
        station=numbers["stations"][other.station],
        stations=robot.stations,
        mounting=numbers["mountings"][other.mounting],
        mountings=robot.mountings,
        payload=payload,
        payloads=names["payloads"],
    )
