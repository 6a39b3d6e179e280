"""Joint torques that a controller measured, beside what weights and forces exert on the joints.

In: an arm as drawn, poses with torques. Out: how they go together, and the mass that is missing on
the flange if one explains what is left. Nothing is corrected, and no fit counts them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.equilibrium import unbent
from elastocal.elastic.springs import joint_springs
from elastocal.errors import Doubt
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot
from elastocal.robot.payloads import Payload

_SURE = 4.0  # standard errors of a mass that is there
_MENDS = 0.7  # of what is left must go with it
_LEAST = 0.1  # share of the largest load of a joint from which on another one counts
_FEW = 5  # poses from which on anything is said


@dataclass(frozen=True)
class TorqueCheck:
    """How measured torques and loads of joints go together.

    Attributes:
        joints: Names of the joints that are loaded.
        load: Root mean square of the loads of these joints [N·m or N], about their means.
        share: Torques over loads; negative if a motor's torque counts against the load.
        left: Root mean square of what differs, with an offset for each joint.
        mass: Mass more on the flange that explains most of it [kg]; 0 if none does.
    """

    joints: tuple[str, ...]
    load: float
    share: float
    left: float
    mass: float = 0.0

    @property
    def doubt(self) -> Doubt:
        """The same as what is said of readings."""
        numbers = {"load": self.load, "share": self.share, "left": self.left, "mass": self.mass}
        return Doubt("torques-compared", self.joints, numbers=numbers)


def torque_check(
    found: Positions, robot: Robot, gravity: Array, payloads: tuple[Payload, ...]
) -> TorqueCheck | None:
    """Measured joint torques beside the arm as drawn; None if there are none, or too few.

    Args:
        found: Poses with torques, configurations, forces and payloads.
        robot: The robot, with the masses of its links.
        gravity: (3,) acceleration that masses feel, base frame [m/s²].
        payloads: What may hang on the flange.

    Source: ours; sensors have offsets, and signs of makers differ.
    """
    if not found.torque.size or len(found.cases) < _FEW:
        return None
    loads = _loads(found, robot, gravity, payloads)
    loads = loads - loads.mean(axis=0)
    torque = found.torque - found.torque.mean(axis=0)
    each = np.sqrt((loads**2).mean(axis=0))
    loaded = each > _LEAST * each.max(initial=0.0)
    names = tuple(name for name, own in zip(robot.joint_names, loaded, strict=True) if own)
    if not names:
        return TorqueCheck((), 0.0, 0.0, float(np.sqrt((torque**2).mean())))
    y, tau = loads[:, loaded], torque[:, loaded]
    share = float((y * tau).sum() / (y * y).sum())
    rest = tau - np.copysign(1.0, share) * y
    left = float(np.sqrt((rest**2).mean()))
    scaled = float(np.sqrt(((tau - share * y) ** 2).sum()))  # another factor explains it, too
    mass = _missing(found, robot, gravity, loaded, np.copysign(1.0, share) * rest, scaled)
    return TorqueCheck(names, float(np.sqrt((y**2).mean())), share, left, mass)


def _loads(found: Positions, robot: Robot, gravity: Array, payloads: tuple[Payload, ...]) -> Array:
    """(N, n) what weights, payloads and forces exert on the joints [N·m or N]."""
    cases, springs = found.cases, joint_springs(robot)
    exerted = np.zeros(cases.q.shape)
    for number in np.unique(found.payload).tolist():
        mine = found.payload == number
        hung = payloads[number] if number >= 0 else None
        arm = ElasticArm(robot, springs, found.tool, gravity, hung)
        exerted[mine] = unbent(arm, cases.q[mine], cases.wrench[mine])[1]
    return exerted


def _missing(
    found: Positions, robot: Robot, gravity: Array, loaded: BoolArray, rest: Array, otherwise: float
) -> float:
    """Mass on the flange [kg] that explains most of the rest (N, k); 0 if none does.

    What else explains it leaves `otherwise`, as a norm.
    """
    bare, springs, q = replace(robot, masses=()), joint_springs(robot), found.cases.q
    nothing = np.zeros((len(q), 6))

    def of(center: Array) -> Array:
        arm = ElasticArm(bare, springs, found.tool, gravity, Payload("", 1.0, center))
        made = unbent(arm, q, nothing)[1][:, loaded]
        return np.asarray((made - made.mean(axis=0)).ravel())

    here = of(np.zeros(3))
    columns = np.column_stack([here, *(of(axis) - here for axis in np.eye(3))])
    values = np.linalg.lstsq(columns, rest.ravel(), rcond=None)[0]
    after = rest.ravel() - columns @ values
    freedom = max(after.size - 4 - rest.shape[1], 1)
    inverse = np.linalg.pinv(columns.T @ columns)
    error = float(np.sqrt(after @ after / freedom * inverse[0, 0]))
    less = np.sqrt(after @ after) < _MENDS * min(np.sqrt((rest**2).sum()), otherwise)
    return float(values[0]) if less and abs(values[0]) > _SURE * error else 0.0
