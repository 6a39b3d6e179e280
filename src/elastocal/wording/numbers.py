"""Numbers as people read them: millimetres, micrometres, degrees; few digits; a true minus sign.

In: SI values. Out: text.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from elastocal.arrays import Array

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_UNIT = re.compile(r"(?<=\d) (µm|mm|%|°|N\b)")
_PEOPLE = {
    "rad/(N·m)": (1e9, "nrad/(N·m)"),
    "m/N": (1e9, "nm/N"),
    "SI, mixed": (1e9, "10⁻⁹ SI, mixed"),
    "N·m/rad": (1e-6, "10⁶ N·m/rad"),
    "N/m": (1e-6, "N/µm"),
}
_SAME = 0.5  # minutes
_AXES = ("x", "y", "z")


def number(value: float, digits: int = 3) -> str:
    """A value with `digits` significant digits, as a power of ten only when very large or small."""
    if np.isnan(value):
        return "–"
    if np.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0.0:
        return "0"
    power = int(np.floor(np.log10(abs(float(f"{value:.{digits - 1}e}")))))
    if not -4 < power < 6:
        mantissa = f"{value / 10.0**power:.{digits - 1}f}".replace("-", "−")
        return f"{mantissa}×10{str(power).translate(_SUPERSCRIPT)}"
    return fixed(round(value, digits - 1 - power), max(0, digits - 1 - power))


def short(value: float) -> str:
    """Two digits, without an exponent as long as people would write none."""
    return f"{float(f'{value:.2g}'):g}"


def plain(value: float) -> str:
    """A value of a load: four significant digits, no zeros behind the point."""
    return f"{value:.0f}" if abs(value) >= 1e4 else f"{value:.4g}"


def fixed(value: float, decimals: int) -> str:
    """A value with so many decimals and no negative zero."""
    text = f"{value:.{decimals}f}"
    if float(text) == 0.0:
        text = text.lstrip("-")
    return text.replace("-", "−")


def more_minutes(minutes: float) -> str:
    """How much longer something takes."""
    if abs(minutes) < _SAME:
        return "as long"
    return f"{abs(minutes):.0f} min {'more' if minutes > 0.0 else 'less'}"


def length_unit(values: Iterable[float]) -> tuple[float, str]:
    """Factor from metres, and unit, that suit the typical one of `values` [m]."""
    finite = [value for value in values if np.isfinite(value) and value > 0.0]
    return (1e6, "µm") if not finite or np.median(finite) < 1e-3 else (1e3, "mm")


def angle_unit(values: Iterable[float]) -> tuple[float, str]:
    """Factor from radians, and unit, that suit the typical one of small `values` [rad]."""
    finite = [value for value in values if np.isfinite(value) and value > 0.0]
    return (1e6, "µrad") if not finite or np.median(finite) < 1e-3 else (1e3, "mrad")


def shown_unit(unit: str, values: Iterable[float] = ()) -> tuple[float, str]:
    """Factor from the SI `unit`, and unit, in which people read results such as `values` [unit]."""
    if unit in _SMALL:
        return _SMALL[unit](values)
    return _PEOPLE.get(unit, (1.0, unit))


def readable(compliance: str, value: float) -> tuple[float, str]:
    """Factor from SI, and unit, in which a value of a `compliance` is no large number."""
    if compliance in _SOFT and 1e-5 <= value < np.inf:
        return 1e6, _SOFT[compliance]
    return 1e9, f"n{compliance}"


_SOFT = {"rad/(N·m)": "µrad/(N·m)", "m/N": "µm/N"}


def length(value: float, digits: int = 3) -> str:
    """A small length [m] with its unit."""
    return " ".join(part for part in length_and_unit(value, digits) if part)


def length_and_unit(value: float, digits: int = 3) -> tuple[str, str]:
    """A small length [m] as a number and its unit, which is empty if it is not finite."""
    return _with_unit(value, "m", digits)


def small(value: float, unit: str, digits: int = 3) -> str:
    """A small length [m] or angle [rad] with its unit."""
    return " ".join(part for part in _with_unit(value, unit, digits) if part)


def _with_unit(value: float, si: str, digits: int) -> tuple[str, str]:
    if not np.isfinite(value):
        return number(value), ""
    factor, unit = shown_unit(si, [value])
    return number(factor * value, digits), unit


_SMALL = {"m": length_unit, "rad": angle_unit}


_RAREST = 1e-6  # no distribution is known so far out


def probability(p: float) -> str:
    """A p value: p = 0.03; of the very small ones only that they are."""
    return "p < 10⁻⁶" if p < _RAREST else f"p = {short(p) if p >= 1e-4 else number(p, 2)}"


def percent(share: float) -> str:
    """A share of 1; efficiencies near 1 keep the digits that tell them from 1."""
    if not np.isfinite(share):
        return "–"
    loss = 1.0 - share
    if loss == 0.0:
        return "100 %"
    decimals = 0 if loss > 0.1 else 1 if loss > 0.01 else 2
    shown = min(100.0 * share, 100.0)
    if loss > 0.0 and round(shown, decimals) == 100.0:
        return "> 99.99 %" if decimals == 2 else f"{99.99:.{decimals}f} %"
    return f"{fixed(shown, decimals)} %"


def sure(confidence: float) -> str:
    """A confidence somebody chose, without the zeros it was not given with."""
    return f"{100.0 * confidence:.4g}\u00a0%"


def shown(unit: str) -> tuple[float, str]:
    """Factor from an SI unit, and the sign of the unit it is shown in."""
    return {"rad": (180.0 / np.pi, "°"), "m": (1e3, "mm")}.get(unit, (1.0, unit))


def suffix(unit: str) -> str:
    """A unit as it stands behind a number."""
    return unit if unit == "°" else f" {unit}"


def described(value: float, unit: str, digits: int = 4) -> str:
    """A value in SI units as people read it: degrees and millimetres."""
    factor, sign = shown(unit)
    return f"{factor * value:.{digits}g}{suffix(sign)}"


def bounded(what: str, relation: str, bound: float, unit: str) -> str:
    """What is limited, and how: 'height of M1 >= 800 mm'."""
    return f"{what} {relation} {described(bound, unit, 6)}"


def given(value: float) -> str:
    """A length somebody chose [m], without the zeros it was not given with."""
    factor, unit = length_unit([value])
    return f"{factor * value:.6g}\u00a0{unit}"


def words(name: str) -> str:
    """Words with the signs that typewriters lack, and no line break before a unit."""
    signs = name.replace(">=", "≥").replace("<=", "≤")
    return _UNIT.sub("\u00a0\\1", signs)


def vector(values: Array, decimals: int = 0) -> str:
    """Three components in brackets."""
    return "[" + ", ".join(fixed(float(value), decimals) for value in values) + "]"


def direction(values: Array) -> str:
    """Where a vector points if it is along an axis of the base frame, else its components."""
    largest = int(np.argmax(np.abs(values)))
    rest = np.delete(values, largest)
    if np.abs(rest).max() > 1e-6 * abs(values[largest]):
        return ""
    if largest == 2:
        return "straight up" if values[2] > 0 else "straight down"
    return f"along {'+' if values[largest] > 0 else '−'}{_AXES[largest]}"
