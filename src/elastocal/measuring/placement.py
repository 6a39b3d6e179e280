"""Where readings of unloaded markers lie, beside where joints and tool put these.

In: positions in the frame that they are believed to be in, one rigid frame for each station. Out:
the frames in which they fit best to the rigid arm, and how far they are apart with and without.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.measuring.best_fit import BestFit, best_fit, best_fits, turn_errors, unseen_turn
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture


@dataclass(frozen=True)
class Unloaded:
    """R readings of markers in N experiments, without load.

    Attributes:
        robot: The robot, taken as rigid.
        markers: (K, 3) where the markers are in the flange frame [m].
        q: (N, n) configurations [rad or m].
        case: (R,) experiment of each reading, in the order in which they were read.
        marker: (R,) its marker.
        position: (R, 3) where it was read [m], in the frame that it is believed to be in.
        station: (R,) number of the station that read it.
    """

    robot: Robot
    markers: Array
    q: Array
    case: IntArray
    marker: IntArray
    position: Array
    station: IntArray

    def __post_init__(self) -> None:
        freeze(self, "markers", "q", "position")
        freeze(self, "case", "marker", "station", dtype=np.int64)

    def __len__(self) -> int:
        return len(self.case)

    def nominal(self, each: Array | None = None) -> Array:
        """(V, R, 3) where the markers are [m] in configurations (V, N, n); those known if None."""
        each = self.q[None] if each is None else each
        count = each.shape[1]
        posture = Posture(self.robot, each.reshape(-1, each.shape[2]))
        points = np.array([posture.point(marker) for marker in self.markers])  # (K, 3, V N)
        points = points.reshape(len(self.markers), 3, -1, count)
        return np.moveaxis(points[self.marker, :, :, self.case], 2, 0)

    def chosen(self, rows: IntArray) -> Unloaded:
        """Some of the readings, of all experiments."""
        return replace(
            self,
            case=self.case[rows],
            marker=self.marker[rows],
            position=self.position[rows],
            station=self.station[rows],
        )


@dataclass(frozen=True)
class Placement:
    """How readings of unloaded markers fit to the arm.

    Attributes:
        fits: The best fit of each station, from the frame believed in to the base.
        rms: Root mean square distance after the best fits [m].
        apart: The same without any fit [m].
        turn_error: Standard uncertainty of the rotations, the length of a small turn [rad].
        count: Number of readings.
        chosen: Whether the readings were taken as these fits have them.
    """

    fits: tuple[BestFit, ...]
    rms: float
    apart: float
    turn_error: float
    count: int
    chosen: bool = False

    @property
    def turn(self) -> float:
        """By what angle the frame believed in is turned, of all stations the most [rad]."""
        cosines = [0.5 * (np.trace(fit.rotation) - 1.0) for fit in self.fits]
        return float(np.arccos(np.clip(min(cosines), -1.0, 1.0)))


def place(unloaded: Unloaded) -> Placement:
    """The best fits of readings of unloaded markers.

    Raises:
        InputError: a station has fewer than three distinct points, or all on a line.
    """
    nominal = unloaded.nominal()[0]
    fits, left, turned = [], 0.0, 0.0
    for number in range(int(unloaded.station.max(initial=0)) + 1):
        mine = unloaded.station == number
        points, wanted = unloaded.position[mine], nominal[mine]
        fit = best_fit(points, wanted)
        fits.append(fit)
        left += fit.rms**2 * len(points)
        errors = turn_errors(fit, points, wanted, unloaded.case[mine])
        turned = max(turned, float(np.trace(errors)))
    apart = np.sum((unloaded.position - nominal) ** 2)
    count = len(unloaded)
    return Placement(
        tuple(fits),
        float(np.sqrt(left / count)),
        float(np.sqrt(apart / count)),
        float(np.sqrt(turned)),
        count,
    )


def placeable(unloaded: Unloaded) -> bool:
    """Whether every station has three points that are not on a line, read as well as nominal."""
    nominal = unloaded.nominal()[0]
    stations = range(int(unloaded.station.max(initial=0)) + 1)
    return len(unloaded) > 0 and not any(
        unseen_turn(points[unloaded.station == number])
        for number in stations
        for points in (unloaded.position, nominal)
    )


def left_over(unloaded: Unloaded, nominal: Array, position: Array | None = None) -> Array:
    """(V,) root mean square distances [m] after the best fits to nominal points (V, R, 3)."""
    position = unloaded.position if position is None else position
    total = np.zeros(len(nominal))
    for number in np.unique(unloaded.station):
        mine = unloaded.station == number
        rms = best_fits(position[mine], nominal[:, mine])[2]
        total += rms**2 * np.count_nonzero(mine)
    return np.sqrt(total / len(unloaded))


def residuals(unloaded: Unloaded, nominal: Array) -> Array:
    """(R, 3) nominal points (R, 3) minus the readings after the best fits [m], base frame."""
    found = np.empty_like(nominal)
    for number in np.unique(unloaded.station):
        mine = unloaded.station == number
        rotation, shift, _ = best_fits(unloaded.position[mine], nominal[None, mine])
        found[mine] = nominal[mine] - unloaded.position[mine] @ rotation[0].T - shift[0]
    return found
