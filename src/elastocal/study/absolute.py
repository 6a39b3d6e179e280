"""Absolute studies: a campaign of absolute readings of an arm that bends under its own weight."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.calibration.arm_model import ArmModel
from elastocal.calibration.parameters import GEOMETRY_PRIOR, Parameters, parameters_of
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.springs import VirtualJoints, subset
from elastocal.elastic.unknowns import each_spring, joined
from elastocal.measuring.instrument import Instrument
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.compensators import Compensator
from elastocal.robot.controller_axes import Coupling, uncoupled
from elastocal.robot.geometry import GROUPS, geometric_errors
from elastocal.robot.payloads import Payload


@dataclass(frozen=True)
class AbsoluteStudy:
    """What is known before a robot is calibrated with absolute readings.

    Attributes:
        robot: The robot as drawn, with the masses of its links.
        tool: What is on the flange: reflectors where they are thought to be, the load point.
        instrument: What reads positions, and the orientation of a probe if it has rotations; its
            noise is that of one reading.
        springs: The compliances that are sought; none, if the arm is taken as rigid.
        blocks: What else is sought: "base", "tool", and groups of geometric errors.
        gravity: (3,) acceleration that masses feel, base frame [m/s²].
        payloads: What may hang on the flange.
        payload: What hangs there where readings do not say; empty for nothing.
        compensators: Springs that hold part of the weight, of unknown stiffness.
        nuisance: Springs that nobody asks for, with their priors; None if there are none.
        geometry_prior: Standard uncertainty of a geometric error before [rad or m].
        controller: What the controller shows for the joint values of the model; the same if None.
        name: What the user calls it.
        text: The study file as written, empty if there is none.
    """

    robot: Robot
    tool: Tool
    instrument: Instrument
    springs: VirtualJoints
    blocks: tuple[str, ...]
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -9.80665]))
    payloads: tuple[Payload, ...] = ()
    payload: str = ""
    compensators: tuple[Compensator, ...] = ()
    nuisance: Nuisance | None = None
    geometry_prior: float = GEOMETRY_PRIOR
    controller: Coupling | None = None
    name: str = "study"
    text: str = ""

    def __post_init__(self) -> None:
        freeze(self, gravity=np.reshape(self.gravity, 3))

    @property
    def coupling(self) -> Coupling:
        """What the controller shows for the joint values of the model."""
        return self.controller or uncoupled(self.robot)


def arm_model(study: AbsoluteStudy) -> ArmModel:
    """The arm of a study with all that may be unlike its drawing."""
    compliances = each_spring(study.springs)
    if study.nuisance is not None:
        compliances = joined(compliances, study.nuisance.unknowns)
    return ArmModel(
        study.robot,
        study.tool,
        geometric_errors(study.robot, study.blocks),
        compliances,
        study.gravity,
        study.payloads,
        study.compensators,
    )


def unknowns_of(study: AbsoluteStudy, model: ArmModel, positions: Positions) -> Parameters:
    """The unknowns of a study that readings may tell, and what was known of them before."""
    p, known, mean = len(study.springs), None, None
    if study.nuisance is not None:
        size = len(model.compliances)
        known, mean = np.zeros((size, size)), np.zeros(size)
        known[p:, p:], mean[p:] = study.nuisance.information, study.nuisance.mean
    held = tuple(block for block in ("base", "tool") if block not in study.blocks)
    return parameters_of(model, positions, known, mean, study.geometry_prior, held)


def growing(study: AbsoluteStudy, positions: Positions) -> list[tuple[str, ArmModel, Parameters]]:
    """Models that grow to that of a study: base and tool, zeros, lengths, angles, compliances.

    Source: ours; the order in which manufacturers and standards name the errors of an arm.
    """
    base = tuple(block for block in study.blocks if block not in GROUPS)
    none = subset(study.springs, ())
    bare = replace(study, blocks=base, springs=none, nuisance=None, compensators=())
    steps = [("base and tool", bare)]
    for group in GROUPS:
        if group in study.blocks:
            bare = replace(bare, blocks=(*bare.blocks, group))
            steps.append((group, bare))
    if len(study.springs):
        bare = replace(bare, springs=study.springs)
        steps.append(("compliances", bare))
    if study.compensators:
        bare = replace(bare, compensators=study.compensators)
        steps.append(("compensators", bare))
    if study.nuisance is not None:
        steps.append(("nuisance", study))
    models = [(name, step, arm_model(step)) for name, step in steps]
    return [(name, model, unknowns_of(step, model, positions)) for name, step, model in models]
