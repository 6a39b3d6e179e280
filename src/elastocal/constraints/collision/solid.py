"""Convex solids on the bodies of a robot, each inside a segment with a radius or a box.

In: a `Shape`. Out: `Solid`. Where the segment or the box is the shape itself, distances have
closed forms; elsewhere it bounds the shape from outside, and tells cheaply which pairs are near.
What stands in for a shape has faces near its surface, too.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.arrays import Array, freeze, unset
from elastocal.constraints.collision.mesh import convex_hull, hulls
from elastocal.constraints.collision.shell import Shell, box_shell, enclosing
from elastocal.robot.rotations import frame_about
from elastocal.robot.shapes import Shape

LINK_PARTS = 3
"""A link of more parts counts as one hull: covers and screws, that cost time and tell little."""


@dataclass(frozen=True)
class Solid:
    """A convex solid that moves with a body.

    Attributes:
        name: What the user calls it.
        body: Number of the body it moves with: 0 is the base and the cell, see `Robot`.
        kind: box, cylinder, sphere, capsule, hull, or plane: all below z = 0 of its pose.
        size: As in `Shape`; of a hull or plane not used.
        pose: (4, 4) T_body_solid [m].
        segment: (2, 3) ends of a segment in the frame of the body [m] ...
        radius: ... within this distance of which lies the whole solid [m].
        boxed: Whether the solid stands still in a box, used instead of the segment.
        half: (3,) half the sides of that box, centred and turned as `box_pose` says [m].
        box_pose: (4, 4) T_base_box [m].
        exact: Whether the segment with its radius, or the box, is the solid itself.
        vertices: (V, 3) corners of a hull in its own frame [m].
        faces: (F, 4) normals n and h [m]: the solid is where n·x <= h, too, in the frame of its
            body; F may be 0.
        corners: (C, 3) corners of the polytope that those faces bound [m].
        covered: Whether another solid of the robot covers it, so that obstacles need not see it.
        joint: Joint that moves it, by which it can be named too; "base"; empty for tool and cell.
    """

    name: str
    body: int
    kind: str
    size: Array
    pose: Array
    segment: Array
    radius: float
    exact: bool
    boxed: bool = False
    half: Array = field(default_factory=unset)
    box_pose: Array = field(default_factory=lambda: np.eye(4))
    vertices: Array = field(default_factory=unset)
    faces: Array = field(default_factory=unset)
    corners: Array = field(default_factory=unset)
    joint: str = ""
    covered: bool = False

    def __post_init__(self) -> None:
        freeze(self, "size", "pose", "segment", "half", "box_pose", "vertices")
        freeze(self, "faces", "corners")

    @property
    def shell(self) -> Shell:
        """Its faces and corners; of a capsule without any its ends, with their radius."""
        if len(self.faces):
            return Shell(self.body, self.faces, self.corners, 0.0)
        if self.boxed:
            return box_shell(self.body, self.box_pose, self.half)
        return Shell(self.body, np.zeros((0, 4)), self.segment, self.radius)

    @property
    def ball(self) -> float:
        """Radius of the ball around its segment or box [m]."""
        if self.boxed:
            return float(np.linalg.norm(self.half))
        return 0.5 * float(np.linalg.norm(self.segment[1] - self.segment[0])) + self.radius

    @property
    def reach(self) -> float:
        """Largest distance of a point of the solid from the origin of its body [m]."""
        return float(np.linalg.norm(self.segment, axis=1).max()) + self.radius

    @property
    def top(self) -> float:
        """Height that no point of the solid is above, in the frame of its body [m]."""
        if self.boxed:
            return float(self.box_pose[2, 3] + np.abs(self.box_pose[2, :3]) @ self.half)
        return float(self.segment[:, 2].max()) + self.radius


def capsule(name: str, body: int, start: Array, end: Array, radius: float) -> Solid:
    """A capsule between two points in the frame of a body [m]."""
    along = np.asarray(end, dtype=float) - start
    length = float(np.linalg.norm(along))
    pose = np.eye(4)
    pose[:3, :3] = frame_about(along / length if length > 0.0 else np.array([0.0, 0.0, 1.0]))
    pose[:3, 3] = (np.asarray(start) + end) / 2.0
    segment = np.array([start, end])
    return Solid(name, body, "capsule", np.array([radius, length]), pose, segment, radius, True)


def around(solid: Solid) -> Solid:
    """The capsule that bounds a solid which moves, the box that bounds one which stands still."""
    if not solid.boxed:
        start, end, radius = *solid.segment, solid.radius
        if solid.kind == "cylinder":  # a short one fits better into a ball
            ends, radius = bounding_capsule(_rims(*solid.size))
            start, end = ends @ solid.pose[:3, :3].T + solid.pose[:3, 3]
        plain = capsule(solid.name, solid.body, start, end, radius)
        return replace(plain, joint=solid.joint)
    return replace(
        solid,
        kind="box",
        size=2.0 * solid.half,
        pose=solid.box_pose,
        exact=True,
        vertices=unset(),
    )


def enclosed(solid: Solid) -> Solid:
    """What `around` puts around a solid, with few faces that are near its surface."""
    points = solid.vertices
    if solid.kind == "cylinder":
        points = _rims(*solid.size)
    elif solid.kind == "box":
        points = box_shell(0, np.eye(4), solid.size / 2.0).corners
    plain = around(solid)
    if not len(points) or (solid.kind == "box" and solid.boxed):
        return plain
    faces, corners = enclosing(points)
    turn, shift = solid.pose[:3, :3], solid.pose[:3, 3]
    normals = faces[:, :3] @ turn.T
    heights = faces[:, 3] + normals @ shift
    return replace(
        plain, faces=np.column_stack([normals, heights]), corners=corners @ turn.T + shift
    )


def without_faces(solid: Solid) -> Solid:
    """A solid as its capsule or box alone."""
    return replace(solid, faces=unset(), corners=unset()) if len(solid.faces) else solid


def _rims(radius: float, length: float) -> Array:
    """(48, 3) corners of a prism around a cylinder [m]."""
    turn = np.arange(_SIDES) * (2.0 * np.pi / _SIDES)
    rim = radius / np.cos(np.pi / _SIDES) * np.array([np.cos(turn), np.sin(turn)])
    ends = np.repeat([-length / 2.0, length / 2.0], _SIDES)
    return np.column_stack([*np.hstack([rim, rim]), ends])


_SIDES = 24


def plane(name: str, height: float) -> Solid:
    """All that is below a height in the base frame [m]."""
    pose = np.eye(4)
    pose[2, 3] = height
    return Solid(name, 0, "plane", unset(), pose, np.zeros((2, 3)), 0.0, True)


def beyond(solid: Solid, distance: float) -> Solid | None:
    """What of a capsule is farther than `distance` [m] from the origin of its body; None: nothing.

    The rest of it counts as another solid that covers this one.
    """
    if solid.kind != "capsule":
        return None
    near, far = sorted(solid.segment, key=np.linalg.norm)
    along = far - near
    # |near + s along| = distance, the larger of the two solutions
    a, b, c = along @ along, near @ along, near @ near - distance**2
    if a < 1e-12 or far @ far <= distance**2 or b * b < a * c:
        return None
    share = max((np.sqrt(b * b - a * c) - b) / a, 0.0)
    piece = capsule(solid.name, solid.body, near + share * along, far, solid.radius)
    return replace(piece, joint=solid.joint, covered=True)


def solids_of(shape: Shape, name: str) -> list[Solid]:
    """The convex solids of a shape: one, or one for every connected part of a mesh.

    Raises:
        InputError: the mesh cannot be used.
    """
    if shape.kind == "mesh":
        parts = hulls(shape)
        if shape.body > 0 and len(parts) > LINK_PARTS:
            parts = [convex_hull(np.vstack(parts))]
        return [
            _bounded(name, shape.body, "hull", shape.size, shape.pose, corners) for corners in parts
        ]
    if shape.kind in ("sphere", "capsule"):
        length = shape.size[1] if shape.kind == "capsule" else 0.0
        ends = np.array([[0.0, 0.0, -length / 2.0], [0.0, 0.0, length / 2.0]])
        segment = ends @ shape.pose[:3, :3].T + shape.pose[:3, 3]
        radius = float(shape.size[0])
        return [Solid(name, shape.body, shape.kind, shape.size, shape.pose, segment, radius, True)]
    half = shape.size / 2.0
    if shape.kind == "cylinder":
        half = np.array([shape.size[0], shape.size[0], shape.size[1] / 2.0])
    corners = half * (2.0 * np.indices((2, 2, 2)).reshape(3, 8).T - 1.0)
    return [_bounded(name, shape.body, shape.kind, shape.size, shape.pose, corners)]


def _bounded(name: str, body: int, kind: str, size: Array, pose: Array, corners: Array) -> Solid:
    """A solid with corners, bounded by a box if it stands still, by a capsule if it moves."""
    segment, radius = bounding_capsule(corners)
    segment = segment @ pose[:3, :3].T + pose[:3, 3]
    if kind == "cylinder":  # its corners are those of a box around it
        ends = np.array([[0.0, 0.0, -size[1] / 2.0], [0.0, 0.0, size[1] / 2.0]])
        segment, radius = ends @ pose[:3, :3].T + pose[:3, 3], float(size[0])
    vertices = corners if kind == "hull" else unset()
    if body > 0:
        return Solid(name, body, kind, size, pose, segment, radius, False, vertices=vertices)
    low, high = corners.min(axis=0), corners.max(axis=0)
    box_pose = np.array(pose)
    box_pose[:3, 3] += pose[:3, :3] @ (low + high) / 2.0
    half, exact = (high - low) / 2.0, kind == "box"
    return Solid(
        name, body, kind, size, pose, segment, radius, exact, True, half, box_pose, vertices
    )


def bounding_capsule(points: Array) -> tuple[Array, float]:
    """A segment (2, 3) and a radius that hold all `points`, (V, 3); slim, not the slimmest.

    Source: ours; along each principal axis a cylinder about the middle of the points' range, its
    ends drawn in as far as the round caps allow.
    """
    middle = points.mean(axis=0)
    axes = np.linalg.svd(points - middle, full_matrices=len(points) < 3)[2]  # all three of them
    best: tuple[float, Array, float] | None = None
    for axis in axes:
        along = points @ axis
        across = points - np.outer(along, axis)
        centre = (across.min(axis=0) + across.max(axis=0)) / 2.0
        centre = centre - (centre @ axis) * axis
        off = np.linalg.norm(across - centre, axis=1)
        radius = float(off.max()) * (1.0 + 1e-9)
        cap = np.sqrt(np.maximum(radius**2 - off**2, 0.0))
        low, high = float((along + cap).min()), float((along - cap).max())
        if low > high:
            low = high = (low + high) / 2.0
        segment = centre + np.outer([low, high], axis)
        # With drawn-in ends that crossed, one ball must do: enlarge it to what it has to hold.
        nearest = np.clip(along, low, high)
        held = np.linalg.norm(points - centre - np.outer(nearest, axis), axis=1)
        radius = max(radius, float(held.max()) * (1.0 + 1e-9))
        volume = np.pi * radius**2 * (high - low + 4.0 / 3.0 * radius)
        if best is None or volume < best[0]:
            best = volume, segment, radius
    assert best is not None
    return best[1], best[2]
