"""Absolute studies: a campaign of absolute readings of an arm that bends under its own weight."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.elastic.unknowns import Unknowns
from elastocal.measuring.instrument import Instrument
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.controller_axes import Coupling, uncoupled
from elastocal.robot.payloads import Payload


@dataclass(frozen=True)
class AbsoluteStudy:
    """What is known before a robot is calibrated with absolute readings.

    Attributes:
        robot: The robot as drawn, with the masses of its links.
        tool: What is on the flange: reflectors where they are thought to be, the load point.
        instrument: What reads positions, and the orientation of a probe if it has rotations.
        compliances: The compliances that are sought; none, if the arm is taken as rigid.
        gravity: (3,) acceleration that masses feel, base frame [m/s²].
        payloads: What may hang on the flange.
        controller: What the controller shows for the joint values of the model; the same if None.
        name: What the user calls it.
        text: The study file as written, empty if there is none.
    """

    robot: Robot
    tool: Tool
    instrument: Instrument
    compliances: Unknowns
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -9.80665]))
    payloads: tuple[Payload, ...] = ()
    controller: Coupling | None = None
    name: str = "study"
    text: str = ""

    def __post_init__(self) -> None:
        freeze(self, gravity=np.reshape(self.gravity, 3))

    @property
    def coupling(self) -> Coupling:
        """What the controller shows for the joint values of the model."""
        return self.controller or uncoupled(self.robot)
