"""A URDF in Pinocchio, and the URDFs there are to compare with."""

from __future__ import annotations

from importlib.metadata import files
from pathlib import Path

import numpy as np
import pinocchio as pin

from elastocal.arrays import Array
from elastocal.robot.chain import Robot

ROOT = Path(__file__).parents[3]
OWN = sorted((ROOT / "examples" / "robots").glob("*/*.urdf"))


def zoo(name: str) -> Path:
    """A URDF of the test dependency example-robot-data, by the end of its path."""
    for file in files("example-robot-data") or ():
        if str(file).endswith(name):
            return Path(str(file.locate())).resolve()
    raise AssertionError(f"example-robot-data has no {name}")


class UrdfOracle:
    """Kinematics and masses of a URDF as Pinocchio has them, in the frame of a base link."""

    def __init__(self, path: Path, base: str, tip: str) -> None:
        self.model = pin.buildModelFromXML(path.read_text(), mimic=False)
        self.data = self.model.createData()
        self.base, self.tip = (
            self.model.getFrameId(name, pin.FrameType.BODY) for name in (base, tip)
        )

    def place(self, robot: Robot, q: Array) -> pin.SE3:
        """Put the joints of `robot` at `q`, others at zero; the pose of the base link."""
        full = pin.neutral(self.model)
        for name, value in zip(robot.joint_names, q, strict=True):
            joint = self.model.joints[self.model.getJointId(name)]
            turn = [np.cos(value), np.sin(value)]
            full[joint.idx_q : joint.idx_q + joint.nq] = turn if joint.nq == 2 else value
        self.full = full
        pin.framesForwardKinematics(self.model, self.data, full)
        return self.data.oMf[self.base]

    def forward(self, robot: Robot, q: Array) -> Array:
        """(4, 4) pose of the tip in the base frame."""
        base = self.place(robot, q)
        return (base.inverse() * self.data.oMf[self.tip]).homogeneous

    def jacobian(self, robot: Robot, q: Array) -> Array:
        """(6, n) velocity of the tip over angular velocity, in the axes of the base."""
        base = self.place(robot, q)
        frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        found = pin.computeFrameJacobian(self.model, self.data, self.full, self.tip, frame)
        columns = [
            self.model.joints[self.model.getJointId(name)].idx_v for name in robot.joint_names
        ]
        turn = np.kron(np.eye(2), base.rotation.T)
        return turn @ found[:, columns]

    def moments(self, robot: Robot, q: Array) -> Array:
        """(n + 1, 4) mass and mass times centre of the links that each body carries.

        Links behind joints that are not of the chain count with the body that carries them.
        """
        base = self.place(robot, q)
        chain = [self.model.getJointId(name) for name in robot.joint_names]
        result = np.zeros((len(chain) + 1, 4))
        for i in range(self.model.njoints):
            above = i
            while above and above not in chain:
                above = self.model.parents[above]
            body = chain.index(above) + 1 if above else 0
            inertia = self.model.inertias[i]
            center = base.inverse().act(self.data.oMi[i].act(inertia.lever))
            result[body] += inertia.mass * np.append(1.0, center)
        return result
