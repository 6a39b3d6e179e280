"""What the readings of a plan cannot show: effects by name, their sizes, and what a test proves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from elastocal.arrays import Array
from elastocal.wording.lists import listed
from elastocal.wording.numbers import length, number


class Blind(Protocol):
    """What is said of an effect; see `planning.blind.BlindEffect`."""

    @property
    def kind(self) -> str: ...
    @property
    def carriers(self) -> tuple[str, ...]: ...
    @property
    def axis(self) -> Array: ...
    @property
    def unit(self) -> str: ...
    @property
    def half(self) -> float: ...
    @property
    def largest(self) -> float: ...
    @property
    def size(self) -> float: ...
    @property
    def seen(self) -> float: ...
    @property
    def usual_seen(self) -> float: ...
    @property
    def error(self) -> float: ...


class Seen(Protocol):
    """What is said of a plan; see `planning.blind.BlindErrors`."""

    @property
    def invisible(self) -> Sequence[Blind]: ...
    @property
    def visible(self) -> Sequence[Blind]: ...
    @property
    def dof(self) -> int: ...


BLIND = "What the readings cannot show"
"""Title of a table, or a section."""

_SAID: Mapping[str, str] = {
    "joint": "joint {}",
    "foot": "foot{} turning {}",
    "bearing": "bearing of {} {}",
    "link": "link behind {} {}",
    "foot-sliding": "foot sliding along {}",
    "tool-sliding": "tool sliding along its {}",
    "load-gain": "all loads too small or too large",
    "load-turn": "all loads turned about {}",
    "tool-shift": "tool shifted along its {} between the readings",
    "station-shift": "station shifted along {} between the readings",
    "station-turn": "station turned about {} between the readings",
}
_SPRINGS = ("foot", "bearing", "link")


def effect_name(effect: Blind) -> str:
    """What may be missing, in a few words; axes are those of an arm with all joints at zero."""
    said, joints = _SAID[effect.kind], listed(effect.carriers)
    if effect.kind in _SPRINGS:
        about = f"about {_axis(effect.axis)}" if len(effect.axis) else "alike in every direction"
        if effect.kind == "foot":
            return said.format(f" and bearing of {joints}," if joints else "", about)
        return said.format(listed(effect.carriers), about)
    return said.format(joints or (_axis(effect.axis) if len(effect.axis) else ""))


def size_of(value: float, unit: str) -> str:
    """A size as people read it."""
    factor, sign = _UNITS[unit]
    if unit == "m":
        return length(value)
    if unit == "rad" and value < _SMALL_TURN:
        factor, sign = 1e6, "µrad"
    shown = number(factor * value, 2 if value else 1)
    return f"{shown}{sign}" if sign == "°" else f"{shown} {sign}"


_SMALL_TURN = 2e-3  # rad
_UNITS = {
    "rad/(N·m)": (1e6, "µrad/(N·m)"),
    "m/N": (1e6, "µm/N"),
    "m": (1e3, "mm"),
    "rad": (180.0 / np.pi, "°"),
    "1": (100.0, "%"),
}


def seen_phrase(effect: Blind, *, invisible: bool) -> str:
    """How often the test sees an effect of its size."""
    if invisible:
        return "never"
    return "half of the time" if effect.half <= effect.largest else f"{100 * effect.seen:.0f} %"


def proof_sentence(found: Seen) -> str:
    """What a test of fit that passes proves."""
    if not found.dof:
        return (
            "The means of the readings are no more than what is fitted, so no test of fit can tell "
            "whether the model is right: more configurations would."
        )
    often = [effect for effect in found.visible if effect.half <= effect.largest]
    seldom = [effect for effect in found.visible if effect.half > effect.largest]
    groups = {
        "what it sees half of the time": often,
        "what it sees more seldom": seldom,
        "what no reading shows": found.invisible,
    }
    left = []
    for what, effects in groups.items():
        if effects:
            worst = max(effects, key=lambda effect: effect.error)
            left.append(f"{what} up to {length(worst.error)} ({effect_name(worst)})")
    if not left:
        return ""
    said = f"If the test of fit passes, there may still be left: {'; '.join(left)}."
    usual = [e.usual_seen for e in (*found.invisible, *found.visible) if e.usual_seen > 0.0]
    if usual:
        count = sum(chance >= 0.5 for chance in usual)
        said += (
            f" Of {len(usual)} things of usual size it sees {count or 'none'} in half of all "
            "campaigns or more."
        )
    return said


def never_seen_sentence(
    unseen: Sequence[Blind], aslant: Sequence[Blind], markers: Sequence[Blind]
) -> str:
    """What no plan of a study shows, and what would; empty if all is shown.

    Args:
        unseen: What is never seen.
        aslant: What of it loads aslant do not show either.
        markers: What of that more markers do not show either.
    """
    if not unseen:
        return ""
    names = [
        f"{effect_name(e)} (up to {length(e.error)} by {size_of(e.size, e.unit)})" for e in unseen
    ]
    said = [
        f"no reading under these loads shows {'; '.join(names)}: that stays at the test poses, and "
        "every test of fit passes"
    ]
    if by_loads := [effect_name(e) for e in unseen if e not in aslant]:
        what = "it" if len(by_loads) == len(unseen) else "; ".join(by_loads)
        said.append(f"Loads of the same size, aslant by 45° to several sides, would show {what}")
    if by_markers := [effect_name(e) for e in aslant if e not in markers]:
        also = ", with these loads," if by_loads else " and loads aslant"
        said.append(f"Three markers{also} would show {'; '.join(by_markers)}")
    return f"{'. '.join(said)}."


def _axis(axis: Array) -> str:
    """A direction: an axis of its frame if it is along one."""
    largest = int(np.argmax(np.abs(axis)))
    if math.isclose(abs(float(axis[largest])), 1.0, abs_tol=_ALONG):
        return "xyz"[largest]
    shown = axis if axis[largest] > 0.0 else -axis
    return "[" + " ".join(f"{v + 0.0:.2g}" for v in np.round(shown, 2)) + "]"


_ALONG = 5e-4  # of a unit vector: two degrees
