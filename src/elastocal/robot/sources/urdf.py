"""Robots from URDF files.

In: a file, the names of base and tip. Out: a `Robot`: the actuated joints between them by name,
fixed joints folded, masses and shapes of everything that hangs on them. Meshes are not opened.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.reading import bytes_of
from elastocal.robot.chain import Follower, Joint, Robot, T_body_joint, moved
from elastocal.robot.joint_kinds import KINDS, PRISMATIC, JointKind, kind_of
from elastocal.robot.reach import reach_of
from elastocal.robot.shapes import BodyMass, Shape
from elastocal.robot.sources.mesh_files import MeshFiles
from elastocal.robot.sources.urdf_elements import Urdf, UrdfJoint, read_elements
from elastocal.robot.sources.urdf_mimic import Following, followings
from elastocal.robot.sources.urdf_tree import Tree, first_few
from elastocal.wording.numbers import described

LARGEST = 10 * 1024 * 1024  # bytes of a robot file; meshes are in files of their own
_LONGEST_REACH = 50.0  # [m]
_DEGREES, _ENDLESS = 8.0 * np.pi, 200.0 * np.pi  # limits [rad] beyond which they are doubted

_SAME = 1e-6  # limits nearer than this are the same [rad or m]
_STILL = Following("", 0.0, 0.0)

Limits = Mapping[str, tuple[float, float]]
Places = dict[str, tuple[int, Array]]
"""By link: the body it moves with, and T_joint_link (4, 4) [m]."""


def from_urdf(
    path: str | Path,
    *,
    base: str | None = None,
    tip: str | None = None,
    packages: Mapping[str, str | Path] | None = None,
    arguments: Mapping[str, str] | None = None,
    limits: Limits | None = None,
) -> Robot:
    """Robot of a URDF or xacro file.

    Args:
        path: The file; with the ending .xacro it is expanded first.
        base: Link that is the base frame; the one without a parent if not given.
        tip: Link that is the flange; the only end of the chain if not given.
        packages: Folders of packages, for meshes named package://... and for xacro's find.
        arguments: Arguments of a xacro file by name.
        limits: Lower and upper limits by joint that replace those of the file [rad or m].

    Raises:
        InputError: the file is wrong, or not a robot this program can treat; one sentence.
    """
    path = Path(path)
    folders = {name: Path(folder) for name, folder in (packages or {}).items()}
    data = bytes_of(path, LARGEST)
    if path.suffix.lower() == ".xacro":
        from elastocal.robot.sources.xacro_text import expanded

        data = expanded(path, folders, arguments)
    elif arguments:
        raise InputError(
            f"{path}: arguments are for xacro files, whose names end in .xacro; this one is read "
            "as it is"
        )
    meshes = MeshFiles(path.parent, folders)
    robot = parse_urdf(data, str(path), meshes, base=base, tip=tip, limits=limits)
    if not arguments:
        return robot
    given = ", ".join(f"{name}: {value}" for name, value in arguments.items())
    return replace(robot, remarks=(f"expanded with arguments {given}", *robot.remarks))


def parse_urdf(
    data: bytes,
    where: str,
    meshes: MeshFiles,
    *,
    base: str | None = None,
    tip: str | None = None,
    limits: Limits | None = None,
) -> Robot:
    """Robot of the text of a URDF; `where` names the file in messages. See `from_urdf`."""
    urdf = read_elements(data, where)
    tree = Tree([link.name for link in urdf.links], urdf.joints, where)
    base_link = tree.base(base)
    tip_link = tree.tip(base_link, tip)
    chain = tree.chain(base_link, tip_link)
    remarks = list(urdf.remarks)
    robot, place = _robot(urdf, tree, chain, base_link, limits or {}, remarks)
    masses, visuals, collisions = _hanging(robot, urdf, place, meshes)
    return replace(
        robot,
        name=urdf.name or Path(where).stem,
        masses=tuple(masses),
        visuals=tuple(visuals),
        collisions=tuple(collisions),
        remarks=(*remarks, *meshes.remark()),
        sha256=hashlib.sha256(data).hexdigest(),
    )


def _robot(
    urdf: Urdf,
    tree: Tree,
    chain: list[UrdfJoint],
    base: str,
    limits: Limits,
    remarks: list[str],
) -> tuple[Robot, Places]:
    """The chain as a robot with its followers, and where every link is."""
    following = followings(urdf.joints)
    on_way = [joint.name for joint in chain if joint.type != "fixed"]
    own = set(on_way) - set(following)
    moves = {name for name, follows in following.items() if follows.leader in own}
    way = [name for name in on_way if name in own | moves]
    joints: list[Joint] = []
    followers: list[Follower] = []
    place: Places = {base: (0, np.eye(4))}
    number = {name: i for i, name in enumerate(way, 1)}  # of the bodies that joints move
    for link, joint, other in tree.away_from(base):
        body, T = place[link]
        back = other == joint.parent
        T = T if back else T @ joint.T_parent_child
        if joint.name in own:
            lower, upper = _limits(joint, limits, remarks)
            axis = _axis(joint, remarks)
            joints.append(Joint(joint.name, T, axis, joint.type == PRISMATIC.name, lower, upper))
        elif joint.name in moves:
            leader, factor, offset = following[joint.name]
            sign = -1.0 if back else 1.0
            moving = Joint(joint.name, T, _axis(joint, remarks), joint.type == PRISMATIC.name)
            followers.append(Follower(moving, body, leader, sign * factor, sign * offset))
            number.setdefault(joint.name, len(number) + 1)
        elif joint.name in following:
            offset = following[joint.name].offset
            T = T @ _standing(joint, -offset if back else offset, remarks)
        if joint.name in number:
            body, T = number[joint.name], np.eye(4)
        place[other] = body, T @ np.linalg.inv(joint.T_parent_child) if back else T
    tip = chain[-1].child if chain else base
    unknown = [name for name in limits if name not in {joint.name for joint in joints}]
    if unknown:
        names = ", ".join(joint.name for joint in joints)
        raise InputError(f"{urdf.where}: no joint {unknown[0]!r} to limit; the joints are {names}")
    if not joints:
        raise InputError(f"{urdf.where}: no joint moves between base {base!r} and tip {tip!r}")
    robot = Robot(
        urdf.name, tuple(joints), place[tip][1], followers=tuple(followers), chain=tuple(way)
    )
    if (size := reach_of(robot)) > _LONGEST_REACH:
        raise InputError(
            f"{urdf.where}: the chain reaches {size:.6g} m; URDF is in metres, were millimetres "
            "meant?"
        )
    remarks += _softer(urdf, joints, limits)
    remarks += _beside(urdf, following, own, moves, base, tip)
    return robot, place


def _standing(joint: UrdfJoint, value: float, remarks: list[str]) -> Array:
    """(4, 4) what a joint that stands at `value` [rad or m] does."""
    if not value:
        return np.eye(4)
    slides = joint.type == PRISMATIC.name
    return moved(Joint(joint.name, np.eye(4), _axis(joint, remarks), slides), value)


def _softer(urdf: Urdf, joints: Sequence[Joint], limits: Limits) -> Iterator[str]:
    """What is said of limits that the controller keeps within those of the file."""
    soft = {joint.name: joint for joint in urdf.joints if joint.name not in limits}
    found = []
    for joint in joints:
        written = soft.get(joint.name)
        low, high = (written and written.soft) or (0.0, 0.0)
        if written is None or low == high == 0.0:  # which many files say that mean none
            continue
        if not low < high:
            yield (
                f"{written.at}: its safety_controller has soft_lower_limit {low:g} and "
                f"soft_upper_limit {high:g}, between which it cannot move; these are not looked at"
            )
        elif not (low < joint.upper and high > joint.lower):
            yield (
                f"{written.at}: its safety_controller keeps it from {low:g} to {high:g}, outside "
                f"its limits {joint.lower:g} to {joint.upper:g}; these are not looked at"
            )
        elif low > joint.lower + _SAME or high < joint.upper - _SAME:
            scale, unit = joint.kind.scale, joint.kind.suffix
            found.append(f"{joint.name} {scale * low:.6g} to {scale * high:.6g}{unit}")
    if found:
        yield (
            f"its safety_controller keeps {first_few(found)}; planned with are the wider limits of "
            "<limit>, at whose ends such a controller slows down or stops: give limits_deg or "
            "limits_mm to stay within"
        )


def _beside(
    urdf: Urdf,
    following: Mapping[str, Following],
    own: set[str],
    moves: set[str],
    base: str,
    tip: str,
) -> Iterator[str]:
    """What is said of joints that do not move on their own."""
    used = own | moves
    still = [
        joint.name for joint in urdf.joints if joint.type != "fixed" and joint.name not in used
    ]
    idle = [name for name in still if not following.get(name, _STILL).offset]
    if idle:
        yield f"{first_few(idle)}: not between {base!r} and {tip!r}, held at zero"
    kinds = {joint.name: kind_of(joint.type == PRISMATIC.name) for joint in urdf.joints}
    held = [
        f"{name} at {described(following[name].offset, kinds[name].unit)}"
        for name in still
        if following.get(name, _STILL).offset
    ]
    if held:
        yield f"{first_few(held)}: held there, as what they follow is held at zero (mimic)"
    if moves:
        rows = [_row(name, following[name], kinds[name]) for name in following if name in moves]
        yield (
            f"{first_few(rows)}: these follow (mimic), in collision, weight and pictures. If they "
            "are the rods of a parallelogram, the arm bends otherwise than a serial one, which is "
            "not modelled"
        )


def _row(name: str, follows: Following, kind: JointKind) -> str:
    """A follower as an equation: "rod = j3 + 28.6°"."""
    factor = {1.0: "", -1.0: "-"}.get(follows.factor, f"{follows.factor:.4g} · ")
    if not follows.offset:
        return f"{name} = {factor}{follows.leader}"
    sign = "+" if follows.offset > 0.0 else "-"
    return f"{name} = {factor}{follows.leader} {sign} {described(abs(follows.offset), kind.unit)}"


def _axis(joint: UrdfJoint, remarks: list[str]) -> Array:
    """The axis of a joint that moves, which must be one this program can treat."""
    at, axis = joint.at, joint.axis
    if joint.type in ("floating", "planar"):
        raise InputError(
            f"{at} is {joint.type} and stands between base and tip; choose as 'base' the link "
            f"behind it, {joint.child!r}"
        )
    length = float(np.linalg.norm(axis))
    if length < 1e-6:
        raise InputError(
            f"{at} has axis {' '.join(f'{v:g}' for v in axis)}, which has no direction"
        )
    if abs(length - 1.0) > 1e-3:
        remarks.append(f"{at}: its axis has length {length:.4g}; only the direction is used")
    return axis


def _limits(joint: UrdfJoint, limits: Limits, remarks: list[str]) -> tuple[float, float]:
    """Limits of a joint of the chain [rad or m]."""
    if joint.name in limits:
        return limits[joint.name]
    at, lower, upper = joint.at, joint.lower, joint.upper
    slides = joint.type == PRISMATIC.name
    mend = f"mend the file, or give limits_{kind_of(slides).key} beside it"
    if joint.type not in [kind.name for kind in KINDS]:
        return -np.inf, np.inf
    if lower is None or upper is None:
        raise InputError(f"{at} is {joint.type} and has no lower and upper limit; {mend}")
    if not lower < upper:
        raise InputError(f"{at} has no room: lower limit {lower:g}, upper limit {upper:g}; {mend}")
    largest = max(abs(lower), abs(upper))
    if slides:
        if largest > _LONGEST_REACH:
            raise InputError(
                f"{at} slides from {lower:g} to {upper:g} m; URDF is in metres, were millimetres "
                f"meant? Otherwise {mend}, or choose a 'base' behind it, such as {joint.child!r}"
            )
        return lower, upper
    if largest > _ENDLESS and lower < 0.0 < upper:
        remarks.append(f"{at}: limits {lower:g} to {upper:g} are taken as none")
        return -np.inf, np.inf
    if largest > _DEGREES:
        raise InputError(
            f"{at} turns from {lower:g} to {upper:g}; URDF is in radians, were degrees meant? "
            f"Otherwise {mend}"
        )
    return lower, upper


def _hanging(
    robot: Robot,
    urdf: Urdf,
    place: Places,
    meshes: MeshFiles,
) -> tuple[list[BodyMass], list[Shape], list[Shape]]:
    """Masses, visuals and collision shapes in the frames of their bodies."""
    masses: list[BodyMass] = []
    shapes: dict[str, list[Shape]] = {"visual": [], "collision": []}
    frames = [T_body_joint(robot, body) for body in range(robot.bodies)]
    for link in urdf.links:
        if link.name not in place:
            continue
        body, T_joint_link = place[link.name]
        T_body_link = frames[body] @ T_joint_link
        if link.mass > 0.0:
            center = (T_body_link @ link.T_link_mass)[:3, 3]
            masses.append(BodyMass(body, link.mass, center, link.name))
        for kind, carried_shapes in shapes.items():
            for shape in link.shapes[kind]:
                file = meshes.find(shape.source) if shape.kind == "mesh" else None
                pose = T_body_link @ shape.pose
                carried_shapes.append(replace(shape, pose=pose, body=body, mesh=file))
    return masses, shapes["visual"], shapes["collision"]
