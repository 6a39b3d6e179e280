"""Constraints on configurations: signed margins in natural units, feasible where >= 0."""

from elastocal.constraints.base import Constraint
from elastocal.constraints.joint_limit import JointLimit
from elastocal.constraints.orientation import Elevation, Tilt
from elastocal.constraints.workspace import HalfSpace, MinRadius

__all__ = ["Constraint", "Elevation", "HalfSpace", "JointLimit", "MinRadius", "Tilt"]
