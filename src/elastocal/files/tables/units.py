"""Units in the headers of measurement files."""

from __future__ import annotations

import difflib
import re
import unicodedata

import numpy as np

_POUND_FORCE = 4.4482216152605  # N; 0.45359237 kg times standard gravity
_FOOT = 0.3048  # m
STANDARD_GRAVITY = 9.80665  # m/s²

UNITS: dict[str, dict[str, float]] = {
    "angle": {"deg": np.pi / 180.0, "rad": 1.0, "mrad": 1e-3},
    "rotation": {"mrad": 1e-3, "rad": 1.0, "urad": 1e-6, "deg": np.pi / 180.0},
    "length": {"mm": 1e-3, "m": 1.0, "cm": 1e-2, "um": 1e-6, "in": 0.0254},
    "force": {
        "N": 1.0,
        "kN": 1e3,
        "daN": 10.0,
        "kgf": STANDARD_GRAVITY,
        "lbf": _POUND_FORCE,
    },
    "torque": {
        "N.m": 1.0,
        "kN.m": 1e3,
        "daN.m": 10.0,
        "N.mm": 1e-3,
        "kgf.m": STANDARD_GRAVITY,
        "lbf.ft": _POUND_FORCE * _FOOT,
        "lbf.in": _POUND_FORCE * 0.0254,
    },
    "mass": {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": 0.45359237},
    "time": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
    "covariance": {"mm2": 1e-6, "m2": 1.0, "um2": 1e-12},
    "covariance of rotations": {"mrad2": 1e-6, "rad2": 1.0, "urad2": 1e-12},
}
"""Factor to SI of every unit in our spelling, by kind of quantity."""

_SIGNS = str.maketrans(
    {
        "µ": "u",
        "μ": "u",
        "°": "deg",
        "º": "deg",
        "˚": "deg",
        **dict.fromkeys("·⋅∙•‧*-‐", "."),
        **dict.fromkeys("^ ", ""),
    }
)
_WITHOUT_DOT = {unit.replace(".", ""): unit for unit in UNITS["torque"]}
_OTHERS = {
    "degree": "deg",
    "degrees": "deg",
    "grad": "deg",
    "radian": "rad",
    "radians": "rad",
    "inch": "in",
    "newton": "N",
    "micron": "um",
}


def split_header(cell: str) -> tuple[str, str | None]:
    """('A1', 'deg') of 'A1  [deg]'; the unit is None without brackets, single spaces inside."""
    text = " ".join(cell.split()).removeprefix("'").strip()
    found = re.fullmatch(r"(.*?)\s*\[([^\[\]]*)\]", text)
    return (found[1], found[2].strip()) if found else (text, None)


def spelled(unit: str) -> str:
    """The unit in our spelling, in which units are compared: µm is um, ° is deg, Nm is N.m."""
    plain = signs_as_ascii(unit)
    return _WITHOUT_DOT.get(plain, plain)


def signs_as_ascii(unit: str) -> str:
    """A unit with u for µ, deg for °, a point for any dot, 2 for ², and without spaces."""
    known = unit.translate(_SIGNS)  # before the rest: º is an ordinal sign to Unicode
    return unicodedata.normalize("NFKC", known).translate(_SIGNS)


def factor(unit: str, kind: str) -> float | None:
    """Factor from `unit` to SI, None if it is no unit of this kind."""
    return UNITS[kind].get(spelled(unit))


def unit_hint(unit: str, kind: str) -> str:
    """What to write instead of a unit that was not accepted."""
    plain = spelled(unit)
    own = list(UNITS[kind])
    if kind == "force" and plain in UNITS["mass"]:
        return (
            "a mass is no force; write N or kgf, or name the column 'hanging mass [kg]' if a "
            "weight hung there"
        )
    other = next((k for k, units in UNITS.items() if plain in units and k != kind), None)
    if other:
        return f"that is a unit of {other}; expected one of {', '.join(own)}"
    near = _OTHERS.get(plain.lower()) or next(
        iter(
            [u for u in own if u.lower() == plain.lower()]
            or difflib.get_close_matches(plain, own, 1)
        ),
        None,
    )
    wrong = near is not None and near not in own
    meant = f"did you mean {near}? " if near and not wrong else ""
    return f"{meant}expected one of {', '.join(own)}"
