"""Figure: one arm in the scene of viser, sent once and then moved by the frames of its bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.drawing.solids import Mesh
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.rotations import quaternions
from elastocal.viewer.parts import Colour, Part, tool_parts


class Figure:
    """An arm with its tools."""

    def __init__(
        self,
        scene: Any,
        root: str,
        robot: Robot,
        parts: Sequence[Part],
        tools: Sequence[Tool],
        *,
        shade: Colour | None = None,
        opacity: float | None = None,
    ) -> None:
        """Send the parts under the node `root`, all in one `shade` if that is given."""
        scene.add_frame(root, show_axes=False)
        count = robot.bodies + 1
        self._bodies = [scene.add_frame(f"{root}/{b}", show_axes=False) for b in range(count)]
        self._tools: dict[int, Any] = {}
        for i, part in enumerate(parts):
            name = f"{root}/{part.body}/{i}"
            add_solid(scene, name, part.solid, shade or part.colour, opacity)
        for k, tool in enumerate(tools):
            node = f"{root}/{count - 1}/tool {k}"
            self._tools[id(tool)] = scene.add_frame(node, show_axes=False)
            for i, part in enumerate(tool_parts(robot, tool)):
                add_solid(scene, f"{node}/{i}", part.solid, shade or part.colour, opacity)

    def place(self, frames: Array, tool: Tool, shown: BoolArray | None = None) -> None:
        """Move the bodies to `frames` (B + 1, 4, 4) [m], with `tool` on the flange.

        Bodies are hidden where `shown` (B + 1,) says so.
        """
        turns = quaternions(frames[:, :3, :3])
        for i, (body, frame) in enumerate(zip(self._bodies, frames, strict=True)):
            body.wxyz, body.position = turns[i], frame[:3, 3]
            body.visible = shown is None or bool(shown[i])
        for key, node in self._tools.items():
            node.visible = key == id(tool)


def add_solid(
    scene: Any, name: str, solid: Mesh, shade: Colour, opacity: float | None = None
) -> Any:
    """Send triangles; translucent ones are seen from both sides and throw no shadow."""
    solid = solid if len(solid.triangles) else _NOTHING
    return scene.add_mesh_simple(
        name,
        solid.vertices,
        solid.triangles,
        color=shade,
        opacity=opacity,
        side="double",
        cast_shadow=opacity is None,
        receive_shadow=opacity is None,
    )


_NOTHING = Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]]))  # viser wants at least one triangle
