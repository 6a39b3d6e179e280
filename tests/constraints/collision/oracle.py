"""The same cell by an independent route: Pinocchio for where things are, coal for how far apart.

Nothing of `elastocal.constraints.collision` is used: capsules are put between joint positions that
Pinocchio computes, with the radii and rules that the documents state.
"""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin

from elastocal.arrays import Array
from elastocal.robot.chain import Robot, Tool
from tests.arms import Oracle

OUTER = (("A4", "A2"), ("tool", "A4"))
"""Links of the KR 270 that touch by nature, of which only the outer part is watched."""


class CellOracle:
    """A robot without shapes, its tool with one point, and boxes; distances by coal."""

    def __init__(
        self, robot: Robot, tool: Tool, boxes: dict[str, tuple[Array, Array]], margin: float
    ) -> None:
        """`boxes` are (sides, pose) by name [m]."""
        self.oracle = Oracle(robot)
        self.data = self.oracle.model.createData()
        self.radius, self.tool, self.margin = 0.05 * self._reach(robot), tool, margin
        self.boxes = {name: (coal.Box(*map(float, s)), T) for name, (s, T) in boxes.items()}

    def _reach(self, robot: Robot) -> float:
        """How far the flange gets from the first, vertical, axis halfway up [m]."""
        limits = np.array([robot.lower, robot.upper])
        draws = np.random.default_rng(0).uniform(*limits, (1000, len(robot.joints)))
        places = []
        for q in draws:
            pin.framesForwardKinematics(self.oracle.model, self.data, q)
            places.append(self.data.oMf[self.oracle.flange].translation.copy())
        height = 0.5 * (np.min(places, axis=0)[2] + np.max(places, axis=0)[2])
        return float(np.linalg.norm(np.array(places) - [0.0, 0.0, height], axis=1).max())

    def capsules(self, q: Array) -> list[tuple[str, Array, Array, float]]:
        """(name, start, end, radius) of the links and the tool at one configuration."""
        model, data = self.oracle.model, self.data
        pin.framesForwardKinematics(model, data, q)
        flange = data.oMf[self.oracle.flange]
        joints = [data.oMi[i].translation.copy() for i in range(1, model.njoints)]
        chain = [np.zeros(3), *joints, flange.translation.copy()]
        found = []
        for i in range(len(joints) + 1):
            name = model.names[i] if i else "base"
            found.append((name, chain[i], chain[i + 1], self.radius))
        tip = flange.act(np.array(self.tool.load_point))
        return [*found, ("tool", flange.translation.copy(), tip, self.tool.radius)]

    def obstacle(self, q: Array, name: str) -> float:
        """Signed distance of the moving robot from a box [m]."""
        box, T = self.boxes[name]
        place = coal.Transform3s(np.array(T[:3, :3]), np.array(T[:3, 3]))
        return min(
            distance(*solid(*ends), box, place)
            for link, *ends in self.capsules(q)
            if link != "base"
        )

    def itself(self, q: Array, left_out: set[frozenset[str]]) -> float:
        """Signed distance between links, without those left out [m]."""
        parts = self.capsules(q)
        found = []
        for i, (first, *a) in enumerate(parts):
            for second, *b in parts[:i]:
                start, end, radius = a
                if (first, second) in OUTER:
                    # From the joint twice the room that the two need.
                    away = 2.0 * (radius + b[2] + self.margin)
                    start = start + away * (end - start) / np.linalg.norm(end - start)
                if frozenset((first, second)) not in left_out:
                    found.append(distance(*solid(start, end, radius), *solid(*b)))
        return min(found)


def solid(start: Array, end: Array, radius: float) -> tuple[coal.Capsule, coal.Transform3s]:
    """A capsule of coal between two points."""
    along = end - start
    length = float(np.linalg.norm(along))
    axis = along / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    rotation = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis).toRotationMatrix()
    return coal.Capsule(radius, length), coal.Transform3s(rotation, (start + end) / 2.0)


def distance(
    first: coal.CollisionGeometry,
    place: coal.Transform3s,
    second: coal.CollisionGeometry,
    other: coal.Transform3s,
) -> float:
    """Signed distance by coal [m]."""
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = 1e-8
    return float(coal.distance(first, place, second, other, request, result))
