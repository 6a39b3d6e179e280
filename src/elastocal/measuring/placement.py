"""Where readings of unloaded markers lie, beside where joints and tool put these.

In: positions in the frame that they are believed to be in, one rigid frame for each station. Out:
the frames in which they fit best to the rigid arm, and how far they are apart with and without.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, IntArray, freeze, frozen
from elastocal.measuring.best_fit import BestFit, best_fit, best_fits, turn_errors, unseen_turn
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture

_ALIKE = 2  # decimals to which joint values are compared [rad or m]
_STEPS, _AT_REST = 12, 1e-8
_SEEN = 1e-3
"""Part of a column that is left beside shifts and turns of the frames, if it is seen at all."""


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

    def nominal(self, each: Array) -> Array:
        """(V, R, 3) where the markers are [m] in configurations (V, N, n)."""
        count = each.shape[1]
        posture = Posture(self.robot, each.reshape(-1, each.shape[2]))
        points = np.array([posture.point(marker) for marker in self.markers])  # (K, 3, V N)
        points = points.reshape(len(self.markers), 3, -1, count)
        return np.moveaxis(points[self.marker, :, :, self.case], 2, 0)

    @cached_property
    def drawn(self) -> Array:
        """(R, 3) where the markers are in the known configurations [m]."""
        return frozen(self.nominal(self.q[None])[0])

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
    nominal = unloaded.drawn
    # An arm is off alike where it stands alike: repeats are no further evidence.
    alike = np.unique(np.round(unloaded.q, _ALIKE), axis=0, return_inverse=True)[1].reshape(-1)
    fits, left, turned = [], 0.0, 0.0
    for number in range(int(unloaded.station.max(initial=0)) + 1):
        mine = unloaded.station == number
        points, wanted = unloaded.position[mine], nominal[mine]
        fit = best_fit(points, wanted)
        fits.append(fit)
        left += fit.rms**2 * len(points)
        errors = turn_errors(fit, points, wanted, alike[unloaded.case[mine]])
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
    nominal = unloaded.drawn
    stations = range(int(unloaded.station.max(initial=0)) + 1)
    return len(unloaded) > 0 and not any(
        unseen_turn(points[unloaded.station == number])
        for number in stations
        for points in (unloaded.position, nominal)
    )


def left_over(unloaded: Unloaded, nominal: Array) -> Array:
    """(V,) root mean square distances [m] after the best fits to nominal points (V, R, 3)."""
    total = np.zeros(len(nominal))
    for number in np.unique(unloaded.station):
        mine = unloaded.station == number
        rms = best_fits(unloaded.position[mine], nominal[:, mine])[2]
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


def settled(few: Unloaded, *, markers: bool, joint: int | None = None) -> Unloaded:
    """The readings with the markers, and the zero of a joint, that fit best to the arm.

    What a shift and a turn of the frames do as well stays as it is.

    Args:
        few: The readings.
        markers: Whether the markers are free in the flange frame.
        joint: Joint whose values may all be larger by as much; None for no joint.

    Source: ours; Gauss-Newton, the frames of the stations projected out.
    """
    count = len(few.markers)
    for _ in range(_STEPS):
        nominal = few.drawn
        posture = Posture(few.robot, few.q)
        columns = np.zeros((len(few), 3, 3 * count * markers + (joint is not None)))
        if markers:
            turned = posture.bodies[-1][:3].transpose(2, 1, 0)[few.case]  # (R, 3, 3)
            for k in range(count):
                mine = few.marker == k
                columns[mine, :, 3 * k : 3 * k + 3] = turned[mine]
        if joint is not None:
            columns[:, :, -1] = _moved_by(posture, few, joint)
        flat, open_ = columns.reshape(3 * len(few), -1), residuals(few, nominal).reshape(-1)
        size = np.linalg.norm(flat, axis=0)
        row = np.repeat(few.station, 3)
        for number in np.unique(few.station):
            frame = _frame(nominal[few.station == number])
            own = row == number
            flat[own] -= frame @ (frame.T @ flat[own])
            open_[own] -= frame @ (frame.T @ open_[own])
        scale = np.where(np.linalg.norm(flat, axis=0) > _SEEN * size, 1.0, 0.0)
        step = -np.linalg.lstsq(flat * scale, open_, rcond=_SEEN)[0] * scale
        if joint is not None:
            if not abs(step[-1]) < np.pi:
                break
            q = np.array(few.q)
            q[:, joint] += step[-1]
            few = replace(few, q=q)
        if markers:
            few = replace(few, markers=few.markers + step[: 3 * count].reshape(-1, 3))
        if np.abs(step).max(initial=0.0) < _AT_REST:
            break
    return few


def _moved_by(posture: Posture, few: Unloaded, joint: int) -> Array:
    """(R, 3) how each marker moves with a joint."""
    columns = [posture.point_jacobian(posture.point(m))[:, joint].T for m in few.markers]
    return np.array(columns)[few.marker, few.case]


def _frame(points: Array) -> Array:
    """(3R, 6) orthonormal columns of small shifts and turns of points (R, 3)."""
    arm = points - points.mean(axis=0)
    columns = np.zeros((len(points), 3, 6))
    for k, axis in enumerate(np.eye(3)):
        columns[:, k, k] = 1.0
        columns[:, :, 3 + k] = np.cross(axis, arm)
    return np.linalg.qr(columns.reshape(-1, 6))[0]
