"""Joints between base and tip that follow others: kinematics, springs and weight as they add up."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from elastocal.arrays import Array
from elastocal.constraints.clearance import Clearance
from elastocal.constraints.collision.chain import robot_solids
from elastocal.constraints.collision.contacts import self_pairs
from elastocal.drawing.skeleton import skeletons
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.equilibrium import equilibrium, linearise
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import Regressor, regressor
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.errors import InputError
from elastocal.motion.margins import relative_speed
from elastocal.robot.chain import Follower, Joint, Robot, Tool
from elastocal.robot.geometry_hash import geometry_hash
from elastocal.robot.posture import Posture, forward_kinematics, jacobian
from elastocal.robot.sources.mesh_files import MeshFiles
from elastocal.robot.sources.urdf import parse_urdf
from elastocal.viewer.frames import bent_frames, rigid_frames
from elastocal.viewer.parts import robot_parts
from tests.robot.sources.test_mimic import GRAVITY, joint, link

# A lifting arm whose hand stays level, with a stretching forearm and a hollow wrist: on the way
# stand four that follow; a rod beside hangs on one of them.
LEVEL = 'joint="j2" multiplier="-1" offset="0.2"'
STRETCH = 'joint="j3" multiplier="0.2" offset="0.1"'
CHAIN = {
    "j1": ("revolute", 'xyz="0 0 0.4"', "0 0 1", ""),
    "j2": ("revolute", 'xyz="0.1 0 0.1" rpy="0.1 0 0"', "0 1 0", ""),
    "level": ("revolute", 'xyz="0.6 0 0" rpy="0 0 0.1"', "0 1 0.1", LEVEL),
    "j3": ("revolute", 'xyz="0.1 0 0"', "0 1 0", ""),
    "stretch": ("prismatic", 'xyz="0.2 0 0"', "1 0 0.2", STRETCH),
    "j5": ("revolute", 'xyz="0.3 0 0"', "0.5 0.5 0.7", ""),
    "j5b": ("revolute", 'xyz="0.1 0 0"', "1 0 0", 'joint="j5" multiplier="-1"'),
    "j6": ("revolute", 'xyz="0.1 0 0"', "1 0 0", ""),
}
MASSES = dict(zip(CHAIN, (40, 30, 5, 20, 8, 3, 2, 1), strict=True))
ARM = (
    '<robot name="level">'
    + link("base")
    + "".join(link(f"of {n}", m, "0.1 0.02 0.03", "0.2 0.05 0.05") for n, m in MASSES.items())
    + link("weight", 60, "-0.3 0 0.1", "0.1 0.1 0.1")
    + link("tool0")
    + "".join(
        joint(name, kind, "PARENT CHILD", origin, axis, mimic)
        .replace('"PARENT"', f'"{below}"')
        .replace('"CHILD"', f'"of {name}"')
        for below, (name, (kind, origin, axis, mimic)) in zip(
            ["base", *(f"of {name}" for name in CHAIN)], CHAIN.items(), strict=False
        )
    )
    + joint("rod", "revolute", "PARENT weight", 'xyz="0 0.1 0"', "0 1 0", 'joint="j3"').replace(
        "PARENT", "of level"
    )
    + joint("end", "fixed", "PARENT tool0", 'xyz="0.05 0 0"', "1 0 0").replace("PARENT", "of j6")
    + "</robot>"
)
OWN = ("j1", "j2", "j3", "j5", "j6")
FOLLOW = {"level": ("j2", -1.0, 0.2), "stretch": ("j3", 0.2, 0.1), "j5b": ("j5", -1.0, 0.0),
          "rod": ("j3", 1.0, 0.0)}  # fmt: skip
TOOL = Tool(
    "t", np.array([0.1, 0.0, 0.05]), np.array([[0.1, 0.0, 0.0], [0.0, 0.1, 0.0]]), ("a", "b")
)
Q = np.random.default_rng(5).uniform(-1.0, 1.0, (6, 5))


def read(text: str = ARM) -> Robot:
    return parse_urdf(text.encode(), "level.urdf", MeshFiles(Path("/nowhere"), {}), tip="tool0")


ROBOT = read()


class Oracle:
    """Pinocchio with all joints moved, as the file says."""

    def __init__(self) -> None:
        self.model = pin.buildModelFromXML(ARM, mimic=False)
        self.data = self.model.createData()
        names = list(self.model.names)[1:]
        self.mixing, self.standing = np.zeros((len(names), 5)), np.zeros(len(names))
        for j, name in enumerate(OWN):
            self.mixing[names.index(name), j] = 1.0
        for name, (leader, factor, offset) in FOLLOW.items():
            self.mixing[names.index(name), OWN.index(leader)] = factor
            self.standing[names.index(name)] = offset

    def full(self, q: Array) -> Array:
        return np.asarray(self.mixing @ q + self.standing)

    def place(self, q: Array, frame: str) -> Array:
        pin.framesForwardKinematics(self.model, self.data, self.full(q))
        return self.data.oMf[self.model.getFrameId(frame, pin.FrameType.BODY)].homogeneous

    def jacobian(self, q: Array) -> Array:
        frame = self.model.getFrameId("tool0", pin.FrameType.BODY)
        pin.computeJointJacobians(self.model, self.data, self.full(q))
        pin.framesForwardKinematics(self.model, self.data, self.full(q))
        aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        return pin.getFrameJacobian(self.model, self.data, frame, aligned) @ self.mixing

    def gravity(self, q: Array) -> Array:
        tau = pin.computeGeneralizedGravity(self.model, self.data, self.full(q))
        return np.asarray(-self.mixing.T @ tau)


def test_the_tip_and_every_link_are_where_the_file_has_them() -> None:
    oracle, posture = Oracle(), Posture(ROBOT, Q)
    assert ROBOT.joint_names == OWN
    assert ROBOT.chain == tuple(CHAIN)
    columns = jacobian(ROBOT, Q)
    for i, q in enumerate(Q):
        assert forward_kinematics(ROBOT, Q)[i] == pytest.approx(oracle.place(q, "tool0"), abs=1e-12)
        assert columns[i] == pytest.approx(oracle.jacobian(q), abs=1e-12)
        for mass in ROBOT.masses:
            centre = [-0.3, 0, 0.1, 1] if mass.name == "weight" else [0.1, 0.02, 0.03, 1]
            there = oracle.place(q, mass.name) @ centre
            assert posture.point(mass.center, mass.body)[:, i] == pytest.approx(
                there[:3], abs=1e-12
            )


def arm(extra: bool = False, names: tuple[str, ...] = OWN) -> ElasticArm:
    springs = joint_springs(ROBOT, names)
    if extra:
        for body in (0, 2, 3, 7):
            axis, origin = [[0.6, 0.0, 0.8]], [[0.1, 0.0, 0.1]]
            one = VirtualJoints((f"x{body}",), [body], axis, origin, [body == 3])  # type: ignore[arg-type]
            springs = merged(springs, one)
    return ElasticArm(ROBOT, springs, TOOL, GRAVITY)


@pytest.mark.parametrize("extra", [False, True])
def test_weights_are_borne_by_leaders(extra: bool) -> None:
    bends, oracle = arm(extra), Oracle()
    p = len(bends.springs)
    own = [bends.springs.names.index(name) for name in OWN]
    state = linearise(bends, np.ones(p), Q, np.zeros((6, 6)), np.zeros((6, p)))
    step = (np.eye(p) - state.stiffening) @ state.step[:, :, None]
    for i, q in enumerate(Q):
        assert step[i, own, 0] == pytest.approx(oracle.gravity(q), abs=1e-9)


WRENCH = np.tile([100.0, -50.0, -300.0, 40.0, -10.0, 20.0], (6, 1))


@pytest.mark.parametrize("extra", [False, True])
def test_the_linear_model_is_the_limit_of_the_equilibrium(extra: bool) -> None:
    bends = arm(extra)
    weightless = ElasticArm(ROBOT, bends.springs, TOOL)
    p, small = len(bends.springs), 1e-10
    cases = LoadCases(Q, WRENCH)
    for s in range(p):
        compliance = small * np.eye(p)[s]
        rest = equilibrium(weightless, compliance, cases)
        state = linearise(weightless, compliance, Q, WRENCH, rest.displacement)
        idle = linearise(weightless, compliance, Q, WRENCH, 0.0 * rest.displacement)
        moved = (state.markers - idle.markers) / small
        assert regressor(weightless, cases)[:, :, s] == pytest.approx(moved, rel=1e-4, abs=2e-3)


@pytest.mark.parametrize("extra", [False, True])
def test_the_slope_of_the_equilibrium_is_that_of_differences(extra: bool) -> None:
    bends = arm(extra)
    p, eps = len(bends.springs), 1e-6
    zero = np.zeros((6, p))

    def effort(displacement: Array) -> Array:
        state = linearise(bends, np.ones(p), Q, WRENCH, displacement)
        raw = (np.eye(p) - state.stiffening) @ state.step[:, :, None]
        return np.asarray(raw[:, :, 0] + displacement)

    found = linearise(bends, np.ones(p), Q, WRENCH, zero)
    for j in range(p):
        shift = eps * np.eye(p)[j]
        slope = (effort(zero + shift) - effort(zero - shift)) / (2.0 * eps)
        assert found.stiffening[:, :, j] == pytest.approx(slope, abs=1e-4)
        ahead, behind = (
            linearise(bends, np.ones(p), Q, WRENCH, zero + s * shift).markers for s in (1, -1)
        )
        assert found.velocity[:, :, j] == pytest.approx((ahead - behind) / (2 * eps), abs=1e-7)


@pytest.mark.parametrize("rotation", [False, True])
@pytest.mark.parametrize("extra", [False, True])
def test_gradients_of_the_regressor_are_those_of_differences(extra: bool, rotation: bool) -> None:
    bends, eps = arm(extra), 1e-6

    def rows(q: Array) -> Array:
        return Regressor(bends, Posture(ROBOT, q), WRENCH, rotation=rotation).rows

    weights = np.random.default_rng(1).normal(size=rows(Q).shape)
    pulled, _ = Regressor(bends, Posture(ROBOT, Q), WRENCH, rotation=rotation).pull(weights)
    for j in range(5):
        shift = eps * np.eye(5)[j]
        slope = ((rows(Q + shift) - rows(Q - shift)) * weights).sum(axis=(0, 1)) / (2.0 * eps)
        assert pulled[j] == pytest.approx(slope, rel=1e-6, abs=1e-3)


def test_constraints_have_the_gradients_of_differences() -> None:
    solids = robot_solids(ROBOT, as_capsules=True)
    pairs, left = self_pairs(ROBOT, np.array([5 * [-1.0], 5 * [1.0]]), solids, ())
    assert ("of j5", "of j5b", "neighbours") in {(u.first, u.second, u.why) for u in left}
    near = Clearance("itself", pairs, 0.0)
    q = np.random.default_rng(3).uniform(-1.0, 1.0, (60, 5))
    posture, eps = Posture(ROBOT, q), 1e-6
    gradient = near.at(posture)[1](np.ones(len(q)))
    direction = posture.direction(np.array([0.0, 0.0, 1.0]))
    turned = posture.pull_direction(direction, np.ones((3, len(q))))
    for j in range(5):
        shift = eps * np.eye(5)[j]
        ahead, behind = (Posture(ROBOT, q + s * shift) for s in (1, -1))
        slope = (near.room(ahead) - near.room(behind)) / (2 * eps)
        assert np.median(np.abs(slope - gradient[j])[near.room(posture) < 0.05]) < 1e-5
        slope = ahead.direction(np.array([0.0, 0, 1])) - behind.direction(np.array([0.0, 0, 1]))
        assert turned[j] == pytest.approx(slope.sum(axis=0) / (2 * eps), abs=1e-7)
    way = np.random.default_rng(4).normal(0.0, 1e-5, q.shape)
    speed = relative_speed(ROBOT, pairs, q, q + way)
    for p in range(len(pairs)):
        one = Clearance("one", type(pairs)(pairs.solids, (pairs.index[p],)), 0.0)
        before, after = (one.room(Posture(ROBOT, each)) for each in (q, q + way))
        assert (np.abs(after - before) <= speed[p] * (1 + 1e-6) + 1e-12).all()


def test_pictures_show_what_is_between() -> None:
    parts, _ = robot_parts(ROBOT)
    assert {f"of {name}" for name in CHAIN} <= {part.name for part in parts}
    frames = rigid_frames(ROBOT, Q[0])
    assert len(frames) == ROBOT.bodies + 1
    for bends in (arm(), arm(extra=True)):
        p = len(bends.springs)
        assert bent_frames(bends, Q[0], np.zeros(p)) == pytest.approx(frames)
    shift = 0.1 * np.arange(5)
    assert bent_frames(arm(), Q[0], shift) == pytest.approx(rigid_frames(ROBOT, Q[0] + shift))
    (skeleton,) = skeletons(ROBOT, TOOL, Q[:1])
    assert len(skeleton.centres) == 5
    assert any(np.linalg.norm(a - b) > 0.05 for a, b in pairwise(skeleton.arm))


def test_a_robot_is_another_one_if_it_follows_otherwise() -> None:
    other = read(ARM.replace('offset="0.2"', 'offset="0.3"'))
    faster = read(ARM.replace('multiplier="0.2"', 'multiplier="0.3"'))
    assert len({geometry_hash(robot) for robot in (ROBOT, other, faster)}) == 3


def test_what_stands_on_the_way_and_follows_an_idle_joint_stands_at_its_offset() -> None:
    text = ARM.replace(LEVEL, 'joint="idle" offset="0.2"')
    idle = joint("idle", "revolute", "base far", "", "0 1 0")
    robot = read(text.replace("</robot>", link("far") + idle + "</robot>"))
    assert robot.chain == ("j1", "j2", "j3", "stretch", "j5", "j5b", "j6")
    q = np.array([[0.3, 0.0, 0.2, 0.1, 0.4]])
    assert forward_kinematics(robot, q)[0] == pytest.approx(forward_kinematics(ROBOT, q)[0])


def test_a_chain_names_its_joints_in_order() -> None:
    a, b = (Joint(name, np.eye(4), np.array([0.0, 0.0, 1.0])) for name in "ab")
    rod = Follower(Joint("rod", np.eye(4), np.array([0.0, 1.0, 0.0])), 0, "a", 1.0)
    assert Robot("r", (a, b), followers=(rod,), chain=("a", "rod", "b")).last == 3
    for chain in (("b", "rod", "a"), ("a", "rod"), ("a", "c", "b"), ("a", "rod", "b", "b")):
        with pytest.raises(InputError, match="must name its joints in order"):
            Robot("r", (a, b), followers=(rod,), chain=chain)
