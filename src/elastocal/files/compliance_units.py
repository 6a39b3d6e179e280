"""Units of compliance and stiffness in files, and their factors to SI."""

from __future__ import annotations

from elastocal.errors import InputError

ANGULAR, LINEAR = "rad/(N·m)", "m/N"
ANGULAR_STIFFNESS, LINEAR_STIFFNESS = "N·m/rad", "N/m"

_FACTORS = {
    ("compliance", False): {
        "rad/N.m": 1.0,
        "mrad/N.m": 1e-3,
        "urad/N.m": 1e-6,
        "rad/kN.m": 1e-3,
        "mrad/kN.m": 1e-6,
    },
    ("compliance", True): {"m/N": 1.0, "mm/N": 1e-3, "um/N": 1e-6, "mm/kN": 1e-6},
    ("stiffness", False): {
        "N.m/rad": 1.0,
        "kN.m/rad": 1e3,
        "MN.m/rad": 1e6,
        "N.m/mrad": 1e3,
        "N.m/urad": 1e6,
    },
    ("stiffness", True): {"N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3, "N/um": 1e6, "kN/mm": 1e6},
}
_ALIKE = str.maketrans(
    {"·": ".", "⋅": ".", "*": ".", "µ": "u", "μ": "u", "(": "", ")": "", " ": ""}
)


def unit_of(kind: str, prismatic: bool) -> str:
    """The SI unit in which files give a "compliance" or a "stiffness"."""
    if kind == "compliance":
        return LINEAR if prismatic else ANGULAR
    return LINEAR_STIFFNESS if prismatic else ANGULAR_STIFFNESS


def factor_to_si(kind: str, unit: object, prismatic: bool) -> float:
    """Factor from `unit` to SI; "rad/(N.m)", "rad/(N·m)" and "rad/Nm" are the same.

    Args:
        kind: "compliance" or "stiffness".
        unit: What the file says.
        prismatic: Whether the spring is linear.

    Raises:
        InputError: not a unit of this quantity.
    """
    expected = f"expected {unit_of(kind, prismatic)}"
    if not isinstance(unit, str):
        raise InputError(f"{expected} as unit, found {unit!r}")
    known = _FACTORS[kind, prismatic]
    plain = unit.translate(_ALIKE).replace("Nm", "N.m")
    if plain not in known:
        others = {k: v for k, v in _FACTORS.items() if plain in v}
        if others:
            quantity, linear = next(iter(others))
            spring = "a linear" if linear else "an angular"
            raise InputError(
                f"unit {unit!r} is that of a {quantity} of {spring} spring; {expected}"
            )
        raise InputError(f"unit {unit!r} is not known; {expected}")
    return known[plain]
