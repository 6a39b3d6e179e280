"""What looks odd in readings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import LONGEST, experiments, listed
from elastocal.wording.numbers import described, number, shown


def _radians(doubt: Doubt) -> str:
    factor, unit = shown("rad")
    return (
        f"no joint value is beyond {factor * doubt.numbers['largest']:.3g}{unit}: were radians "
        "meant?"
    )


def _beyond(doubt: Doubt) -> str:
    factor, unit = shown(doubt.unit)
    lower, upper = (f"{factor * doubt.numbers[name]:.6g}" for name in ("lower", "upper"))
    return (
        f"{experiments(doubt.about)}: {doubt.because[0]} is beyond its limits {lower} … {upper} "
        f"{unit} (at {_between(doubt, factor, 6)} {unit})"
    )


def _only_noise(doubt: Doubt) -> str:
    deflection, noise = 1e3 * doubt.numbers["deflection"], 1e3 * doubt.numbers["noise"]
    what, unit = _reading(doubt), "mrad" if doubt.unit else "mm"
    return (
        f"no {what} is above three times its noise (the largest is {deflection:.3g} {unit}, with "
        f"noise of {noise:.3g} {unit}): were the robot and the gauge as they should be?"
    )


def _reading(doubt: Doubt) -> str:
    """What was read."""
    return "rotation" if doubt.unit == "rad" else "deflection"


def _large(doubt: Doubt) -> str:
    size = _between(doubt)
    if doubt.unit == "rad":
        return (
            f"{experiments(doubt.about)}: the rotation is {size} rad: were milliradians or "
            "degrees meant, or orientations of different things subtracted?"
        )
    return (
        f"{experiments(doubt.about)}: the deflection is {size} m: "
        "were millimetres or micrometres meant, or positions of different points subtracted?"
    )


def _between(doubt: Doubt, factor: float = 1.0, digits: int = 4) -> str:
    """'500', or '115 to 1166' where they differ."""
    ends = dict.fromkeys(f"{factor * doubt.numbers[e]:.{digits}g}" for e in ("least", "most"))
    return " to ".join(ends)


def _not_used(names: Sequence[str]) -> str:
    """'columns 'a', 'b' are', as the beginning of a sentence."""
    quoted = listed([repr(name[:LONGEST]) for name in names])
    return f"columns {quoted} are" if len(names) > 1 else f"column {quoted} is"


def _with(doubt: Doubt) -> str:
    """'with A2 below zero and A1 beyond its limits'."""
    parts = [f"{listed(doubt.about)} below zero"] if doubt.about else []
    if doubt.because:
        their = "its" if len(doubt.because) == 1 else "their"
        parts.append(f"{listed(doubt.because)} beyond {their} limits")
    return f"with {' and '.join(parts)}"


def _rotation_unit(doubt: Doubt) -> str:
    ratio = doubt.numbers["ratio"]
    off = f"{ratio:.3g} times too large" if ratio > 1.0 else f"{1.0 / ratio:.3g} times too small"
    return (
        f"the rotations are about {off} for the positions beside them: so are {doubt.about[0]} "
        f"read as {doubt.because[0]}; look at the unit of their columns"
    )


def _torques_compared(doubt: Doubt) -> str:
    found, unused = doubt.numbers, "they count in no fit"
    if not doubt.about:
        return f"joint torques were read, but nothing is known that loads the joints; {unused}"
    share = found["share"]
    sign = ", with the other sign" if share < 0.0 else ""
    said = (
        f"measured joint torques are {abs(share):.2f} times what weights and forces exert on "
        f"{listed(doubt.about)}{sign}; {number(found['left'], 2)} of {number(found['load'], 2)} "
        f"N·m (RMS) is not explained"
    )
    if found["mass"]:
        more = "more" if found["mass"] > 0.0 else "less"
        return (
            f"{said}, most of it by {number(abs(found['mass']), 2)} kg {more} on the flange than "
            f"the study says; {unused}"
        )
    if found["left"] > _MUCH_LEFT * found["load"]:
        said += ": look at masses, payload and units"
    return f"{said}; {unused}"


_MUCH_LEFT = 0.3  # of the loads


SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "degrees-for-radians": lambda doubt: (
        f"joint values reach {doubt.numbers['largest']:.4g} rad, more than a full turn: were "
        "degrees meant?"
    ),
    "radians-for-degrees": _radians,
    "beyond-joint-limits": _beyond,
    "no-load": lambda doubt: f"{experiments(doubt.about)}: no load at all, so nothing can deflect",
    "other-force": lambda doubt: (
        f"{experiments(doubt.about)}: the force is {_between(doubt)} N where the study plans "
        f"{doubt.numbers['planned']:.4g} N"
    ),
    "other-direction": lambda doubt: (
        f"{experiments(doubt.about)}: the force points where the study does not plan it, in "
        f"{experiments(doubt.because)} along "
        f"[{' '.join(f'{doubt.numbers[axis]:.2f}' for axis in 'xyz')}]"
    ),
    "no-torques": lambda doubt: (
        f"the study plans torques of {doubt.numbers['planned']:.4g} N·m, the file has none"
    ),
    "torques-compared": _torques_compared,
    "stuck-sensor": lambda _: (
        "the force has one value in some experiments and to the last digit another in the "
        "rest: is the force sensor stuck?"
    ),
    "large-deflection": _large,
    "only-noise": _only_noise,
    "against-force": lambda doubt: (
        f"{doubt.numbers['against']} of {doubt.numbers['clear']} deflections go against the force: "
        "were loaded and unloaded exchanged, or the sign of the force?"
    ),
    "zero-deflection": lambda doubt: (
        f"{experiments(doubt.about)}: the {_reading(doubt)} is exactly zero"
    ),
    "fewer-readings": lambda doubt: (
        f"{experiments(doubt.about)}: {_between(doubt)} of up to "
        f"{doubt.numbers['others']} readings that other experiments have"
    ),
    "marker-not-measured": lambda doubt: (
        "the rotation of the flange, which the study measures, was never read"
        if doubt.unit == "rad"
        else f"marker {doubt.about[0]!r} was never measured"
    ),
    "unfinished": lambda doubt: (
        f"{doubt.numbers['experiments']} of the {doubt.numbers['planned']} experiments of the "
        "study are in the file"
    ),
    "impossible-joints": lambda doubt: (
        f"no robot stands there: {', '.join(doubt.about)} "
        f"{'is' if len(doubt.about) == 1 else 'are'} far beyond the limits in "
        f"{doubt.numbers['experiments']} experiments ({doubt.because[0]} at "
        f"{described(doubt.numbers['value'], doubt.unit)}); look at the units of the joint values"
        + (": were degrees meant?" if doubt.unit == "rad" else "")
    ),
    "impossible-loads": lambda doubt: (
        f"no robot bears that: most loads are {doubt.numbers['load']:.3g} {doubt.unit} or so; look "
        "at their unit"
    ),
    "impossible-deflections": lambda doubt: (
        f"no arm bends so far: most deflections are {doubt.numbers['deflection']:.3g} m or so, at "
        f"no more than {doubt.numbers['distance']:.3g} m from the base; look at their unit, and "
        "whether positions of different points were subtracted"
    ),
    "impossible-zeros": lambda doubt: (
        f"{doubt.numbers['zero']:g} of {doubt.numbers['readings']:g} {_reading(doubt)}s under load "
        "are exactly zero, which no arm and no gauge is: were loaded and unloaded readings the "
        "same, or the gauge not read?"
    ),
    "impossible-copies": lambda doubt: (
        f"all {doubt.numbers['readings']:g} {_reading(doubt)}s are the same to the last digit, "
        f"under {doubt.numbers['cases']:g} different load cases: was the gauge stuck, or one "
        "reading copied?"
    ),
    "impossible-signs": lambda doubt: (
        f"no spring gives way against its load, but by these readings all of "
        f"{', '.join(doubt.about)} do: were loaded and unloaded exchanged, or the sign of the "
        "force?"
    ),
    "impossible-fit": lambda doubt: (
        f"no springs explain these readings: they are {number(doubt.numbers['scale'], 2)} times as "
        f"far from the model as σ promises, {_with(doubt)}; look at the units and signs of joint "
        "values, at frame, markers and loads; --sigma estimated or a robust --loss identify all "
        "the same"
    ),
    "looks-used": lambda doubt: (
        f"column {doubt.about[0]!r} looks like {doubt.because[0]} but is not used; its name means "
        "nothing here"
    ),
    "rotations-not-used": lambda doubt: (
        f"{_not_used(doubt.about)} a rotation and not used, for the study measures positions "
        "alone; with `measures: pose` and sigma_mrad in its `instrument` they are"
    ),
    "columns-not-used": lambda doubt: f"{_not_used(doubt.about)} not used",
    "rotation-unit": _rotation_unit,
    "rotation-sign": lambda _: (
        "the rotations go against the positions: were they taken from loaded to unloaded, or "
        "those of the frame and not of the tool?"
    ),
}
