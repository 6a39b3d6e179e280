"""How far what was found of each joint moves the tool: geometry and sag side by side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.calibration.calibrate import Calibration, values_of
from elastocal.calibration.parameters import COMPLIANCE
from elastocal.calibration.prediction import predicted
from elastocal.robot.geometry import GROUPS


@dataclass(frozen=True)
class JointShare:
    """What one joint, or spring, does to the positions that were read.

    Attributes:
        name: Of the joint or the spring.
        geometry: Root mean square length by which its geometric errors move them [m].
        sag: The same of its compliance [m].
    """

    name: str
    geometry: float
    sag: float


def joint_shares(found: Calibration) -> tuple[JointShare, ...]:
    """What every joint and spring does to the positions, to first order.

    Of errors that do the same, what rests on its prior is small and counts for nothing.
    """
    p, values = found.parameters, values_of(found)
    points = ~found.positions.rotations
    rows = predicted(found.model, found.positions, p, found.state).rows[points]
    names = [joint.name for joint in found.model.robot.moving]
    names += [name for name in found.model.compliances.names if name not in names]
    shares = []
    for name in names:
        geometry = [
            u for u in p.of(*GROUPS) if p.names[u].split(" ", 1)[1] == name and p.block[u] in GROUPS
        ]
        sag = [u for u in p.of(COMPLIANCE) if p.names[u] == name]
        if geometry or sag:
            moved = [_rms(rows[..., mine] @ values[mine]) for mine in (geometry, sag)]
            shares.append(JointShare(name, *moved))
    return tuple(shares)


def _rms(moved: Array) -> float:
    return float(np.sqrt((moved**2).sum(axis=1).mean())) if len(moved) else 0.0
