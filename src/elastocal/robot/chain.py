"""Robot: a serial chain of revolute and prismatic joints, as data, and its tools.

A robot is data: fixed transforms, joint axes, limits. What follows from it, such as forward
kinematics and Jacobians, is in `posture.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.arrays import Array, BoolArray, freeze, unset
from elastocal.errors import InputError
from elastocal.robot.joint_kinds import JointKind, kind_of
from elastocal.robot.rotations import frame_about
from elastocal.robot.shapes import BodyMass, Shape


@dataclass(frozen=True)
class Joint:
    """One actuated joint.

    Attributes:
        name: Name by which files and messages address the joint.
        T_parent_joint: (4, 4) pose of the joint frame at q = 0 in the frame of the body
            before it [m].
        axis: (3,) axis in the joint frame; positive turn by the right-hand rule.
        prismatic: True if the joint slides along its axis [m], False if it turns [rad].
        lower: Lower limit [rad or m].
        upper: Upper limit [rad or m].
    """

    name: str
    T_parent_joint: Array
    axis: Array
    prismatic: bool = False
    lower: float = -np.inf
    upper: float = np.inf

    @property
    def kind(self) -> JointKind:
        """What goes with a joint that turns or slides: names and units."""
        return kind_of(self.prismatic)

    def __post_init__(self) -> None:
        transform = np.array(self.T_parent_joint, dtype=float)
        axis = np.array(self.axis, dtype=float)
        if transform.shape != (4, 4) or not np.all(np.isfinite(transform)):
            raise InputError(f"joint {self.name!r}: its transform must be a finite 4x4 matrix")
        length = float(np.linalg.norm(axis)) if axis.shape == (3,) else 0.0
        if not (np.isfinite(length) and length > 0.0):
            raise InputError(f"joint {self.name!r}: its axis must be a non-zero vector [x, y, z]")
        if not self.lower < self.upper:
            raise InputError(
                f"joint {self.name!r}: the lower limit {self.lower:g} must be below the upper "
                f"limit {self.upper:g}"
            )
        freeze(self, T_parent_joint=transform, axis=axis / length)


ROTATION = "rotation"
"""What the rotation of the flange is called among the targets of a tool."""


@dataclass(frozen=True)
class Tool:
    """What is mounted on the flange, as points in the flange frame [m].

    Attributes:
        name: Name of the tool.
        load_point: (3,) point where the wrench acts.
        markers: (K, 3) points whose deflection is measured or asked for.
        marker_names: K names.
        tcp: (3,) point whose accuracy matters in a test pose; the load point if not given.
        radius: How thick it is between the flange and its points, for collisions [m].
        rotation: Whether the rotation of the flange is measured or asked for too.
    """

    name: str
    load_point: Array
    markers: Array
    marker_names: tuple[str, ...]
    tcp: Array = field(default_factory=unset)
    radius: float = 0.03
    rotation: bool = False

    def __post_init__(self) -> None:
        tcp = self.tcp if np.size(self.tcp) else self.load_point
        freeze(self, tcp=np.reshape(tcp, 3), load_point=np.reshape(self.load_point, 3))
        freeze(self, markers=np.reshape(self.markers, (-1, 3)))
        if len(self.marker_names) != len(self.markers):
            raise InputError(
                f"tool {self.name!r}: {len(self.markers)} markers, {len(self.marker_names)} names"
            )
        if self.rotation and ROTATION in self.marker_names:
            raise InputError(
                f"tool {self.name!r}: a marker is called {ROTATION!r}, as the rotation of the "
                "flange is, which is measured too; give it another name"
            )

    @property
    def targets(self) -> tuple[str, ...]:
        """What an experiment reads: the markers, then the rotation if it is measured."""
        return (*self.marker_names, ROTATION) if self.rotation else self.marker_names

    @property
    def at_tcp(self) -> Tool:
        """The same tool with its TCP as the one marker, and nothing else to measure."""
        return replace(self, markers=self.tcp[None], marker_names=("TCP",), rotation=False)


@dataclass(frozen=True)
class Robot:
    """A serial chain from the base to the flange.

    Attributes:
        name: Name of the robot.
        joints: The n actuated joints from base to flange.
        T_tip_flange: (4, 4) pose of the flange in the frame of the last body [m].
        tools: Tools known for this robot, by name.
        masses: Masses of the bodies, for gravity; empty if not known.
        visuals: Shapes to draw, in the frames of their bodies.
        collisions: Shapes that must not touch.
        remarks: Sentences on what was left out or assumed when the robot was read from a file.
        sha256: Hash of that file, empty if there is none.
        links: Transforms of the chain in normal form, (n + 1, 4, 4); made here.
    """

    name: str
    joints: tuple[Joint, ...]
    T_tip_flange: Array = field(default_factory=lambda: np.eye(4))
    tools: dict[str, Tool] = field(default_factory=dict)
    masses: tuple[BodyMass, ...] = ()
    visuals: tuple[Shape, ...] = ()
    collisions: tuple[Shape, ...] = ()
    remarks: tuple[str, ...] = ()
    sha256: str = ""
    links: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not self.joints:
            raise InputError(f"robot {self.name!r}: it has no joints")
        names = [joint.name for joint in self.joints]
        repeated = sorted({name for name in names if names.count(name) > 1})
        if repeated:
            raise InputError(f"robot {self.name!r}: joint name {repeated[0]!r} is used twice")
        parts: list[BodyMass | Shape] = [*self.masses, *self.visuals, *self.collisions]
        for part in parts:
            if not 0 <= part.body <= len(self.joints):
                raise InputError(
                    f"robot {self.name!r}: {part.name!r} belongs to body {part.body}, but the "
                    f"bodies are 0 to {len(self.joints)}"
                )
        freeze(self, "T_tip_flange", links=_normal_form(self.joints, self.T_tip_flange))

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the n joints from base to flange."""
        return tuple(joint.name for joint in self.joints)

    @property
    def prismatic(self) -> BoolArray:
        """(n,) which joints slide."""
        return np.array([joint.prismatic for joint in self.joints])

    @property
    def shown_scale(self) -> Array:
        """(n,) factors from joint values to degrees or millimetres."""
        return np.array([joint.kind.scale for joint in self.joints])

    @property
    def lower(self) -> Array:
        """(n,) lower limits [rad or m]."""
        return np.array([joint.lower for joint in self.joints])

    @property
    def upper(self) -> Array:
        """(n,) upper limits [rad or m]."""
        return np.array([joint.upper for joint in self.joints])

    def index(self, names: Sequence[str]) -> list[int]:
        """Positions of the joints called `names` in the chain.

        Raises:
            InputError: a name is not a joint of this robot; the message lists those that are.
        """
        unknown = [name for name in names if name not in self.joint_names]
        if unknown:
            raise InputError(
                f"robot {self.name!r} has no joint {unknown[0]!r}; its joints are "
                f"{', '.join(self.joint_names)}"
            )
        return [self.joint_names.index(name) for name in names]


def transform(rotation: Array | None = None, translation: Sequence[float] = (0, 0, 0)) -> Array:
    """(4, 4) homogeneous transform of a (3, 3) rotation and a translation [m]."""
    matrix = np.eye(4)
    if rotation is not None:
        matrix[:3, :3] = rotation
    matrix[:3, 3] = translation
    return matrix


def T_body_joint(robot: Robot, body: int) -> Array:
    """(4, 4) frame of a joint, moved with its joint, seen from the frame of the body it moves.

    The bodies of a `Posture` have their z along the joint axis; files give masses and shapes in
    the joint's own frame. Both have the same origin. Body 0 is the base: the identity.

    Args:
        robot: Robot with n joints.
        body: Number of actuated joints that move the body, 0 to n.

    Source: ours; the normal form is G = T_parent_joint @ R with R z = axis, and R commutes as
    Rot(axis, q) @ R = R @ Rot(z, q), so the answer is Rᵀ for any q.
    """
    if body == 0:
        return np.eye(4)
    return transform(frame_about(robot.joints[body - 1].axis).T)


def _normal_form(joints: tuple[Joint, ...], T_tip_flange: Array) -> Array:
    """Transforms between bodies when every joint moves about, or along, its own z axis."""
    links = []
    undo = np.eye(4)
    for joint in joints:
        to_axis = transform(frame_about(joint.axis))
        links.append(undo @ joint.T_parent_joint @ to_axis)
        undo = to_axis.T
    links.append(undo @ T_tip_flange)
    return np.array(links)
