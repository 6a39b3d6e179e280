"""What a model may lack: further springs, and what moved between unloaded and loaded reading.

In: an identification. Out: candidates, each with the columns that it would add to the fit.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.springs import VirtualJoints, joint_springs
from elastocal.identification.linearised import linear_rows
from elastocal.identification.result import Identification
from elastocal.measuring.measurements import Measurements
from elastocal.robot.chain import Robot, T_body_joint
from elastocal.robot.posture import Posture, flange_axes

Kind = Literal[
    "in-joint", "turning", "sliding", "tool-shift", "station-shift", "station-turn", "load-gain"
]
"""A spring in a rigid joint, across one or along an axis; what shifted or turned between readings
without and with load; loads that are all wrong by one factor."""

SPRINGS: tuple[Kind, ...] = ("in-joint", "turning", "sliding")
"""Those that cannot be below zero."""


@dataclass(frozen=True)
class Candidate:
    """One thing that a model may lack.

    Attributes:
        kind: What it is.
        carrier: Joint that carries a spring, or "base"; empty otherwise.
        axis: Axis of a spring in the frame of its carrier, as files have it; empty otherwise.
    """

    kind: Kind
    carrier: str = ""
    axis: str = ""


def candidates(found: Identification) -> list[tuple[Candidate, Array]]:
    """Candidates with their columns (R, 3, d) [deflection for one of each unknown, SI].

    What the model has already is among them: its column says nothing new.

    Source: ours.
    """
    data, robot = found.measurements, found.arm.robot
    each = list(_springs(robot, found.model.names))
    each.sort(key=lambda pair: int(pair[1].body[0]))
    springs = _all_of([spring for _, spring in each])
    rows = linear_rows(replace(found.arm, springs=springs, tool=data.tool), data)
    columns = [(candidate, rows[:, :, [i]]) for i, (candidate, _) in enumerate(each)]
    return [*columns, *_moved(robot, data), (Candidate("load-gain"), _gain(found))]


def _springs(robot: Robot, present: tuple[str, ...]) -> Iterator[tuple[Candidate, VirtualJoints]]:
    """Springs one by one: in rigid joints, across every joint, of the foot and of the flange."""
    for name in robot.joint_names:
        if name not in present:
            yield Candidate("in-joint", name), joint_springs(robot, [name])
    last = robot.joint_names[-1]
    for i, axis in enumerate("xyz"):
        for kind, carrier in (("turning", "base"), ("sliding", "base"), ("sliding", last)):
            body = 0 if carrier == "base" else int(robot.place[-1]) + 1
            yield _spring(robot, Candidate(kind, carrier, axis), body, np.eye(3)[i])  # type: ignore[arg-type]
    for joint, place in zip(robot.joints, robot.place.tolist(), strict=True):
        along = int(np.argmax(np.abs(joint.axis)))
        for i in {0, 1, 2} - {along}:
            across = np.eye(3)[i] - joint.axis[i] * joint.axis
            candidate = Candidate("turning", joint.name, "xyz"[i])
            yield _spring(robot, candidate, place + 1, across / np.linalg.norm(across))


def _spring(
    robot: Robot, candidate: Candidate, body: int, axis: Array
) -> tuple[Candidate, VirtualJoints]:
    """A spring through the origin of its carrier."""
    frame = T_body_joint(robot, body)
    return candidate, VirtualJoints(
        names=("",),
        body=np.array([body]),
        axis=(frame[:3, :3] @ axis)[None],
        origin=frame[:3, 3][None],
        prismatic=np.array([candidate.kind == "sliding"]),
    )


def _all_of(each: list[VirtualJoints]) -> VirtualJoints:
    """One value of springs in chain order."""
    return VirtualJoints(
        names=tuple(f"candidate {i}" for i in range(len(each))),
        body=np.concatenate([spring.body for spring in each]),
        axis=np.concatenate([spring.axis for spring in each]),
        origin=np.concatenate([spring.origin for spring in each]),
        prismatic=np.concatenate([spring.prismatic for spring in each]),
        joint=np.concatenate([spring.joint for spring in each]),
    )


def _moved(robot: Robot, data: Measurements) -> Iterator[tuple[Candidate, Array]]:
    """What moved between the readings without and with load: tool, or station."""
    posture = Posture(robot, data.cases.q)
    turned = data.rotations
    tool = np.where(turned[:, None, None], 0.0, flange_axes(posture)[data.case])
    yield Candidate("tool-shift"), tool
    shift = np.where(turned[:, None, None], 0.0, np.eye(3))
    yield Candidate("station-shift"), shift
    points = np.array([posture.point(marker).T for marker in data.tool.markers])
    at = points[np.where(turned, 0, data.marker), data.case]
    turn = np.cross(np.eye(3)[None], at[:, None]).transpose(0, 2, 1)
    turn = np.where(turned[:, None, None], np.eye(3), turn)
    yield Candidate("station-turn"), np.concatenate([shift, turn], axis=2)


def _gain(found: Identification) -> Array:
    """(R, 3, 1) deflections of the model, which grow with all loads."""
    return np.asarray(found.measurements.deflection - found.residual)[:, :, None]
