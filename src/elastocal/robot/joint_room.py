"""Joint values outside the limits, in words, and which ones are inside."""

from __future__ import annotations

import numpy as np

from elastocal.robot.chain import Joint


def outside(joint: Joint, value: float) -> str:
    """In words that a joint value [rad or m] is outside the limits; empty if it is not.

    Says too which value is inside: another turn of the same place, or the middle if it was zero.
    """
    if joint.lower - 1e-9 <= value <= joint.upper + 1e-9:
        return ""
    scale, unit = joint.kind.scale, joint.kind.suffix
    said = (
        f"{joint.name} at {scale * value:.6g}{unit}, outside its limits "
        f"{scale * joint.lower:.6g} to {scale * joint.upper:.6g}{unit}"
    )
    middle = 0.5 * (joint.lower + joint.upper)
    turned = value + 2.0 * np.pi * round((middle - value) / (2.0 * np.pi))
    if not joint.prismatic and joint.lower <= turned <= joint.upper:
        return f"{said}; the same place is at {scale * turned:.6g}{unit}"
    return f"{said}, whose middle is {scale * middle:.6g}{unit}"
