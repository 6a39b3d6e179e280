"""Loads from one side: a joint that may turn together with the load brings them there.

In: a space and load cases of it. Out: load cases of the same information and margins whose loads
lie in one half plane that ends at the axis of that joint, or as near as its limits allow.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.symmetry import same_worth
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture
from elastocal.robot.rotations import frame_about, from_rotation_vectors
from elastocal.study.experiment_space import LoadCaseSpace

_TRIED = (0.7, -2.0)  # turns that must change nothing [rad]: no fraction of a circle
_ALONG = 1e-9  # share of a load across an axis below which it is along it
_TIE = 1e-9  # angles [rad], and shares of a load, that count as equal


def from_one_side(
    space: LoadCaseSpace, cases: LoadCases, free: tuple[str, ...]
) -> tuple[LoadCases, str]:
    """The same experiments with all loads at one azimuth about a joint that may turn with them.

    Turning the first joint and the load by the same angle turns all that is measured. Whether that
    is a symmetry is tried, not presumed: a tracker, a wall or a rope of fixed direction breaks it;
    so does weight across the axis, though only beyond the linear model.
    The joint keeps its limits and stays as near to its rest position as it can.

    Args:
        space: Where the load cases are from.
        cases: N load cases.
        free: Joints known to change nothing even without the load.

    Returns:
        The load cases, and the name of the joint; the same and "" if there is none.

    Source: ours; A(q1 + δ, R_δ w) = R_δ A(q1, w).
    """
    for j, joint in enumerate(space.arm.robot.joints):
        held = space.limits[0, j] == space.limits[1, j]
        axis = _fixed_axis(space.arm.robot, cases.q, j)
        leads = any(follower.leader == joint.name for follower in space.arm.robot.followers)
        weighs = axis is not None and (_weighs(space, axis) or (leads and space.arm.sags))
        if joint.prismatic or held or joint.name in free or axis is None or weighs:
            continue
        turns = [_turned(cases, j, axis, np.full(len(cases), turn)) for turn in _TRIED]
        if all(same_worth(space, cases, turned, j) for turned in turns):
            return _gathered(space, cases, j, axis), joint.name
    return cases, ""


def azimuth_range(robot: Robot, cases: LoadCases, name: str) -> float:
    """Over which angle about the axis of a joint the loads of load cases spread [rad]."""
    joint = robot.joint_names.index(name)
    axis = _fixed_axis(robot, cases.q, joint)
    azimuth = np.array([]) if axis is None else azimuths(axis, cases.wrench)
    azimuth = np.sort(azimuth[np.isfinite(azimuth)])
    if not len(azimuth):
        return 0.0
    gaps = np.diff(azimuth, append=azimuth[0] + 2.0 * np.pi)
    return float(max(2.0 * np.pi - gaps.max(), 0.0))


def azimuths(axis: Array, wrench: Array) -> Array:
    """(N,) where about an axis (3,) wrenches (N, 6) point [rad]; NaN where they are along it.

    The force says so, and the moment where there is no force across the axis.
    """
    x, y, _ = frame_about(axis).T
    azimuth = np.full(len(wrench), np.nan)
    for vectors in (wrench[:, 3:], wrench[:, :3]):
        u, v = vectors @ x, vectors @ y
        across = np.hypot(u, v) > _ALONG * np.linalg.norm(vectors, axis=1)
        azimuth[across] = np.arctan2(v, u)[across]
    return azimuth


def _fixed_axis(robot: Robot, q: Array, joint: int) -> Array | None:
    """(3,) axis of a joint in the base frame; None if it depends on the configuration."""
    axes = Posture(robot, q).axes[:, joint]
    return axes[:, 0] if np.abs(axes - axes[:, :1]).max() <= _TIE else None


def _weighs(space: LoadCaseSpace, axis: Array) -> bool:
    """Whether the arm sags otherwise when it is turned about an axis (3,)."""
    gravity = space.arm.gravity
    across = np.linalg.norm(np.cross(gravity, axis))
    return space.arm.sags and bool(across > _ALONG * np.linalg.norm(gravity))


def _turned(cases: LoadCases, joint: int, axis: Array, angles: Array) -> LoadCases:
    """A joint and the loads turned by (N,) angles about its axis."""
    q = np.array(cases.q)
    q[:, joint] += angles
    rotation = from_rotation_vectors(angles[:, None] * axis)
    force, moment = (
        np.einsum("nij,nj->ni", rotation, vectors)
        for vectors in (cases.wrench[:, :3], cases.wrench[:, 3:])
    )
    return LoadCases(q, np.hstack([force, moment]))


def _gathered(space: LoadCaseSpace, cases: LoadCases, joint: int, axis: Array) -> LoadCases:
    """A joint turned so that all loads come from one side, as near to rest as possible."""
    lower, upper = space.limits[:, joint]
    azimuth = azimuths(axis, cases.wrench)
    along = np.isnan(azimuth)  # such a load does not care
    at_zero = cases.q[~along, joint] - azimuth[~along]  # the joint with the load at azimuth zero
    goal = np.full(len(cases), np.clip(0.0, lower, upper))
    goal[~along] = min(
        (_placed(at_zero + side, lower, upper) for side in _sides(at_zero, lower, upper)),
        key=lambda placed: placed[:2],
    )[2]
    turned = _turned(cases, joint, axis, goal - cases.q[:, joint])
    q, wrench = np.array(turned.q), np.array(turned.wrench)
    q[:, joint] = goal  # exact at a limit
    wrench[along] = cases.wrench[along]
    for i in range(len(wrench)):  # the same load is the same to the last digit: no change of load
        close = np.abs(wrench[:i] - wrench[i]) <= _TIE * np.abs(wrench[i]).max()
        same = np.flatnonzero(close.all(axis=1))
        if len(same):
            wrench[i] = wrench[same[0]]
    return LoadCases(q, wrench)


def _sides(at_zero: Array, lower: float, upper: float) -> Array:
    """Azimuths of which one is the best for all: every local optimum is among them.

    An arc that holds all values of the joint has its ends next to each other on the circle; it is
    put around the rest position, around the middle of the range, or against one of its ends.
    """
    angles = np.sort(at_zero % (2.0 * np.pi))
    after = np.append(angles[1:], angles[0] + 2.0 * np.pi)
    middles = 0.5 * (angles + after) + np.pi  # of the arc from `after` on to `angles`
    rest, centre = np.clip(0.0, lower, upper), 0.5 * (lower + upper)
    sides = [rest - middles, centre - middles, lower - angles, upper - angles]
    return np.concatenate(sides)


def _placed(wanted: Array, lower: float, upper: float) -> tuple[float, float, Array]:
    """Angles beyond the limits and away from rest, and values (N,) for wanted ones (N,).

    Whole turns do not matter.
    """
    rest = float(np.clip(0.0, lower, upper))
    wanted = rest + np.remainder(wanted - rest + np.pi, 2.0 * np.pi) - np.pi
    options = wanted + 2.0 * np.pi * np.array([[0.0], [-1.0], [1.0]])
    values = np.clip(options, lower, upper)
    beyond, away = np.abs(options - values), np.abs(values - rest)
    # The nearest to rest of those that are inside, else the nearest to what is wanted.
    best = np.where(beyond <= _TIE, away, 1e3 + beyond).argmin(axis=0)
    columns = np.arange(len(wanted))
    chosen = values[best, columns]
    worst = float(beyond[best, columns].max())
    return (
        round(worst / _TIE) * _TIE,
        round(float(away[best, columns].max()) / _TIE) * _TIE,
        chosen,
    )
