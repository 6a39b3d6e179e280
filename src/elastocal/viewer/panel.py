"""The panel beside the scene, handed to viser: what one reads, and what one can set."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from elastocal.arrays import Array
from elastocal.viewer.readout_html import heading_html
from elastocal.viewer.scene import LAYERS
from elastocal.viewer.subject import Subject

_STEP = 0.01  # of a slider [deg, mm]


class Actions(Protocol):
    """What a user can ask for."""

    def go(self, stop: int) -> None:
        """Move to a stop."""

    def step(self, by: int) -> None:
        """Move to the next stop, or the one before."""

    def play(self) -> None:
        """Begin or end stepping by the clock."""

    def set_joint(self, joint: int, value: float) -> None:
        """Set one joint [rad or m]."""

    def set_load(self, force: Array | None, moment: Array | None) -> None:
        """Set the force [N] or the torque [N·m]."""

    def reset(self, what: str) -> None:
        """Put "joints" or "load" back to those of the stop, or joints to their "middle"."""

    def switch(self, layer: str, on: bool) -> None:
        """Show or hide a layer."""

    def magnify(self, factor: float) -> None:
        """Set the magnification of deflections."""


class Panel:
    """The controls."""

    def __init__(
        self,
        server: Any,
        subject: Subject,
        layers: tuple[str, ...],
        remarks: list[str],
        magnification: float,
        actions: Actions,
    ) -> None:
        """Make the controls, and have them call `actions`."""
        self._gui, self._subject, self._actions = server.gui, subject, actions
        robot = subject.study.robot
        self._gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        self._gui.add_html(heading_html(subject, remarks))
        self._stops = [stop.label for stop in subject.stops]
        self._pose = self._gui.add_dropdown("Pose", self._stops, initial_value=self._stops[0])
        self._by_hand(self._pose, lambda value: actions.go(self._stops.index(value)))
        steps = self._gui.add_button_group("Step", ["previous", "play", "next"])
        self._pressed(
            steps,
            {
                "previous": lambda: actions.step(-1),
                "play": actions.play,
                "next": lambda: actions.step(1),
            },
        )
        self._readout = self._gui.add_html("")
        with self._gui.add_folder("Joints"):
            self._sliders = [self._slider(i) for i in range(len(robot.joints))]
            back = self._gui.add_button_group("Reset", ["to the pose", "to the middle"])
            self._pressed(
                back,
                {
                    "to the pose": lambda: actions.reset("joints"),
                    "to the middle": lambda: actions.reset("middle"),
                },
            )
        with self._gui.add_folder("Load", expand_by_default=False):
            self._loads = [
                self._gui.add_vector3(f"{name} [{unit}]", (0.0, 0.0, 0.0), step=step)
                for name, unit, step in (("Force", "N", 1.0), ("Torque", "N·m", 0.1))
            ]
            self._by_hand(self._loads[0], lambda v: actions.set_load(np.array(v), None))
            self._by_hand(self._loads[1], lambda v: actions.set_load(None, np.array(v)))
            again = self._gui.add_button_group("Reset", ["to the pose"])
            self._pressed(again, {"to the pose": lambda: actions.reset("load")})
        with self._gui.add_folder("Show"):
            if "bent" in layers:
                self._magnifier(magnification)
            for layer in layers:
                self._checkbox(layer)

    def tell(self, html: str) -> None:
        """Show what there is to read."""
        self._readout.content = html

    def follow(self, stop: int, q: Array, wrench: Array) -> None:
        """Set the controls to what is shown, as if nobody had touched them."""
        self._pose.value = self._stops[stop]
        limits, scale = self._subject.slider_limits, self._subject.study.robot.shown_scale
        for slider, value in zip(self._sliders, scale * np.clip(q, *limits), strict=True):
            slider.value = float(np.clip(np.round(value, 2), slider.min, slider.max))
        for box, part in zip(self._loads, (wrench[:3], wrench[3:]), strict=True):
            box.value = tuple(float(np.round(v, 3)) for v in part)

    def _slider(self, joint: int) -> Any:
        """The slider of a joint, in degrees or millimetres."""
        what = self._subject.study.robot.joints[joint]
        scale, unit = what.kind.scale, what.kind.key
        low, high = scale * self._subject.slider_limits[:, joint]
        low, high = (float(round(v, 2)) for v in (low, high))
        held = low == high
        high = max(high, low + _STEP)  # a slider needs a range
        at = float(np.clip(np.round(scale * self._subject.stops[0].q[joint], 2), low, high))
        name = f"{what.name} [{unit}]" + (", held" if held else "")
        slider = self._gui.add_slider(name, low, high, _STEP, at, disabled=held)
        self._by_hand(slider, lambda value: self._actions.set_joint(joint, value / scale))
        return slider

    def _magnifier(self, magnification: float) -> None:
        """The slider of the magnification, with room for more than what suits at first."""
        most = float(max(5.0 * magnification, 10.0))
        slider = self._gui.add_slider("Magnified [×]", 0.0, most, most / 200.0, magnification)
        self._by_hand(slider, self._actions.magnify)

    def _checkbox(self, layer: str) -> None:
        name, on = LAYERS[layer]
        box = self._gui.add_checkbox(name, on)
        self._by_hand(box, lambda value: self._actions.switch(layer, value))

    @staticmethod
    def _by_hand(control: Any, act: Callable[[Any], None]) -> None:
        """Call `act` with the value that a user sets; not when the program sets it."""

        def changed(event: Any) -> None:
            if event.client is not None:
                act(control.value)

        control.on_update(changed)

    @staticmethod
    def _pressed(group: Any, acts: dict[str, Callable[[], None]]) -> None:
        """Call what belongs to the button that is pressed."""
        group.on_click(lambda _: acts[group.value]())
