"""The state in which a fit begins: every base and every reflector from the readings alone."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.calibration.arm_model import ArmModel, State
from elastocal.calibration.start import placed
from elastocal.errors import InputError
from elastocal.measuring.best_fit import best_fits
from elastocal.measuring.positions import Positions
from elastocal.robot.posture import forward_kinematics
from elastocal.robot.rotations import from_rotation_vectors

FEWEST = 4
"""Poses with one reflector from which base and reflector can be found."""
_ABSURD = 0.1  # m beyond which an arm as drawn is not the one that was measured
_SHARE = 0.25  # the same as a share of how far the readings spread


def begin(
    model: ArmModel, positions: Positions, *, base_known: bool = False, tool_known: bool = False
) -> State:
    """Bases and reflectors that fit best to the arm as drawn, unless they are known.

    Raises:
        InputError: too few poses, or joints and positions do not belong together.
    """
    flange = forward_kinematics(model.robot, positions.cases.q)
    stations, mountings = len(positions.stations), len(positions.mountings)
    base = np.tile(np.eye(4), (stations, 1, 1))
    markers = np.tile(np.asarray(model.tool.markers), (mountings, 1, 1))
    mounting = positions.mounting[positions.case]
    points = ~positions.rotations
    known_base, known = np.full(stations, base_known), np.full(markers.shape[:2], tool_known)
    while True:
        pairs = np.stack([positions.station, mounting, positions.marker], axis=1)[points]
        open_ = [
            (int((pairs == pair).all(axis=1).sum()), tuple(pair))
            for pair in np.unique(pairs, axis=0).tolist()
            if not (known_base[pair[0]] and known[pair[1], pair[2]])
        ]
        if not open_:
            break
        # What hangs together with what is known comes first, then what was read most.
        near = [o for o in open_ if known_base[o[1][0]] or known[o[1][1], o[1][2]]]
        _, (s, m, k) = max(near or open_)
        mine = points & (positions.station == s) & (mounting == m) & (positions.marker == k)
        frames, seen = flange[positions.case[mine]], positions.value[mine]
        if known_base[s] and known[m, k]:
            continue
        if known_base[s]:
            inside = (seen - base[s, :3, 3]) @ base[s, :3, :3] - frames[:, :3, 3]
            markers[m, k] = np.einsum("nij,ni->nj", frames[:, :3, :3], inside).mean(axis=0)
        elif known[m, k] and len(seen) >= FEWEST - 1:
            base[s] = _registered(frames[:, :3, :3] @ markers[m, k] + frames[:, :3, 3], seen)
        else:
            base[s], markers[m, k] = _alone(frames, seen, markers[m, k], positions, s)
        known_base[s] = known[m, k] = True
    probe = np.tile(np.eye(3), (mountings, 1, 1))
    for m in range(0 if tool_known else mountings):
        mine = positions.rotations & (mounting == m)
        if mine.any():
            turned = base[positions.station[mine], :3, :3] @ flange[positions.case[mine], :3, :3]
            seen = from_rotation_vectors(positions.value[mine])
            u, _, vt = np.linalg.svd(np.einsum("nji,njk->ik", turned, seen))
            probe[m] = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    payload = np.array([[p.mass, *(p.mass * p.center)] for p in model.payloads]).reshape(-1, 4)
    return State(
        base,
        markers,
        probe,
        np.zeros(len(model.errors)),
        np.zeros(len(model.compliances)),
        payload,
        np.zeros(len(model.compensators)),
    )


def _registered(points: Array, seen: Array) -> Array:
    """(4, 4) T_station_base of points in the frame of the base [m], and where they were read."""
    rotation, shift, _ = best_fits(points, seen[None])
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation[0], shift[0]
    return T


def _alone(
    frames: Array, seen: Array, near: Array, positions: Positions, s: int
) -> tuple[Array, Array]:
    """Base and reflector of one station of which nothing is known."""
    station = f" of station {positions.stations[s]!r}" if len(positions.stations) > 1 else ""
    source = positions.source or "the positions"
    if len(seen) < FEWEST:
        raise InputError(
            f"{source}: {len(seen)} readings of a reflector{station} are too few to find where "
            f"base and reflector are; expected at least {FEWEST} poses"
        )
    T, point, left = placed(frames, seen, near)
    spread = float(np.sqrt(((seen - seen.mean(axis=0)) ** 2).sum(axis=1).mean()))
    if left > _ABSURD or left > _SHARE * spread:
        raise InputError(
            f"{source}: the positions{station} are {1e3 * left:.0f} mm (root mean square) from "
            "where the joint values put the arm, after the best rotation and shift; expected some "
            "millimetres: joint values and positions do not belong together (order of rows, units, "
            "signs, zeros or another robot)"
        )
    return T, point
