"""Where a calibrated robot has a point of its tool, and how certain that is.

The flange of a calibrated robot rests on priors: what its last joint errs and where the tool is
cannot be told apart. Reflectors are where they were read; so a TCP is carried along by them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.calibration.calibrated_robot import CalibratedRobot
from elastocal.calibration.parameters import TOOL, Parameters
from elastocal.calibration.prediction import predicted
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.measuring.best_fit import best_fits, unseen_turn
from elastocal.measuring.positions import Positions
from elastocal.robot.rotations import cross_matrices, rotation_vectors

TCP = "TCP"
_SAME = 1e-6  # m within which a TCP is one of the reflectors
_ELSEWHERE, _TURNED = 0.01, 0.05  # m, rad beyond which a drawing is of no tool that is there


@dataclass(frozen=True)
class Carried:
    """A point of the tool in the frame of the calibrated flange.

    Attributes:
        name: What it is called: a reflector, or the TCP.
        point: (3,) where it is [m].
        rotation: (3, 3) how the tool is turned on the flange, against its drawing.
        drawn: (3,) where the drawing has it [m].
        slope: (3, U) how it moves on the flange with the unknowns.
        measured: Whether reflectors carry it; else it is where the drawing has it on a flange that
            was never seen.
    """

    name: str
    point: Array
    rotation: Array
    drawn: Array
    slope: Array
    measured: bool

    def __post_init__(self) -> None:
        freeze(self, "point", "rotation", "drawn", "slope")

    @property
    def elsewhere(self) -> bool:
        """Whether it is so far from its drawing that this is of another tool, or of none."""
        off = float(np.linalg.norm(self.point - self.drawn))
        turn = float(np.linalg.norm(rotation_vectors(self.rotation[None])[0]))
        return off > _ELSEWHERE or turn > _TURNED

    @property
    def meant(self) -> Array:
        """(3,) where on the flange a task means it to be: as drawn, if that is its tool [m]."""
        return self.point if self.elsewhere else self.drawn


@dataclass(frozen=True)
class PlacedPoint:
    """A point of the tool in N configurations.

    Attributes:
        point: (N, 3) where it is, in the frame of the robot's base [m].
        rows: (N, 3, U) what a unit of each unknown moves it by for the station, which sees the base
            move too; in the axes of the base.
    """

    point: Array
    rows: Array

    def __post_init__(self) -> None:
        freeze(self, "point", "rows")


def carried_point(calibrated: CalibratedRobot, mounting: int = 0, name: str = TCP) -> Carried:
    """A point of the tool as a mounting has it.

    The TCP is one of the reflectors, or moves along with three of them that are not on a line, or
    is where the drawing has it.

    Args:
        calibrated: The robot.
        mounting: Number of the mounting.
        name: A reflector, or the TCP.

    Raises:
        InputError: the tool has no such reflector, or this mounting was not read with it.
    """
    model, state, parameters = calibrated.model, calibrated.state, calibrated.parameters
    tool, u = model.tool, len(calibrated.parameters)
    read = parameters.targets[mounting, :-1].astype(bool)
    drawn = tool.tcp
    if name != TCP or TCP in tool.marker_names:
        k = _reflector(calibrated, mounting, name)
        drawn = tool.markers[k]
    else:
        apart = np.linalg.norm(tool.markers - drawn, axis=1)
        near = np.flatnonzero(read & (apart < _SAME))
        k = int(near[0]) if len(near) else -1
    some: IntArray = np.asarray(np.flatnonzero(read), dtype=np.int64)
    rotation, slope = np.eye(3), np.zeros((3, u))
    solid = not unseen_turn(tool.markers[some]) if len(some) > 2 else False
    if solid:
        turn, shift, _ = best_fits(tool.markers[some], state.markers[mounting, some][None])
        rotation = turn[0]
    if k >= 0:
        slope[:, parameters.marker(mounting, k)] = np.eye(3)
        return Carried(name, state.markers[mounting, k], rotation, drawn, slope, measured=True)
    if not solid:
        return Carried(name, drawn, rotation, drawn, slope, measured=False)
    point = rotation @ drawn + shift[0]
    slope = _along(state.markers[mounting, some], point, parameters, mounting, some)
    return Carried(name, point, rotation, drawn, slope, measured=True)


def _reflector(calibrated: CalibratedRobot, mounting: int, name: str) -> int:
    tool = calibrated.model.tool
    read = calibrated.parameters.targets[mounting, :-1]
    known = [n for n, one in zip(tool.marker_names, read.tolist(), strict=True) if one]
    if name not in known:
        raise InputError(f"no reflector {name!r} was read; there are {', '.join([*known, TCP])}")
    return tool.marker_names.index(name)


def _along(
    points: Array, at: Array, parameters: Parameters, mounting: int, some: IntArray
) -> Array:
    """(3, U) how a point moves that is rigid with reflectors, to first order of their best fit."""
    middle = points.mean(axis=0)
    arms = -cross_matrices(points - middle)  # (K, 3, 3): a turn moves a point by turn × arm
    normal = np.einsum("kij,kil->jl", arms, arms)
    slope = np.zeros((3, len(parameters)))
    for k, own in zip(some.tolist(), arms, strict=True):
        turn = np.linalg.solve(normal, own.T)
        slope[:, parameters.marker(mounting, k)] = (
            np.eye(3) / len(points) - cross_matrices((at - middle)[None])[0] @ turn
        )
    return slope


def placed(
    calibrated: CalibratedRobot,
    cases: LoadCases,
    carried: Carried,
    *,
    station: int = 0,
    mounting: int = 0,
    payload: int = -1,
) -> PlacedPoint:
    """Where a point of the tool is in N load cases, with the arm bent and its geometry as it is.

    Args:
        calibrated: The robot.
        cases: N load cases; the wrench acts at the load point, besides weights.
        carried: The point.
        station: Number of the station for which the rows count.
        mounting: Number of the mounting.
        payload: Number of what hangs on the flange, -1 for nothing.

    Raises:
        EquilibriumError: the arm gives way in one of them.
    """
    model, state, parameters = calibrated.model, calibrated.state, calibrated.parameters
    count, markers = len(cases), len(model.tool.markers)
    # The point is one more reflector, of this mounting alone, with three unknowns of its own.
    tool = replace(
        model.tool,
        markers=np.vstack([model.tool.markers, carried.point]),
        marker_names=(*model.tool.marker_names, "the point"),
    )
    mountings = len(state.markers)
    more = np.zeros((mountings, 1), dtype=np.int64)
    more[mounting] = 1
    targets = np.hstack([parameters.targets[:, :-1], more, parameters.targets[:, -1:]])
    own_markers = np.concatenate([state.markers, np.zeros((mountings, 1, 3))], axis=1)
    own_markers[mounting, markers] = carried.point
    wider = replace(
        parameters,
        names=(*parameters.names, "x", "y", "z"),
        block=(*parameters.block, *3 * [TOOL]),
        turns=(*parameters.turns, *3 * [False]),
        targets=targets,
        held=np.append(parameters.held, np.zeros(3)),
    )
    positions = Positions(
        tool,
        cases,
        tuple(str(i + 1) for i in range(count)),
        np.arange(count),
        np.full(count, markers),
        np.zeros((count, 3)),
        np.zeros((count, 3, 3)),
        np.full(count, station),
        calibrated.stations,
        np.full(count, mounting),
        calibrated.mountings,
        np.full(count, payload),
        tuple(p.name for p in model.payloads),
    )
    found = predicted(
        replace(model, tool=tool), positions, wider, replace(state, markers=own_markers)
    )
    base = state.base[station]
    point = (-found.error - base[:3, 3]) @ base[:3, :3]
    rows = base[:3, :3].T @ found.rows
    own = wider.marker(mounting, markers)
    rest = np.delete(rows, own, axis=2)
    return PlacedPoint(point, rest + rows[..., own] @ carried.slope)
