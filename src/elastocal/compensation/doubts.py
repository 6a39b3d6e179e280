"""What must be said of corrected configurations: limits, singular arms, rigid joints."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.robot.chain import Robot
from elastocal.robot.posture import jacobian

_NO_LOAD = 1e-6  # share of the largest joint load below which a joint is not loaded
_FEW = 1e-9  # remaining error not worth a number [m]


def remarks(
    robot: Robot,
    q: Array,
    after: Array,
    stable: BoolArray,
    at_rest: BoolArray,
    damped: BoolArray,
    lost: Array,
) -> tuple[str, ...]:
    """One sentence for each of N points, empty where nothing is odd.

    Args:
        robot: The robot.
        q: (N, n) corrected configurations [rad or m].
        after: (N, 3) remaining error [m].
        stable: (N,) whether the loaded arm has a stable equilibrium there.
        at_rest: (N,) whether the search for it came to rest.
        damped: (N,) whether the arm is nearly singular.
        lost: (N, 6) twist that the joints cannot give to the tool there.
    """
    sentences = []
    for i in range(len(q)):
        said = []
        if not stable[i]:
            said.append("no stable equilibrium: the arm gives way under the load")
        elif not at_rest[i]:
            said.append("the search for the corrected configuration did not come to rest")
        elif not np.isfinite(q[i]).all():
            said.append("the arm comes to rest elsewhere: the load is too large for it")
        else:
            said += limits(robot, q[i])
        if damped[i]:
            said.append(f"nearly singular: the joints hardly {direction(lost[i])}")
            rest = float(np.linalg.norm(after[i]))
            if np.isfinite(rest):
                said.append(f"{1e3 * rest:.3g} mm remain" if rest > _FEW else "no error remains")
        sentences.append("; ".join(said))
    return tuple(sentences)


def limits(robot: Robot, q: Array) -> list[str]:
    """A sentence for every joint of one configuration (n,) that is beyond its limits."""
    said = []
    for joint, value in zip(robot.joints, q, strict=True):
        scale, unit = joint.shown
        for limit, over in ((joint.lower, joint.lower - value), (joint.upper, value - joint.upper)):
            if over > 0.0:
                said.append(
                    f"{joint.name} would need {scale * value:.4f}{unit}, beyond its limit "
                    f"{scale * limit:.6g}{unit}"
                )
    return said


def direction(lost: Array) -> str:
    """What the joints hardly do, of a unit twist (6,): 'move the tool along [1 0 0]'."""
    moves = bool(np.linalg.norm(lost[:3]) >= np.linalg.norm(lost[3:]))
    axis = lost[:3] if moves else lost[3:]
    axis = axis / np.linalg.norm(axis)
    if axis[np.argmax(np.abs(axis))] < 0.0:
        axis = -axis
    shown = " ".join(f"{v:.3g}" for v in np.round(axis, 3) + 0.0)
    return f"{'move the tool along' if moves else 'turn the tool about'} [{shown}]"


def notes(arm: ElasticArm, compliance: Array, cases: LoadCases, rows: int) -> tuple[str, ...]:
    """Sentences on all N load cases: what is taken as rigid, what is not restored."""
    said = [
        f"{name} has no compliance in the model and is taken as rigid; the load turns it with up "
        f"to {load:.3g} {unit}"
        for name, load, unit in _rigid_but_loaded(arm, cases)
    ]
    negative = [n for n, k in zip(arm.springs.names, compliance, strict=True) if k < 0.0]
    if negative:
        said.append(
            f"{', '.join(negative)}: negative compliance, so its correction goes to the wrong "
            "side; identify again before a robot drives this"
        )
    count = len(arm.robot.joints)
    if rows < 6:
        said.append(
            f"the robot has {count} joints: the position of the tool is corrected, not its "
            "orientation"
        )
    if not cases.wrench.any():
        said.append("no load acts on the tool: there is nothing to compensate")
    return tuple(said)


def _rigid_but_loaded(arm: ElasticArm, cases: LoadCases) -> list[tuple[str, float, str]]:
    """Joints without a spring that the wrenches load: name, largest load, unit."""
    robot = arm.robot
    columns = jacobian(robot, cases.q, arm.tool.load_point)
    load = np.abs(np.einsum("nrj,nr->nj", columns, cases.wrench)).max(axis=0, initial=0.0)
    sprung = set(arm.springs.joint.tolist())
    return [
        (joint.name, float(load[j]), "N" if joint.prismatic else "N·m")
        for j, joint in enumerate(robot.joints)
        if j not in sprung and load[j] > _NO_LOAD * load.max()
    ]
