"""What straight motions come near to that they must not."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from elastocal.errors import Code, Doubt
from elastocal.wording.numbers import described


def _near(doubt: Doubt) -> str:
    """What comes near what, and how near: 'hits wall with ball by 150 mm'."""
    other, own = doubt.because
    distance = 1e3 * doubt.numbers["distance"]
    if distance < 0.0:
        return f"hits {other} with {own} by {-distance:.0f} mm"
    return f"passes {other} with {own} at {distance:.0f} mm"


def _where(doubt: Doubt) -> str:
    """The same with where along the motion it is."""
    n = doubt.numbers
    said = f"{_near(doubt)} at {100.0 * n['share']:.0f} %"
    if n["distance"] < 0.0:
        return said
    return f"{said}, where {1e3 * n['keep']:.0f} mm must be kept"


def _motion(doubt: Doubt) -> str:
    """From where to where: the names, or the leg of a plan that starts and ends at home."""
    if doubt.about:
        return f"from {doubt.about[0]} to {doubt.about[1]}"
    leg, legs = doubt.numbers["leg"], doubt.numbers["legs"]
    first = f"configuration {leg}" if leg else "home"
    return f"from {first} to {f'configuration {leg + 1}' if leg + 1 < legs else 'home'}"


def _blocked(doubt: Doubt) -> str:
    part, parts = doubt.numbers.get("part", 1), doubt.numbers.get("parts", 1)
    which = f", part {part} of {parts}," if parts > 1 else ""
    return f"the motion {_motion(doubt)}{which} {_where(doubt)}"


def _via(doubt: Doubt) -> str:
    by = described(doubt.numbers["by"], doubt.unit)
    return f"via point {doubt.numbers['via']} {_motion(doubt)} breaks {doubt.because[0]} by {by}"


def _out_of_reach(doubt: Doubt) -> str:
    name, n = doubt.about[0], doubt.numbers
    lower, upper = (described(n[end], doubt.unit, 4) for end in ("lower", "upper"))
    return (
        f"of the range of {name} only {lower} to {upper} can be reached from home: to get "
        "beyond, it would have to pass through itself or its cell; plans keep within"
    )


def _left_out(other: str, own: str) -> str:
    """The key by which a study lets two things touch."""
    return "floor: off" if other == "floor" else f"collision: {{ignore: [[{own}, {other}]]}}"


SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "via-breaks": _via,
    "out-of-reach": _out_of_reach,
    "motion-blocked": _blocked,
    "no-way": lambda doubt: (
        f"no motion without collision was found {_motion(doubt)}: the straight one {_where(doubt)}"
    ),
    "home-blocked": lambda doubt: (
        f"home is no place to start from: the robot {_near(doubt)}; give another one in motion: "
        f"{' and '.join(doubt.about)}, or do not watch the two: constraints: "
        f"{{{_left_out(*doubt.because)}}}"
    ),
}
