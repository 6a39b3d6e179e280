"""Positions: where reflectors on the arm were read, in the frames of the trackers that read them.

Nothing is taken off a reading here: the arm bends under its own weight, tool and payload, and
where the tracker stands is not known before.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, freeze, frozen, unset
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt, InputError
from elastocal.robot.chain import Tool


@dataclass(frozen=True)
class FootReadings:
    """F readings of reflectors that stand still on the robot's foot, or on the floor beside it.

    Attributes:
        names: Names of the reflectors.
        reflector: (F,) which of them was read.
        station: (F,) number of the station that read it.
        position: (F, 3) where [m], in the frame of the station.
        covariance: (F, 3, 3) [m²].
        order: (F,) number of readings of the arm that were made before it.
        time: (F,) when [s], from the first reading of all; NaN where it is not known.
    """

    names: tuple[str, ...]
    reflector: IntArray
    station: IntArray
    position: Array
    covariance: Array
    order: IntArray
    time: Array

    def __post_init__(self) -> None:
        freeze(self, "reflector", "station", "order", dtype=np.int64)
        freeze(self, "position", "covariance", "time")
        count = len(self.reflector)
        if (
            self.position.shape != (count, 3)
            or self.covariance.shape != (count, 3, 3)
            or {len(self.station), len(self.order), len(self.time)} != {count}
        ):
            raise InputError(f"{count} readings of the foot need as much of everything")

    def __len__(self) -> int:
        return len(self.reflector)


@dataclass(frozen=True)
class Positions:
    """R absolute readings of N poses of the arm.

    Attributes:
        tool: Tool with the reflectors where they are thought to be; a probe that reads its
            orientation, too, has `rotation`.
        cases: N configurations of the model, and what acts at the load point besides weights.
        names: N names of the poses.
        case: (R,) pose of each reading.
        marker: (R,) target of each reading, as in `tool.targets`: a reflector, or behind them the
            rotation.
        value: (R, 3) where the reflector was read [m], or how the probe was turned, as axis times
            angle [rad]; in the frame of the station.
        covariance: (R, 3, 3) covariance of each of them [m², rad²].
        station: (R,) number of the station that made each reading: each has a frame of its own.
        stations: Their names.
        mounting: (N,) number of the mounting of the tool in each pose: each has reflectors of its
            own.
        mountings: Their names.
        payload: (N,) number of what is carried in each pose, -1 for nothing.
        payloads: Names of what is carried.
        time: (R,) when [s], from the first reading of all; NaN where it is not known.
        torque: (N, n) joint torques, or forces, that the controller measured [N·m, N]; none if not
            given.
        foot: Readings of reflectors that stand still; None if there are none.
        apart: Root mean square distance of the positions from the arm as drawn, with bases and
            reflectors that fit best [m]; NaN if it is not known.
        own_uncertainty: Whether the covariance came with the readings (True) or from the
            instrument of the study (False).
        source: File they were read from, or how they were made.
        sha256: Hash of that file, empty if there is none.
        readings: Hashes of the files that have the readings.
        remarks: Sentences of the reader on what it made of the file.
        doubts: What looks odd in them.
    """

    tool: Tool
    cases: LoadCases
    names: tuple[str, ...]
    case: IntArray
    marker: IntArray
    value: Array
    covariance: Array
    station: IntArray
    stations: tuple[str, ...] = ("",)
    mounting: IntArray = field(default_factory=lambda: frozen([], np.int64))
    mountings: tuple[str, ...] = ("",)
    payload: IntArray = field(default_factory=lambda: frozen([], np.int64))
    payloads: tuple[str, ...] = ()
    time: Array = field(default_factory=unset)
    torque: Array = field(default_factory=unset)
    foot: FootReadings | None = None
    apart: float = float("nan")
    own_uncertainty: bool = False
    source: str = ""
    sha256: str = ""
    readings: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    doubts: tuple[Doubt, ...] = ()

    def __post_init__(self) -> None:
        count, poses = len(self.case), len(self.cases)
        freeze(self, "case", "marker", "station", dtype=np.int64)
        mounting = self.mounting if len(self.mounting) else np.zeros(poses)
        payload = self.payload if len(self.payload) else np.full(poses, -1)
        freeze(self, mounting=mounting, payload=payload, dtype=np.int64)
        time = self.time if self.time.size else np.full(count, np.nan)
        freeze(self, "value", "covariance", "torque", time=time)
        if (
            {len(self.marker), len(self.station), len(self.time)} != {count}
            or self.value.shape != (count, 3)
            or self.covariance.shape != (count, 3, 3)
            or len(self.names) != poses
            or {len(self.mounting), len(self.payload)} != {poses}
        ):
            raise InputError(
                f"{count} positions of {poses} poses need as much of everything; found values "
                f"{self.value.shape}, covariances {self.covariance.shape}, {len(self.names)} names"
            )
        for what, number, most in (
            ("pose", self.case, poses),
            ("reflector", self.marker, len(self.tool.targets)),
            ("station", self.station, len(self.stations)),
            ("mounting", self.mounting, len(self.mountings)),
            ("payload", self.payload + 1, len(self.payloads) + 1),
        ):
            if count and not 0 <= number.min() <= number.max() < most:
                raise InputError(f"a reading refers to a {what} that does not exist")
        if not (np.isfinite(self.value).all() and np.isfinite(self.covariance).all()):
            raise InputError("positions and covariances must be finite numbers")

    def __len__(self) -> int:
        return len(self.case)

    @property
    def rotations(self) -> BoolArray:
        """(R,) which readings are rotations."""
        return np.asarray(self.marker == len(self.tool.markers))

    def by_size(self) -> Iterator[tuple[IntArray, IntArray]]:
        """Poses (n,) of which equally many readings, k, were made, and these readings (n, k)."""
        order = np.argsort(self.case, kind="stable")
        size = np.bincount(self.case, minlength=len(self.cases))
        first = np.cumsum(size) - size
        for k in np.unique(size[size > 0]).tolist():
            poses = np.flatnonzero(size == k)
            yield poses, order[first[poses][:, None] + np.arange(k)]


def chosen_poses(positions: Positions, keep: BoolArray) -> Positions:
    """The readings of the poses where `keep`, (N,), is true; readings of the foot stay."""
    keep = np.asarray(keep, dtype=bool)
    number, reading = np.cumsum(keep) - 1, keep[positions.case]
    before = np.concatenate([[0], np.cumsum(reading)])
    foot = positions.foot
    return replace(
        positions,
        cases=positions.cases.chosen(keep),
        names=tuple(n for n, k in zip(positions.names, keep, strict=True) if k),
        case=number[positions.case[reading]],
        marker=positions.marker[reading],
        value=positions.value[reading],
        covariance=positions.covariance[reading],
        station=positions.station[reading],
        mounting=positions.mounting[keep],
        payload=positions.payload[keep],
        time=positions.time[reading],
        torque=positions.torque[keep] if positions.torque.size else positions.torque,
        foot=None if foot is None else replace(foot, order=before[foot.order]),
    )
