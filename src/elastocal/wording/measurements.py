"""What looks odd in readings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import listed
from elastocal.wording.numbers import shown

_LONGEST = 40  # characters of a name


def _experiments(names: Sequence[str]) -> str:
    """'experiments 3, 5' and how many more."""
    return f"experiment{'s' if len(names) > 1 else ''} {listed([n[:_LONGEST] for n in names])}"


def _radians(doubt: Doubt) -> str:
    factor, unit = shown("rad")
    return (
        f"no joint value is beyond {factor * doubt.numbers['largest']:.3g}{unit}: were radians "
        "meant?"
    )


def _beyond(doubt: Doubt) -> str:
    factor, unit = shown(doubt.unit)
    lower, upper, value = (
        f"{factor * doubt.numbers[name]:.6g}" for name in ("lower", "upper", "value")
    )
    return (
        f"{_experiments(doubt.about)}: {doubt.because[0]} is beyond its limits {lower} … {upper} "
        f"{unit} (at {value} {unit})"
    )


def _only_noise(doubt: Doubt) -> str:
    deflection, noise = 1e3 * doubt.numbers["deflection"], 1e3 * doubt.numbers["noise"]
    return (
        f"no deflection is above three times its noise (the largest is {deflection:.3g} mm, with "
        f"noise of {noise:.3g} mm): were the robot and the gauge as they should be?"
    )


SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "degrees-for-radians": lambda doubt: (
        f"joint values reach {doubt.numbers['largest']:.4g} rad, more than a full turn: were "
        "degrees meant?"
    ),
    "radians-for-degrees": _radians,
    "beyond-joint-limits": _beyond,
    "no-load": lambda doubt: f"{_experiments(doubt.about)}: no load at all, so nothing can deflect",
    "other-force": lambda doubt: (
        f"{_experiments(doubt.about)}: the force is {doubt.numbers['force']:.4g} N where the study "
        f"plans {doubt.numbers['planned']:.4g} N"
    ),
    "other-direction": lambda doubt: (
        f"{_experiments(doubt.about)}: the force points along "
        f"[{' '.join(f'{doubt.numbers[axis]:.2f}' for axis in 'xyz')}], which the study does not "
        "plan"
    ),
    "no-torques": lambda doubt: (
        f"the study plans torques of {doubt.numbers['planned']:.4g} N·m, the file has none"
    ),
    "stuck-sensor": lambda _: (
        "the force has one value in some experiments and to the last digit another in the "
        "rest: is the force sensor stuck?"
    ),
    "large-deflection": lambda doubt: (
        f"{_experiments(doubt.about)}: the deflection is {doubt.numbers['deflection']:.4g} m: "
        "were millimetres or micrometres meant, or positions of different points subtracted?"
    ),
    "only-noise": _only_noise,
    "against-force": lambda doubt: (
        f"{doubt.numbers['against']} of {doubt.numbers['clear']} deflections go against the force: "
        "were loaded and unloaded exchanged, or the sign of the force?"
    ),
    "zero-deflection": lambda doubt: f"{_experiments(doubt.about)}: the deflection is exactly zero",
    "fewer-readings": lambda doubt: (
        f"{_experiments(doubt.about)}: {doubt.numbers['readings']} of up to "
        f"{doubt.numbers['most']} readings that other experiments have"
    ),
    "marker-not-measured": lambda doubt: f"marker {doubt.about[0]!r} was never measured",
    "unfinished": lambda doubt: (
        f"{doubt.numbers['experiments']} of the {doubt.numbers['planned']} experiments of the "
        "study are in the file"
    ),
}
