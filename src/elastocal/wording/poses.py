"""How far a model is from the poses read off at its robot, and which mistakes explain it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from elastocal.errors import Code, Doubt
from elastocal.wording.numbers import shown


def misfit(doubt: Doubt, explanations: Sequence[tuple[Doubt, ...]]) -> str:
    """Why the model is not that of the controller."""
    if not explanations:
        return (
            f"{_differ(doubt)}, and no mistake of signs, couplings, one zero or unit explains it; "
            "compare lengths, base and flange of the model with the robot"
        )
    return (
        f"{_differ(doubt)}; it would fit to {1e3 * doubt.numbers['mended']:.1f} mm if "
        f"{', or if '.join(map(explained, explanations))}"
    )


def explained(mistakes: tuple[Doubt, ...]) -> str:
    """One mistake, or some made together."""
    said = [SENTENCES[m.code](m) for m in mistakes if m.code != "base-elsewhere"]
    base = [SENTENCES[m.code](m) for m in mistakes if m.code == "base-elsewhere"]
    if not said:
        return base[0]
    text = " and ".join([", ".join(said[:-1]), said[-1]] if len(said) > 1 else said)
    return "; besides, ".join([text, *base])


def _differ(doubt: Doubt) -> str:
    off = 1e3 * doubt.numbers["off"]
    return f"the check poses are up to {off:.1f} mm from where the model has them"


def _zero(doubt: Doubt) -> str:
    (factor, unit), joint = shown("rad"), doubt.about[0]
    return (
        f"the zero of {joint} is {abs(factor * doubt.numbers['by']):g}{unit} elsewhere "
        f"(offsets_deg: {{{joint}: {factor * doubt.numbers['offset']:g}}})"
    )


def _coupled(doubt: Doubt) -> str:
    joint, other = doubt.about
    factor = doubt.numbers["factor"]
    if factor == 0.0:
        return f"{joint} is not coupled to {other}"
    return f"{joint} is coupled to {other} (couple: {{{joint}: {{{other}: {factor:g}}}}})"


def _base(doubt: Doubt) -> str:
    if not doubt.numbers:
        return "its base is elsewhere"
    shift = " ".join(f"{1e3 * doubt.numbers[name]:.1f}" for name in "xyz")
    return f"its base frame is elsewhere, by [{shift}] mm"


SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "poses-differ": _differ,
    "counts-other-way": lambda doubt: (
        f"{doubt.about[0]} counts the other way (signs: {{{doubt.about[0]}: "
        f"{doubt.numbers['sign']}}})"
    ),
    "zero-elsewhere": _zero,
    "coupled": _coupled,
    "in-radians": lambda _: "the joint values are in radians",
    "in-metres": lambda _: "the positions are in metres, not in millimetres",
    "in-inches": lambda _: "the positions are in inches",
    "base-elsewhere": _base,
}
