"""The text of a URDF, checked element by element and written anew for the library that reads it.

In: a file from anywhere. Out: a plain URDF with only the elements and numbers this program uses,
and where each joint stood. The library that reads it is lenient and tells no lines, so everything
local is checked here; what concerns the chain is in `urdf_tree.py`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.etree import ElementTree as ET

from elastocal.errors import InputError
from elastocal.robot.shapes import DIMENSIONS
from elastocal.robot.sources.xml_tree import Node, parse_xml

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?", re.ASCII)
_LARGEST, _LONGEST = 1e30, 64
_HUGE = 50.0  # size of a shape [m] that is probably millimetres


@dataclass
class UrdfText:
    """A checked URDF.

    Attributes:
        where: The file, for messages.
        name: Name of the robot, empty if it has none.
        data: Plain XML, safe to hand on.
        lines: Line of each joint by its name.
        mimics: Joints that follow another one, and which.
        remarks: What was left out.
    """

    where: str
    name: str = ""
    data: bytes = b""
    lines: dict[str, int] = field(default_factory=dict)
    mimics: dict[str, str] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def at(self, joint: str) -> str:
        """'arm.urdf, line 12: joint 'J2'' for the beginning of a message."""
        return f"{self.where}, line {self.lines[joint]}: joint {joint!r}"


def checked(data: bytes, where: str) -> UrdfText:
    """A URDF from anywhere, checked and written anew.

    Raises:
        InputError: it is wrong; the message names the line.
    """
    root = parse_xml(data, where)
    if root.tag != "robot":
        raise _error(where, root, f"expected a URDF, which begins with <robot>, found <{root.tag}>")
    for node in _walk(root):
        if node.tag.startswith("xacro:"):
            raise _error(
                where, node, f"<{node.tag}> is xacro; give the file a name that ends in .xacro"
            )
    text = UrdfText(where, root.attributes.get("name", "").strip())
    plain = ET.Element("robot", name=text.name)
    links = _links(text, root, plain)
    _joints(text, root, plain, links)
    for node in root.all("material"):
        _material(text, node, plain)
    text.data = ET.tostring(plain, encoding="utf-8")
    return text


def _links(text: UrdfText, root: Node, plain: ET.Element) -> set[str]:
    names: set[str] = set()
    for node in root.all("link"):
        name = _name(text, node, names)
        link = ET.SubElement(plain, "link", name=name)
        for inertial in node.all("inertial")[:1]:
            _inertial(text, inertial, link)
        for kind in ("visual", "collision"):
            for shape in node.all(kind):
                _shape(text, shape, link, name)
    if not names:
        raise _error(text.where, root, "the robot has no links")
    return names


def _joints(text: UrdfText, root: Node, plain: ET.Element, links: set[str]) -> None:
    names: set[str] = set()
    parents: dict[str, str] = {}
    for node in root.all("joint"):
        name = _name(text, node, names)
        text.lines[name] = node.line
        kind = node.attributes.get("type", "")
        if kind not in JOINT_TYPES:
            raise _error(
                text.where,
                node,
                f"joint {name!r} has type {kind!r}; expected one of {', '.join(JOINT_TYPES)}",
            )
        joint = ET.SubElement(plain, "joint", name=name, type=kind)
        for end in ("parent", "child"):
            link = _attribute(text, _one(text, node, end, name), "link")
            if link not in links:
                raise _error(text.where, node, f"joint {name!r}: {end} link {link!r} is not there")
            ET.SubElement(joint, end, link=link)
            if end == "child" and link in parents:
                raise _error(
                    text.where,
                    node,
                    f"link {link!r} is the child of two joints, {parents[link]!r} and {name!r}; "
                    "closed loops are not supported",
                )
            if end == "child":
                parents[link] = name
        _origin(text, node, joint)
        for axis in node.all("axis")[:1]:
            ET.SubElement(joint, "axis", xyz=_numbers(text, axis, "xyz", 3))
        for limit in node.all("limit")[:1]:
            ET.SubElement(joint, "limit", _given(text, limit, ("lower", "upper"), 1))
        for mimic in node.all("mimic")[:1]:
            text.mimics[name] = _attribute(text, mimic, "joint")


def _inertial(text: UrdfText, node: Node, link: ET.Element) -> None:
    mass = _one(text, node, "mass", link.attrib["name"])
    value = _numbers(text, mass, "value", 1)
    if float(value) < 0.0:
        raise _error(text.where, mass, f"link {link.attrib['name']!r} has mass {value}")
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "mass", value=value)
    _origin(text, node, inertial)


def _shape(text: UrdfText, node: Node, link: ET.Element, name: str) -> None:
    """A visual or collision; its name in the new text is the kind of its shape."""
    for solid in _one(text, node, "geometry", name).children[:1]:
        if solid.tag not in DIMENSIONS:
            known = f"known are {', '.join(DIMENSIONS)}"
            text.remarks.append(_left_out(text, solid, name, known))
            return
        if solid.tag == "mesh":
            given = _given(text, solid, ("scale",), 3)
            given["filename"] = _attribute(text, solid, "filename")
        elif solid.tag == "box":
            given = {"size": _numbers(text, solid, "size", 3)}
        else:
            given = {key: _numbers(text, solid, key, 1) for key in DIMENSIONS[solid.tag]}
        sizes = [float(word) for key in given if key != "filename" for word in given[key].split()]
        if solid.tag != "mesh" and min(sizes) <= 0.0:
            text.remarks.append(_left_out(text, solid, name, "it has no size"))
            return
        if solid.tag != "mesh" and max(sizes) > _HUGE:
            text.remarks.append(
                f"{text.where}, line {solid.line}: <{solid.tag}> of link {name!r} measures "
                f"{max(sizes):g} m; were millimetres meant?"
            )
        shape = ET.SubElement(link, node.tag, name=solid.tag)
        _origin(text, node, shape)
        geometry = ET.SubElement(shape, "geometry")
        ET.SubElement(geometry, "cylinder" if solid.tag == "capsule" else solid.tag, given)
        for material in node.all("material")[:1]:
            _material(text, material, shape)


def _left_out(text: UrdfText, solid: Node, link: str, why: str) -> str:
    return f"{text.where}, line {solid.line}: <{solid.tag}> of link {link!r} is left out: {why}"


def _material(text: UrdfText, node: Node, parent: ET.Element) -> None:
    material = ET.SubElement(parent, "material", name=node.attributes.get("name", ""))
    for color in node.all("color")[:1]:
        ET.SubElement(material, "color", rgba=_numbers(text, color, "rgba", 4))


def _origin(text: UrdfText, node: Node, plain: ET.Element) -> None:
    for origin in node.all("origin")[:1]:
        ET.SubElement(plain, "origin", _given(text, origin, ("xyz", "rpy"), 3))


def _given(text: UrdfText, node: Node, keys: tuple[str, ...], count: int) -> dict[str, str]:
    """Those of the attributes that are there, each of `count` numbers."""
    return {key: _numbers(text, node, key, count) for key in keys if key in node.attributes}


def _name(text: UrdfText, node: Node, names: set[str]) -> str:
    name = _attribute(text, node, "name")
    if name in names:
        raise _error(text.where, node, f"two {node.tag}s are called {name!r}")
    names.add(name)
    return name


def _one(text: UrdfText, node: Node, tag: str, name: str) -> Node:
    found = node.all(tag)
    if len(found) != 1:
        many = "no" if not found else f"{len(found)} elements"
        raise _error(text.where, node, f"{name!r} has {many} <{tag}> in <{node.tag}>, expected one")
    return found[0]


def _attribute(text: UrdfText, node: Node, key: str) -> str:
    value = node.attributes.get(key, "").strip()
    if not value:
        raise _error(text.where, node, f"<{node.tag}> has no {key!r}")
    return value


def _numbers(text: UrdfText, node: Node, key: str, count: int) -> str:
    """An attribute of `count` finite numbers, as plain text."""
    words = _attribute(text, node, key).split()
    if len(words) != count:
        what = "a number" if count == 1 else f"{count} numbers with spaces between"
        hint = "; write the decimal point as '.'" if "," in node.attributes[key] else ""
        raise _error(
            text.where,
            node,
            f"{key!r} of <{node.tag}> must be {what}, found {node.attributes[key][:40]!r}{hint}",
        )
    for word in words:
        plain = len(word) <= _LONGEST and _NUMBER.fullmatch(word)
        if not plain or not abs(float(word)) < _LARGEST:
            hint = "; write the decimal point as '.'" if "," in word else ""
            raise _error(
                text.where,
                node,
                f"{key!r} of <{node.tag}> must be finite numbers, found {word[:40]!r}{hint}",
            )
    return " ".join(words)


def _walk(node: Node) -> Iterator[Node]:
    yield node
    for child in node.children:
        yield from _walk(child)


def _error(where: str, node: Node, message: str) -> InputError:
    return InputError(f"{where}, line {node.line}: {message}")
