"""Springs that are not in a joint, as a section of files: link and base springs by name."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import reduce
from typing import Any, Literal

import numpy as np
from pydantic import Field

from elastocal.arrays import Array
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.files.values import Name, Section, Vector
from elastocal.files.yaml_lines import LocatedError, Path_
from elastocal.robot.chain import Robot, T_body_joint


class SpringFile(Section):
    """A spring of a link or of the base."""

    carried_by: Name
    type: Literal["revolute", "prismatic"] = "revolute"
    axis: Vector
    origin_mm: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])


def springs_section(robot: Robot, springs: VirtualJoints) -> dict[str, Any]:
    """Where the springs sit that are not in a joint, in frames that files use."""
    section = {}
    for i in np.flatnonzero(springs.joint < 0):
        body = int(springs.body[i])
        own = np.linalg.inv(T_body_joint(robot, body))
        origin = own[:3, :3] @ springs.origin[i] + own[:3, 3]
        section[springs.names[i]] = {
            "carried_by": robot.joint_names[body - 1] if body else "base",
            "type": springs.kinds[i].name,
            "axis": [float(v) for v in own[:3, :3] @ springs.axis[i]],
            "origin_mm": [1e3 * float(v) for v in origin],
        }
    return section


def extra_springs(section: Any, robot: Robot) -> dict[str, VirtualJoints]:
    """Springs that are not in a joint, one by one."""
    if not isinstance(section, dict):
        raise LocatedError(("springs",), "springs must give a section for each spring, by name")
    found = {}
    for name, entry in section.items():
        where: Path_ = ("springs", name)
        if name in robot.joint_names:
            raise LocatedError(where, f"spring {name!r} has the name of a joint; choose another")
        keys = {"carried_by", "type", "axis", "origin_mm"}
        if not isinstance(entry, dict) or set(entry) - keys or "carried_by" not in entry:
            raise LocatedError(
                where, f"spring {name!r}: expected the keys {', '.join(sorted(keys))}"
            )
        carrier = entry["carried_by"]
        if carrier != "base" and carrier not in robot.joint_names:
            known = ", ".join(["base", *robot.joint_names])
            raise LocatedError(
                (*where, "carried_by"),
                f"spring {name!r}: no joint {short(carrier)!r}; expected one of {known}",
            )
        if entry.get("type", "revolute") not in ("revolute", "prismatic"):
            raise LocatedError(
                (*where, "type"), f"spring {name!r}: type must be revolute or prismatic"
            )
        body = 0 if carrier == "base" else robot.joint_names.index(carrier) + 1
        T = T_body_joint(robot, body)
        axis = vector(entry.get("axis"), (*where, "axis"), f"axis of {name!r}")
        length = float(np.linalg.norm(axis))
        if not length > 0.0:
            raise LocatedError((*where, "axis"), f"axis of {name!r}: must not be zero")
        origin = vector(entry.get("origin_mm", [0, 0, 0]), (*where, "origin_mm"), "origin_mm")
        found[str(name)] = VirtualJoints(
            names=(str(name),),
            body=np.array([body]),
            axis=(T[:3, :3] @ axis / length)[None],
            origin=(T[:3, :3] @ origin / 1e3 + T[:3, 3])[None],
            prismatic=np.array([entry.get("type") == "prismatic"]),
        )
    return found


def vector(value: Any, where: Path_, what: str) -> Array:
    """(3,) finite numbers of a file.

    Raises:
        LocatedError: anything else.
    """
    if not isinstance(value, list) or len(value) != 3:
        raise LocatedError(where, f"{what}: expected [x, y, z], found {short(value)}")
    return np.array([number_at(entry, where, what) for entry in value])


def in_chain_order(
    names: Mapping[str, object], extra: dict[str, VirtualJoints], robot: Robot
) -> VirtualJoints:
    """The springs called `names`, of joints or `extra`, from the base to the flange."""
    each = [extra[n] if n in extra else joint_springs(robot, [n]) for n in names]
    return reduce(merged, each)


def number_at(value: Any, where: Path_, what: str) -> float:
    """A finite number of a file.

    Raises:
        LocatedError: anything else.
    """
    if isinstance(value, str) and re.fullmatch(r"[-+]?\d+(\.\d*)?[eE][-+]?\d+", value):
        value = float(value)  # YAML 1.1 reads 1e-8 as text
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not abs(value) < 1e30:
        raise LocatedError(where, f"{what}: expected a finite number, found {short(value)}")
    return float(value)


def short(value: Any) -> str:
    """As much of a value as a message can hold."""
    return str(value)[:40]
