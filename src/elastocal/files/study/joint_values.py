"""Joint values in files: by joint name, angles in degrees and distances in millimetres."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.files.yaml_lines import LocatedError
from elastocal.robot.chain import Robot


def configuration(
    robot: Robot,
    degrees: dict[str, float] | list[float] | None,
    mm: dict[str, float] | None,
    *,
    keys: tuple[str, str] = ("q_deg", "q_mm"),
) -> Array:
    """(n,) joint vector [rad or m] of values by joint name; `keys` are those of the file.

    Raises:
        InputError: a joint is missing, unknown, or in the wrong unit.
    """
    angles, slides = keys
    if isinstance(degrees, list):
        if robot.prismatic.any():
            raise LocatedError(
                (angles,), f"the robot has sliding joints: give {angles} and {slides} by name"
            )
        if len(degrees) != len(robot.joints):
            raise LocatedError(
                (angles,),
                f"{angles} needs {len(robot.joints)} angles ({', '.join(robot.joint_names)}), "
                f"found {len(degrees)}",
            )
        return np.radians(degrees)
    values = {angles: degrees or {}, slides: mm or {}}
    for key, entries in values.items():
        for name in entries:
            if name not in robot.joint_names:
                raise LocatedError(
                    (key, name), f"no joint {name!r}; the joints are {', '.join(robot.joint_names)}"
                )
            if robot.joints[robot.joint_names.index(name)].prismatic != (key == slides):
                right = angles if key == slides else slides
                raise LocatedError((key, name), f"joint {name!r} belongs under {right}")
    q = []
    for joint in robot.joints:
        key = slides if joint.prismatic else angles
        if joint.name not in values[key]:
            raise LocatedError((key,), f"joint {joint.name!r} has no value in {key}")
        q.append(values[key][joint.name] * (1e-3 if joint.prismatic else np.pi / 180.0))
    return np.array(q)
