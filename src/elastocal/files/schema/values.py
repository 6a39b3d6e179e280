"""Numbers, vectors and names as they may stand in a file, and the base of all sections."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict


def _number(value: Any) -> float:
    """A finite number. YAML 1.1 reads 1e-8 as text, so such text is accepted."""
    if isinstance(value, str) and re.fullmatch(r"[-+]?\d+(\.\d*)?[eE][-+]?\d+", value):
        value = float(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        hint = ""
        if isinstance(value, str) and re.match(r"[-+]?[\d.]+\s*[A-Za-z°]", value):
            hint = "; the unit belongs in the key, the value is a bare number"
        elif isinstance(value, str) and re.fullmatch(r"[-+]?\d+,\d+", value):
            hint = "; write the decimal point as '.'"
        raise ValueError(f"expected a number, found {value!r}{hint}")
    if not math.isfinite(value if isinstance(value, float) else 0.0):
        raise ValueError(f"expected a finite number, found {value}")
    if not (value == 0 or 1e-30 < abs(value) < 1e30):
        raise ValueError("expected a number of ordinary size, found one beyond 1e30 or 1e-30")
    return float(value)


def _positive(value: Any) -> float:
    number = _number(value)
    if not number > 0.0:
        raise ValueError(f"expected a positive number, found {number:g}")
    return number


def _count(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"expected a whole number, found {value!r}")
    if not 1 <= value <= 1_000_000:
        raise ValueError(f"expected a whole number from 1 to 1000000, found {value}")
    return value


def _numbers(count: int, what: str) -> BeforeValidator:
    def check(value: Any) -> list[float]:
        if not isinstance(value, list):
            raise ValueError(f"expected {what}, found {value!r}")
        if len(value) != count:
            raise ValueError(f"expected {what}, found {len(value)} values")
        return [_number(entry) for entry in value]

    return BeforeValidator(check)


def _pair(value: Any) -> list[str]:
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"expected two names [A, B], found {value!r}")
    return [_text(entry) for entry in value]


def _text(value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (str, int)):
        raise ValueError(f"expected a name, found {value!r}")
    if not str(value).strip():
        raise ValueError("expected a name, found none")
    return str(value)


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"expected true or false without quotes, found {value!r}")
    return value


Number = Annotated[float, BeforeValidator(_number)]
Positive = Annotated[float, BeforeValidator(_positive)]
Count = Annotated[int, BeforeValidator(_count)]
Vector = Annotated[list[float], _numbers(3, "three numbers [x, y, z]")]
Range = Annotated[list[float], _numbers(2, "two numbers [lower, upper]")]
Name = Annotated[str, BeforeValidator(_text)]
Flag = Annotated[bool, BeforeValidator(_flag)]
NamePair = Annotated[list[str], BeforeValidator(_pair)]
Axis = Literal["x", "y", "z"] | Vector


class Section(BaseModel):
    """A mapping of the file; unknown keys are errors."""

    model_config = ConfigDict(extra="forbid")
