"""A URDF of a robot that has none: joints, limits, what follows, masses; no shapes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.robot.chain import Follower, Joint, Robot, T_body_joint
from elastocal.robot.sinks.urdf_words import element, opened, pose_words, words_of

BASE, FLANGE = "base_link", "flange"
"""Names of the first and the last link."""
_UNKNOWN = "Inertia, effort and velocity are not known here and stand as 0."


def urdf_of(robot: Robot, extension: Sequence[str] = ()) -> str:
    """The text of a URDF.

    Args:
        robot: The robot; every link is called after the joint that moves it.
        extension: Lines that stand at its end, for readers that know them.

    Raises:
        InputError: a joint has limits that no URDF can say.
    """
    links = [BASE, *(f"{joint.name}_link" for joint in robot.moving)]
    if BASE in links[1:] or FLANGE in links:
        raise InputError(f"robot {robot.name!r}: rename the joint whose link would be a second one")
    follows = {follower.joint.name: follower for follower in robot.followers}
    lines = [opened("robot", name=robot.name), f"  <!-- {_UNKNOWN} -->"]
    lines += [line for body, name in enumerate(links) for line in _link(robot, body, name)]
    lines.append("  " + element("link", name=FLANGE))
    for body, joint in enumerate(robot.moving, 1):
        parent = links[int(robot.carriers[body])]
        lines += _joint(robot, joint, parent, links[body], follows.get(joint.name))
    lines += [
        "  " + opened("joint", name="to_flange", type="fixed"),
        "    " + element("origin", **pose_words(robot.T_tip_flange)),
        "    " + element("parent", link=links[robot.last]),
        "    " + element("child", link=FLANGE),
        "  </joint>",
    ]
    return "\n".join([*lines, *(f"  {line}" for line in extension), "</robot>", ""])


def _link(robot: Robot, body: int, name: str) -> list[str]:
    """A link with all masses of its body as one."""
    own = [mass for mass in robot.masses if mass.body == body and mass.mass > 0.0]
    if not own:
        return ["  " + element("link", name=name)]
    total = sum(mass.mass for mass in own)
    center = np.asarray(sum(mass.mass * mass.center for mass in own)) / total
    T: Array = np.asarray(np.linalg.inv(T_body_joint(robot, body)), dtype=np.float64)
    zeros = dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0")
    return [
        "  " + opened("link", name=name),
        "    <inertial>",
        "      " + element("origin", xyz=words_of(_at(T, center))),
        "      " + element("mass", value=words_of([total])),
        "      " + element("inertia", **zeros),
        "    </inertial>",
        "  </link>",
    ]


def _joint(
    robot: Robot, joint: Joint, parent: str, child: str, follows: Follower | None
) -> list[str]:
    lower, upper = joint.lower, joint.upper
    if follows is not None:
        leader = robot.joints[robot.index([follows.leader])[0]]
        ends = sorted(follows.factor * v + follows.offset for v in (leader.lower, leader.upper))
        lower, upper = ends if follows.factor else (follows.offset - 1e-6, follows.offset + 1e-6)
    endless = not (np.isfinite(lower) or np.isfinite(upper))
    kind = "prismatic" if joint.prismatic else "continuous" if endless else "revolute"
    if kind != "continuous" and not (np.isfinite(lower) and np.isfinite(upper)):
        raise InputError(
            f"joint {joint.name!r}: a URDF needs both limits of a joint that slides, and both or "
            f"none of one that turns; found {lower:g} to {upper:g}; give them in the study"
        )
    lines = [
        "  " + opened("joint", name=joint.name, type=kind),
        "    " + element("origin", **pose_words(joint.T_parent_joint)),
        "    " + element("parent", link=parent),
        "    " + element("child", link=child),
        "    " + element("axis", xyz=words_of(joint.axis)),
    ]
    if kind != "continuous":
        ends_of = {"lower": words_of([lower]), "upper": words_of([upper])}
        lines.append("    " + element("limit", **ends_of, effort="0", velocity="0"))
    if follows is not None:
        factor, offset = words_of([follows.factor]), words_of([follows.offset])
        lines.append(
            "    " + element("mimic", joint=follows.leader, multiplier=factor, offset=offset)
        )
    return [*lines, "  </joint>"]


def _at(T: Array, point: Array) -> Array:
    """(3,) a point in the frame that T leads to."""
    return np.asarray(T[:3, :3] @ point + T[:3, 3])
