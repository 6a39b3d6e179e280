"""Tables of Denavit and Hartenberg from a robot of any source, classic or modified.

From axis to axis a robot is a screw about z, then one about x, in turn:

    T_base_first · Z₁ · X₁ · Z₂ · X₂ · … · T_last_flange,
    Z = Rot_z(theta + q) Trans_z(d),  X = Trans_x(a) Rot_x(alpha) Rot_y(beta).

A classic row has the screw about z and the X behind it, a modified one the X before it. beta is 0,
but where two axes are so nearly parallel that their common normal is far away: d would be many
metres there, and jump with every calibration. There X starts where the joint is drawn, with beta.

Source: Denavit & Hartenberg (1955); Craig, Introduction to Robotics, ch. 3; Hayati (1983).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.errors import InputError
from elastocal.robot.chain import Joint, Robot, transform
from elastocal.robot.posture import forward_kinematics
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.robot.sources.dh import DHRow

_CROSSING = 2e-2  # sine of the angle from which axes have a common normal worth the name
_LEAST = 1e-5  # sine below which its direction is rounding
_FAR = 0.1  # how far from where a joint is drawn its common normal may stand [m]
_FITS = 1e-11  # m and sine up to which a frame is where a row has it
_SAME = 1e-9  # how far a table may be from its robot [m]


@dataclass(frozen=True)
class DHTable:
    """A robot as a table.

    Attributes:
        rows: One row for each joint, from the base.
        beta: (n,) angle about y of each row, behind alpha [rad]; zero in a plain table.
        far: (n,) where it is not: how far along its axis the plain table would go to the common
            normal [m]; infinite for parallel axes that are skew.
        modified: Whether the x parameters of a row stand before its joint.
        T_base_first: (4, 4) what stands before the first row [m].
        T_last_flange: (4, 4) what stands behind the last one [m].
    """

    rows: tuple[DHRow, ...]
    beta: Array
    far: Array
    modified: bool
    T_base_first: Array
    T_last_flange: Array

    def __post_init__(self) -> None:
        freeze(self, "beta", "far", "T_base_first", "T_last_flange")

    @property
    def plain(self) -> bool:
        """Whether it needs no beta."""
        return not self.beta.any()


@dataclass(frozen=True)
class _Screw:
    """X: from a point of one axis to a point of the next."""

    start: Array
    end: Array
    x: Array
    """(3,) its direction, and the x axis behind it."""
    x_behind: Array
    a: float
    alpha: float
    beta: float = 0.0
    far: float = 0.0


def dh_table(robot: Robot, *, modified: bool, like: Robot | None = None) -> DHTable:
    """The table of a robot.

    Args:
        robot: The robot; no joint of its chain may follow another.
        modified: Craig's convention; else the classic one.
        like: A robot that is nearly the same: where a direction may be chosen, as that of a common
            normal, it is chosen as for this one.

    Raises:
        InputError: a joint of the chain follows another one.
    """
    if robot.follows:
        follower = next(name for name in robot.way if name not in robot.joint_names)
        raise InputError(
            f"robot {robot.name!r}: joint {follower!r} stands between base and flange and follows "
            "another one, which no table of Denavit and Hartenberg says; export it as URDF"
        )
    towards = None if like is None else [screw.x for screw in _screws(like, None)]
    axes, screws = _axes(robot), _screws(robot, towards)
    first, last = _first(axes[0], modified), _last(robot, axes[-1], modified)
    whole = [first[1], *screws, last[0]]
    rows, beta, far = [], [], []
    for i, joint in enumerate(robot.joints):
        before, behind = whole[i], whole[i + 1]
        z = axes[i][1]
        theta = float(
            np.arctan2(np.cross(before.x_behind, behind.x) @ z, before.x_behind @ behind.x)
        )
        d = float(z @ (behind.start - before.end))
        x = before if modified else behind
        rows.append(_row(joint, theta, d, x, axes[i][2]))
        beta.append(x.beta)
        far.append(x.far)
    return DHTable(tuple(rows), np.array(beta), np.array(far), modified, first[0], last[1])


def flange_of(table: DHTable, q: Sequence[float] | Array) -> Array:
    """(4, 4) pose of the flange by the rows of a table, at joint values (n,) [rad or m]."""
    T = np.array(table.T_base_first)
    for row, beta, value in zip(table.rows, table.beta.tolist(), q, strict=True):
        way = row.sign * float(value)
        z = transform(
            _turn(2, row.theta + (0.0 if row.prismatic else way)),
            (0.0, 0.0, row.d + (way if row.prismatic else 0.0)),
        )
        x = transform(_turn(0, row.alpha) @ _turn(1, beta), (row.a, 0.0, 0.0))
        T = T @ x @ z if table.modified else T @ z @ x
    return np.asarray(T @ table.T_last_flange)


def refuse_unlike(table: DHTable, robot: Robot) -> None:
    """Compare a table with its robot, in random configurations.

    Raises:
        InputError: they differ by more than a nanometre, as with axes hundreds of metres away.
    """
    rng = np.random.default_rng(0)
    q = rng.uniform(
        np.maximum(robot.lower, -3.0), np.minimum(robot.upper, 3.0), (20, len(robot.joints))
    )
    apart = max(
        float(np.abs(flange_of(table, one) - T).max())
        for one, T in zip(q, forward_kinematics(robot, q), strict=True)
    )
    if not apart < _SAME:
        raise InputError(
            f"robot {robot.name!r}: its table would be {1e6 * apart:.2g} µm off; export it as URDF"
        )


def _row(joint: Joint, theta: float, d: float, x: _Screw, sign: float) -> DHRow:
    return DHRow(
        joint.name, theta, d, x.a, x.alpha, joint.prismatic, sign, joint.lower, joint.upper
    )


def _axes(robot: Robot) -> list[tuple[Array, Array, float]]:
    """Where each joint is drawn, its z, and its sense about it; at zero, in the base frame."""
    T, found = np.eye(4), []
    for joint in robot.joints:
        T = T @ joint.T_parent_joint
        along = float(joint.axis[2])
        own = abs(along) > 1.0 - 1e-12  # z of its own frame, as tables have it
        z = T[:3, 2] if own else T[:3, :3] @ joint.axis
        found.append((T[:3, 3], z, float(np.sign(along)) if own else 1.0))
    return found


def _screws(robot: Robot, towards: Sequence[Array] | None) -> list[_Screw]:
    """The X between the axes."""
    axes, found = _axes(robot), []
    x_before = _across(np.eye(3)[0], np.eye(3)[1], axes[0][1])
    for i, ((point, z, _), (other, z_next, _)) in enumerate(pairwise(axes)):
        screw = _between(point, z, other, z_next, _x_of(robot, i, z))
        turned = float(screw.x @ (x_before if towards is None else towards[i]))
        if abs(turned) < 1e-2 and towards is None:  # a right angle: either will do
            turned = screw.a if abs(screw.a) > 1e-4 else float(np.cross(x_before, screw.x) @ z)
        if turned < 0.0:
            screw = _between(point, z, other, z_next, _x_of(robot, i, z), -screw.x)
        found.append(screw)
        x_before = screw.x_behind
    return found


def _x_of(robot: Robot, i: int, z: Array) -> Array:
    """A direction across an axis where no other is better: x of the frame the joint is drawn in."""
    T = np.eye(4)
    for joint in robot.joints[: i + 1]:
        T = T @ joint.T_parent_joint
    return _across(T[:3, 0], T[:3, 1], z)


def _between(
    point: Array, z: Array, other: Array, z_next: Array, else_: Array, x: Array | None = None
) -> _Screw:
    """X from one axis to the next; `x` is its direction, if that is known but for rounding."""
    normal, apart = np.cross(z, z_next), other - point
    sine = float(np.linalg.norm(normal))
    along, along_next = 0.0, 0.0
    if sine > _LEAST:
        along = float(np.cross(apart, z_next) @ normal) / sine**2
        along_next = float(np.cross(apart, z) @ normal) / sine**2
    near = sine > _LEAST and max(abs(along), abs(along_next)) < _FAR
    if sine >= _CROSSING or near:
        x = normal / sine if x is None else x
        alpha = float(np.arctan2(normal @ x, z @ z_next))
        start, end = point + along * z, other + along_next * z_next
        return _Screw(start, end, x, x, float(x @ apart), alpha)
    # Nearly parallel: from where the joint is drawn straight across to the next axis.
    end = other + z_next * float(z @ (point - other)) / float(z @ z_next)
    across = end - point
    size = float(np.linalg.norm(across))
    if x is None:
        x = across / size if size > 1e-10 else else_
    local = np.column_stack([x, np.cross(z, x), z]).T @ z_next
    beta = float(np.arcsin(np.clip(local[0], -1.0, 1.0)))
    alpha = float(np.arctan2(-local[1], local[2]))
    if abs(beta) < 1e-13:
        beta = 0.0
    frame = np.column_stack([x, np.cross(z, x), z]) @ _turn(0, alpha) @ _turn(1, beta)
    far = 0.0 if not beta else max(abs(along), abs(along_next)) or np.inf
    return _Screw(point, end, x, frame[:, 0], float(x @ across), alpha, beta, far)


def _first(axis: tuple[Array, Array, float], modified: bool) -> tuple[Array, _Screw]:
    """What stands before the first row, and the X with which a modified table begins."""
    point, z, _ = axis
    x = np.eye(3)[0]
    if modified and abs(x @ z) < _FITS:
        a = float(point[0])
        end = np.array([a, 0.0, 0.0])
        if np.linalg.norm(np.cross(end - point, z)) < _FITS:
            return np.eye(4), _Screw(np.zeros(3), end, x, x, a, float(np.arctan2(-z[1], z[2])))
    x = _across(x, np.eye(3)[1], z)
    foot = point - (point @ z) * z
    T = transform(np.column_stack([x, np.cross(z, x), z]), foot)
    return T, _Screw(foot, foot, x, x, 0.0, 0.0)


def _last(robot: Robot, axis: tuple[Array, Array, float], modified: bool) -> tuple[_Screw, Array]:
    """The X with which a classic table ends, and what stands behind the last row."""
    point, z, _ = axis
    flange = np.eye(4)
    for joint in robot.joints:
        flange = flange @ joint.T_parent_joint
    flange = flange @ robot.T_tip_flange
    x, origin = flange[:3, 0], flange[:3, 3]
    if not modified and abs(x @ z) < _FITS:
        a = float(x @ (origin - point))
        start = origin - a * x
        if np.linalg.norm(np.cross(start - point, z)) < _FITS:
            alpha = float(np.arctan2(np.cross(z, flange[:3, 2]) @ x, z @ flange[:3, 2]))
            return _Screw(start, origin, x, x, a, alpha), np.eye(4)
    x = _across(x, flange[:3, 1], z)
    foot = point + ((origin - point) @ z) * z
    T = transform(np.column_stack([x, np.cross(z, x), z]), foot)
    return _Screw(foot, foot, x, x, 0.0, 0.0), np.asarray(np.linalg.inv(T) @ flange)


def _across(x: Array, y: Array, z: Array) -> Array:
    """A unit vector across z: x as far as that goes, else y."""
    for one in (x, y):
        across = one - (one @ z) * z
        size = float(np.linalg.norm(across))
        if size > 0.1:
            return np.asarray(across / size)
    raise AssertionError("two of three axes are across any direction")


def _turn(axis: int, angle: float) -> Array:
    """(3, 3) rotation about a coordinate axis."""
    return from_rotation_vectors(np.eye(3)[axis : axis + 1] * angle)[0]
