"""Whether robot or obstacles stand in the beam from a laser tracker to a marker."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from elastocal.arrays import Array, IntArray
from elastocal.constraints.base import Pull
from elastocal.constraints.collision.segments import Closest, between_segments, segment_and_box
from elastocal.constraints.collision.solid import Solid
from elastocal.constraints.view import ViewConstraint
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture, dot

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

    costly = True

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
        beside = [self._touches(solid, robot, at_rest) for solid in solids]
        self.solids = tuple(s for s, near in zip(solids, beside, strict=True) if not near)
        around = [s.name for s, near in zip(solids, beside, strict=True) if near and s.body == 0]
        self.around_head = tuple(dict.fromkeys(around))  # names of what the head stands in
        self._bodies = np.array([solid.body for solid in self.solids], dtype=np.int64)
        self._boxed = np.array([solid.boxed for solid in self.solids], dtype=bool)
        self._radii = np.array([solid.radius for solid in self.solids])
        self._reach = np.array([solid.ball for solid in self.solids])

    def _touches(self, solid: Solid, robot: Robot, at_rest: Posture) -> bool:
        """Whether a solid holds the marker or the head of the tracker."""
        if solid.body == robot.last:
            end, room = at_rest.point(self.point), NEAR_MARKER
        elif solid.body == 0:
            end, room = self.position[:, None], 0.0
        else:
            return False
        return _alone(solid, at_rest, end) < self.radius + room

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
        """The nearest solid of every posture: balls first, then what they leave in one go."""
        count = posture.count
        found = _Found(
            np.full(count, horizon),
            np.full(count, -1, dtype=np.int64),
            *(np.zeros((3, count)) for _ in range(3)),
        )
        if not self.solids:
            return found
        start, end = self._ends(posture)
        solid, case = np.nonzero(self._ball_gaps(posture, start, end) < horizon + self.radius)
        if not len(solid):
            return found
        closest = self._closest(posture, start[:, case], end[:, case], solid, case)
        margin = closest.distance - self.radius
        # Entries in order of case, the nearest of each first; every case has one winner.
        order = np.lexsort((margin, case))
        first = np.flatnonzero(np.diff(case[order], prepend=-1))
        best = order[first][margin[order[first]] < horizon]
        k = case[best]
        found.margin[k], found.solid[k] = margin[best], solid[best]
        found.beam[:, k] = closest.first[:, best]
        found.second[:, k] = closest.second[:, best]
        found.normal[:, k] = closest.normal[:, best]
        return found

    def _ball_gaps(self, posture: Posture, start: Array, end: Array) -> Array:
        """(S, N) lower bounds of the distances of the beams, by the balls around the solids."""
        middle = np.empty((3, len(self.solids), posture.count))
        for s, solid in enumerate(self.solids):
            if solid.boxed:
                middle[:, s] = solid.box_pose[:3, 3:]
            else:
                one, two = (posture.point(local, solid.body) for local in solid.segment)
                np.add(one, two, out=middle[:, s])
                middle[:, s] *= 0.5
        along, way = (end - start)[:, None], middle - start[:, None]
        share = dot(along, way) / np.maximum(dot(along, along), 1e-12)
        way -= np.clip(share, 0.0, 1.0) * along
        return np.asarray(np.sqrt(dot(way, way)) - self._reach[:, None])

    def _closest(
        self, posture: Posture, start: Array, end: Array, solid: IntArray, case: IntArray
    ) -> Closest:
        """Segments, (3, K), from one solid each: round ones in one go, boxes one by one."""
        total = len(solid)
        found = Closest(np.zeros(total), *(np.zeros((3, total)) for _ in range(3)))
        ends = np.empty((2, 3, total))
        for s in np.unique(solid).tolist():
            k = np.flatnonzero(solid == s)
            one = self.solids[s]
            if one.boxed:
                pose = one.box_pose
                args = start[:, k], end[:, k], pose[:3, :3], pose[:3, 3], one.half
                for whole, part in zip(found, segment_and_box(*args), strict=True):
                    whole[..., k] = part
            else:
                for e, local in enumerate(one.segment):
                    ends[e][:, k] = posture.point(local, one.body)[:, case[k]]
        k = np.flatnonzero(~self._boxed[solid])
        if len(k):
            pieces = between_segments(start[:, k], end[:, k], ends[0][:, k], ends[1][:, k])
            for whole, piece in zip(found, pieces, strict=True):
                whole[..., k] = piece
            found.distance[k] -= self._radii[solid[k]]
        return found

    def _gradient(self, posture: Posture, found: _Found, weights: Array) -> Array:
        """(n, N) normal · (velocity of the beam - velocity of the solid), times weights.

        Both nearest points are held fixed, the one to its share of the beam, the other to its
        body. Source: ours; the rule is an envelope theorem.
        """
        k = np.flatnonzero((weights != 0.0) & (found.solid >= 0))
        point, length, unit = self.beam(posture)
        unit, length, normal = unit[:, k], length[k], found.normal[:, k] * weights[k]
        # The watched end is a fixed way before the marker, along a beam that turns.
        watched = np.maximum(length - NEAR_MARKER, 1e-9)
        share = dot(found.beam[:, k] - self.position[:, None], unit) / watched
        along = unit * dot(unit, normal)
        force = share * (along + (normal - along) * (watched / length))
        flange = np.full(len(k), posture.robot.last)
        solid = self._bodies[found.solid[k]]
        return posture.pull_carried(
            k, (point[:, k], flange, force), (found.second[:, k], solid, -normal)
        )


def _alone(solid: Solid, posture: Posture, point: Array) -> float:
    """Distance of a point (3, 1) from the surface of one solid [m]."""
    if solid.boxed:
        pose = solid.box_pose
        return float(segment_and_box(point, point, pose[:3, :3], pose[:3, 3], solid.half)[0][0])
    one, two = (posture.point(local, solid.body) for local in solid.segment)
    return float(between_segments(point, point, one, two).distance[0]) - solid.radius
