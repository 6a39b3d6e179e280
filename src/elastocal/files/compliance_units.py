"""Units of compliance and stiffness in files, and their factors to SI."""

from __future__ import annotations

from elastocal.errors import InputError
from elastocal.files.tables.units import signs_as_ascii

_KNOWN = {
    "rad/(N·m)": (
        "a compliance of an angular spring",
        {
            "rad/N.m": 1.0,
            "mrad/N.m": 1e-3,
            "urad/N.m": 1e-6,
            "rad/kN.m": 1e-3,
            "mrad/kN.m": 1e-6,
        },
    ),
    "m/N": (
        "a compliance of a linear spring",
        {"m/N": 1.0, "mm/N": 1e-3, "um/N": 1e-6, "mm/kN": 1e-6},
    ),
    "N·m/rad": (
        "a stiffness of an angular spring",
        {
            "N.m/rad": 1.0,
            "kN.m/rad": 1e3,
            "MN.m/rad": 1e6,
            "N.m/mrad": 1e3,
            "N.m/urad": 1e6,
        },
    ),
    "N/m": (
        "a stiffness of a linear spring",
        {"N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3, "N/um": 1e6, "kN/mm": 1e6},
    ),
}


def factor_to_si(unit: object, si: str) -> float:
    """Factor from `unit` to SI; "rad/(N.m)", "rad/(N·m)" and "rad/Nm" are the same.

    Args:
        unit: What the file says.
        si: SI unit of the quantity, as joint kinds have it.

    Raises:
        InputError: not a unit of this quantity.
    """
    if not isinstance(unit, str):
        raise InputError(f"expected {si} as unit, found {unit!r}")
    factors = _KNOWN[si][1]
    plain = signs_as_ascii(unit).replace("(", "").replace(")", "").replace("Nm", "N.m")
    if plain in factors:
        return factors[plain]
    for quantity, others in _KNOWN.values():
        if plain in others:
            raise InputError(f"unit {unit!r} is that of {quantity}; expected {si}")
    raise InputError(f"unit {unit!r} is not known; expected {si}")
