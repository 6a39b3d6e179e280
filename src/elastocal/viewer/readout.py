"""Readout: the numbers of one configuration under one load.

In: subject, tool, configuration, load. Out: deflections, margins, worth. Everything in SI units;
`readout_html` turns it into text.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.constraints import Constraint, JointLimit
from elastocal.constraints.view import ViewConstraint
from elastocal.elastic.cartesian import CartesianCompliance, cartesian_compliance
from elastocal.elastic.deflections import markers_at
from elastocal.elastic.equilibrium import equilibrium
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.sensitivity import worth
from elastocal.robot.chain import Tool
from elastocal.robot.posture import Posture
from elastocal.study.study import Study
from elastocal.viewer.subject import Subject

NEAR = {"rad": float(np.radians(5.0)), "m": 0.05}
"""Margins below this are shown as near, by their unit."""
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Room:
    """How far a configuration is from breaking a constraint.

    Attributes:
        name: Name of the constraint.
        margin: Room left [unit], negative if broken.
        unit: "m" or "rad".
        marker: Marker whose beam it is about, empty if it is about none.
    """

    name: str
    margin: float
    unit: str
    marker: str = ""

    @property
    def state(self) -> str:
        """broken, near or free."""
        if self.margin < -_ROUNDING:
            return "broken"
        return "near" if self.margin < NEAR.get(self.unit, 0.0) else "free"


@dataclass(frozen=True)
class Bending:
    """How the arm gives way.

    Attributes:
        points: Names of the K points that are watched.
        deflection: (K, 3) how far they move, loaded minus unloaded [m].
        displacement: (p,) how far the springs move, loaded minus unloaded [rad or m].
        idle: (p,) how far the weight of the links alone moves them [rad or m].
        problem: What is wrong instead, empty if nothing is.
    """

    points: tuple[str, ...]
    deflection: Array
    displacement: Array
    idle: Array
    problem: str = ""


@dataclass(frozen=True)
class Readout:
    """The numbers of one configuration.

    Attributes:
        place: Name of the point that is followed: the TCP, or a marker.
        position: (3,) where it is, unloaded, in the base frame [m].
        bending: How the arm gives way; None without compliances.
        rooms: Margins: first of the constraints, if the tool is the one they are made for, then
            of every joint the nearer limit.
        worth: Sensitivity over its largest value; None if not known, or with another tool.
        cartesian: How the TCP gives way to a force in any direction; None without compliances.
    """

    place: str
    position: Array
    bending: Bending | None
    rooms: tuple[Room, ...]
    worth: float | None
    cartesian: CartesianCompliance | None = None


def watched(subject: Subject, tool: Tool) -> Tool:
    """The tool with the points to be watched as markers: of a test pose the TCP."""
    if tool is subject.study.experiments.tool and len(tool.markers):
        return tool
    return tool.at_tcp


def read_out(subject: Subject, tool: Tool, q: Array, wrench: Array) -> Readout:
    """The numbers of a configuration.

    Args:
        subject: What is shown.
        tool: What the robot carries.
        q: (n,) joint values [rad or m].
        wrench: (6,) load at the tool's load point, base frame [N, N·m].
    """
    study = subject.study
    posture = Posture(study.robot, q[None])
    seen = watched(subject, tool)
    measured = tool is study.experiments.tool
    share = None
    if measured and subject.sensitivity is not None:
        case = LoadCases(q[None], wrench[None])
        share = float(worth(study, subject.sensitivity, case)[0])
    return Readout(
        place=seen.marker_names[0],
        position=frozen(posture.point(seen.markers[0])[:, 0]),
        bending=bending(subject, tool, q, wrench),
        rooms=(*(_rooms(study.constraints, posture) if measured else ()), *_joints(study, posture)),
        worth=share,
        cartesian=yielding(subject, tool, q),
    )


def bending(subject: Subject, tool: Tool, q: Array, wrench: Array) -> Bending | None:
    """How the arm gives way, by the nonlinear equilibrium; None without compliances."""
    if subject.model is None:
        return None
    arm = replace(subject.study.arm, springs=subject.model.springs, tool=watched(subject, tool))
    p, names = len(arm.springs), arm.tool.marker_names
    # Loaded, and under the weight of the links alone.
    cases = LoadCases(np.array([q, q]), np.array([wrench, np.zeros(6)]))
    rest = equilibrium(arm, subject.model.compliance, cases)
    if not rest.stable.all():
        nothing = np.zeros(p)
        problem = "the arm gives way under this load: no stable equilibrium"
        return Bending(names, np.zeros((len(names), 3)), nothing, nothing, problem)
    places = markers_at(arm, cases.q, rest.displacement).reshape(2, -1, 3)
    loaded, idle = rest.displacement
    return Bending(names, frozen(places[0] - places[1]), frozen(loaded - idle), frozen(idle))


def yielding(subject: Subject, tool: Tool, q: Array) -> CartesianCompliance | None:
    """Compliance and stiffness at the TCP of the tool; None without compliances."""
    if subject.model is None:
        return None
    arm = replace(subject.study.arm, tool=tool)
    return cartesian_compliance(arm, subject.model, q[None], subject.width)[0]


def _rooms(constraints: tuple[Constraint, ...], posture: Posture) -> tuple[Room, ...]:
    """Room to every constraint."""
    found = []
    for constraint in constraints:
        name = constraint.names_at(posture)[0]
        marker = constraint.marker if isinstance(constraint, ViewConstraint) else ""
        found.append(Room(name, float(constraint.room(posture)[0]), constraint.unit, marker))
    return tuple(found)


def _joints(study: Study, posture: Posture) -> tuple[Room, ...]:
    """Room of every joint to the nearer of its limits."""
    nearest: dict[int, Room] = {}
    for limit in study.joint_limits:
        if not isinstance(limit, JointLimit):
            continue
        room = Room(limit.name, float(limit.room(posture)[0]), limit.unit)
        if limit.joint not in nearest or room.margin < nearest[limit.joint].margin:
            nearest[limit.joint] = room
    return tuple(nearest[joint] for joint in sorted(nearest))
