"""The two kinds of joints, turning and sliding, and what goes with each: names and units.

Inside all is SI. Files, screens and messages ask the kind for what people read.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.wording.numbers import shown, suffix


@dataclass(frozen=True)
class JointKind:
    """What is true of every joint of a kind, and of a spring in one.

    Attributes:
        name: What files call it.
        moves: What it does, in a table.
        spring: What a spring in it is called.
        quantity: What its values are: "angle" or "length".
        unit: SI unit of its values.
        key: Unit of its values in headers and keys of files: "A1 [deg]", `limits_deg`.
        si: Factor from that unit to SI.
        decimals: Digits behind the point that are worth printing.
        load: Unit of what it bears.
        compliance: SI unit of a compliance.
        stiffness: SI unit of a stiffness.
    """

    name: str
    moves: str
    spring: str
    quantity: str
    unit: str
    key: str
    si: float
    decimals: int
    load: str
    compliance: str
    stiffness: str

    @property
    def shown(self) -> tuple[float, str]:
        """Factor from SI, and unit, in which people read values: degrees or millimetres."""
        return shown(self.unit)

    @property
    def scale(self) -> float:
        """The factor alone."""
        return self.shown[0]

    @property
    def shown_unit(self) -> str:
        """The unit alone."""
        return self.shown[1]

    @property
    def suffix(self) -> str:
        """The unit as it stands behind a number."""
        return suffix(self.shown_unit)


REVOLUTE = JointKind(
    name="revolute",
    moves="turns",
    spring="angular",
    quantity="angle",
    unit="rad",
    key="deg",
    si=np.pi / 180.0,
    decimals=3,
    load="N·m",
    compliance="rad/(N·m)",
    stiffness="N·m/rad",
)
PRISMATIC = JointKind(
    name="prismatic",
    moves="slides",
    spring="linear",
    quantity="length",
    unit="m",
    key="mm",
    si=1e-3,
    decimals=2,
    load="N",
    compliance="m/N",
    stiffness="N/m",
)
KINDS = (REVOLUTE, PRISMATIC)


def kind_of(prismatic: bool) -> JointKind:
    """The kind of a joint that slides, or else turns."""
    return PRISMATIC if prismatic else REVOLUTE
