"""Whether stations stand still, by reflectors that do: blocks of readings of the robot's foot.

In: readings of the foot. Out: how each station moved from block to block, with how certain that
is, and what it was: still, drifting or knocked. What drifted can be taken off the readings of the
arm; of a knock nobody knows when it was, so it is refused.

Points that a station reads move by a shift and a turn about the middle of the foot. The smallest
of five ways that explains the blocks is taken: none, one steady, one that bends, one step, one
steady with a step; else every block has its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.errors import Doubt, InputError
from elastocal.fitting.chances import chi_square_above, ratio_above
from elastocal.measuring.best_fit import unseen_turn
from elastocal.measuring.positions import FootReadings, Positions
from elastocal.robot.rotations import cross_matrices, from_rotation_vectors, rotation_vectors

STILL, DRIFTING, KNOCKED = "still", "drifting", "knocked"

_BEYOND_CHANCE = 1e-3
_NOISY = 0.01  # chance of readings that scatter so, below which what is seen counts as noise
_PRICE = 4.0  # of each number of a way, in squares over the noise; chance alone gives 1
_SURE = 6.0  # squares by which a step must be better than a drift, for it is refused
_ROUNDS = 4


@dataclass(frozen=True)
class StationMotion:
    """How a station moved, seen by B blocks of readings of the foot.

    Attributes:
        station: Its number.
        order: (B,) readings of the arm before each block.
        when: (B,) time [s], or number of readings of the arm where no time is known.
        motion: (B, 6) shift [m] and turn [rad] of what it sees since the first block, about
            `middle`; the way that was chosen.
        covariance: (B, B, 6, 6) of that, between blocks.
        middle: (3,) middle of the foot, frame of the station [m].
        verdict: still, drifting or knocked.
        p_value: Chance of blocks as far apart if it stood still.
        between: Blocks before and after the knock; (-1, -1) if there was none.
        scatter: Readings of the foot over their noise, each block by itself; 1 if as promised.
        timed: Whether `when` is a time.
    """

    station: int
    order: IntArray
    when: Array
    motion: Array
    covariance: Array
    middle: Array
    verdict: str
    p_value: float
    between: tuple[int, int]
    scatter: float
    timed: bool

    def __post_init__(self) -> None:
        freeze(self, "when", "motion", "covariance", "middle")
        freeze(self, "order", dtype=np.int64)


def station_motions(positions: Positions) -> tuple[StationMotion, ...]:
    """How stations moved that read the foot at least twice, three reflectors or more each time."""
    foot = positions.foot
    if foot is None:
        return ()
    timed = bool(np.isfinite(foot.time).all() and np.isfinite(positions.time).all())
    found = []
    for station in np.unique(foot.station).tolist():
        blocks = _blocks(foot, np.flatnonzero(foot.station == station))
        if len(blocks) > 1:
            found.append(_moved(foot, station, blocks, timed))
    return tuple(found)


def _blocks(foot: FootReadings, mine: IntArray) -> list[IntArray]:
    """Readings of the foot with no reading of the arm between them, in order.

    Of reflectors that the first of them has; blocks in which these leave a turn open are left out.
    """
    blocks: list[IntArray] = []
    for at in np.unique(foot.order[mine]).tolist():
        r = mine[foot.order[mine] == at]
        if blocks:
            r = r[np.isin(foot.reflector[r], foot.reflector[blocks[0]])]
        if not unseen_turn(foot.position[r]):
            blocks.append(r)
    return blocks


def _moved(foot: FootReadings, station: int, blocks: list[IntArray], timed: bool) -> StationMotion:
    """The motion of one station."""
    motion, covariance, middle, square, dof = _registered(foot, blocks)
    scatter = float(np.sqrt(square / dof)) if dof else 1.0
    if dof and chi_square_above(square, dof) < _NOISY:
        covariance = scatter**2 * covariance  # the noise is what is seen, not what was promised
    else:
        dof = 0
    order = np.array([foot.order[r[0]] for r in blocks])
    when = np.array([foot.time[r].mean() for r in blocks]) if timed else order.astype(float)
    chosen = _chosen(motion[1:].ravel(), covariance, when - when[0], dof)
    count = len(blocks)
    way = np.vstack([np.zeros(6), chosen.motion.reshape(-1, 6)])
    whole = np.zeros((count, 6, count, 6))
    whole[1:, :, 1:] = chosen.covariance.reshape(count - 1, 6, count - 1, 6)
    return StationMotion(
        station,
        order,
        when,
        way,
        whole.transpose(0, 2, 1, 3),
        middle,
        chosen.verdict,
        chosen.p_value,
        chosen.between,
        scatter,
        timed,
    )


def _registered(
    foot: FootReadings, blocks: list[IntArray]
) -> tuple[Array, Array, Array, float, int]:
    """Motions (B, 6) since the first block, covariance of those after it, the middle, χ² and dof.

    Reflectors and motions together by least squares: rigid motions, so only how the reflectors
    stand to each other counts.
    """
    used = np.concatenate(blocks)
    block = np.repeat(np.arange(len(blocks)), [len(r) for r in blocks])
    first, spot = (
        blocks[0],
        np.searchsorted(np.unique(foot.reflector[blocks[0]]), foot.reflector[used]),
    )
    points = np.array(
        [foot.position[first[spot[: len(first)] == f]].mean(axis=0) for f in range(spot.max() + 1)]
    )
    middle = points.mean(axis=0)
    white = np.linalg.inv(np.linalg.cholesky(foot.covariance[used]))
    motion = np.zeros((len(blocks), 6))
    size = 3 * len(points)
    rows = np.zeros((len(used), 3, size + 6 * (len(blocks) - 1)))
    turn = np.tile(np.eye(3), (len(blocks), 1, 1))
    for _ in range(_ROUNDS):
        arms = np.einsum("rij,rj->ri", turn[block], points[spot] - middle)
        error = foot.position[used] - (arms + middle + motion[block, :3])
        rows[:] = 0.0
        for r, (f, b) in enumerate(zip(spot.tolist(), block.tolist(), strict=True)):
            rows[r, :, 3 * f : 3 * f + 3] = turn[b]
            if b:
                place = size + 6 * (b - 1)
                rows[r, :, place : place + 3] = np.eye(3)
                rows[r, :, place + 3 : place + 6] = -cross_matrices(arms[r : r + 1])[0]
        flat = (white @ rows).reshape(-1, rows.shape[2])
        values = np.einsum("rij,rj->ri", white, error).ravel()
        step = np.linalg.lstsq(flat, values, rcond=None)[0]
        points = points + step[:size].reshape(-1, 3)
        moved = step[size:].reshape(-1, 6)
        motion[1:, :3] += moved[:, :3]
        turn[1:] = from_rotation_vectors(moved[:, 3:]) @ turn[1:]
        motion[1:, 3:] += moved[:, 3:]  # small turns, which add
    left = values - flat @ step
    covariance = np.linalg.pinv(flat.T @ flat)[size:, size:]
    dof = len(values) - flat.shape[1]
    return motion, np.asarray(covariance), np.asarray(middle), float(left @ left), dof


@dataclass(frozen=True)
class _Way:
    """A way that explains the blocks after the first, as numbers (6 (B - 1),)."""

    motion: Array
    covariance: Array
    square: float
    price: float
    verdict: str
    between: tuple[int, int] = (-1, -1)
    p_value: float = 1.0


def _chosen(motion: Array, covariance: Array, since: Array, dof: int) -> _Way:
    """The way with the smallest squares and price together."""
    blocks = len(since)
    root = np.linalg.inv(np.linalg.cholesky(covariance))

    def chance(square: float, numbers: int) -> float:
        if dof:
            return ratio_above(square / numbers, numbers, dof)
        return chi_square_above(square, numbers)

    def fitted(curves: list[Array], verdict: str, between: tuple[int, int] = (-1, -1)) -> _Way:
        """By curves (B - 1,), each with a shift and a turn of its own."""
        made = np.kron(np.array(curves).T, np.eye(6))
        solved = np.linalg.lstsq(root @ made, root @ motion, rcond=None)[0]
        left = root @ (motion - made @ solved)
        inner = np.linalg.pinv((root @ made).T @ (root @ made))
        places = _SURE + 2.0 * np.log(blocks - 1) if between[0] >= 0 else 0.0
        price = _PRICE * 6 * len(curves) + places
        return _Way(
            made @ solved, made @ inner @ made.T, float(left @ left), price, verdict, between
        )

    none = float(((root @ motion) ** 2).sum())
    p_value = chance(none, len(motion))
    still = _Way(np.zeros_like(motion), np.zeros_like(covariance), none, 0.0, STILL)
    if p_value >= _BEYOND_CHANCE:
        return replace(still, p_value=p_value)
    t = since[1:] / since[-1]
    steps = [(t * 0.0 + (np.arange(1, blocks) > g), (g, g + 1)) for g in range(blocks - 1)]
    ways = [
        fitted([t], DRIFTING),
        _Way(motion, covariance, 0.0, _PRICE * len(motion), DRIFTING),
    ]
    if blocks > 2:  # of two blocks nobody can say
        ways += [fitted([step], KNOCKED, between) for step, between in steps]
    if blocks > 3:
        ways += [fitted([t, t**2], DRIFTING)]
        ways += [fitted([t, step], KNOCKED, between) for step, between in steps]
    best = min(ways, key=lambda way: way.square + way.price)
    return replace(best, p_value=p_value)


def steadied(positions: Positions, motions: tuple[StationMotion, ...]) -> Positions:
    """The readings as if every station stood where it stood in its first block.

    What is uncertain of a drift is in the covariance of the readings that it is taken off.

    Raises:
        InputError: a station was knocked, and nobody knows when.
    """
    value, covariance = np.array(positions.value), np.array(positions.covariance)
    odd = list(positions.doubts)
    for motion in motions:
        if motion.verdict == KNOCKED:
            raise InputError(knock_sentence(positions, motion))
        if motion.verdict == STILL:
            continue
        r = np.flatnonzero(positions.station == motion.station)
        when = positions.time[r] if motion.timed else r.astype(float)
        way, spread = moved_at(motion, when)
        back = from_rotation_vectors(-way[:, 3:])
        turns = positions.rotations[r]
        arms = value[r] - motion.middle - way[:, :3]
        moved = np.einsum("rij,rj->ri", back, arms) + motion.middle
        jacobian = np.concatenate(
            [np.tile(np.eye(3), (len(r), 1, 1)), -cross_matrices(arms)], axis=2
        )
        jacobian[turns, :, :3], jacobian[turns, :, 3:] = 0.0, np.eye(3)
        if turns.any():
            moved[turns] = rotation_vectors(back[turns] @ from_rotation_vectors(value[r[turns]]))
        value[r] = moved
        far = float(
            np.linalg.norm(way[:, :3] + np.cross(way[:, 3:], arms), axis=1).max(initial=0.0)
        )
        name = positions.stations[motion.station]
        odd.append(Doubt("tracker-drifted", (name,), (), {"size": far}, "m"))
        more = jacobian @ spread @ jacobian.transpose(0, 2, 1)
        covariance[r] = back @ (covariance[r] + more) @ back.transpose(0, 2, 1)
    return replace(positions, value=value, covariance=covariance, doubts=tuple(odd))


def moved_at(motion: StationMotion, when: Array) -> tuple[Array, Array]:
    """(R, 6) where a station is at times (R,), between its blocks, and (R, 6, 6) covariance."""
    after = np.clip(np.searchsorted(motion.when, when, side="right"), 1, len(motion.when) - 1)
    start, end = motion.when[after - 1], motion.when[after]
    share = np.clip((when - start) / np.where(end > start, end - start, 1.0), 0.0, 1.0)
    weights = np.zeros((len(when), len(motion.when)))
    rows = np.arange(len(when))
    weights[rows, after - 1], weights[rows, after] = 1.0 - share, share
    spread = np.einsum("rb,bcij,rc->rij", weights, motion.covariance, weights)
    return weights @ motion.motion, spread


def knock_sentence(positions: Positions, motion: StationMotion) -> str:
    """That a station was knocked, by how much, and between which readings."""
    before, after = motion.between
    mine = positions.value[(positions.station == motion.station) & ~positions.rotations]
    step = motion.motion[after] - motion.motion[before]
    way = step[:3] + np.cross(step[3:], mine - motion.middle)
    size = 1e3 * float(np.sqrt((way**2).sum(axis=1).mean()))
    first = int(motion.order[before])
    last = min(int(motion.order[after]) + 1, len(positions))
    name = positions.stations[motion.station]
    return (
        f"{positions.source or 'the positions'}: {f'station {name!r}' if name else 'the station'} "
        f"moved by {size:.2g} mm between readings {max(first, 1)} and {last}, as reflectors on the "
        "foot show; expected it to stand still or drift: make it two stations, one before and one "
        "after"
    )
