"""Joint limits, and joints that are held at a value."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints.base import Constraint, Pull
from elastocal.robot.posture import Posture


class JointLimit(Constraint):
    """One end of the range of one joint."""

    def __init__(self, name: str, joint: int, bound: float, *, upper: bool, unit: str) -> None:
        """`joint` is the position in the chain, `bound` its limit [rad or m]."""
        self.name, self.unit = name, unit
        self.joint, self.bound, self.sign = joint, bound, -1.0 if upper else 1.0

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        def pull(weights: Array) -> Array:
            gradient = np.zeros_like(posture.q)
            gradient[self.joint] = self.sign * weights
            return gradient

        return self.sign * (posture.q[self.joint] - self.bound), pull


class HeldJoint(Constraint):
    """One joint stays where it is: the margin is minus its distance from there, 0 at best."""

    def __init__(self, name: str, joint: int, value: float, *, unit: str) -> None:
        """`joint` is the position in the chain, `value` where it is held [rad or m]."""
        self.name, self.unit, self.joint, self.value = name, unit, joint, value

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        off = posture.q[self.joint] - self.value

        def pull(weights: Array) -> Array:
            gradient = np.zeros_like(posture.q)
            gradient[self.joint] = -np.sign(off) * weights
            return gradient

        return -np.abs(off), pull
