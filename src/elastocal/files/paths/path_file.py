"""Path files: the load cases of a task as CSV, configurations or poses of the tool with wrenches.

In: a table with units in its header. Out: `ToolPath`. Poses become configurations by following
the path from a configuration to start with.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import PathFileError
from elastocal.files.paths.orientation_columns import Form, form_of, read_orientations
from elastocal.files.tables.csv_table import FORCES, LENGTHS, TORQUES, TextTable, read_table
from elastocal.files.tables.units import UNITS
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.inverse_kinematics import follow
from elastocal.robot.joint_kinds import PRISMATIC, REVOLUTE
from elastocal.robot.posture import forward_kinematics

CORRECTED = "deflection dx"
"""Column by which a corrected path is known."""
_POSITION = ("x", "y", "z")
_FORCE = ("Fx", "Fy", "Fz")
_TORQUE = ("Tx", "Ty", "Tz")
_JUMP = 10.0  # a step this many times the median one is a jump
_SMALL_JUMP = {REVOLUTE: np.radians(5.0), PRISMATIC: 0.05}  # unless this small [rad or m]


@dataclass(frozen=True)
class ToolPath:
    """N load cases of a task, from a file.

    Attributes:
        cases: The load cases, wrench in the base frame.
        names: N names of the points.
        lines: N lines of the file.
        form: How orientations are written in it; None for configurations or positions alone.
        remarks: Sentences on what is odd.
        source: File it was read from.
        sha256: Hash of that file.
    """

    cases: LoadCases
    names: tuple[str, ...]
    lines: tuple[int, ...]
    form: Form | None
    remarks: tuple[str, ...]
    source: str
    sha256: str


def read_path(
    path: str | Path,
    robot: Robot,
    tool: Tool,
    start: Array,
    wrench: Array | None = None,
    *,
    frame: Array | None = None,
    idle: bool = False,
) -> ToolPath:
    """The path in a file.

    Args:
        path: CSV with configurations or poses of the TCP, and wrenches unless given here.
        robot: The robot.
        tool: Tool of the task.
        start: (n,) configuration near the first point, for paths of poses [rad or m].
        wrench: (6,) wrench of every point, base frame [N, N·m]; None if the file has them.
        frame: (4, 4) frame of the poses in that of the base [m]; they are the same if None.
        idle: Whether a path without loads is one without loads, where nothing is said of them.

    Raises:
        PathFileError: what is wrong with the file, with line and column.
    """
    path = Path(path)
    table = read_table(path, PathFileError)
    if CORRECTED in table.names:
        raise PathFileError(
            f"{path}, line {table.header_line}: this is a corrected path already, it has a column "
            f"{CORRECTED!r}; expected the path as the task wants it"
        )
    joints = _has_joints(table, robot)
    position = [name for name in _POSITION if name in table.names]
    form = None
    if joints and frame is not None:
        raise PathFileError(
            f"{path}, line {table.header_line}: joint values are in no frame; expected poses of "
            "the TCP, x [mm], y [mm], z [mm]"
        )
    if joints:
        q = _configurations(table, robot)
    elif len(position) == 3:
        form = _checked_form(table, robot)
        q = _followed(table, robot, tool, form, start, np.eye(4) if frame is None else frame)
    else:
        raise PathFileError(
            f"{path}, line {table.header_line}: expected the joints "
            f"{', '.join(robot.joint_names)} with [deg] or [mm], or x [mm], y [mm], z [mm] of the "
            f"TCP; found {', '.join(n for n in table.names if n) or 'no names'}"
        )
    wrenches, loads = _wrenches(table, robot, q, wrench, idle=idle)
    read = {"point", *loads, *(robot.joint_names if joints else _POSITION)}
    left_out = [n for n in table.names if n and n not in read | set(form.columns if form else ())]
    remarks = [f"columns not read: {', '.join(left_out)}"] if left_out else []
    return ToolPath(
        cases=LoadCases(q, wrenches),
        names=_names(table),
        lines=tuple(line for line, _ in table.rows),
        form=form,
        remarks=(*remarks, *_jumps(table, robot, q)),
        source=str(path),
        sha256=table.sha256,
    )


def _has_joints(table: TextTable, robot: Robot) -> bool:
    """Whether the table gives configurations.

    Raises:
        PathFileError: some joints are missing, or poses are given too.
    """
    there = [name for name in robot.joint_names if name in table.names]
    where = f"{table.path}, line {table.header_line}"
    if there and len(there) < len(robot.joints):
        missing = next(name for name in robot.joint_names if name not in there)
        raise PathFileError(f"{where}: the column of joint {missing!r} is missing")
    other = [name for name in _POSITION if name in table.names and name not in there]
    if there and other:
        raise PathFileError(
            f"{where}: joint values and tool positions (column {other[0]!r}) are both given; keep "
            "one"
        )
    return bool(there)


def _configurations(table: TextTable, robot: Robot) -> Array:
    """(N, n) configurations, within the joint limits."""
    q = np.zeros((len(table.rows), len(robot.joints)))
    for j, joint in enumerate(robot.joints):
        q[:, j] = table.numbers([joint.name], UNITS[joint.kind.quantity])[:, 0]
        wrong = np.flatnonzero((q[:, j] < joint.lower) | (q[:, j] > joint.upper))
        if len(wrong):
            scale, unit = joint.kind.shown
            raise PathFileError(
                f"{table.path}, line {table.rows[wrong[0]][0]}, column {joint.name!r}: "
                f"{scale * q[wrong[0], j]:.6g}{unit} is outside the limits "
                f"{scale * joint.lower:.6g} to {scale * joint.upper:.6g}{unit}"
            )
    return q


def _checked_form(table: TextTable, robot: Robot) -> Form | None:
    """How orientations are given: not at all with few joints, somehow with six or more."""
    form = form_of(table)
    where = f"{table.path}, line {table.header_line}"
    count = len(robot.joints)
    if form is not None and count < 6:
        raise PathFileError(
            f"{where}, column {form.columns[0]!r}: a robot with {count} joints cannot take any "
            "orientation; leave these columns out"
        )
    if form is None and count >= 6:
        raise PathFileError(
            f"{where}: the orientation is missing; expected qw, qx, qy, qz (quaternion), or "
            "rx [deg], ry [deg], rz [deg] (rotation vector), or A [deg], B [deg], C [deg] "
            "(about z, y, x as KUKA counts)"
        )
    return form


def _followed(
    table: TextTable, robot: Robot, tool: Tool, form: Form | None, start: Array, frame: Array
) -> Array:
    """(N, n) configurations of poses, each the nearest one to that before."""
    count = len(table.rows)
    targets = np.tile(np.eye(4), (count, 1, 1))
    targets[:, :3, 3] = table.numbers(_POSITION, LENGTHS)
    targets[:, :3, :3] = read_orientations(table, form) if form else np.eye(3)
    q, last = follow(robot, tool.tcp, frame @ targets, start)
    if not last.found:
        off = f"{1e3 * last.distance:.4g} mm"
        turn = f" and {np.degrees(last.turn):.3g}°" if last.turn > 1e-6 else ""
        near = "; name a configuration near it: --start, in a study q_deg"
        hint = near if len(q) == 1 else ""
        raise PathFileError(
            f"{table.path}, line {table.rows[len(q) - 1][0]}: no configuration within the joint "
            f"limits has the TCP there, the nearest found is {off}{turn} off{hint}"
        )
    return q


def _wrenches(
    table: TextTable, robot: Robot, q: Array, wrench: Array | None, *, idle: bool
) -> tuple[Array, tuple[str, ...]]:
    """(N, 6) wrenches in the base frame, and the columns they come from."""
    where = f"{table.path}, line {table.header_line}"
    found: list[tuple[str, tuple[str, ...], tuple[str, ...]]] = []
    for frame in ("", " tool"):
        parts = [tuple(f"{name}{frame}" for name in part) for part in (_FORCE, _TORQUE)]
        there = [tuple(n for n in part if n in table.names) for part in parts]
        for part, named in zip(parts, there, strict=True):
            if named and len(named) < 3:
                missing = next(n for n in part if n not in named)
                raise PathFileError(f"{where}: column {missing!r} is missing beside {named[0]!r}")
        if there[0] or there[1]:
            found.append((frame, there[0], there[1]))
    if len(found) > 1:
        raise PathFileError(
            f"{where}: the load is given in the base frame and in that of the tool; keep one"
        )
    if found and wrench is not None:
        raise PathFileError(
            f"{where}: the file has loads (column {(found[0][1] + found[0][2])[0]!r}) and one for "
            "all points is given too; keep one"
        )
    if not found and wrench is None and idle:
        return np.zeros((len(q), 6)), ()
    if not found and wrench is None:
        raise PathFileError(
            f"{where}: no load; expected columns Fx [N], Fy [N], Fz [N] in the base frame, or "
            "Fx tool [N], ... in the axes of the flange, or one load for all points: --force-n, "
            "in a study force_N"
        )
    if not found:
        return np.tile(np.asarray(wrench, dtype=float), (len(q), 1)), ()
    frame, force, torque = found[0]
    result = np.zeros((len(q), 6))
    if force:
        result[:, :3] = table.numbers(force, FORCES)
    if torque:
        result[:, 3:] = table.numbers(torque, TORQUES)
    if frame:
        rotation = forward_kinematics(robot, q)[:, :3, :3]
        result = np.einsum("nij,nkj->nki", rotation, result.reshape(-1, 2, 3)).reshape(-1, 6)
    return result, (*force, *torque)


def _names(table: TextTable) -> tuple[str, ...]:
    """Names of the points, numbers if there are none."""
    if "point" in table.names:
        return tuple(table.text("point"))
    return tuple(str(i + 1) for i in range(len(table.rows)))


def _jumps(table: TextTable, robot: Robot, q: Array) -> Sequence[str]:
    """A sentence on the largest jump between two points, if there is one."""
    steps = np.abs(np.diff(q, axis=0))
    if len(steps) < 2:
        return ()
    usual = np.median(steps, axis=0)
    least = np.array([_SMALL_JUMP[joint.kind] for joint in robot.joints])
    jumps = (steps > np.maximum(_JUMP * usual, least)).any(axis=1)
    if not jumps.any():
        return ()
    # In shares of what is still no jump, so that angles and lengths can be compared.
    i, j = np.unravel_index(np.argmax(steps / least), steps.shape)
    scale, unit = robot.joints[j].kind.shown
    lines = table.rows[i][0], table.rows[i + 1][0]
    return (
        f"{int(jumps.sum())} jump{'s' if jumps.sum() > 1 else ''} between consecutive points; the "
        f"largest from line {lines[0]} to line {lines[1]}, where {robot.joint_names[j]} moves by "
        f"{scale * steps[i, j]:.4g}{unit}",
    )
