"""What must be said of corrected configurations: limits, singular arms, rigid joints."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import joint_springs
from elastocal.elastic.tensors import against_the_load
from elastocal.errors import Doubt
from elastocal.robot.chain import Robot
from elastocal.robot.posture import jacobian

_NO_LOAD = 1e-6  # share of the largest joint load below which a joint is not loaded


def doubts(
    robot: Robot,
    q: Array,
    after: Array,
    stable: BoolArray,
    at_rest: BoolArray,
    damped: BoolArray,
    lost: Array,
) -> tuple[tuple[Doubt, ...], ...]:
    """What is odd at each of N points.

    Args:
        robot: The robot.
        q: (N, n) corrected configurations [rad or m].
        after: (N, 3) remaining error [m].
        stable: (N,) whether the loaded arm has a stable equilibrium there.
        at_rest: (N,) whether the search for it came to rest.
        damped: (N,) whether the arm is nearly singular.
        lost: (N, 6) twist that the joints cannot give to the tool there.
    """
    return tuple(
        (
            *_reached(robot, q[i], bool(stable[i]), bool(at_rest[i])),
            *([_singular(lost[i], after[i])] if damped[i] else []),
        )
        for i in range(len(q))
    )


def _reached(robot: Robot, q: Array, stable: bool, at_rest: bool) -> list[Doubt]:
    """Why a configuration (n,) cannot be driven."""
    if not stable:
        return [Doubt("gives-way")]
    if not at_rest:
        return [Doubt("not-at-rest")]
    if not np.isfinite(q).all():
        return [Doubt("rests-elsewhere")]
    return [
        Doubt(
            "beyond-limit",
            (joint.name,),
            numbers={"value": value, "limit": limit},
            unit=joint.kind.unit,
        )
        for joint, value in zip(robot.joints, q.tolist(), strict=True)
        for limit, over in ((joint.lower, joint.lower - value), (joint.upper, value - joint.upper))
        if over > 0.0
    ]


def _singular(lost: Array, after: Array) -> Doubt:
    """What the joints hardly do, of a unit twist (6,), and what remains of the error (3,)."""
    moves = bool(np.linalg.norm(lost[:3]) >= np.linalg.norm(lost[3:]))
    axis = lost[:3] if moves else lost[3:]
    axis = axis / np.linalg.norm(axis)
    if axis[np.argmax(np.abs(axis))] < 0.0:
        axis = -axis
    numbers = dict(zip("xyz", axis.tolist(), strict=True))
    rest = float(np.linalg.norm(after))
    if np.isfinite(rest):
        numbers["remaining"] = rest
    return Doubt("hardly-moves" if moves else "hardly-turns", numbers=numbers)


def notes(arm: ElasticArm, compliance: Array, cases: LoadCases, rows: int) -> tuple[Doubt, ...]:
    """What is to be said of all N load cases: what is taken as rigid, what is not restored."""
    found = _rigid_but_loaded(arm, cases)
    if negative := against_the_load(arm.springs, compliance):
        found.append(Doubt("wrong-side", negative))
    if held := tuple(
        name for name, value in zip(arm.springs.names, compliance, strict=True) if value == 0.0
    ):
        found.append(Doubt("taken-as-zero", held))
    if rows < 6:
        found.append(Doubt("position-only", numbers={"joints": len(arm.robot.joints)}))
    if not cases.wrench.any():
        found.append(Doubt("nothing-to-compensate"))
    return tuple(found)


def _rigid_but_loaded(arm: ElasticArm, cases: LoadCases) -> list[Doubt]:
    """Joints without a spring that the wrenches load."""
    robot = arm.robot
    columns = jacobian(robot, cases.q, arm.tool.load_point)
    load = np.abs(np.einsum("nrj,nr->nj", columns, cases.wrench)).max(axis=0, initial=0.0)
    sprung = set(arm.springs.joint.tolist())
    joints = ElasticArm(robot, joint_springs(robot), arm.tool.at_tcp)
    moved = np.linalg.norm(regressor(joints, cases), axis=1).max(axis=0, initial=0.0)
    return [
        Doubt(
            "rigid-but-loaded",
            (joint.name,),
            numbers={"load": float(load[j]), "moves": float(moved[j])},
            unit=joint.kind.load,
        )
        for j, joint in enumerate(robot.joints)
        if j not in sprung and load[j] > _NO_LOAD * load.max()
    ]
