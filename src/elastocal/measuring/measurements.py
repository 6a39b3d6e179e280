"""Measurements: the deflections of a campaign, as one frozen value.

A reading is one marker in one experiment, or the rotation of the flange in it: three numbers with
their covariance. All readings of an experiment share its load case.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, freeze, frozen, unset
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt, InputError
from elastocal.measuring.placement import Placement
from elastocal.robot.chain import Tool

JOINT_SCATTER = np.radians(0.02)  # rad, or 0.02/57 m
"""What a controller may show differently while the robot stands."""
FORCE_SCATTER = 0.01
"""What a force sensor may under one load, relative to it."""


@dataclass(frozen=True)
class Quantity:
    """Readings of one kind, whose errors may be compared and summed.

    Attributes:
        name: What is read: "position" or "rotation".
        unit: Its SI unit, "m" or "rad".
        readings: (R,) which readings are of this kind.
    """

    name: str
    unit: str
    readings: BoolArray


@dataclass(frozen=True)
class Measurements:
    """R readings of N experiments.

    Attributes:
        tool: Tool whose markers were measured, and at whose load point the wrench acts.
        cases: The N load cases: configurations as commanded, wrenches at the load point.
        names: N names of the experiments, as the file has them.
        case: (R,) experiment of each reading.
        marker: (R,) target of each reading, as a position in `tool.targets`: a marker, or behind
            the markers the rotation.
        deflection: (R, 3) loaded minus unloaded position [m], or the rotation from unloaded to
            loaded as axis times angle [rad]; base frame.
        covariance: (R, 3, 3) covariance of each of them [m², rad²].
        own_uncertainty: Whether the covariance came with the readings (True) or from the
            instrument of the study (False).
        source: File they were read from, or how they were made.
        sha256: Hash of that file, empty if there is none.
        readings: Hashes of the files that have the readings, those with joints or loads alone
            left out; what is in one of them is known by what was fitted to it.
        remarks: Sentences of the reader on what it made of the file.
        doubts: What looks odd in them.
        placement: How unloaded markers fit to the arm; None if their positions are not known.
        common: (R, 3, e) what a unit of each of e errors moves that the readings of one experiment
            share, in `covariance` already [m, rad]; none if not given.
        unloaded_of: (R,) number of the unloaded reading that was taken off each; none if each has
            one of its own: see `unloaded`.
    """

    tool: Tool
    cases: LoadCases
    names: tuple[str, ...]
    case: IntArray
    marker: IntArray
    deflection: Array
    covariance: Array
    own_uncertainty: bool = False
    source: str = ""
    sha256: str = ""
    readings: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    doubts: tuple[Doubt, ...] = ()
    unloaded_of: IntArray = field(default_factory=lambda: frozen([], np.int64))
    common: Array = field(default_factory=unset)
    placement: Placement | None = None

    def __post_init__(self) -> None:
        freeze(self, "case", "marker", dtype=np.int64)
        freeze(self, "unloaded_of", dtype=np.int64)
        if len(self.unloaded_of) not in (0, len(self.case)):
            raise InputError(
                f"measurements of {len(self.case)} readings need as many numbers of unloaded "
                f"readings, or none; found {len(self.unloaded_of)}"
            )
        freeze(self, "deflection", "covariance", "common")
        if self.common.size and self.common.shape[:2] != (len(self.case), 3):
            raise InputError(
                f"measurements of {len(self.case)} readings need as many common errors, or none; "
                f"found {self.common.shape}"
            )
        case, marker = self.case, self.marker
        deflection, covariance = self.deflection, self.covariance
        count = len(case)
        if (
            marker.shape != (count,)
            or deflection.shape != (count, 3)
            or covariance.shape != (count, 3, 3)
            or len(self.names) != len(self.cases)
        ):
            raise InputError(
                "measurements need case (R,), marker (R,), deflection (R, 3), covariance "
                f"(R, 3, 3) and a name for every load case; found {case.shape}, {marker.shape}, "
                f"{deflection.shape}, {covariance.shape} and {len(self.names)} names for "
                f"{len(self.cases)} load cases"
            )
        if count and not (
            case.min() >= 0
            and case.max() < len(self.cases)
            and marker.min() >= 0
            and marker.max() < len(self.tool.targets)
        ):
            raise InputError("a reading refers to an experiment or marker that does not exist")
        if not (np.isfinite(deflection).all() and np.isfinite(covariance).all()):
            raise InputError("deflections and covariances must be finite numbers")

    def __len__(self) -> int:
        return len(self.case)

    @property
    def unloaded(self) -> IntArray:
        """(R,) number of the unloaded reading behind each; deflections with one share its noise."""
        return self.unloaded_of if len(self.unloaded_of) else np.arange(len(self.case))

    @property
    def rotations(self) -> BoolArray:
        """(R,) which readings are rotations."""
        return np.asarray(self.marker == len(self.tool.markers))

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What was read, positions before rotations; only what there is."""
        turned = self.rotations
        kinds = Quantity("position", "m", ~turned), Quantity("rotation", "rad", turned)
        return tuple(kind for kind in kinds if kind.readings.any())

    @cached_property
    def length(self) -> Array:
        """(R,) lengths of the deflections [m], sizes of the rotations [rad]."""
        return np.sqrt(np.einsum("rc,rc->r", self.deflection, self.deflection))

    @property
    def deviation(self) -> Array:
        """(R, 3) standard deviations of the coordinates [m, rad]."""
        return np.sqrt(np.einsum("rii->ri", self.covariance))

    def noise_of(self, kind: Quantity) -> float:
        """Typical standard deviation of a coordinate of this kind [its unit]."""
        own = self.covariance[kind.readings]
        return float(np.sqrt(np.einsum("rii->", own) / (3.0 * len(own))))

    def by_experiment(self, error: Array, kind: Quantity | None = None) -> Array:
        """(N,) root mean square length of errors (R, 3) of the readings of each experiment.

        Of one kind, or of all if the errors have one unit, as those over the noise have.
        """
        if kind is None:
            return rms_of_groups(error, self.case, len(self.cases))
        return rms_of_groups(error[kind.readings], self.case[kind.readings], len(self.cases))


def rms_of_groups(error: Array, group: IntArray, count: int) -> Array:
    """(count,) root mean square length of the errors (R, 3) in each group; zero for none."""
    squares = np.bincount(group, np.einsum("rc,rc->r", error, error), count)
    return np.sqrt(squares / np.maximum(np.bincount(group, minlength=count), 1))


def chosen(measurements: Measurements, keep: BoolArray) -> Measurements:
    """The readings of the experiments where `keep`, (N,), is true."""
    keep = np.asarray(keep, dtype=bool)
    number = np.cumsum(keep) - 1
    reading = keep[measurements.case]
    return replace(
        measurements,
        cases=measurements.cases.chosen(keep),
        names=tuple(n for n, k in zip(measurements.names, keep, strict=True) if k),
        case=number[measurements.case[reading]],
        marker=measurements.marker[reading],
        deflection=measurements.deflection[reading],
        covariance=measurements.covariance[reading],
        common=measurements.common[reading] if measurements.common.size else measurements.common,
        unloaded_of=measurements.unloaded[reading],
    )
