"""Numbers, vectors and names as they may stand in a file, and the base of all sections.

A type with the name of a unit converts: what is millimetres in the file is metres in the model.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Annotated, Any, Literal, TypeVar

from elastocal.files.sections import After, Before, Told, Variant, as_written
from elastocal.names import LONGEST, flaw

_LONGEST_PATH = 4096  # as long as paths may be
_DIGITS = re.compile(r"[-+]?(0[xX][\da-fA-F_]+|(0[oObB])?[\d_:.]+([eE][-+]?\d+)?)", re.ASCII)
_ROUNDING = 1e-3  # by which a share may be above 1; closer claims are judged, not refused
_EXTREME = "expected a number of ordinary size, found one beyond 1e30 or 1e-30"


def _finite(value: Any) -> float:
    """A number below 1e30."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        hint = ""
        if isinstance(value, str) and _DIGITS.fullmatch(value):
            hint = "; write it in decimal, without quotes, leading zeros, colons and underscores"
        elif isinstance(value, str) and re.match(r"[-+]?[\d.]+\s*[A-Za-z°]", value):
            hint = "; the unit belongs in the key, the value is a bare number"
        elif isinstance(value, str) and re.fullmatch(r"[-+]?\d+,\d+", value):
            hint = "; write the decimal point as '.'"
        raise ValueError(f"expected a number, found {as_written(value)}{hint}")
    if not math.isfinite(value if isinstance(value, float) else 0.0):
        raise ValueError(f"expected a finite number, found {value}")
    if not abs(value) < 1e30:
        raise ValueError(_EXTREME)
    return float(value)


def _number(value: Any) -> float:
    number = _finite(value)
    if not (number == 0.0 or abs(number) > 1e-30):
        raise ValueError(_EXTREME)
    return number


def _positive(value: Any) -> float:
    number = _number(value)
    if not number > 0.0:
        raise ValueError(f"expected a positive number, found {number:g}")
    return number


def _non_negative(value: Any) -> float:
    return _from_zero(_number(value))


def _from_zero(number: float) -> float:
    if number < 0.0:
        raise ValueError(f"expected 0 or a positive number, found {number:g}")
    return number


def _count(value: Any) -> int:
    number = _whole(value)
    if not 1 <= number <= 1_000_000:
        raise ValueError(f"expected a whole number from 1 to 1000000, found {number}")
    return number


def _at_least_zero(value: Any) -> float:
    return _from_zero(_finite(value))


def _share(value: Any) -> float:
    number = _finite(value)
    if not 0.0 <= number <= 1.0 + _ROUNDING:
        raise ValueError(f"expected a share from 0 to 1, found {number:.10g}")
    return number


def _natural(value: Any) -> int:
    number = _whole(value)
    if number < 0:
        raise ValueError(f"expected a whole number from 0, found {number}")
    return number


def _whole(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"expected a whole number, found {as_written(value)}")
    return value


def _numbers(count: int, what: str, number: Callable[[Any], float] = _number) -> Before:
    def check(value: Any) -> list[float]:
        if not isinstance(value, list):
            raise ValueError(f"expected {what}, found {as_written(value)}")
        if len(value) != count:
            raise ValueError(f"expected {what}, found {len(value)} values")
        return [number(entry) for entry in value]

    return Before(check)


def _rows(value: Any) -> list[list[float]]:
    if not isinstance(value, list) or not all(isinstance(row, list) for row in value):
        raise ValueError("expected rows of numbers [[...], ...]")
    return [[_finite(entry) for entry in row] for row in value]


def _pair(value: Any) -> list[str]:
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"expected two names [A, B], found {as_written(value)}")
    return [_text(entry) for entry in value]


def _text(value: Any, longest: int = LONGEST) -> str:
    if isinstance(value, bool) or not isinstance(value, (str, int)):
        hint = "; yes, no, on and off are names in quotes" if isinstance(value, bool) else ""
        raise ValueError(f"expected a name, found {as_written(value)}{hint}")
    if not str(value).strip():
        raise ValueError("expected a name, found none")
    if wrong := flaw(str(value), longest):
        raise ValueError(wrong)
    return str(value)


def _argument(value: Any) -> str:
    """The text of a value that is handed on: booleans as xacro has them, numbers as written."""
    if isinstance(value, bool):
        return str(value).lower()
    if not isinstance(value, (str, int, float)):
        raise ValueError(f"expected a text or a number, found {as_written(value)}")
    if value != "" and (wrong := flaw(str(value), _LONGEST_PATH)):
        raise ValueError(wrong)
    return str(value)


def off_or(section: str) -> Before:
    """`off`, which YAML 1.1 reads as false; `section` is what may be written instead."""

    def check(value: Any) -> Any:
        if value is False or (isinstance(value, str) and value.lower() in ("off", "false", "no")):
            return "off"
        raise ValueError(f"expected off or {section}, found {as_written(value)}")

    return Before(check)


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"expected true or false without quotes, found {as_written(value)}")
    return value


def _metres(millimetres: float) -> float:
    return millimetres / 1e3


def _each(convert: Callable[[float], float]) -> After:
    return After(lambda values: [convert(value) for value in values])


def mm(length: float) -> str:
    """A length [m] in millimetres, as its file has it."""
    return f"{1e3 * length:g}"


def deg(angle: float) -> str:
    """An angle [rad] in degrees, as its file has it."""
    return f"{math.degrees(angle):g}"


Number = Annotated[float, Before(_number)]
Finite = Annotated[float, Before(_finite)]
"""A number however small, as products of sines and covariances are."""
FiniteVector = Annotated[list[float], _numbers(3, "three numbers [x, y, z]", _finite)]
Matrix = Annotated[list[list[float]], Before(_rows)]
AtLeastZero = Annotated[float, Before(_at_least_zero)]
"""As `Finite`, not negative: what sizes, errors and ratios are."""
Share = Annotated[float, Before(_share)]
Natural = Annotated[int, Before(_natural)]
"""How many of something there were: a whole number from 0."""
Positive = Annotated[float, Before(_positive)]
NonNegative = Annotated[float, Before(_non_negative)]
Count = Annotated[int, Before(_count)]
Vector = Annotated[list[float], _numbers(3, "three numbers [x, y, z]")]
Range = Annotated[list[float], _numbers(2, "two numbers [lower, upper]")]
Name = Annotated[str, Before(_text)]
"""One line of visible signs, not too long."""
FileName = Annotated[str, Before(lambda value: _text(value, _LONGEST_PATH))]
"""A name with folders."""
Argument = Annotated[str, Before(_argument)]
Flag = Annotated[bool, Before(_flag)]
NamePair = Annotated[list[str], Before(_pair)]
Axis = Literal["x", "y", "z"] | Vector

Millimetres = Annotated[Number, After(_metres)]
PositiveMillimetres = Annotated[Positive, After(_metres)]
MillimetreVector = Annotated[Vector, _each(_metres)]
MillimetreRange = Annotated[Range, _each(_metres)]
Micrometres = Annotated[Number, After(lambda value: value / 1e6)]
PositiveMicrometres = Annotated[Positive, After(lambda value: value / 1e6)]
PositiveMilliradians = Annotated[Positive, After(lambda value: value / 1e3)]
Degrees = Annotated[Number, After(math.radians)]
PositiveDegrees = Annotated[Positive, After(math.radians)]
DegreeVector = Annotated[Vector, _each(math.radians)]
DegreeRange = Annotated[Range, _each(math.radians)]
Minutes = Annotated[Number, After(lambda value: 60.0 * value)]


_T = TypeVar("_T")
_U = TypeVar("_U")
Either = Annotated[
    Annotated[_T, Variant("plain")] | Annotated[_U, Variant("section")],
    Told(lambda value: "section" if isinstance(value, dict) else "plain"),
]
"""A plain value or a section, told apart by form, so that errors speak of one of them only."""
OneOrByName = Either[_T, dict[Name, _T]]
ListOrByName = Either[list[_T], dict[Name, _T]]
