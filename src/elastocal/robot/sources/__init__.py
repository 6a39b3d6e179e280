"""Ways to get a robot: built in, from a table, or from a file (`urdf`, loaded when it is read)."""

from __future__ import annotations

from collections.abc import Callable

from elastocal.errors import InputError
from elastocal.robot.chain import Robot
from elastocal.robot.sources.dh import DHRow, from_dh
from elastocal.robot.sources.kuka_kr270 import USUAL as KR270_USUAL
from elastocal.robot.sources.kuka_kr270 import kuka_kr270
from elastocal.robot.sources.three_link import three_link

__all__ = ["BUILTIN", "USUAL", "DHRow", "from_dh", "kuka_kr270", "load", "three_link"]

BUILTIN: dict[str, Callable[[], Robot]] = {
    "kuka-kr270": kuka_kr270,
    "three-link": three_link,
}

USUAL: dict[str, tuple[float, ...]] = {"kuka-kr270": KR270_USUAL}
"""Compliances of the order that such robots have, of those that are built in [rad/(N·m)]."""


def load(name: str) -> Robot:
    """The built-in robot called `name`.

    Raises:
        InputError: there is none; the message lists those there are.
    """
    if name not in BUILTIN:
        raise InputError(f"no built-in robot {name!r}; there are {', '.join(BUILTIN)}")
    return BUILTIN[name]()
