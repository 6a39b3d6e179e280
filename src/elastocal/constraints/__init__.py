"""Where the arm may be: signed margins over configurations, feasible where >= 0."""

from elastocal.constraints.base import Constraint, margins_at, room_at
from elastocal.constraints.clearance import Clearance
from elastocal.constraints.distinct import Distinct
from elastocal.constraints.joint_limit import HeldJoint, JointLimit
from elastocal.constraints.line_of_sight import LineOfSight
from elastocal.constraints.orientation import Elevation, Tilt
from elastocal.constraints.view import AcceptanceCone, BeamRange, HeadAzimuth, HeadElevation
from elastocal.constraints.workspace import HalfSpace, MinRadius

__all__ = [
    "AcceptanceCone",
    "BeamRange",
    "Clearance",
    "Constraint",
    "Distinct",
    "Elevation",
    "HalfSpace",
    "HeadAzimuth",
    "HeadElevation",
    "HeldJoint",
    "JointLimit",
    "LineOfSight",
    "MinRadius",
    "Tilt",
    "margins_at",
    "room_at",
]
