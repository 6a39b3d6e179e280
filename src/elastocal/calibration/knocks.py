"""Whether a tracker was knocked while it read, by what a calibration leaves: a scan for a step.

In: a calibration. Out: for every station the place between two poses at which a step of its base
explains most, with how certain that is. No reflectors on the foot are needed.

For a step s of the base after a pose, with S its rows on what is read later and W all rows,

    g = Sᵀ r,   M = SᵀS - SᵀW C WᵀS,   g M⁻¹ g / 6 over what is left ~ F

Sums from the end give g and M of every place at once. What an arm errs by is alike in poses that
are near, and readings follow each other along a path, so slow waves of errors look like steps:
squares are taken over those that errors make that are correlated so. Source: ours; the bandwidth
is that of Newey & West (1994).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.calibration.calibrate import Calibration
from elastocal.calibration.prediction import predicted
from elastocal.errors import Doubt
from elastocal.fitting.chances import ratio_above
from elastocal.fitting.robust import robust_scale
from elastocal.measuring.positions import Positions

FEWEST = 4
"""Poses on either side of a step that can be found."""
_FAR_OUT = 3.0  # noise beyond which a reading pulls no more
_LIKELY = 6.0  # squares by which a place may be worse and still be where it was, 95 %


@dataclass(frozen=True)
class Knock:
    """The step of a station that explains most.

    Attributes:
        station: Number of the station.
        before: Last reading before the most likely place.
        after: First reading after it.
        first: Last reading that surely was before it.
        last: First reading that surely was after it.
        motion: (6,) shift [m] and turn [rad] of the base, frame of the station.
        size: Root mean square by which the readings moved [m].
        p_value: Chance of a step as clear anywhere in a station that stands still.
    """

    station: int
    before: int
    after: int
    first: int
    last: int
    motion: Array
    size: float
    p_value: float

    def __post_init__(self) -> None:
        freeze(self, "motion")


def likeliest_knocks(found: Calibration) -> tuple[Knock, ...]:
    """The step of every station that reads poses enough; most are by chance, see `p_value`."""
    positions, parameters = found.positions, found.parameters
    rows = predicted(found.model, positions, parameters, found.state).rows
    white = np.array(found.noise.over(rows))
    white[..., parameters.held] = 0.0
    error = _tamed(found, found.noise.over(found.error[..., None])[..., 0])
    # What is tamed is no longer square to the rows.
    score = np.einsum("rcu,rc->u", white, error)
    error = error - white @ (found.covariance @ score)
    knocks = []
    for station in range(len(positions.stations)):
        knock = _scanned(found, rows, white, error, station)
        if knock is not None:
            knocks.append(knock)
    return tuple(knocks)


def _tamed(found: Calibration, error: Array) -> Array:
    """(R, 3) errors over the noise, of which those far out count less."""
    size = np.linalg.norm(error, axis=1)
    scale = robust_scale(size, int(found.dof))
    return error * np.minimum(1.0, _FAR_OUT * scale / np.maximum(size, 1e-300))[:, None]


def _scanned(
    found: Calibration, rows: Array, white: Array, error: Array, station: int
) -> Knock | None:
    """The best place of one station."""
    positions = found.positions
    mine = np.flatnonzero(positions.station == station)
    when = positions.time[mine]
    order = mine[np.argsort(when, kind="stable")] if np.isfinite(when).all() else mine
    poses, first = np.unique(positions.case[order], return_index=True)
    poses = poses[np.argsort(first)]
    if len(poses) < 2 * FEWEST:
        return None
    place = np.full(len(positions.cases), -1)
    place[poses] = np.arange(len(poses))
    base = found.parameters.base(np.array([station]))[0]
    step = _white_steps(found, rows, mine, base)
    at, count = place[positions.case[mine]], len(poses)
    squares, crosses = np.zeros((count, 6, 6)), np.zeros((count, 6, white.shape[2]))
    np.add.at(squares, at, np.einsum("rci,rcj->rij", step, step))
    np.add.at(crosses, at, np.einsum("rci,rcu->riu", step, white[mine]))
    own = (_by_pose(step, error[mine], at, count), squares, crosses)
    # Sums over the poses that come later, from the first place that may be to the last.
    score, square, cross = (np.cumsum(each[::-1], axis=0)[::-1][1:] for each in own)
    places = slice(FEWEST - 1, count - FEWEST)
    gram = square - cross @ found.covariance @ cross.transpose(0, 2, 1)
    score, gram, cross = score[places], gram[places], cross[places]
    jump = np.linalg.solve(gram, score[..., None])[..., 0]
    won = np.einsum("ki,ki->k", score, jump)
    best = int(won.argmax())
    # What is left once the best step is taken off.
    later = at > best + FEWEST - 1
    left = np.array(error)
    left[mine[later]] -= np.einsum("rci,i->rc", step[later], jump[best])
    left += white @ (found.covariance @ (cross[best].T @ jump[best]))
    noise = float((left**2).sum()) / max(found.dof - 6.0, 1.0)
    waves = _inflation(_by_pose(step, left[mine], at, count))
    won = won / (noise * waves)
    p_value = len(won) * ratio_above(float(won[best]) / 6.0, 6.0, max(found.dof - 6.0, 1.0))
    likely = np.flatnonzero(won > won[best] - _LIKELY) + FEWEST - 1
    ends = [np.flatnonzero(at <= k) for k in (best + FEWEST - 1, likely[0], likely[-1])]
    starts = [np.flatnonzero(at > k) for k in (best + FEWEST - 1, likely[-1])]
    moved = np.einsum("rci,i->rc", rows[mine][..., base], jump[best])
    points = ~positions.rotations[mine]
    return Knock(
        station,
        int(mine[ends[0]].max()),
        int(mine[starts[0]].min()),
        int(mine[ends[1]].max()),
        int(mine[starts[1]].min()),
        jump[best],
        float(np.sqrt((moved[points] ** 2).sum(axis=1).mean())),
        min(p_value, 1.0),
    )


def _white_steps(found: Calibration, rows: Array, mine: IntArray, base: IntArray) -> Array:
    """(r, 3, 6) what a unit step of a base does to readings of its station, over their noise."""
    plain = np.zeros((len(rows), 3, 6))
    plain[mine] = rows[mine][..., base]
    return found.noise.over(plain)[mine]


def _by_pose(step: Array, error: Array, at: IntArray, count: int) -> Array:
    """(count, 6) scores of poses."""
    found = np.zeros((count, 6))
    np.add.at(found, at, np.einsum("rci,rc->ri", step, error))
    return found


def _inflation(score: Array) -> float:
    """By how much sums of scores (P, 6) in their order scatter more than if all were apart."""
    scaled = score / np.maximum(np.sqrt((score**2).mean(axis=0)), 1e-300)
    total, reach = 1.0, int(4.0 * (len(score) / 100.0) ** (2.0 / 9.0)) + 1
    for lag in range(1, reach):
        alike = float((scaled[lag:] * scaled[:-lag]).mean())
        total += 2.0 * (1.0 - lag / reach) * alike
    return max(total, 1.0)


def split_at(positions: Positions, knock: Knock) -> Positions:
    """The same readings with the station as two, one before the knock and one after it."""
    station = np.array(positions.station)
    mine = np.flatnonzero(station == knock.station)
    when = positions.time
    timed = np.isfinite(when[mine]).all()
    later = when[mine] >= when[knock.after] if timed else mine >= knock.after
    station[mine[later]] = len(positions.stations)
    name = positions.stations[knock.station] or "station"
    foot = positions.foot
    if foot is not None:
        by = np.array(foot.station)
        by[(by == knock.station) & (foot.order > knock.before)] = len(positions.stations)
        foot = replace(foot, station=by)
    stations = (*positions.stations, f"{name} after the knock")
    return replace(positions, station=station, stations=stations, foot=foot)


def knocked(positions: Positions, knock: Knock) -> Doubt:
    """That a station seems to have been knocked, by how much and where; readings from 1."""
    places = {name: getattr(knock, name) + 1 for name in ("before", "after", "first", "last")}
    numbers = {"size": knock.size, "p_value": knock.p_value, **places}
    return Doubt("tracker-knocked", (positions.stations[knock.station],), (), numbers, "m")
