"""Whether robot or obstacles stand in the beam from a laser tracker to a marker."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from elastocal.arrays import Array, IntArray
from elastocal.collision.segments import Closest, between_segments, segment_and_box
from elastocal.collision.solid import Solid
from elastocal.constraints.base import Pull
from elastocal.constraints.view import ViewConstraint
from elastocal.posture import Posture, cross, dot
from elastocal.robot import Robot

BEAM_RADIUS = 0.01
"""Radius of the beam with some room [m], if nothing is said."""
NEAR_MARKER = 0.05
"""The last piece of the beam is not watched [m]: the reflector sits in its nest."""
PLENTY = 0.1
"""Margins above this [m] are not measured while planning: they are said to be this."""


class _Found(NamedTuple):
    """What stands nearest to the beam in each of N postures."""

    margin: Array  # (N,) distance of the surfaces [m], at most the horizon
    solid: IntArray  # (N,) which solid, -1 where all are beyond the horizon
    beam: Array  # (3, N) nearest point of the beam
    second: Array  # (3, N) nearest point of the solid
    normal: Array  # (3, N) unit vector along which the beam gets away


class LineOfSight(ViewConstraint):
    """Distance of the beam to a marker from the nearest solid in its way, less its radius [m].

    The solids are taken as the capsules or boxes around them; that of a capsule, a sphere and a
    box is the solid itself. Where a solid that carries the marker is nearer to it than the end of
    the beam that is not watched, it is left out: whether the tool hides its own reflector is for
    the acceptance cone to say. So is what the head of the tracker stands in or touches.
    """

    def __init__(
        self,
        name: str,
        marker: str,
        point: ArrayLike,
        position: ArrayLike,
        solids: Sequence[Solid],
        robot: Robot,
        *,
        radius: float = BEAM_RADIUS,
    ) -> None:
        """Watch one beam.

        Args:
            name: What the user reads.
            marker: Name of the marker.
            point: (3,) the marker in the flange frame [m].
            position: (3,) head of the tracker in the base frame [m].
            solids: Parts of robot, tool and cell that may be in the way.
            robot: The robot that carries the marker.
            radius: Radius of the beam with its room [m].
        """
        super().__init__(name, "m", marker, point, position)
        self.radius = radius
        at_rest = Posture(robot, np.zeros((1, len(robot.joints))))
        self.solids = tuple(solid for solid in solids if not self._touches(solid, robot, at_rest))
        self._bodies = np.array([solid.body for solid in self.solids], dtype=np.int64)

    def _touches(self, solid: Solid, robot: Robot, at_rest: Posture) -> bool:
        """Whether a solid holds the marker or the head of the tracker."""
        if solid.body == len(robot.joints):
            end, room = at_rest.point(self.point), NEAR_MARKER
        elif solid.body == 0:
            end, room = self.position[:, None], 0.0
        else:
            return False
        return bool(_closest(solid, at_rest, end, end).distance[0] < self.radius + room)

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        found = self._nearest(posture, PLENTY)

        def pull(weights: Array) -> Array:
            return self._gradient(posture, found, weights)

        return found.margin, pull

    def room(self, posture: Posture) -> Array:
        return self._nearest(posture, np.inf).margin

    def names_at(self, posture: Posture) -> list[str]:
        found = self._nearest(posture, np.inf).solid.tolist()
        return [f"{self.name} past {self.solids[s].name}" if s >= 0 else self.name for s in found]

    def _ends(self, posture: Posture) -> tuple[Array, Array]:
        """(3, N) both ends of the piece of the beam that is watched."""
        _, length, unit = self.beam(posture)
        start = np.broadcast_to(self.position[:, None], unit.shape)
        return start, start + np.maximum(length - NEAR_MARKER, 0.0) * unit

    def _nearest(self, posture: Posture, horizon: float) -> _Found:
        count = posture.count
        found = _Found(
            np.full(count, horizon),
            np.full(count, -1, dtype=np.int64),
            *(np.zeros((3, count)) for _ in range(3)),
        )
        start, end = self._ends(posture)
        for s, solid in enumerate(self.solids):
            gap = _ball_gap(solid, posture, start, end) - self.radius
            k = np.flatnonzero(gap < found.margin)
            if not len(k):
                continue
            closest = _closest(solid, posture, start[:, k], end[:, k], k)
            margin = closest.distance - self.radius
            nearer = margin < found.margin[k]
            k = k[nearer]
            found.margin[k], found.solid[k] = margin[nearer], s
            found.beam[:, k] = closest.first[:, nearer]
            found.second[:, k] = closest.second[:, nearer]
            found.normal[:, k] = closest.normal[:, nearer]
        return found

    def _gradient(self, posture: Posture, found: _Found, weights: Array) -> Array:
        """(n, N) normal · (velocity of the beam - velocity of the solid), times weights.

        Both nearest points are held fixed, the one to its share of the beam, the other to its
        body. Source: ours; the rule is an envelope theorem.
        """
        gradient = np.zeros_like(posture.q)
        k = np.flatnonzero((weights != 0.0) & (found.solid >= 0))
        if not len(k):
            return gradient
        point, length, unit = self.beam(posture)
        unit, length, normal = unit[:, k], length[k], found.normal[:, k] * weights[k]
        # The watched end is a fixed way before the marker, along a beam that turns.
        watched = np.maximum(length - NEAR_MARKER, 1e-9)
        share = dot(found.beam[:, k] - self.position[:, None], unit) / watched
        along = unit * dot(unit, normal)
        force = share * (along + (normal - along) * (watched / length))
        axes, origins = posture.axes[:, :, k], posture.origins[:, :, k]
        slides = posture.robot.prismatic
        joint = np.arange(len(posture.q))[:, None]
        total = np.zeros((len(posture.q), len(k)))
        everywhere = np.full(len(k), len(posture.q))
        for at, body, pushed in (
            (point[:, k], everywhere, force),
            (found.second[:, k], self._bodies[found.solid[k]], -normal),
        ):
            velocity = cross(axes, at[:, None] - origins)
            velocity[:, slides] = axes[:, slides]
            total += np.where(joint < body, dot(velocity, pushed[:, None]), 0.0)
        gradient[:, k] = total
        return gradient


def _closest(
    solid: Solid, posture: Posture, start: Array, end: Array, k: IntArray | slice = slice(None)
) -> Closest:
    """Segments from a solid in the postures `k`; distances from its surface."""
    if solid.boxed:
        pose = solid.box_pose
        return segment_and_box(start, end, pose[:3, :3], pose[:3, 3], solid.half)
    one, two = (posture.point(local, solid.body)[:, k] for local in solid.segment)
    found = between_segments(start, end, one, two)
    return found._replace(distance=found.distance - solid.radius)


def _ball_gap(solid: Solid, posture: Posture, start: Array, end: Array) -> Array:
    """(N,) lower bounds of the distance of segments from a solid, by the ball around it."""
    if solid.boxed:
        middle, reach = solid.box_pose[:3, 3:], float(np.linalg.norm(solid.half))
    else:
        one, two = (posture.point(local, solid.body) for local in solid.segment)
        middle = 0.5 * (one + two)
        reach = 0.5 * float(np.linalg.norm(solid.segment[1] - solid.segment[0])) + solid.radius
    along, way = end - start, middle - start
    share = np.clip(dot(along, way) / np.maximum(dot(along, along), 1e-12), 0.0, 1.0)
    off = way - share * along
    return np.asarray(np.sqrt(dot(off, off)) - reach)
