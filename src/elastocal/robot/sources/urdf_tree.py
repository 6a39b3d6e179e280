"""The tree of a URDF: the chain from base to tip, and what hangs on it.

In: joints with parents and children. Out: which joints are the chain, and the way from the base to
every link.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Sequence

from elastocal.errors import InputError
from elastocal.robot.sources.urdf_elements import UrdfJoint

_SHOWN = 6


class Tree:
    """Links as the nodes of a tree and joints as its edges.

    Attributes:
        links: Names of the links.
        parent_joint: The joint above a link, by the name of the link.
        child_joints: The joints below a link.
    """

    def __init__(self, links: Sequence[str], joints: Sequence[UrdfJoint], where: str) -> None:
        """Take links and joints of which every link has one parent at most.

        Raises:
            InputError: the joints close a loop.
        """
        self.links, self.where = list(links), where
        self.parent_joint = {joint.child: joint for joint in joints}
        self.child_joints: dict[str, list[UrdfJoint]] = {link: [] for link in links}
        for joint in joints:
            self.child_joints[joint.parent].append(joint)
        hanging = set()
        for root in self.roots:
            hanging |= set(self.below(root))
        looped = [link for link in links if link not in hanging]
        if looped:
            raise InputError(
                f"{where}: the joints close a loop through {first_few(looped)}; closed loops are "
                "not supported"
            )

    @property
    def roots(self) -> list[str]:
        """Links without a parent."""
        return [link for link in self.links if link not in self.parent_joint]

    def below(self, link: str) -> list[str]:
        """`link` and all links that hang on it."""
        found = [link]
        for name in found:
            found += [joint.child for joint in self.child_joints[name]]
        return found

    def base(self, wanted: str | None) -> str:
        """The base link: the one wanted, or the only one without a parent."""
        if wanted is not None:
            return self._known(wanted, "base")
        if len(self.roots) > 1:
            raise InputError(
                f"{self.where}: {len(self.roots)} links have no parent ({first_few(self.roots)}); "
                "say with 'base' which one is meant"
            )
        return self.roots[0]

    def tip(self, base: str, wanted: str | None) -> str:
        """The tip link: the one wanted, or the only end there is."""
        if wanted is not None:
            return self._known(wanted, "tip")
        ends = [link for link in self.below(base) if not self.child_joints[link]]
        if len(ends) > 1:
            ends.sort(key=lambda end: -self._moving(base, end))  # rods and frames last
            raise InputError(
                f"{self.where}: the robot has {len(ends)} ends ({first_few(ends)}); say with 'tip' "
                "which one carries the tool"
            )
        return ends[0]

    def chain(self, base: str, tip: str) -> list[UrdfJoint]:
        """The joints from base to tip."""
        found = []
        link = tip
        while link != base:
            if link not in self.parent_joint:
                raise InputError(f"{self.where}: tip {tip!r} does not hang on base {base!r}")
            found.append(self.parent_joint[link])
            link = found[-1].parent
        return found[::-1]

    def away_from(self, base: str) -> Iterator[tuple[str, UrdfJoint, str]]:
        """Every joint connected to `base`, nearest first: the link before it, it, the link behind.

        Links before the base are reached backwards, through the joints of which they are parents.
        """
        found = {base}
        todo = [base]
        for link in todo:
            around = [(joint, joint.child) for joint in self.child_joints[link]]
            if link in self.parent_joint:
                around.append((self.parent_joint[link], self.parent_joint[link].parent))
            for joint, other in around:
                if other not in found:
                    found.add(other)
                    todo.append(other)
                    yield link, joint, other

    def _moving(self, base: str, end: str) -> int:
        """How many joints from base to end move by themselves."""
        return sum(j.type != "fixed" and not j.follows.leader for j in self.chain(base, end))

    def _known(self, name: str, what: str) -> str:
        if name not in self.links:
            near = difflib.get_close_matches(name, self.links, 1)
            hint = (
                f"did you mean {near[0]!r}?" if near else f"the links are {first_few(self.links)}"
            )
            raise InputError(f"{self.where}: there is no link {name!r} for {what!r}; {hint}")
        return name


def first_few(names: Sequence[str]) -> str:
    """The first few names, and how many more there are."""
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(names[:_SHOWN]) + more
