"""Units of columns: every factor against numbers from elsewhere."""

from __future__ import annotations

import pytest

from elastocal.files.tables.units import UNITS, factor, spelled, split_header

# NIST Special Publication 811, appendix B; a degree is π/180.
SI = {
    "angle": {"deg": 1.745329252e-2, "rad": 1.0, "mrad": 1e-3},
    "rotation": {"mrad": 1e-3, "rad": 1.0, "urad": 1e-6, "deg": 1.745329252e-2},
    "length": {"mm": 1e-3, "m": 1.0, "cm": 1e-2, "um": 1e-6, "in": 2.54e-2},
    "force": {"N": 1.0, "kN": 1e3, "daN": 1e1, "kgf": 9.80665, "lbf": 4.448222},
    "torque": {
        "N.m": 1.0, "kN.m": 1e3, "daN.m": 1e1, "N.mm": 1e-3, "kgf.m": 9.80665,
        "lbf.ft": 1.355818, "lbf.in": 0.1129848,
    },
    "mass": {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": 0.4535924},
    "time": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
    "covariance": {"mm2": 1e-6, "m2": 1.0, "um2": 1e-12},
    "covariance of rotations": {"mrad2": 1e-6, "rad2": 1.0, "urad2": 1e-12},
}  # fmt: skip


def test_every_factor_is_that_of_the_tables() -> None:
    assert {kind: set(units) for kind, units in UNITS.items()} == {k: set(u) for k, u in SI.items()}
    for kind, units in SI.items():
        for unit, size in units.items():
            assert factor(unit, kind) == pytest.approx(size, rel=3e-7), unit
    assert factor("N", "length") is None


TWINS = {
    "N.m": ("N·m", "N*m", "N ⋅ m", "Nm", "N m", "N-m", "N\u00a0m", "N∙m"),
    "kN.m": ("kNm", "kN·m"),
    "N.mm": ("Nmm", "N·mm"),
    "lbf.ft": ("lbf·ft", "lbf-ft"),
    "mm2": ("mm²", "mm^2", "mm ²", "㎟"),
    "um": ("\u00b5m", "\u03bcm", "\u339b"),
    "um2": ("µm²", "μm^2", "um²"),
    "urad": ("µrad", "\u03bcrad"),
    "urad2": ("µrad²", "μrad^2"),
    "deg": ("°", "º", "˚"),
}


@pytest.mark.parametrize("unit", TWINS)
def test_spellings_of_one_unit(unit: str) -> None:
    assert {spelled(twin) for twin in (unit, *TWINS[unit])} == {unit}
    kinds = [kind for kind in UNITS if unit in UNITS[kind]]
    assert kinds
    for kind in kinds:
        assert {factor(twin, kind) for twin in TWINS[unit]} == {UNITS[kind][unit]}


def test_no_two_units_have_one_spelling() -> None:
    for units in UNITS.values():
        assert {spelled(unit) for unit in units} == set(units)
    assert spelled("m.m") == "m.m"
    assert factor("m.m", "length") is None
    assert factor("Mm", "length") is None


def test_headers_are_names_and_units() -> None:
    assert split_header("A1   [ deg ]") == ("A1", "deg")
    assert split_header("'Fz[N]") == ("Fz", "N")
    assert split_header("marker  name") == ("marker name", None)
    assert split_header("a [b] c") == ("a [b] c", None)
