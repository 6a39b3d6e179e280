"""The same elastic arm in MuJoCo: bodies, springs, weights, left to settle under the load.

Built from what the user says of a robot (joint transforms and axes), not from its normal form, nor
from the chain that `ElasticArm` makes. MuJoCo integrates its own equations of motion.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

import mujoco
import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.robot.chain import T_body_joint

_STEP = 0.1  # s
_STEPS = 4000
_LIGHT = 1e-9  # kg and kg·m² of a body without weight: MuJoCo wants some


class Settling:
    """An elastic arm with commanded joint values, simulated until it rests."""

    def __init__(self, arm: ElasticArm, compliance: Array, q: Array) -> None:
        self.arm = arm
        self.compliance = dict(zip(arm.springs.names, compliance, strict=True))
        root = ET.Element("mujoco")
        ET.SubElement(root, "compiler", angle="radian", autolimits="false")
        gravity = _text(arm.gravity)
        ET.SubElement(root, "option", timestep=str(_STEP), integrator="implicit", gravity=gravity)
        world = ET.SubElement(root, "worldbody")
        self._build(world, q)
        self.model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
        self.flange = self.model.body("flange").id

    def deflection(self, wrench: Array) -> Array:
        """(3K,) marker positions loaded minus unloaded [m]."""
        return self.markers(wrench) - self.markers(np.zeros(6))

    def markers(self, wrench: Array) -> Array:
        """(3K,) marker positions at rest under the wrench [m]."""
        data = mujoco.MjData(self.model)
        data.qpos[:] = self.model.qpos_spring
        for _ in range(_STEPS):
            mujoco.mj_kinematics(self.model, data)
            mujoco.mj_comPos(self.model, data)
            # xfrc_applied acts at the centre of mass of the body.
            arm = data.site("load").xpos - data.xipos[self.flange]
            data.xfrc_applied[self.flange, :3] = wrench[:3]
            data.xfrc_applied[self.flange, 3:] = wrench[3:] + np.cross(arm, wrench[:3])
            before = data.qpos.copy()
            mujoco.mj_step(self.model, data)
            if np.abs(data.qpos - before).max() <= 1e-16:
                break
        assert np.abs(data.qvel).max() * _STEP <= 1e-15, "MuJoCo's arm does not come to rest"
        mujoco.mj_kinematics(self.model, data)
        count = len(self.arm.tool.markers)
        return np.concatenate([data.site(f"marker {i}").xpos for i in range(count)])

    def _build(self, world: ET.Element, q: Array) -> None:
        robot, springs = self.arm.robot, self.arm.springs
        parent = world
        for body in range(len(robot.joints) + 1):
            own = np.linalg.inv(T_body_joint(robot, body))  # the files' frame from the body's
            if body:
                joint, value = robot.joints[body - 1], float(q[body - 1])
                masses = [m for m in robot.masses if m.body == body]
                weights = [(m.mass, own[:3, :3] @ m.center + own[:3, 3]) for m in masses]
                if joint.name in self.compliance:
                    parent = _body(parent, joint.T_parent_joint, weights)
                    origin = np.zeros(3)
                    self._spring(parent, joint.name, joint.prismatic, joint.axis, origin, value)
                else:
                    moved = joint.T_parent_joint @ _motion(joint.axis, value, joint.prismatic)
                    parent = _body(parent, moved, weights)
            for i in np.flatnonzero((springs.body == body) & (springs.joint < 0)):
                parent = _body(parent, np.eye(4), [])
                place = own[:3, :3] @ springs.origin[i] + own[:3, 3]
                axis = own[:3, :3] @ springs.axis[i]
                slides = bool(springs.prismatic[i])
                self._spring(parent, springs.names[i], slides, axis, place, 0.0)
        flange = _body(parent, robot.T_tip_flange, [], "flange")
        ET.SubElement(flange, "site", name="load", pos=_text(self.arm.tool.load_point))
        for i, marker in enumerate(self.arm.tool.markers):
            ET.SubElement(flange, "site", name=f"marker {i}", pos=_text(marker))

    def _spring(
        self, body: ET.Element, name: str, slides: bool, axis: Array, origin: Array, rest: float
    ) -> None:
        stiffness = 1.0 / float(self.compliance[name])
        ET.SubElement(
            body,
            "joint",
            name=name,
            type="slide" if slides else "hinge",
            axis=_text(axis),
            pos=_text(origin),
            stiffness=repr(stiffness),
            springref=repr(rest),
            # Inertia of the drive and heavy damping: the arm creeps to its rest in some 100 steps.
            armature=repr(stiffness * _STEP**2),
            damping=repr(2.0 * stiffness * _STEP),
        )


def _body(
    parent: ET.Element, T: Array, weights: list[tuple[float, Array]], name: str = ""
) -> ET.Element:
    """A body fixed to its parent at T, with the weights that belong to it."""
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.array(T[:3, :3]).reshape(9))
    named = {"name": name} if name else {}
    body = ET.SubElement(parent, "body", pos=_text(T[:3, 3]), quat=_text(quaternion), **named)
    mass = sum(weight for weight, _ in weights)
    center = sum((w * at for w, at in weights), np.zeros(3)) / mass if mass else np.zeros(3)
    light = _text([_LIGHT] * 3)
    ET.SubElement(
        body, "inertial", mass=repr(float(mass or _LIGHT)), pos=_text(center), diaginertia=light
    )
    return body


def _motion(axis: Array, value: float, slides: bool) -> Array:
    """(4, 4) turn or shift by a joint value."""
    T = np.eye(4)
    if slides:
        T[:3, 3] = value * np.array(axis)
        return T
    quaternion, matrix = np.zeros(4), np.zeros(9)
    mujoco.mju_axisAngle2Quat(quaternion, np.array(axis), value)
    mujoco.mju_quat2Mat(matrix, quaternion)
    T[:3, :3] = matrix.reshape(3, 3)
    return T


def _text(values: object) -> str:
    return " ".join(repr(float(v)) for v in np.asarray(values, dtype=float))
