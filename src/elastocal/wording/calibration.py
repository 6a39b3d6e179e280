"""What is weak in a calibration from absolute readings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import listed
from elastocal.wording.numbers import length, number, readable, small


def _hardly_checked(doubt: Doubt) -> str:
    n = doubt.numbers
    return (
        f"{n['numbers']:.0f} numbers were read for {n['told']:.0f} that are found from them: next "
        "to nothing is left to check the model with; read more poses"
    )


def _below_zero(doubt: Doubt) -> str:
    n = doubt.numbers
    factor, unit = readable(doubt.unit, n["value"])
    text = (
        f"{listed(doubt.about)}: {number(factor * n['value'])} ± {number(factor * n['error'], 2)} "
        f"{unit}, and no spring gives way against its load"
    )
    if "geometry" in doubt.because:
        return f"{text}; a sign that the geometry is off: add 'geometry' to what is identified"
    if n["far"] < _SURELY:
        return f"{text}; zero is within its error"
    return f"{text}; look at masses, signs and the direction of gravity"


_SURELY = 2.0  # standard errors below zero


def _not_told(doubt: Doubt) -> str:
    return (
        f"{listed(doubt.about)}: these readings do not tell; poses or payloads that load them "
        "otherwise would"
    )


def _large_errors(doubt: Doubt) -> str:
    said = [f"{name} {small(doubt.numbers[name], doubt.unit)}" for name in doubt.about]
    return (
        f"{listed(said)}: far larger than geometric errors are; look at zeros, signs and units of "
        "the joint values, and at the table of the robot"
    )


def _scatters(doubt: Doubt) -> str:
    n = doubt.numbers
    return (
        f"the model is off by {length(n['model'])} in each coordinate where the instrument errs by "
        f"{length(n['instrument'])}: the arm does what the model does not know; all intervals "
        "count it"
    )


def _smaller_will_do(doubt: Doubt) -> str:
    n = doubt.numbers
    if n["small"] <= n["large"]:
        what = f"predicts poses left out better ({length(n['small'])} than {length(n['large'])})"
    else:
        what = f"predicts poses left out as well ({length(n['small'])}, {length(n['large'])})"
    return f"the smaller model {doubt.about[0]!r} {what}; {listed(doubt.because)} did not help"


def _drifted(doubt: Doubt) -> str:
    n = doubt.numbers
    return (
        f"{_station(doubt)} drifted by {length(n['size'])} while it read, as reflectors on the "
        "foot show: taken off, with what that leaves open"
    )


def _knocked(doubt: Doubt) -> str:
    n = doubt.numbers
    where = f"between readings {n['before']:.0f} and {n['after']:.0f}"
    if (n["first"], n["last"]) != (n["before"], n["after"]):
        where += f" (surely between {n['first']:.0f} and {n['last']:.0f})"
    return (
        f"{_station(doubt)} seems to have moved by {length(n['size'])} {where}: make it two "
        "stations, one before and one after"
    )


def _station(doubt: Doubt) -> str:
    """Which tracker is meant."""
    name = doubt.about[0]
    return f"station {name!r}" if name else "the tracker"


def _payload_exact(doubt: Doubt) -> str:
    return (
        f"payload {listed(doubt.about)} counts as known exactly, and tells {listed(doubt.because)} "
        "through the sag of the arm: give mass_error_kg and center_error_mm if it is not"
    )


def _lacks(doubt: Doubt) -> str:
    n, (name,), (block, *alike) = doubt.numbers, doubt.about, doubt.because
    soft = block == "compliance"
    if soft:
        factor, unit = readable(doubt.unit, n["value"])
        size = f"{number(factor * n['value'])} ± {number(factor * n['error'], 2)} {unit}"
    else:
        size = f"{small(n['value'], doubt.unit)} ± {small(n['error'], doubt.unit, 2)}"
    or_ = f" (or {listed(alike)}, which does nearly the same)" if alike else ""
    wanted = repr(name if soft else block)
    often = "less than one of a million"
    if n["chance"] > 1e-6:
        often = f"one of {number(1.0 / n['chance'], 1)}"
    return (
        f"{'a spring in ' if soft else ''}{name}{or_} explains what the fit leaves, {size}, where "
        f"chance does as much in {often} campaigns: add {wanted} to what is identified"
    )


SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "tracker-drifted": _drifted,
    "tracker-knocked": _knocked,
    "hardly-checked": _hardly_checked,
    "spring-below-zero": _below_zero,
    "not-told": _not_told,
    "large-errors": _large_errors,
    "model-scatters": _scatters,
    "smaller-will-do": _smaller_will_do,
    "payload-exact": _payload_exact,
    "calibration-lacks": _lacks,
}


def combination(names: Sequence[str]) -> str:
    """Unknowns that do the same, in words."""
    if len(names) == 1:
        return f"{names[0]} moves no reading"
    if len(names) == 2:
        return f"{names[0]} and {names[1]} do the same"
    return f"{listed(names)} together move no reading"
