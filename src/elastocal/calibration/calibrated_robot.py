"""A calibrated robot: what a calibration leaves behind when its readings are put away.

It predicts what the fit predicts, and carries what is known of every number of it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, BoolArray, freeze
from elastocal.calibration.arm_model import ArmModel, State, calibrated_robot, springs_on
from elastocal.calibration.calibrate import Calibration
from elastocal.calibration.parameters import Parameters
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.errors import InputError
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot


@dataclass(frozen=True)
class StationNoise:
    """What readings of one station scatter by: standard deviation of each coordinate.

    Attributes:
        instrument: What the instrument has [m]; zero if it read no position.
        shared: What the model leaves, alike for all reflectors of a pose [m].
        own: The same of each reflector by itself [m].
        turned: The same of each component of a rotation [rad].
    """

    instrument: float
    shared: float
    own: float
    turned: float

    @property
    def model(self) -> float:
        """What the model leaves of each coordinate of a reflector [m]."""
        return float(np.hypot(self.shared, self.own))


@dataclass(frozen=True)
class Origin:
    """What a calibrated robot was made from.

    Attributes:
        study: Name of the study.
        study_sha256: Hash of its text.
        measurements: Name of the file of readings.
        measurements_sha256: Its hash.
        readings: Hashes of all files that have readings.
    """

    study: str = ""
    study_sha256: str = ""
    measurements: str = ""
    measurements_sha256: str = ""
    readings: tuple[str, ...] = ()


@dataclass(frozen=True)
class CalibratedRobot:
    """A robot with its geometric errors, its compliances, where it stands and what it carries.

    Attributes:
        model: The arm as drawn, and what may be unlike it.
        state: What it is like: bases, reflectors, geometric errors, compliances, payloads.
        parameters: The U unknowns that were found; what was known of them before is not kept.
        covariance: (U, U) of the unknowns, the prior included [SI].
        seen: (U,) unknowns of which the readings said more than was known before; the others
            rest on their prior.
        open: (r, U) combinations that nothing tells, the largest part 1 [rad or m of each].
        told: Number of combinations that the readings tell.
        dof: Degrees of freedom of the noise found.
        stations: Names of the S stations.
        mountings: Names of the M mountings of the tool.
        noise: What readings of each station scatter by.
        poses: Number of poses that were read.
        readings: Number of readings.
        fitted: Root mean square error of positions of the fit [m].
        left_out: The same of poses that were left out in turn [m].
        loss: Name of the loss by which readings counted.
        origin: What it was made from.
        source: Where it comes from, in words.
    """

    model: ArmModel
    state: State
    parameters: Parameters
    covariance: Array
    seen: BoolArray
    open: Array
    told: int
    dof: float
    stations: tuple[str, ...]
    mountings: tuple[str, ...]
    noise: tuple[StationNoise, ...]
    poses: int = 0
    readings: int = 0
    fitted: float = 0.0
    left_out: float = 0.0
    loss: str = "squares"
    origin: Origin = field(default_factory=Origin)
    source: str = ""

    def __post_init__(self) -> None:
        u = len(self.parameters)
        freeze(self, "covariance", open=np.reshape(self.open, (-1, u)))
        freeze(self, "seen", dtype=np.bool_)
        if self.covariance.shape != (u, u) or self.seen.shape != (u,):
            raise InputError(
                f"{u} unknowns need a covariance of {u} x {u}, found {self.covariance.shape}"
            )

    @cached_property
    def robot(self) -> Robot:
        """The robot with its geometric errors."""
        return calibrated_robot(self.model, self.state)

    @property
    def standard_error(self) -> Array:
        """(U,) of the unknowns, given the prior [SI]."""
        return np.sqrt(np.diagonal(self.covariance))

    @cached_property
    def compliances(self) -> ComplianceModel:
        """The springs, where the calibrated robot has them, with compliances and covariance."""
        make, first = self.model.compliances.make, self.parameters.arm + self.parameters.geometry
        own = slice(first, first + self.parameters.compliances)
        return ComplianceModel(
            springs_on(self.robot, self.model.compliances.springs),
            make @ self.state.compliance,
            make @ self.covariance[own, own] @ make.T,
            dof=self.dof,
            source=self.source,
        )

    def station(self, name: str | None = None) -> int:
        """Number of a station; the only one if no name is given.

        Raises:
            InputError: there is none of that name, or one of several must be named.
        """
        return _number(self.stations, name, "station")

    def mounting(self, name: str | None = None) -> int:
        """Number of a mounting of the tool; likewise."""
        return _number(self.mountings, name, "mounting")


def _number(names: tuple[str, ...], name: str | None, what: str) -> int:
    shown = ", ".join(n or "one without a name" for n in names)
    if name is None and len(names) != 1:
        raise InputError(f"there are several {what}s; name one of {shown}")
    if name is not None and name not in names:
        raise InputError(f"no {what} {name!r}; there are {shown}")
    return 0 if name is None else names.index(name)


def put_away(calibration: Calibration, study: str = "", study_sha256: str = "") -> CalibratedRobot:
    """The calibrated robot of a calibration, without its readings.

    Args:
        calibration: The fit.
        study: Name of its study.
        study_sha256: Hash of the text of the study.
    """
    positions, parameters = calibration.positions, calibration.parameters
    points = ~positions.rotations
    found = calibration.noise
    noise = tuple(
        StationNoise(
            _instrument(positions, s),
            float(found.shared[s]),
            float(found.own[s]),
            float(found.turned[s]),
        )
        for s in range(len(positions.stations))
    )
    return CalibratedRobot(
        model=calibration.model,
        state=calibration.state,
        parameters=parameters,
        covariance=calibration.covariance,
        seen=calibration.redundancy.seen,
        open=calibration.redundancy.open,
        told=calibration.redundancy.told,
        dof=calibration.dof,
        stations=positions.stations,
        mountings=positions.mountings,
        noise=noise,
        poses=len(positions.cases),
        readings=len(positions),
        fitted=_rms(calibration.error[points]),
        left_out=_rms(calibration.left_out[points]),
        loss=calibration.loss,
        origin=Origin(study, study_sha256, positions.source, positions.sha256, positions.readings),
        source=positions.source,
    )


def _instrument(positions: Positions, station: int) -> float:
    mine = (positions.station == station) & ~positions.rotations
    if not mine.any():
        return 0.0
    return float(np.sqrt(np.einsum("rii->r", positions.covariance[mine]).mean() / 3.0))


def _rms(errors: Array) -> float:
    """Root mean square length of (R, 3) errors."""
    return float(np.sqrt((errors**2).sum(axis=1).mean())) if len(errors) else 0.0
