"""Joint values in files: by joint name, angles in degrees and distances in millimetres."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.io.yaml_lines import LocatedError
from elastocal.robot import Robot


def configuration(
    robot: Robot, degrees: dict[str, float] | list[float] | None, mm: dict[str, float] | None
) -> Array:
    """(n,) joint vector [rad or m] of values by joint name.

    Raises:
        InputError: a joint is missing, unknown, or in the wrong unit.
    """
    if isinstance(degrees, list):
        if robot.prismatic.any():
            raise LocatedError(
                ("q_deg",), "the robot has sliding joints: give q_deg and q_mm by name"
            )
        if len(degrees) != len(robot.joints):
            raise LocatedError(
                ("q_deg",),
                f"q_deg needs {len(robot.joints)} angles ({', '.join(robot.joint_names)}), found "
                f"{len(degrees)}",
            )
        return np.radians(degrees)
    values = {"q_deg": degrees or {}, "q_mm": mm or {}}
    for key, entries in values.items():
        for name in entries:
            if name not in robot.joint_names:
                raise LocatedError(
                    (key, name), f"no joint {name!r}; the joints are {', '.join(robot.joint_names)}"
                )
            if robot.joints[robot.joint_names.index(name)].prismatic != (key == "q_mm"):
                right = "q_deg" if key == "q_mm" else "q_mm"
                raise LocatedError((key, name), f"joint {name!r} belongs under {right}")
    q = []
    for joint in robot.joints:
        key = "q_mm" if joint.prismatic else "q_deg"
        if joint.name not in values[key]:
            raise LocatedError((key,), f"joint {joint.name!r} has no value in {key}")
        q.append(values[key][joint.name] * (1e-3 if joint.prismatic else np.pi / 180.0))
    return np.array(q)
