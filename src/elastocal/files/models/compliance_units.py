"""Units of compliance and stiffness in files, and their factors to SI."""

from __future__ import annotations

from elastocal.errors import InputError

_FACTORS = {
    "rad/(N·m)": {"rad/N.m": 1.0, "mrad/N.m": 1e-3, "urad/N.m": 1e-6}
    | {"rad/kN.m": 1e-3, "mrad/kN.m": 1e-6},
    "m/N": {"m/N": 1.0, "mm/N": 1e-3, "um/N": 1e-6, "mm/kN": 1e-6},
    "N·m/rad": {"N.m/rad": 1.0, "kN.m/rad": 1e3, "MN.m/rad": 1e6}
    | {"N.m/mrad": 1e3, "N.m/urad": 1e6},
    "N/m": {"N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3, "N/um": 1e6, "kN/mm": 1e6},
}
_QUANTITIES = {
    "rad/(N·m)": "a compliance of an angular spring",
    "m/N": "a compliance of a linear spring",
    "N·m/rad": "a stiffness of an angular spring",
    "N/m": "a stiffness of a linear spring",
}
_ALIKE = str.maketrans(
    {"·": ".", "⋅": ".", "*": ".", "µ": "u", "μ": "u", "(": "", ")": "", " ": ""}
)


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
    plain = unit.translate(_ALIKE).replace("Nm", "N.m")
    if plain in _FACTORS[si]:
        return _FACTORS[si][plain]
    other = next((known for known, factors in _FACTORS.items() if plain in factors), None)
    what = f"is that of {_QUANTITIES[other]}" if other else "is not known"
    raise InputError(f"unit {unit!r} {what}; expected {si}")
