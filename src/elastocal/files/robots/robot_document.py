"""A calibrated robot as one JSON document for programs: joints, tables, and all that was found."""

from __future__ import annotations

from typing import Any

from elastocal import __version__
from elastocal.arrays import Array
from elastocal.calibration.calibrated_robot import CalibratedRobot
from elastocal.errors import InputError
from elastocal.files.models.calibration_writing import calibration_document, listed
from elastocal.robot.chain import Joint, Robot
from elastocal.robot.sinks.dh import DHTable, dh_table

KIND = "calibrated robot"


def robot_document(calibrated: CalibratedRobot) -> dict[str, Any]:
    """Joints with their frames [m, rad], tables where there are any, and the calibration whole."""
    robot = calibrated.robot
    follows = {f.joint.name: f for f in robot.followers}
    joints = []
    for body, joint in enumerate(robot.moving, 1):
        entry = _joint(joint)
        entry["carried_by"] = _carrier(robot, body)
        if joint.name in follows:
            one = follows[joint.name]
            entry["follows"] = {"joint": one.leader, "factor": one.factor, "offset": one.offset}
        joints.append(entry)
    return {
        "elastocal": 1,
        "kind": KIND,
        "made_by": f"elastocal {__version__}",
        "robot": robot.name,
        "units": "m, rad, kg, N and what is made of them; other units in the key",
        "joints": joints,
        "chain": list(robot.way),
        "T_tip_flange": _rows(robot.T_tip_flange),
        "dh": {
            "classic": _table(calibrated, modified=False),
            "modified": _table(calibrated, modified=True),
        },
        "calibration": calibration_document(calibrated),
    }


def _joint(joint: Joint) -> dict[str, Any]:
    return {
        "name": joint.name,
        "type": joint.kind.name,
        "T_parent_joint": _rows(joint.T_parent_joint),
        "axis": listed(joint.axis),
        "lower": float(joint.lower),
        "upper": float(joint.upper),
    }


def _carrier(robot: Robot, body: int) -> str:
    carrier = int(robot.carriers[body])
    return robot.moving[carrier - 1].name if carrier else "base"


def _table(calibrated: CalibratedRobot, *, modified: bool) -> dict[str, Any] | None:
    """The rows of a table, None where none says the robot."""
    try:
        found = dh_table(calibrated.robot, modified=modified, like=calibrated.model.robot)
    except InputError:
        return None
    return {
        "T_base_first": _rows(found.T_base_first),
        "rows": _dh_rows(found),
        "T_last_flange": _rows(found.T_last_flange),
    }


def _dh_rows(table: DHTable) -> list[dict[str, Any]]:
    return [
        {
            "joint": row.name,
            "sign": row.sign,
            "theta": row.theta,
            "d": row.d,
            "a": row.a,
            "alpha": row.alpha,
            "beta": beta,
        }
        for row, beta in zip(table.rows, table.beta.tolist(), strict=True)
    ]


def _rows(T: Array) -> list[list[float]]:
    return [listed(row) for row in T]
