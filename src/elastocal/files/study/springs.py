"""Springs that are not in a joint, as a section of files: link and base springs by name."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from typing import Literal

import numpy as np

from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.errors import InputError
from elastocal.files.sections import Section, fresh
from elastocal.files.values import FiniteVector, Name
from elastocal.files.yaml_lines import LocatedError, at
from elastocal.robot.chain import Robot, T_body_joint


class SpringFile(Section):
    """A spring of a link or of the base."""

    carried_by: Name
    type: Literal["revolute", "prismatic"] = "revolute"
    axis: FiniteVector
    origin_mm: FiniteVector = fresh(lambda: [0.0, 0.0, 0.0])


def extra_springs(section: Mapping[str, SpringFile], robot: Robot) -> dict[str, VirtualJoints]:
    """Springs that are not in a joint, one by one."""
    found = {}
    for name, entry in section.items():
        with at("springs", name):
            found[name] = _spring(name, entry, robot)
    return found


def _spring(name: str, entry: SpringFile, robot: Robot) -> VirtualJoints:
    if name in robot.joint_names:
        raise InputError(f"spring {name!r} has the name of a joint; choose another")
    carriers = ["base", *robot.way]
    if entry.carried_by not in carriers:
        raise LocatedError(
            ("carried_by",),
            f"spring {name!r}: no joint {entry.carried_by[:40]!r}; "
            f"expected one of {', '.join(carriers)}",
        )
    body = carriers.index(entry.carried_by)
    T = T_body_joint(robot, body)
    axis, origin = np.array(entry.axis), np.array(entry.origin_mm)
    length = float(np.linalg.norm(axis))
    if not length > 0.0:
        raise LocatedError(("axis",), f"axis of {name!r}: must not be zero")
    return VirtualJoints(
        names=(name,),
        body=np.array([body]),
        axis=(T[:3, :3] @ axis / length)[None],
        origin=(T[:3, :3] @ origin / 1e3 + T[:3, 3])[None],
        prismatic=np.array([entry.type == "prismatic"]),
    )


def in_chain_order(
    names: Mapping[str, object], extra: dict[str, VirtualJoints], robot: Robot
) -> VirtualJoints:
    """The springs called `names`, of joints or `extra`, from the base to the flange."""
    each = [extra[n] if n in extra else joint_springs(robot, [n]) for n in names]
    return reduce(merged, each)
