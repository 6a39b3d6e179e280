"""Robot: a serial chain of revolute and prismatic joints, as data, and its tools.

A robot is data: fixed transforms, joint axes, limits. What follows from it, such as forward
kinematics and Jacobians, is in `posture.py`. There may be joints that follow another one, on the
chain as in a hollow wrist, or beside it as the rods of a parallelogram: so the value of every
joint, that of a follower too, is an affine function of the n joint values.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, freeze, unset
from elastocal.errors import InputError
from elastocal.robot.drawn_in import drawn_in
from elastocal.robot.joint_kinds import JointKind, kind_of
from elastocal.robot.rotations import frame_about, from_rotation_vectors
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
            lower, upper = (f"{self.kind.scale * x:g}" for x in (self.lower, self.upper))
            raise InputError(
                f"joint {self.name!r}: the lower limit {lower} must be below the upper limit "
                f"{upper} {self.kind.shown_unit}"
            )
        freeze(self, T_parent_joint=transform, axis=axis / length)


@dataclass(frozen=True)
class Follower:
    """A joint that does not move on its own: factor · leader + offset.

    Attributes:
        joint: The joint; its limits are not used.
        carrier: Number of the body that carries it, which comes before its own; not used if it
            stands on the chain.
        leader: Name of the joint that it follows, which moves on its own.
        factor: Its way for a unit way of the leader [its unit over that of the leader].
        offset: Its value where the leader is at zero [rad or m].
    """

    joint: Joint
    carrier: int
    leader: str
    factor: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.factor) and np.isfinite(self.offset)):
            raise InputError(
                f"joint {self.joint.name!r} follows {self.leader!r}: factor and offset must be "
                "finite numbers"
            )


_MOST_JOINTS = 1000  # matrices of their number squared are kept
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
    """A serial chain from the base to the flange, and what moves along with it.

    Its bodies are numbered: 0 is the base, 1 to m are moved by the joints of the chain in order,
    followers among them, m + 1 to n + F by followers beside it. Without followers m is n.

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
        followers: The F joints that follow others.
        chain: Names of the m joints from base to flange, followers included; empty if none is.
        links: Transforms of the chain in normal form, (m + 1, 4, 4); made here.
        shifts: (n + F,) how far along their axes the frames of the bodies stand from those of the
            joints [m]: zero, unless frames run far out and back; made here.
        branches: Transforms from their carriers to the followers beside the chain, in normal form.
        moving: The n + F joints that move the bodies 1 to n + F.
        place: (n,) where the joints that move on their own are among those.
        mixing: (n + F, n) ways of all joints that move for unit ways of the n.
        standing: (n + F,) their values where the n are at zero [rad or m].
        carriers: (n + F + 1,) number of the body that carries the joint of each body.
        carries: (n + F + 1, n + F) which joints move each body.
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
    followers: tuple[Follower, ...] = ()
    chain: tuple[str, ...] = ()
    links: Array = field(init=False, repr=False)
    shifts: Array = field(init=False, repr=False)
    branches: Array = field(init=False, repr=False)
    moving: tuple[Joint, ...] = field(init=False, repr=False)
    place: IntArray = field(init=False, repr=False)
    mixing: Array = field(init=False, repr=False)
    standing: Array = field(init=False, repr=False)
    carriers: IntArray = field(init=False, repr=False)
    carries: BoolArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not self.joints:
            raise InputError(f"robot {self.name!r}: it has no joints")
        count = len(self.joints) + len(self.followers)
        if count > _MOST_JOINTS:
            raise InputError(
                f"robot {self.name!r}: {count} joints that move, more than the {_MOST_JOINTS} that "
                "are treated; choose 'base' and 'tip' nearer to each other"
            )
        names = Counter((*self.joint_names, *(f.joint.name for f in self.followers)))
        repeated = sorted(name for name, times in names.items() if times > 1)
        if repeated:
            raise InputError(f"robot {self.name!r}: joint name {repeated[0]!r} is used twice")
        object.__setattr__(self, "moving", _moving(self))
        parts: list[BodyMass | Shape] = [*self.masses, *self.visuals, *self.collisions]
        for part in parts:
            if not 0 <= part.body < self.bodies:
                raise InputError(
                    f"robot {self.name!r}: {part.name!r} belongs to body {part.body}, but the "
                    f"bodies are 0 to {self.bodies - 1}"
                )
        way = {*self.way}
        beside = [f for f in self.followers if f.joint.name not in way]
        carriers = [0, *range(self.last), *(follower.carrier for follower in beside)]
        freeze(self, carriers=carriers, dtype=np.int64)
        freeze(self, carries=_carries(self), dtype=np.bool_)
        links, shifts = _normal_form(self.moving[: self.last], self.T_tip_flange)
        shifts = np.append(shifts, np.zeros(len(beside)))
        freeze(self, "T_tip_flange", links=links, shifts=shifts)
        freeze(self, branches=np.reshape([_branch(self, f) for f in beside], (-1, 4, 4)))
        at = {joint.name: i for i, joint in enumerate(self.moving)}
        freeze(self, place=[at[name] for name in self.joint_names], dtype=np.int64)
        mixing, standing = np.zeros((count, len(self.joints))), np.zeros(count)
        mixing[self.place, np.arange(len(self.joints))] = 1.0
        for follower in self.followers:
            mixing[at[follower.joint.name], self.index([follower.leader])[0]] = follower.factor
            standing[at[follower.joint.name]] = follower.offset
        freeze(self, mixing=mixing, standing=standing)

    @property
    def way(self) -> tuple[str, ...]:
        """Names of the m joints from base to flange."""
        return self.chain or self.joint_names

    @property
    def bodies(self) -> int:
        """Number of bodies, the base included."""
        return 1 + len(self.moving)

    @property
    def last(self) -> int:
        """Number m of the last body of the chain, which carries the flange."""
        return len(self.chain or self.joints)

    @property
    def follows(self) -> bool:
        """Whether a joint of the chain follows another, so that m is more than n."""
        return self.last > len(self.joints)

    @property
    def sliding(self) -> BoolArray:
        """(n + F,) which of the joints that move slide."""
        return np.array([joint.prismatic for joint in self.moving])

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


def transform(
    rotation: Array | None = None, translation: Sequence[float] | Array = (0, 0, 0)
) -> Array:
    """(4, 4) homogeneous transform of a (3, 3) rotation and a translation [m]."""
    matrix = np.eye(4)
    if rotation is not None:
        matrix[:3, :3] = rotation
    matrix[:3, 3] = translation
    return matrix


def moved(joint: Joint, value: float) -> Array:
    """(4, 4) what a joint does at a value [rad or m], in its own frame."""
    way = value * joint.axis
    if joint.prismatic:
        return transform(None, way)
    return transform(from_rotation_vectors(way[None])[0])


def T_body_joint(robot: Robot, body: int) -> Array:
    """(4, 4) frame of a joint, moved with its joint, seen from the frame of the body it moves.

    The bodies of a `Posture` have their z along the joint axis; files give masses and shapes in
    the joint's own frame. Both origins are on the axis, `robot.shifts` apart. Body 0 is the base:
    the identity.

    Args:
        robot: Robot with n joints and F followers.
        body: Number of the body, 0 to n + F.

    Source: ours; the normal form is G = T_parent_joint @ R @ S with R z = axis and S a shift along
    z. Both commute with the joint, Rot(axis, q) @ R @ S = R @ S @ Rot(z, q), so the answer is
    S⁻¹ Rᵀ for any q.
    """
    if body == 0:
        return np.eye(4)
    along = (0.0, 0.0, -float(robot.shifts[body - 1]))
    return transform(frame_about(robot.moving[body - 1].axis).T, along)


def _normal_form(joints: tuple[Joint, ...], T_tip_flange: Array) -> tuple[Array, Array]:
    """Transforms between bodies when every joint moves about, or along, its own z axis; shifts."""
    links = []
    undo = np.eye(4)
    for joint in joints:
        to_axis = transform(frame_about(joint.axis))
        links.append(undo @ joint.T_parent_joint @ to_axis)
        undo = to_axis.T
    links.append(undo @ T_tip_flange)
    return drawn_in(np.array(links), ~np.array([joint.prismatic for joint in joints]))


def _moving(robot: Robot) -> tuple[Joint, ...]:
    """The joints of the chain in order, then those beside it."""
    known = {joint.name: joint for joint in robot.joints}
    known |= {follower.joint.name: follower.joint for follower in robot.followers}
    names = {joint.name for joint in robot.joints}
    own = tuple(name for name in robot.way if name in names)
    if own != robot.joint_names or len({*robot.way} & {*known}) != robot.last:
        raise InputError(
            f"robot {robot.name!r}: its chain must name its joints in order, with followers between"
        )
    on_chain = {*robot.way}
    beside = (f.joint for f in robot.followers if f.joint.name not in on_chain)
    return (*(known[name] for name in robot.way), *beside)


def _branch(robot: Robot, follower: Follower) -> Array:
    """Transform from the carrier of a follower to it, in normal form."""
    joint = follower.joint
    to_axis = transform(frame_about(joint.axis))
    return np.asarray(T_body_joint(robot, follower.carrier) @ joint.T_parent_joint @ to_axis)


def _carries(robot: Robot) -> BoolArray:
    """(n + F + 1, n + F) which joints move each body: its own, and those that move its carrier."""
    found = np.zeros((robot.bodies, robot.bodies - 1), dtype=bool)
    for body in range(1, robot.bodies):
        carrier = int(robot.carriers[body])
        if not 0 <= carrier < body:
            raise InputError(
                f"robot {robot.name!r}: {robot.moving[body - 1].name!r} is carried by body "
                f"{carrier}, which does not come before it"
            )
        found[body] = found[carrier]
        found[body, body - 1] = True
    return found
