"""Where unloaded markers were read, beside where joints and tool put them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import experiments, listed
from elastocal.wording.numbers import number


def distance(rms: float, apart: float, *, chosen: bool = False) -> str:
    """How far they are apart, with and without the best fit [m]."""
    fitted = "in the frame by best fit" if chosen else "after the best rotation and shift"
    return (
        f"unloaded markers are {_mm(rms)} mm (RMS) from where joints and tool put them, {fitted}; "
        f"without it {_mm(apart)} mm"
    )


def by_best_fit(rms: float, turn_error: float, count: int, largest: float) -> str:
    """What was taken as the frame, and how certain it is.

    Args:
        rms: Root mean square distance that is left [m].
        turn_error: Standard uncertainty of the rotation [rad].
        count: Number of positions that it rests on.
        largest: Largest deflection that is turned by it [m].
    """
    return (
        f"the frame of the readings is the best fit of {count} unloaded positions to joints and "
        f"tool: {_mm(rms)} mm (RMS) are left, its rotation is uncertain by {_deg(turn_error)}°, "
        f"which turns the largest deflection by {1e6 * largest * turn_error:.2g} µm"
    )


def from_drawing(rms: float) -> str:
    """How far absolute readings are from the arm as drawn [m]."""
    return (
        f"positions are {_mm(rms)} mm (RMS) from where the joint values put the arm as drawn, with "
        "the base and the reflectors that fit best"
    )


def unlike_arm(doubt: Doubt) -> str:
    """That they do not fit, and what would explain it."""
    numbers = doubt.numbers
    away = (
        f"unloaded markers are {_mm(numbers['rms'])} mm (RMS) from where joints and tool put them, "
        "even after the best rotation and shift"
        if "apart" in numbers
        else from_drawing(numbers["rms"])
    )
    if not doubt.because:
        sag = "" if "apart" in numbers else ", or is it its sag?"
        return (
            f"{away}, and no mistake of units, signs, one zero, markers, single experiments or a "
            "bumped tracker alone explains it; compare lengths and tool of the model with the "
            f"robot{sag}"
        )
    mended = f"they would fit to {_mm(numbers['mended'])} mm"
    return f"{away}; {mended} if {_WHY[doubt.because[0]](doubt)}"


_UNITS = {
    1e3: "metres, and not millimetres",
    1e-3: "millimetres, and not metres",
    25.4: "inches, and not millimetres",
    1.0 / 25.4: "millimetres, and not inches",
    10.0: "centimetres, and not millimetres",
    0.1: "millimetres, and not centimetres",
}


def _scale(doubt: Doubt) -> str:
    factor = doubt.numbers["scale"]
    meant = next(words for size, words in _UNITS.items() if abs(factor / size - 1.0) < 1e-6)
    return f"the positions were {number(factor)} times as large: are they {meant}?"


def _joint_unit(doubt: Doubt) -> str:
    if doubt.numbers["factor"] > 1.0:
        return "the joint values were radians and not degrees"
    return "the joint values were degrees and not radians"


def _signs(doubt: Doubt) -> str:
    parts = []
    if doubt.about:
        verb = "counts" if len(doubt.about) == 1 else "count"
        parts.append(f"{listed(doubt.about)} {verb} the other way")
    pairs = doubt.because[1:]
    for joint, other in zip(pairs[::2], pairs[1::2], strict=True):
        factor = doubt.numbers[f"{joint}/{other}"]
        times = f" by {factor:g}" if factor else ""
        parts.append(f"{joint} is{'' if factor else ' not'} coupled to {other}{times}")
    return " and ".join(parts)


def _zero(doubt: Doubt) -> str:
    by = doubt.numbers["by"]
    size = f"{1e3 * abs(by):.2g} mm" if doubt.numbers.get("sliding") else _degrees(abs(by))
    than = "larger" if by > 0.0 else "smaller"
    return f"all values of {doubt.about[0]} were {size} {than}: is its zero elsewhere?"


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):.2g}°"


def _controller(doubt: Doubt) -> str:
    if doubt.about[0] == "controller":
        return "the joint values are those that the controller shows ('joints: controller')"
    return "the joint values are those of the model already, and not those of the controller"


def _exchanged(doubt: Doubt) -> str:
    return f"the markers {listed(doubt.about)} have each other's names"


def _single(doubt: Doubt) -> str:
    return f"{experiments(doubt.about)} were left out: other joint values there, or another marker?"


def _bumped(doubt: Doubt) -> str:
    return (
        f"the tracker stood elsewhere from {experiments(doubt.about)} on, by "
        f"{_mm(doubt.numbers['by'])} mm at the markers: was it bumped?"
    )


def _markers(doubt: Doubt) -> str:
    what = "marker" if len(doubt.about) == 1 else "markers"
    return (
        f"the {what} {listed(doubt.about)} were elsewhere on the tool, by up to "
        f"{_mm(doubt.numbers['by'])} mm"
    )


def _mirrored(_: Doubt) -> str:
    return (
        "they were mirrored: are two of the columns x, y, z exchanged, or does one have the other "
        "sign?"
    )


_WHY: Mapping[str, Callable[[Doubt], str]] = {
    "scale": _scale,
    "joint-unit": _joint_unit,
    "mirrored": _mirrored,
    "sign": _signs,
    "quarter": _zero,
    "controller": _controller,
    "exchanged": _exchanged,
    "zero": _zero,
    "markers": _markers,
    "experiments": _single,
    "bumped": _bumped,
}


def _turned(doubt: Doubt) -> str:
    turn, error = doubt.numbers["turn"], doubt.numbers["turn_error"]
    return (
        f"{distance(doubt.numbers['rms'], doubt.numbers['apart'])}: the frame of the readings is "
        f"turned by {_deg(turn)}° (± {_deg(error)}°) against the base, and so are the deflections; "
        "a mapping with 'frame: best-fit' mends it"
    )


def _probe(doubt: Doubt) -> str:
    off = _deg(doubt.numbers["off"])
    turned = f"from pose to pose the probe turns {off}° (RMS) otherwise than the arm"
    if doubt.about:
        mended = _deg(doubt.numbers["mended"])
        return f"{turned}; {mended}° if {doubt.about[0]} counts the other way"
    if not doubt.because:
        return f"{turned}: do 'orientation' and the unit of the angles say what these are?"
    other = doubt.because[0]
    mended = _deg(doubt.numbers["mended"])
    if other == "inverse":
        return f"{turned}; {mended}° if the orientations are those of the tracker in the probe"
    return f"{turned}; {mended}° if 'orientation' were {other}"


def _mm(length: float) -> str:
    """Millimetres, no tenths where there are tens."""
    return f"{1e3 * length:.0f}" if length >= 1e-2 else f"{1e3 * length:.2g}"


def _deg(angle: float) -> str:
    return f"{np.degrees(angle):.2g}" if angle < 0.1 else f"{np.degrees(angle):.4g}"


SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "unlike-arm": unlike_arm,
    "readings-turned": _turned,
    "probe-turned": _probe,
}
