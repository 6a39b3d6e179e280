"""Absolute campaigns on a true arm: what trackers would read that stand, drift and get knocked.

In: a true arm, reflectors and stations as they are, poses. Out: `Positions`, as a file of a real
campaign gives them, with what the controller showed and not where the joints were.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, freeze, frozen, unset
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.measuring.positions import FootReadings, Positions
from elastocal.robot.chain import Tool
from elastocal.robot.rotations import from_rotation_vectors, rotation_vectors
from elastocal.simulation.absolute_truth import TrueArm, commanded, flanges
from elastocal.simulation.virtual_campaign import Outliers

Covariance = Callable[[Array], Array]
"""(N, 3, 3) covariance of single readings of points (N, 3), frame of the station [m²]."""


@dataclass(frozen=True)
class TrueStation:
    """Where a tracker stands, and how it moves: points in its frame shift, and turn about it.

    Attributes:
        T_station_base: (4, 4) pose of the robot's base in its frame, at the start [m].
        drift: (6,) shift [m/s], then turn [rad/s], all the time alike.
        bumped_after: Number of readings of the arm after which it is knocked; -1: never.
        bump: (6,) shift [m] and turn [rad] by which it is knocked.
    """

    T_station_base: Array
    drift: Array = field(default_factory=lambda: np.zeros(6))
    bumped_after: int = -1
    bump: Array = field(default_factory=lambda: np.zeros(6))

    def __post_init__(self) -> None:
        freeze(self, "T_station_base", "drift", "bump")

    def seen(self, points: Array, time: Array, order: IntArray) -> tuple[Array, Array]:
        """(N, 3) base points, and (N, 3, 3) base axes, as it sees them at times and orders (N,)."""
        way = time[:, None] * self.drift
        if self.bumped_after >= 0:
            way = way + np.where(order[:, None] >= self.bumped_after, self.bump, 0.0)
        turn = from_rotation_vectors(way[:, 3:])
        there = points @ self.T_station_base[:3, :3].T + self.T_station_base[:3, 3]
        return (
            np.einsum("nij,nj->ni", turn, there) + way[:, :3],
            turn @ self.T_station_base[:3, :3],
        )


@dataclass(frozen=True)
class Visits:
    """N poses as they are commanded, in the order of the campaign.

    Attributes:
        q: (N, n) what the controller shows, in joint values of the model [rad or m].
        wrench: (N, 6) what acts at the load point besides weights [N, N·m]; nothing if not given.
        payload: (N,) number of what hangs on the flange; nothing if not given.
        mounting: (N,) number of the mounting of the reflectors; the first if not given.
        station: (N,) number of the station that reads; the first if not given.
    """

    q: Array
    wrench: Array = field(default_factory=unset)
    payload: IntArray = field(default_factory=lambda: frozen([], np.int64))
    mounting: IntArray = field(default_factory=lambda: frozen([], np.int64))
    station: IntArray = field(default_factory=lambda: frozen([], np.int64))

    def __post_init__(self) -> None:
        count = len(self.q)
        freeze(self, "q", wrench=self.wrench if self.wrench.size else np.zeros((count, 6)))
        for name, usual in (("payload", -1), ("mounting", 0), ("station", 0)):
            given = getattr(self, name)
            freeze(self, **{name: given if len(given) else np.full(count, usual)}, dtype=np.int64)

    def __len__(self) -> int:
        return len(self.q)


@dataclass(frozen=True)
class Foot:
    """Reflectors that stand still, and how often they are read.

    Attributes:
        points: (F, 3) where they are, base frame [m].
        blocks: How often all of them are read: first of all, last of all, and between.
    """

    points: Array
    blocks: int = 5

    def __post_init__(self) -> None:
        freeze(self, "points")
        if self.blocks < 1:
            raise InputError(f"a foot is read at least once, found {self.blocks} blocks")


@dataclass(frozen=True)
class AbsoluteTruth:
    """A cell as it is, which no campaign knows.

    Attributes:
        arm: The arm.
        markers: (M, K, 3) reflectors of each mounting, flange frame [m].
        stations: Where trackers stand.
        probe: (M, 3, 3) axes of the probe of each mounting in the flange frame, as columns; the
            flange's if not given.
        foot: Reflectors that stand still; None if there are none.
    """

    arm: TrueArm
    markers: Array
    stations: tuple[TrueStation, ...]
    probe: Array = field(default_factory=unset)
    foot: Foot | None = None

    def __post_init__(self) -> None:
        probe = self.probe if self.probe.size else np.tile(np.eye(3), (len(self.markers), 1, 1))
        freeze(self, "markers", probe=probe)


def alike(deviation: float) -> Covariance:
    """Readings whose coordinates all have the same standard deviation [m]."""
    return lambda points: np.tile(deviation**2 * np.eye(3), (len(points), 1, 1))


def simulated_positions(
    truth: AbsoluteTruth,
    tool: Tool,
    visits: Visits,
    rng: np.random.Generator,
    *,
    covariance: Covariance,
    turned: float = 0.0,
    noise: float = 1.0,
    outliers: Outliers | None = None,
    seconds: float = 5.0,
    skipped: float = 0.0,
) -> Positions:
    """What is read on a true arm, all reflectors in each pose after one another.

    Args:
        truth: The cell as it is.
        tool: The tool as it is thought to be; its rotation is read if it says so.
        visits: Poses.
        rng: Source of chance.
        covariance: How well single readings are promised to be made.
        turned: Standard deviation of each component of a read rotation [rad].
        noise: Noise that there is over what is promised; 0 for readings without.
        outliers: Gross errors; none if None.
        seconds: What a reading takes [s].
        skipped: Share of the readings that are not made, as where a beam is broken.

    Raises:
        EquilibriumError: the arm does not come to rest in a pose.
    """
    by_arm, by_noise, by_error, by_gap = rng.spawn(4)
    targets = len(tool.targets)
    case = np.repeat(np.arange(len(visits)), targets)
    marker = np.tile(np.arange(targets), len(visits))
    made = by_gap.random(len(case)) >= skipped
    case, marker = case[made], marker[made]
    station, mounting = visits.station[case], visits.mounting[case]
    blocks = _blocks(truth.foot, case, station)
    spots = 0 if truth.foot is None else len(truth.foot.points)
    order = np.arange(len(case))
    # Before a reading come all before it, and the blocks of the foot that are due.
    before = order + spots * np.searchsorted(blocks[0], order, side="right")
    time: Array = seconds * before.astype(np.float64)
    frame = flanges(
        truth.arm,
        commanded(truth.arm, visits.q, by_arm),
        visits.wrench,
        tool.load_point,
        visits.payload,
    )[case]
    turns = marker == len(tool.markers)
    local = truth.markers[mounting, np.where(turns, 0, marker)]
    points = np.einsum("nij,nj->ni", frame[:, :3, :3], local) + frame[:, :3, 3]
    value, spread = np.empty((len(case), 3)), np.empty((len(case), 3, 3))
    for s, stand in enumerate(truth.stations):
        mine = station == s
        seen, axes = stand.seen(points[mine], time[mine], order[mine])
        probe = axes @ frame[mine, :3, :3] @ truth.probe[mounting[mine]]
        value[mine] = np.where(turns[mine, None], rotation_vectors(probe), seen)
        spread[mine] = covariance(seen)
    spread[turns] = turned**2 * np.eye(3)
    value = _read(value, noise**2 * spread, turns, by_noise)
    value = _wrong(value, turns, outliers, by_error)
    return Positions(
        tool,
        LoadCases(visits.q, visits.wrench),
        tuple(f"P{i + 1}" for i in range(len(visits))),
        case,
        marker,
        value,
        spread,
        station,
        tuple(f"station {s + 1}" for s in range(len(truth.stations))),
        visits.mounting,
        tuple(f"mounting {m + 1}" for m in range(len(truth.markers))),
        visits.payload,
        tuple(load.name for load in truth.arm.payloads),
        time,
        foot=_foot(truth, blocks, seconds, covariance, noise, by_noise),
        source="simulated",
    )


def _blocks(foot: Foot | None, case: IntArray, station: IntArray) -> tuple[IntArray, IntArray]:
    """(B,) readings of the arm before each block of the foot, between poses; (B,) its station."""
    if foot is None:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    after, by = [], []
    for s in np.unique(station).tolist():
        mine = np.flatnonzero(station == s)
        at = np.round(np.linspace(mine[0], mine[-1] + 1, foot.blocks)).astype(np.int64)
        inner = at[1:-1]
        at[1:-1] = np.searchsorted(case, case[np.minimum(inner, len(case) - 1)])
        after.append(at)
        by.append(np.full(foot.blocks, s))
    order = np.argsort(np.concatenate(after), kind="stable")
    return np.concatenate(after)[order], np.concatenate(by)[order]


def _foot(
    truth: AbsoluteTruth,
    blocks: tuple[IntArray, IntArray],
    seconds: float,
    covariance: Covariance,
    noise: float,
    rng: np.random.Generator,
) -> FootReadings | None:
    """The readings of the foot, all its reflectors in each block."""
    if truth.foot is None:
        return None
    spots = len(truth.foot.points)
    order, by = (np.repeat(each, spots) for each in blocks)
    reflector = np.tile(np.arange(spots), len(blocks[0]))
    time: Array = seconds * (order + np.arange(len(order))).astype(np.float64)
    value, spread = np.empty((len(order), 3)), np.empty((len(order), 3, 3))
    for s, stand in enumerate(truth.stations):
        mine = by == s
        value[mine] = stand.seen(truth.foot.points[reflector[mine]], time[mine], order[mine])[0]
        spread[mine] = covariance(value[mine])
    value = _read(value, noise**2 * spread, np.zeros(len(order), dtype=bool), rng)
    names = tuple(f"F{i + 1}" for i in range(spots))
    return FootReadings(names, reflector, by, value, spread, order, time)


def _read(value: Array, spread: Array, turns: BoolArray, rng: np.random.Generator) -> Array:
    """Values with noise; that of a rotation is a turn in the frame of the station."""
    root = np.linalg.cholesky(spread + 1e-300 * np.eye(3))
    noise = np.einsum("nij,nj->ni", root, rng.normal(size=value.shape))
    found = value + noise
    if turns.any():
        turn = from_rotation_vectors(noise[turns]) @ from_rotation_vectors(value[turns])
        found[turns] = rotation_vectors(turn)
    return np.asarray(found)


def _wrong(
    value: Array, turns: BoolArray, outliers: Outliers | None, rng: np.random.Generator
) -> Array:
    """Values of which some are grossly wrong."""
    if outliers is None or outliers.share == 0.0:
        return value
    wrong = (rng.random(len(value)) < outliers.share) & ~turns
    way = rng.normal(size=value.shape)
    way *= outliers.size / np.linalg.norm(way, axis=1, keepdims=True)
    return np.where(wrong[:, None], value + way, value)
