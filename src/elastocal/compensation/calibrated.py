"""Compensation with a calibrated robot: its geometry and what it bends by, at once.

In: a calibrated robot, load cases of a task for the robot as drawn. Out: the joint values at which
the robot as it is, loaded with its own weight, a payload and the wrench of the task, has its tool
where the drawing has it; and what is expected to remain.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, BoolArray, frozen
from elastocal.calibration.arm_model import loaded_arm
from elastocal.calibration.calibrated_robot import CalibratedRobot
from elastocal.calibration.placed import TCP, Carried, carried_point, placed
from elastocal.compensation.compensate import SAME_PLACE, Compensation
from elastocal.compensation.doubts import doubts
from elastocal.compensation.loaded_inverse_kinematics import (
    loaded_arm_at,
    stable,
    task_rows,
    tcp_poses,
)
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.equilibrium import equilibrium
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.tensors import against_the_load
from elastocal.errors import Doubt
from elastocal.robot.chain import transform
from elastocal.robot.posture import forward_kinematics
from elastocal.squares import largest_likely, weights_of


def compensate_calibrated(
    calibrated: CalibratedRobot,
    cases: LoadCases,
    *,
    station: int = 0,
    mounting: int = 0,
    payload: int = -1,
    point: str = TCP,
) -> Compensation:
    """Joint values at which the calibrated robot has its tool where the robot as drawn would.

    What remains counts as the station sees it: where the base stands is uncertain, too, and what
    nothing can tell apart of base and robot makes no difference. With six joints or more position
    and orientation are restored, with fewer the position. A tool that is a centimetre or more from
    its drawing is taken as it was found: the drawing was of another one, or of none.

    Args:
        calibrated: The robot.
        cases: N load cases of the task: joint values for the robot as drawn, wrenches besides
            weights.
        station: Number of the station in whose frame the task is.
        mounting: Number of the mounting of the tool.
        payload: Number of what hangs on the flange, -1 for nothing.
        point: What is to be there: the TCP, or a reflector.

    Raises:
        InputError: no such reflector.

    Source: paper eqs. (14), (17), (20), with all that was calibrated in place of compliances.
    """
    carried = carried_point(calibrated, mounting, point)
    arm = _arm(calibrated, payload, carried)
    compliance = calibrated.compliances.compliance
    drawn = forward_kinematics(calibrated.model.robot, cases.q)
    turned = np.eye(3) if carried.elsewhere else carried.rotation
    target = drawn @ transform(turned.T)
    target[:, :3, 3] = _at(drawn, carried.meant)
    q, found = loaded_arm_at(arm, compliance, cases, target, cases.q)
    finite = np.where(np.isfinite(q), q, cases.q)
    rest = equilibrium(arm, compliance, LoadCases(finite, cases.wrench))
    after = tcp_poses(arm, finite, stable(rest))[:, :3, 3] - target[:, :3, 3]
    good: BoolArray = np.asarray(
        (np.isfinite(after) & np.isfinite(q).all(axis=1, keepdims=True)).all(axis=1)
    )
    there = np.linalg.norm(np.nan_to_num(after), axis=1) < SAME_PLACE
    converged = good & found.at_rest & (there | found.damped)
    q[~converged], after[~converged] = np.nan, np.nan
    loaded = tcp_poses(arm, cases.q, stable(equilibrium(arm, compliance, cases)))
    # What the robot as drawn is told, if its controller takes poses.
    command = np.full_like(target, np.nan)
    told = forward_kinematics(calibrated.model.robot, q[converged])
    command[converged] = told
    command[converged, :3, 3] = _at(told, carried.meant)
    standing = LoadCases(np.where(converged[:, None], q, cases.q), cases.wrench)
    rows = placed(
        calibrated, standing, carried, station=station, mounting=mounting, payload=payload
    ).rows
    covariance = rows @ calibrated.covariance @ rows.transpose(0, 2, 1)
    before = loaded[:, :3, 3] - target[:, :3, 3]
    model = replace(
        calibrated.compliances, model_error=float(np.sqrt(3.0)) * calibrated.noise[station].model
    )
    return Compensation(
        arm=arm,
        model=model,
        cases=cases,
        rule="calibrated",
        q=frozen(q),
        target=frozen(target),
        command=frozen(command),
        before=frozen(before),
        after=frozen(after),
        covariance=frozen(covariance),
        limit=_limit(calibrated, rows),
        floor=frozen(np.zeros(len(cases))),
        converged=frozen(converged, np.bool_),
        iterations=frozen(found.iterations, np.int64),
        damped=frozen(found.damped, np.bool_),
        doubts=doubts(arm.robot, q, after, good, found.at_rest, found.damped, found.lost),
        notes=(*_notes(arm, compliance, carried), *_no_better(before, covariance)),
        calibrated=True,
    )


def _arm(calibrated: CalibratedRobot, payload: int, carried: Carried) -> ElasticArm:
    """The calibrated arm with its tool and what hangs on it."""
    arm = loaded_arm(calibrated.model, calibrated.state, calibrated.robot, payload)
    return replace(arm, tool=replace(calibrated.model.tool.at_tcp, tcp=carried.point))


def _at(poses: Array, point: Array) -> Array:
    """(N, 3) a point of the flange in poses (N, 4, 4) of it [m]."""
    return np.asarray(poses[:, :3, :3] @ point + poses[:, :3, 3])


def _limit(calibrated: CalibratedRobot, rows: Array) -> float:
    """What the root mean square of the error left stays below with 95 % [m]."""
    form = np.einsum("nip,niq->pq", rows, rows) / len(rows)
    weight, _ = weights_of(form, calibrated.covariance)
    return largest_likely(weight, dof=calibrated.dof)


def _no_better(before: Array, covariance: Array) -> tuple[Doubt, ...]:
    """That what the calibration does not know is as much as what it corrects."""
    was = float(np.sqrt((before**2).sum(axis=1).mean()))
    left = float(np.sqrt(np.einsum("nii->n", covariance).mean()))
    if left < was:
        return ()
    return (Doubt("no-better", (), (), {"before": was, "after": left}, "m"),)


def _notes(arm: ElasticArm, compliance: Array, carried: Carried) -> tuple[Doubt, ...]:
    """What is to be said of all points."""
    found = []
    if negative := against_the_load(arm.springs, compliance):
        found.append(Doubt("wrong-side", negative))
    if task_rows(arm) < 6:
        found.append(Doubt("position-only", numbers={"joints": len(arm.robot.joints)}))
    if carried.elsewhere:
        off = float(np.linalg.norm(carried.point - carried.drawn))
        found.append(Doubt("tool-elsewhere", (carried.name,), numbers={"off": off}))
    if not carried.measured:
        found.append(Doubt("tcp-not-read", (carried.name,)))
    return tuple(found)
