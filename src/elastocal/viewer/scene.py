"""The scene in 3D, handed to viser: made once, then only moved.

In: subject, and what `frames`, `readout` and `surroundings` say of a configuration.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import Clearance
from elastocal.drawing.shape_solids import solid_of
from elastocal.drawing.skeleton import skeletons
from elastocal.drawing.solids import arrow, union
from elastocal.drawing.surfaces import APERTURES, WALLS, Surface
from elastocal.errors import InputError
from elastocal.measuring.instrument import tracker_of
from elastocal.robot.chain import Tool
from elastocal.viewer.figure import Figure, add_solid
from elastocal.viewer.parts import colour, robot_parts
from elastocal.viewer.readout import Bending, Room
from elastocal.viewer.subject import Subject
from elastocal.viewer.surroundings import (
    apertures,
    beams,
    cones,
    floors,
    ghost,
    obstacles,
    reach,
    traces,
    tracker_solid,
    walls,
)
from elastocal.wording.numbers import words

LAYERS = {
    "loads": ("force and torque", True),
    "bent": ("magnified deflection", True),
    "tests": ("test poses", True),
    "limits": ("limits", True),
    "cell": ("obstacles", True),
    "tracker": ("laser tracker", True),
    "names": ("names of the joints", False),
}
"""What can be switched on and off: what it is called, and whether it is on at first."""

_ARROW = 0.22  # longest arrow over the size of the robot

_CORNERS: tuple[Literal["top-left", "bottom-left"], ...] = ("top-left", "bottom-left")
"""Corners by which names are pinned, in turn, so that two at one place can be read."""


class Scene:
    """Everything that is drawn.

    Attributes:
        remarks: Sentences on what cannot be drawn.
        size: Size of the robot [m].
        present: The layers that have something to show.
    """

    def __init__(self, server: Any, subject: Subject) -> None:
        """Draw what does not depend on the configuration; `show` and `bend` do the rest."""
        self._scene, self._subject = server.scene, subject
        robot = subject.study.robot
        parts, remarks = robot_parts(robot)
        self._lower, self._upper, self.size = reach(subject, parts)
        self.remarks = list(remarks)
        self._layers = {name: self._scene.add_frame(f"/{name}", show_axes=False) for name in LAYERS}
        self._robot = Figure(self._scene, "/robot", robot, parts, subject.tools)
        self._bent = None
        if subject.model is not None:
            self._bent = Figure(
                self._scene,
                "/bent/arm",
                robot,
                parts,
                subject.tools,
                shade=colour("accent"),
                opacity=0.45,
            )
        names = robot.joint_names
        self._names = [self._scene.add_label(f"/names/{i}", name) for i, name in enumerate(names)]
        self._largest = _largest_loads(subject)
        self._passing: dict[str, list[Any]] = {}  # what is drawn anew for every configuration
        self._stand()
        self.present = self._present()
        for name, (_, on) in LAYERS.items():
            self.switch(name, on)
        self._camera(server)

    def _present(self) -> tuple[str, ...]:
        subject = self._subject
        limits = [c for c in subject.study.constraints if not isinstance(c, Clearance)]
        wanted = {
            "bent": subject.model is not None,
            "tests": any(stop.kind == "test" for stop in subject.stops),
            "limits": any(isinstance(c, (*WALLS, *APERTURES)) for c in limits),
            "cell": bool(obstacles(subject)),
            "tracker": tracker_of(subject.study.instrument) is not None,
        }
        return tuple(layer for layer in LAYERS if wanted.get(layer, True))

    def switch(self, layer: str, on: bool) -> None:
        """Show or hide a layer."""
        self._layers[layer].visible = on

    def show(
        self, tool: Tool, q: Array, wrench: Array, frames: Array, rooms: Sequence[Room]
    ) -> None:
        """Move the robot to `frames`, and draw what depends on where it is."""
        self._robot.place(frames, tool)
        for label, frame in zip(self._names, frames[1:-1], strict=True):
            label.position = frame[:3, 3]
        self._renew("loads", self._load(frames[-1], tool, wrench))
        made: list[Any] = []
        for i, surface in enumerate(apertures(self._subject, tool, q)):
            made.append(self._surface(f"/limits/at the tool {i}", surface))
        self._renew("limits", made)
        made = []
        for i, beam in enumerate(beams(self._subject, tool, q, rooms)):
            shade = colour("accent" if beam.seen else "alarm")
            name, line = f"/tracker/beam {i}", beam.ends[None]
            thick = 0.003 * self.size
            made.append(self._scene.add_line_segments(name, line, shade, thickness=thick))
        for i, cone in enumerate(cones(self._subject, tool, q)):
            shade = colour("accent" if cone.met else "alarm")
            made.append(add_solid(self._scene, f"/tracker/cone {i}", cone.solid, shade, 0.22))
        self._renew("tracker", made)

    def bend(
        self, tool: Tool, rigid: Array, bent: Array, points: Array, bending: Bending, by: float
    ) -> None:
        """Draw the bent arm at frames `bent`, and arrows along which points (K, 3) move [m].

        Bodies that are where they were in `rigid` are left out: two at one place would flicker.
        """
        if self._bent is None:
            return
        moved = np.abs(bent - rigid).max(axis=(1, 2)) > 0.002 * min(1.0, self.size)
        self._bent.place(bent, tool, moved & (not bending.problem))
        arrows = union(
            arrow(point, by * along, 0.004 * self.size)
            for point, along in zip(points, bending.deflection, strict=True)
        )
        self._renew("bent", [add_solid(self._scene, "/bent/arrows", arrows, colour("accent"))])

    def _renew(self, layer: str, made: list[Any]) -> None:
        """Keep what was made under the same names; take away what was not made again."""
        names = {handle.name for handle in made}
        for handle in self._passing.get(layer, []):
            if handle.name not in names:
                handle.remove()
        self._passing[layer] = made

    def _load(self, flange: Array, tool: Tool, wrench: Array) -> list[Any]:
        """Arrows of force and torque, a torque with two heads, and what they amount to."""
        at = flange[:3, :3] @ tool.load_point + flange[:3, 3]
        force, moment = (
            part * (_ARROW * self.size / largest if largest > 0.0 else 0.0)
            for part, largest in zip((wrench[:3], wrench[3:]), self._largest, strict=True)
        )
        thick = 0.006 * self.size
        solids = [arrow(at, along, thick) for along in (force, moment, 0.8 * moment)]
        return [add_solid(self._scene, "/loads/arrows", union(solids), colour("ink"))]

    def _stand(self) -> None:
        """What stands around the robot."""
        robot = self._subject.study.robot
        floor = (*floors(self._subject), min(0.0, float(self._lower[2])))[0]
        width = 2.0 * float(np.abs([self._lower[:2], self._upper[:2]]).max()) + self.size
        cell = 10.0 ** np.floor(np.log10(self.size / 3.0))
        self._scene.add_grid(
            "/floor",
            width,
            width,
            position=(0.0, 0.0, floor - 1e-3),
            cell_size=cell,
            section_size=5.0 * cell,
            cell_color=(222, 227, 233),
            section_color=(196, 204, 214),
        )
        self._scene.add_frame("/base", axes_length=0.12 * self.size, axes_radius=0.004 * self.size)
        for i, stop in enumerate(self._subject.stops):
            if stop.kind == "test":
                figure = ghost(self._subject, stop)
                add_solid(self._scene, f"/tests/{i}", figure, colour("contrast"), 0.7)
                at = skeletons(robot, stop.tool, stop.q[None])[0].tcp
                corner = _CORNERS[i % len(_CORNERS)]  # a path may start at a test pose
                name = f"/tests/{i}/name"
                self._scene.add_label(name, stop.label, position=at, anchor=corner)
        for i, line in enumerate(traces(self._subject)):
            ends = np.stack([line[:-1], line[1:]], axis=1)
            thick = 0.004 * self.size
            shade = colour("contrast")
            self._scene.add_line_segments(f"/tests/path {i}", ends, shade, thickness=thick)
        for i, surface in enumerate(walls(self._subject)):
            self._surface(f"/limits/wall {i}", surface)
        for i, shape in enumerate(obstacles(self._subject)):
            try:
                solid = solid_of(shape)
            except InputError as error:
                self.remarks.append(str(error))
                continue
            add_solid(self._scene, f"/cell/{i}", solid, (214, 200, 178))
            self._scene.add_label(f"/cell/{i}/name", shape.name, position=shape.pose[:3, 3])
        tracker = tracker_of(self._subject.study.instrument)
        if tracker is not None:
            solid = tracker_solid(tracker.position, floor, self.size)
            add_solid(self._scene, "/tracker/stand", solid, colour("muted"))

    def _surface(self, name: str, surface: Surface) -> Any:
        """A translucent limit; outline and name are below its node, and go when it goes."""
        lines = [np.stack([line[:-1], line[1:]], axis=1) for line in surface.outlines]
        thick = 0.0015 * self.size
        body = add_solid(self._scene, name, surface.solid, colour("muted"), 0.1)
        self._scene.add_line_segments(
            f"{name}/outline", np.concatenate(lines), colour("faint"), thickness=thick
        )
        self._scene.add_label(f"{name}/name", words(surface.name), position=surface.label)
        return body

    def _camera(self, server: Any) -> None:
        """Look from the front and the right; what there is to see is left of the panel."""
        self._scene.set_up_direction("+z")
        tracker = tracker_of(self._subject.study.instrument)
        middle, extent = _middle(self._lower, self._upper)
        if tracker is not None:
            low = np.minimum(self._lower, tracker.position)
            high = np.maximum(self._upper, tracker.position)
            middle, farther = _middle(low, high)
            extent = max(extent, 0.9 * farther)
        server.initial_camera.look_at = middle + 0.17 * extent * _ACROSS
        server.initial_camera.position = middle + 0.17 * extent * _ACROSS + 1.4 * extent * _FROM
        server.initial_camera.fov = float(np.radians(40.0))


_FROM = np.array([0.62, -0.72, 0.4])  # where the camera stands, seen from what it looks at
_FROM = _FROM / np.linalg.norm(_FROM)
_ACROSS = np.cross([0.0, 0.0, 1.0], _FROM) / np.linalg.norm(_FROM[:2])  # to its right


def _middle(lower: Array, upper: Array) -> tuple[Array, float]:
    """Middle and diagonal of a box [m]."""
    return 0.5 * (lower + upper), float(np.linalg.norm(upper - lower))


def _largest_loads(subject: Subject) -> tuple[float, float]:
    """Largest force [N] and torque [N·m] of all stops: their arrows are the longest."""
    wrenches = np.array([stop.wrench for stop in subject.stops])
    sizes = [np.linalg.norm(part, axis=1).max() for part in (wrenches[:, :3], wrenches[:, 3:])]
    return float(sizes[0]), float(sizes[1])
