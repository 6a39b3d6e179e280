"""Live: the view while it runs: one configuration, shown to whoever has the page open.

viser calls from threads of its own; a lock keeps them apart, and only the latest wish is shown.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from elastocal.arrays import Array
from elastocal.viewer.frames import bent_frames, magnified, rigid_frames, suitable_factor
from elastocal.viewer.local_server import local_server, stop
from elastocal.viewer.panel import Panel
from elastocal.viewer.readout import bending, read_out, watched
from elastocal.viewer.readout_html import readout_html
from elastocal.viewer.scene import Scene
from elastocal.viewer.subject import Stop, Subject, way
from elastocal.viewer.travel import PAUSE, Travel

_TICK = 0.05  # seconds between two pictures of a motion


@dataclass(frozen=True)
class Shown:
    """What is shown: a stop, and the configuration and load, which may have left it.

    Attributes:
        stop: Number of the stop.
        q: (n,) joint values [rad or m].
        wrench: (6,) load [N, N·m].
    """

    stop: int
    q: Array
    wrench: Array


class Live:
    """The view of a subject on a server; it does what `panel.Actions` ask for."""

    def __init__(self, server: Any, subject: Subject) -> None:
        """Draw the first stop."""
        self._server, self._subject = server, subject
        self._lock = threading.RLock()
        self._shown = _at(subject.stops[0], 0)
        self._travel: Travel | None = None
        self._next: float | None = None  # when to go on while playing [s]
        self._scene = Scene(server, subject)
        self._factor = _first_factor(subject, self._scene.size)
        self._panel = Panel(
            server, subject, self._scene.present, self._scene.remarks, self._factor, self
        )
        self._draw(follow=True)

    def run(self, waiting: Callable[[], bool] = lambda: True) -> None:
        """Serve until `waiting` says no; moves what moves by the clock."""
        while waiting():
            self.tick(time.monotonic())
            time.sleep(_TICK)

    def tick(self, now: float) -> None:
        """Show what is due at a time [s]."""
        with self._lock:
            if self._travel is not None:
                q, wrench = self._travel.at(now)
                over = now >= self._travel.ends
                self._shown = replace(self._shown, q=q, wrench=wrench)
                self._travel = None if over else self._travel
                if over and self._next is not None:
                    self._next = now + PAUSE
                self._draw(follow=True)
            elif self._next is not None and now >= self._next:
                self.step(1)

    def go(self, stop: int) -> None:
        """Move to a stop."""
        with self._lock:
            here, target = self._shown, self._subject.stops[stop]
            left = self._subject.stops[here.stop]
            # Via points begin at a stop: from elsewhere they would lead nowhere.
            at_stop = bool(np.array_equal(here.q, left.q))
            passed = way(self._subject.stops, here.stop, stop) if at_stop else left.via[:0]
            self._shown = replace(here, stop=stop)
            path = np.vstack([here.q, passed, target.q])
            loads = np.array([here.wrench, target.wrench])
            self._travel = Travel(path, loads, time.monotonic())

    def step(self, by: int) -> None:
        """Move to the next stop, or the one before, round and round."""
        with self._lock:
            self.go((self._shown.stop + by) % len(self._subject.stops))

    def play(self) -> None:
        """Begin or end stepping by the clock."""
        with self._lock:
            self._next = None if self._next is not None else time.monotonic()

    def set_joint(self, joint: int, value: float) -> None:
        """Set one joint [rad or m]; a motion ends there."""
        with self._lock:
            q = np.array(self._shown.q)
            q[joint] = value
            self._by_hand(replace(self._shown, q=q), follow=False)

    def set_load(self, force: Array | None, moment: Array | None) -> None:
        """Set the force [N] or the torque [N·m]."""
        with self._lock:
            wrench = np.array(self._shown.wrench)
            if force is not None:
                wrench[:3] = force
            if moment is not None:
                wrench[3:] = moment
            self._by_hand(replace(self._shown, wrench=wrench), follow=False)

    def reset(self, what: str) -> None:
        """Put "joints" or "load" back to those of the stop, or joints to their "middle"."""
        with self._lock:
            there, shown = self._subject.stops[self._shown.stop], self._shown
            if what == "load":
                shown = replace(shown, wrench=there.wrench)
            else:
                middle = self._subject.study.limits.mean(axis=0)
                shown = replace(shown, q=middle if what == "middle" else there.q)
            self._by_hand(shown, follow=True)

    def switch(self, layer: str, on: bool) -> None:
        """Show or hide a layer."""
        self._scene.switch(layer, on)

    def magnify(self, factor: float) -> None:
        """Set the magnification of deflections."""
        with self._lock:
            self._factor = factor
            self._draw(follow=False)

    def _by_hand(self, shown: Shown, *, follow: bool) -> None:
        """Show what a user has set; what moved by the clock stands still."""
        self._travel = self._next = None
        self._shown = shown
        self._draw(follow=follow)

    def _draw(self, *, follow: bool) -> None:
        """Bring scene and panel to what is shown; `follow`: the controls, too."""
        subject, shown = self._subject, self._shown
        study, tool = subject.study, subject.stops[shown.stop].tool
        readout = read_out(subject, tool, shown.q, shown.wrench)
        rigid = rigid_frames(study.robot, shown.q)
        with self._server.atomic():
            self._scene.show(tool, shown.q, shown.wrench, rigid, readout.rooms)
            if readout.bending is not None and subject.model is not None:
                seen, bent = watched(subject, tool), readout.bending
                arm = replace(study.arm, springs=subject.model.springs, tool=seen)
                moved = magnified(bent.idle, bent.displacement, self._factor)
                points = seen.markers @ rigid[-1][:3, :3].T + rigid[-1][:3, 3]
                frames = bent_frames(arm, shown.q, moved)
                self._scene.bend(tool, rigid, frames, points, bent, self._factor)
            there = subject.stops[shown.stop]
            at_stop = np.array_equal(shown.q, there.q) and np.array_equal(
                shown.wrench, there.wrench
            )
            html = readout_html(readout, shown.wrench, self._factor, moved=not at_stop)
            self._panel.tell(html)
            if follow:
                self._panel.follow(shown.stop, shown.q, shown.wrench)
        self._server.flush()


def _at(stop: Stop, number: int) -> Shown:
    return Shown(number, stop.q, stop.wrench)


def _first_factor(subject: Subject, size: float) -> float:
    """A magnification that suits the largest deflection of all stops."""
    sizes = [0.0]
    for there in subject.stops:
        found = bending(subject, there.tool, there.q, there.wrench)
        if found is not None:
            sizes.append(float(np.linalg.norm(found.deflection, axis=1).max()))
    return suitable_factor(max(sizes), size)


def serve(subject: Subject, port: int, ready: Callable[[str], None]) -> None:
    """Show a subject on `port` of this machine until interrupted; `ready` is told the address.

    Raises:
        InputError: viser is missing, or the port is busy.
    """
    server = local_server(port, "elastocal")
    try:
        live = Live(server, subject)
        ready(f"http://127.0.0.1:{port}/")
        live.run()
    except KeyboardInterrupt:
        return
    finally:
        stop(server)
