"""The units of a kind of joint agree with each other and with those that files know."""

from __future__ import annotations

import pytest

from elastocal.files.compliance_units import factor_to_si
from elastocal.files.tables.units import UNITS, spelled
from elastocal.robot.joint_kinds import KINDS, PRISMATIC, REVOLUTE, JointKind, kind_of


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_units_agree(kind: JointKind) -> None:
    known = UNITS[kind.quantity]
    assert known[kind.key] == known[spelled(kind.shown_unit)] == kind.si
    assert known[spelled(kind.unit)] == 1.0
    assert kind.scale * kind.si == pytest.approx(1.0, rel=1e-15)
    assert kind.suffix.strip() == kind.shown_unit
    assert factor_to_si(kind.compliance, kind.compliance) == 1.0
    assert factor_to_si(kind.stiffness, kind.stiffness) == 1.0


def test_a_joint_that_slides_is_in_millimetres() -> None:
    assert (kind_of(True), kind_of(False)) == (PRISMATIC, REVOLUTE)
    assert 0.25 * PRISMATIC.scale == 250.0
    assert 3.141592653589793 * REVOLUTE.scale == 180.0
