"""A URDF with other origins of its joints, and everything else as it was written.

Meshes, limits, materials, comments, what other programs read: all of it stays, sign by sign. What
changes are the origins of joints between base and tip whose frames moved.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from xml.parsers import expat

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.robot.chain import Robot
from elastocal.robot.sinks.urdf_words import element, opened, pose_words
from elastocal.robot.sources.urdf_elements import UrdfJoint, read_elements
from elastocal.robot.sources.urdf_tree import Tree
from elastocal.robot.sources.xml_tree import decoded

_STILL = 1e-15  # by which a pose may differ from itself, of rounding
_ADDED = "calibrated_flange"


@dataclass(frozen=True)
class ChangedUrdf:
    """A URDF with other origins.

    Attributes:
        text: The whole text.
        tip: The link that is the flange now.
        changed: Names of the joints whose origins are others.
    """

    text: str
    tip: str
    changed: tuple[str, ...]


def with_origins(
    data: bytes,
    where: str,
    drawn: Robot,
    robot: Robot,
    *,
    base: str | None = None,
    tip: str | None = None,
    extension: Sequence[str] = (),
) -> ChangedUrdf:
    """The URDF of `drawn` with the joint frames of `robot`, which has the same joints.

    What hangs on the tip moves along with it; if a joint that moves carries the tip itself, so that
    no origin stands between them, a link is added that is the flange.

    Args:
        data: The URDF that `drawn` was read from.
        where: Names the file in messages.
        drawn: The robot as read.
        robot: The robot as it is to be.
        base: Link that is the base frame, as for `from_urdf`.
        tip: Link that is the flange, likewise.
        extension: Lines that stand at its end, for readers that know them.

    Raises:
        InputError: not the URDF of that robot.
    """
    urdf = read_elements(data, where)
    tree = Tree([link.name for link in urdf.links], urdf.joints, where)
    base_link = tree.base(base)
    tip_link = tree.tip(base_link, tip)
    chain = tree.chain(base_link, tip_link)
    names = {joint.name for joint in chain}
    if missing := [name for name in drawn.way if name not in names]:
        raise InputError(f"{where}: joint {missing[0]!r} is not between {base_link!r} and the tip")
    was, now = ({joint.name: joint for joint in one.moving} for one in (drawn, robot))
    origins: dict[str, Array] = {}
    for joint in chain:
        if joint.name in was:
            change = _change(was[joint.name].T_parent_joint, now[joint.name].T_parent_joint)
            if change is not None:
                origins[joint.name] = joint.T_parent_child @ change
    added: list[str] = []
    end = _change(drawn.T_tip_flange, robot.T_tip_flange)
    if end is not None and chain[-1].type == "fixed":
        origins[chain[-1].name] = chain[-1].T_parent_child @ end
    elif end is not None:
        added, tip_link = _flange(chain[-1], end, {*tree.links, *(j.name for j in urdf.joints)})
    text = _replaced(decoded(data, where), origins, [*added, *extension])
    return ChangedUrdf(text, tip_link, tuple(origins))


def _change(was: Array, now: Array) -> Array | None:
    """(4, 4) what leads from one pose to another, behind it; None if they are the same."""
    if np.abs(was - now).max() <= _STILL:
        return None
    return np.asarray(np.linalg.inv(was) @ now)


def _flange(last: UrdfJoint, end: Array, taken: set[str]) -> tuple[list[str], str]:
    """A link behind the tip, and its name."""
    name = next(n for n in (_ADDED, *(f"{_ADDED}_{i}" for i in range(2, 1000))) if n not in taken)
    lines = [
        element("link", name=name),
        opened("joint", name=f"to_{name}", type="fixed"),
        "  " + element("origin", **pose_words(end)),
        "  " + element("parent", link=last.child),
        "  " + element("child", link=name),
        "</joint>",
    ]
    return lines, name


class _TagPlaces:
    """Where in a text the joints of a URDF begin, and their origins.

    Attributes:
        joints: Offset of the tag, by name.
        origins: Offset of the tag of its origin, by name of the joint.
        end: Offset of the last tag.
    """

    def __init__(self, data: bytes) -> None:
        self.joints: dict[str, int] = {}
        self.origins: dict[str, int] = {}
        self.end = len(data)
        self._depth, self._joint = 0, ""
        parser = expat.ParserCreate("utf-8")
        self._parser = parser
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._stop
        parser.Parse(data, True)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        if self._depth == 2:
            self._joint = attributes.get("name", "").strip() if tag == "joint" else ""
            if self._joint:
                self.joints[self._joint] = self._parser.CurrentByteIndex
        elif self._depth == 3 and self._joint and tag == "origin":
            self.origins[self._joint] = self._parser.CurrentByteIndex

    def _stop(self, _: str) -> None:
        self._depth -= 1
        if self._depth == 0:
            self.end = self._parser.CurrentByteIndex


def _replaced(text: str, origins: dict[str, Array], lines: Sequence[str]) -> str:
    """The text with other origins and further lines."""
    data = text.encode()
    places = _TagPlaces(data)
    parts = [(places.end, places.end, "".join(f"  {line}\n" for line in lines))]
    for name, T in origins.items():
        words = pose_words(T)
        if name in places.origins:
            start = places.origins[name]
            stop = _end_of_tag(data, start)
            parts.append((start, stop, _tag(data[start:stop].decode(), words)))
        else:
            stop = _end_of_tag(data, places.joints[name])
            parts.append((stop, stop, "\n    " + element("origin", **words)))
    done, last = [], 0
    for start, stop, new in sorted(parts):
        done += [data[last:start].decode(), new]
        last = stop
    done.append(data[last:].decode())
    return '<?xml version="1.0" encoding="utf-8"?>\n' + "".join(done).lstrip()


def _end_of_tag(data: bytes, start: int) -> int:
    """Where a tag that begins at `start` ends; quoted values may have any sign."""
    found = re.compile(rb"""<(?:[^<>"']|"[^"]*"|'[^']*')*>""").match(data, start)
    assert found is not None  # it was parsed
    return found.end()


def _tag(tag: str, words: dict[str, str]) -> str:
    """A tag with other values of `xyz` and `rpy`; what else it has stays."""
    for key, value in words.items():
        own = re.compile(rf"""(\s{key}\s*=\s*)("[^"]*"|'[^']*')""")
        if own.search(tag):
            tag = own.sub(lambda found, v=value: f'{found[1]}"{v}"', tag, count=1)  # type: ignore[misc]
        else:
            tag = re.sub(r"\s*(/?>)$", rf' {key}="{value}"\1', tag)
    return tag
