"""The elements of a URDF, each number of which is checked and named with its line.

In: a file from anywhere. Out: links and joints with the elements and numbers that this program
uses, and remarks on what was left out. What concerns the chain is in `urdf_tree.py`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array
from elastocal.names import flaw
from elastocal.robot.shapes import DIMENSIONS, Shape
from elastocal.robot.sources.xml_tree import Node, parse_xml

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_LIMITED = ("revolute", "prismatic")
_ALONG_AN_AXIS = (*_LIMITED, "continuous")
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?", re.ASCII)
_LARGEST, _LONGEST = 1e30, 64
_HUGE = 50.0  # size of a shape [m] that is probably millimetres


class Follows(NamedTuple):
    """What a joint mimics, as written; the leader is empty if it moves on its own."""

    leader: str = ""
    factor: float = 1.0
    offset: float = 0.0


Color = tuple[float, ...]


@dataclass(frozen=True)
class UrdfLink:
    """A link.

    Attributes:
        name: Its name.
        mass: Mass [kg].
        T_link_mass: (4, 4) where its centre is [m].
        shapes: Its "visual" and "collision" shapes in its frame; the files of meshes are not
            looked for yet.
    """

    name: str
    mass: float
    T_link_mass: Array
    shapes: Mapping[str, tuple[Shape, ...]]


@dataclass(frozen=True)
class UrdfJoint:
    """A joint.

    Attributes:
        name: Its name.
        type: One of `JOINT_TYPES`.
        parent: Link that carries it.
        child: Link that it carries.
        T_parent_child: (4, 4) with the joint at zero [m].
        axis: (3,) as written.
        lower: Lower limit [rad or m], None if not given.
        upper: Upper limit, likewise.
        soft: (lower, upper) of its safety controller [rad or m], None if not given.
        follows: Joint that it mimics, and how.
        at: "arm.urdf, line 12: joint 'J2'", for the beginning of a message.
    """

    name: str
    type: str
    parent: str
    child: str
    T_parent_child: Array
    axis: Array
    lower: float | None
    upper: float | None
    soft: tuple[float, float] | None
    follows: Follows
    at: str


@dataclass
class Urdf:
    """A checked URDF.

    Attributes:
        where: The file, for messages.
        name: Name of the robot, empty if it has none.
        palette: Colours of its materials by name.
        links: Its links.
        joints: Its joints.
        remarks: What was left out.
    """

    where: str
    name: str = ""
    palette: dict[str, Color] = field(default_factory=dict)
    links: list[UrdfLink] = field(default_factory=list)
    joints: list[UrdfJoint] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def read_elements(data: bytes, where: str) -> Urdf:
    """A URDF from anywhere, checked.

    Raises:
        InputError: it is wrong; the message names the line.
    """
    root = parse_xml(data, where)
    if root.tag != "robot":
        raise root.error(f"expected a URDF, which begins with <robot>, found <{root.tag}>")
    for node in _walk(root):
        if node.tag.startswith("xacro:"):
            raise node.error(f"<{node.tag}> is xacro; give the file a name that ends in .xacro")
    urdf = Urdf(where, _visible(root, "name", root.attributes.get("name", "").strip()))
    for node in root.all("material"):
        urdf.palette |= _colors(node)
    urdf.palette.pop("", None)
    names: set[str] = set()
    urdf.links += [_link(urdf, node, _name(node, names)) for node in root.all("link")]
    if not names:
        raise root.error("the robot has no links")
    _read_joints(urdf, root, names)
    return urdf


def _link(urdf: Urdf, node: Node, name: str) -> UrdfLink:
    mass, pose = 0.0, np.eye(4)
    for inertial in _at_most_one(node, "inertial"):
        element = _one(inertial, "mass", name)
        mass = float(_numbers(element, "value", 1)[0])
        if mass < 0.0:
            written = element.attributes["value"].strip()
            raise element.error(f"link {name!r} has mass {written}")
        pose = _pose(inertial)
    shapes = {
        kind: tuple(shape for inner in node.all(kind) for shape in _shapes(urdf, inner, name))
        for kind in ("visual", "collision")
    }
    return UrdfLink(name, mass, pose, shapes)


def _read_joints(urdf: Urdf, root: Node, links: set[str]) -> None:
    names: set[str] = set()
    parents: dict[str, str] = {}
    for node in root.all("joint"):
        name = _name(node, names)
        kind = node.attributes.get("type", "")
        if kind not in JOINT_TYPES:
            raise node.error(
                f"joint {name!r} has type {kind!r}; expected one of {', '.join(JOINT_TYPES)}"
            )
        ends = []
        for end in ("parent", "child"):
            ends.append(_attribute(_one(node, end, name), "link"))
            if ends[-1] not in links:
                raise node.error(f"joint {name!r}: {end} link {ends[-1]!r} is not there")
        parent, child = ends
        if child in parents:
            raise node.error(
                f"link {child!r} is the child of two joints, {parents[child]!r} and {name!r}; "
                "closed loops are not supported"
            )
        parents[child] = name
        pose, axis, follows = _pose(node), np.array([1.0, 0.0, 0.0]), Follows()
        limits: dict[str, float] = {}
        # What means nothing for a joint of this type is not looked at.
        for inner in _at_most_one(node, "axis") if kind in _ALONG_AN_AXIS else ():
            axis = _numbers(inner, "xyz", 3)
        for inner in _at_most_one(node, "limit") if kind in _LIMITED else ():
            given = _given(inner, ("lower", "upper"), 1)
            limits = {key: float(value[0]) for key, value in given.items()}
        soft = None
        for inner in _at_most_one(node, "safety_controller") if kind in _LIMITED else ():
            keys = ("soft_lower_limit", "soft_upper_limit")
            given = _given(inner, keys, 1)
            if given:
                soft = (float(given.get(keys[0], [0.0])[0]), float(given.get(keys[1], [0.0])[0]))
        for inner in _at_most_one(node, "mimic") if kind in _ALONG_AN_AXIS else ():
            given = _given(inner, ("multiplier", "offset"), 1)
            numbers = {key: float(value[0]) for key, value in given.items()}
            leader = _attribute(inner, "joint")
            follows = Follows(leader, numbers.get("multiplier", 1.0), numbers.get("offset", 0.0))
        at = f"{node.place}: joint {name!r}"
        lower, upper = limits.get("lower"), limits.get("upper")
        urdf.joints.append(
            UrdfJoint(name, kind, parent, child, pose, axis, lower, upper, soft, follows, at)
        )


def _shapes(urdf: Urdf, node: Node, link: str) -> Iterator[Shape]:
    """The shape of a visual or collision; none if it is left out."""
    geometry = _one(node, "geometry", link)
    if len(geometry.children) > 1:
        raise geometry.error(f"{link!r} has more than one shape in <geometry>, expected one")
    for solid in geometry.children:
        place, source = f"{solid.place}: <{solid.tag}> of link {link!r}", ""
        if solid.tag not in DIMENSIONS:
            urdf.remarks.append(f"{place} is left out: known are {', '.join(DIMENSIONS)}")
            return
        if solid.tag == "mesh":
            size = _given(solid, ("scale",), 3).get("scale", np.ones(3))
            source = _visible(solid, "filename", _attribute(solid, "filename"))
        elif solid.tag == "box":
            size = _numbers(solid, "size", 3)
        else:
            size = np.array([_numbers(solid, key, 1)[0] for key in DIMENSIONS[solid.tag]])
        if solid.tag != "mesh" and size.min() <= 0.0:
            urdf.remarks.append(f"{place} is left out: it has no size")
            return
        if solid.tag != "mesh" and node.tag == "visual" and size.max() > _HUGE:
            urdf.remarks.append(f"{place} measures {size.max():g} m; were millimetres meant?")
        pose = _pose(node)
        color: Color = ()
        for material in _at_most_one(node, "material"):
            own = _colors(material)
            name = material.attributes.get("name", "")
            color = (own or urdf.palette).get(name, ()) if node.tag == "visual" else ()
        yield Shape(solid.tag, size, pose, 0, link, source=source, color=color)


def _colors(node: Node) -> dict[str, Color]:
    """The colour of a material by its name, if it has one."""
    return {
        node.attributes.get("name", ""): tuple(_numbers(color, "rgba", 4).tolist())
        for color in _at_most_one(node, "color")
    }


def _pose(node: Node) -> Array:
    """(4, 4) pose that an element says with its origin, the identity if it has none [m].

    Rot_z(yaw) Rot_y(pitch) Rot_x(roll). Source: specification of URDF.
    """
    pose = np.eye(4)
    for origin in _at_most_one(node, "origin"):
        given = _given(origin, ("xyz", "rpy"), 3)
        pose[:3, 3] = given.get("xyz", np.zeros(3))
        rpy = given.get("rpy", np.zeros(3)).tolist()
        (cr, cp, cy), (sr, sp, sy) = map(math.cos, rpy), map(math.sin, rpy)
        pose[0, :3] = cp * cy, sp * (sr * cy) - cr * sy, sp * (cr * cy) + sr * sy
        pose[1, :3] = cp * sy, sp * (sr * sy) + cr * cy, sp * (cr * sy) - sr * cy
        pose[2, :3] = -sp, cp * sr, cp * cr
    return pose


def _given(node: Node, keys: tuple[str, ...], count: int) -> dict[str, Array]:
    """Those of the attributes that are there, each of `count` numbers."""
    return {key: _numbers(node, key, count) for key in keys if key in node.attributes}


def _name(node: Node, names: set[str]) -> str:
    name = _visible(node, "name", _attribute(node, "name"))
    if name in names:
        raise node.error(f"two {node.tag}s are called {name!r}")
    names.add(name)
    return name


def _visible(node: Node, key: str, name: str) -> str:
    """A name as it is, if it may be one."""
    if wrong := flaw(name):
        raise node.error(f"{key!r} of <{node.tag}>: {wrong}")
    return name


def _one(node: Node, tag: str, name: str) -> Node:
    found = node.all(tag)
    if len(found) != 1:
        many = "no" if not found else f"{len(found)} elements"
        raise node.error(f"{name!r} has {many} <{tag}> in <{node.tag}>, expected one")
    return found[0]


def _at_most_one(node: Node, tag: str) -> list[Node]:
    """The element called `tag`, if there is one; which of several counts is not for us to say."""
    found = node.all(tag)
    if len(found) > 1:
        raise found[1].error(f"a second <{tag}> in <{node.tag}>, expected one at most")
    return found


def _attribute(node: Node, key: str) -> str:
    value = node.attributes.get(key, "").strip()
    if not value:
        raise node.error(f"<{node.tag}> has no {key!r}")
    return value


def _numbers(node: Node, key: str, count: int) -> Array:
    """(count,) finite numbers of an attribute."""
    words = _attribute(node, key).split()
    if len(words) != count:
        what = "a number" if count == 1 else f"{count} numbers with spaces between"
        hint = _hint(node.attributes[key])
        raise node.error(
            f"{key!r} of <{node.tag}> must be {what}, found {node.attributes[key][:40]!r}{hint}"
        )
    for word in words:
        plain = len(word) <= _LONGEST and _NUMBER.fullmatch(word)
        if not plain or not abs(float(word)) < _LARGEST:
            raise node.error(
                f"{key!r} of <{node.tag}> must be finite numbers, found {word[:40]!r}{_hint(word)}"
            )
    return np.array([float(word) for word in words])


def _hint(written: str) -> str:
    """What may be meant by a text that is no number."""
    if "${" in written or "$(" in written:
        return "; this is xacro, expanded in files that end in .xacro but not in arguments"
    return "; write the decimal point as '.'" if "," in written else ""


def _walk(node: Node) -> Iterator[Node]:
    yield node
    for child in node.children:
        yield from _walk(child)
