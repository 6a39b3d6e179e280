"""Links that follow a joint: kinematics and weight against Pinocchio, leader and follower moved."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from typer.testing import CliRunner

from elastocal.arrays import Array
from elastocal.cli import app
from elastocal.constraints.clearance import Clearance
from elastocal.constraints.collision.chain import robot_solids
from elastocal.constraints.collision.contacts import self_pairs
from elastocal.drawing.silhouette import solid_points
from elastocal.drawing.skeleton import skeletons
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.equilibrium import linearise
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.errors import InputError
from elastocal.motion.margins import relative_speed
from elastocal.robot.chain import Follower, Joint, Robot, Tool
from elastocal.robot.posture import Posture, forward_kinematics
from elastocal.robot.sources.mesh_files import MeshFiles
from elastocal.robot.sources.urdf import parse_urdf
from elastocal.viewer.frames import bent_frames, rigid_frames
from elastocal.viewer.parts import robot_parts

LIMIT = '<limit lower="-2" upper="2" effort="1" velocity="1"/>'


def link(name: str, mass: float = 0.0, center: str = "0 0 0", size: str = "") -> str:
    weight = f'<inertial><origin xyz="{center}"/><mass value="{mass}"/>{INERTIA}</inertial>'
    box = f'<origin xyz="{center}" rpy="0.1 0.2 0.3"/><geometry><box size="{size}"/></geometry>'
    shape = f"<collision>{box}</collision><visual>{box}</visual>" if size else ""
    return f'<link name="{name}">{weight if mass else ""}{shape}</link>'


INERTIA = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'


def joint(
    name: str, kind: str, ends: str, origin: str, axis: str, mimic: str = "", limit: str = LIMIT
) -> str:
    parent, child = ends.split()
    follow = f"<mimic {mimic}/>" if mimic else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin {origin}/><axis xyz="{axis}"/>{limit}{follow}</joint>'
    )


# An arm that lifts with rods: on the chain j1, j2, slide, j4; beside it rods on two carriers, a
# lever behind a rod, a ram, and a gripper that nothing drives.
PALLET = "".join([
    '<robot name="pallet">',
    link("base"), link("l1", 40, "0.1 0 0.2", "0.2 0.2 0.4"),
    link("l2", 30, "0.4 0 0", "0.6 0.1 0.1"), link("ram", 10, "0.1 0 0", "0.3 0.05 0.05"),
    link("l4", 8, "0.1 0 0.02", "0.2 0.06 0.06"), link("tool0"),
    link("weight", 100, "-0.5 0 0.1", "0.1 0.1 0.1"),
    link("lever", 5, "0.2 0.1 0", "0.3 0.04 0.04"),
    link("gas", 12, "0 0 0.2", "0.05 0.05 0.4"), link("piston", 3, "0 0.02 0.3", "0.03 0.03 0.3"),
    link("finger", 2, "0.05 0 0"), link("thumb", 1, "0.06 0 0"),
    joint("j1", "revolute", "base l1", 'xyz="0 0 0.5"', "0 0 1"),
    joint("j2", "revolute", "l1 l2", 'xyz="0.1 0 0.4" rpy="0.3 0 0"', "0 1 0"),
    joint("slide", "prismatic", "l2 ram", 'xyz="0.8 0 0" rpy="0 0.1 0"', "1 0 0",
          limit='<limit lower="0" upper="0.4" effort="1" velocity="1"/>'),
    joint("j4", "continuous", "ram l4", 'xyz="0.3 0 0"', "0 2 0", limit=""),
    joint("end", "fixed", "l4 tool0", 'xyz="0.2 0 0"', "1 0 0"),
    joint("rod", "revolute", "l1 weight", 'xyz="0 0.2 0.4" rpy="0 0 0.2"', "0 -1 0.2",
          'joint="j2" multiplier="-1.5" offset="0.3"'),
    joint("lever", "revolute", "weight lever", 'xyz="-0.3 0 0"', "0.1 1 0",
          'joint="rod" multiplier="-0.5" offset="-0.2"'),
    joint("gas", "continuous", "l2 gas", 'xyz="0.1 -0.2 0"', "0 1 0", 'joint="j4"', limit=""),
    joint("piston", "prismatic", "gas piston", 'xyz="0 0 0.1"', "0 0 1",
          'joint="slide" multiplier="0.4" offset="0.05"'),
    joint("finger", "prismatic", "tool0 finger", 'xyz="0.02 0 0"', "0 1 0"),
    joint("thumb", "prismatic", "tool0 thumb", 'xyz="0.02 0 0"', "0 -1 0",
          'joint="finger" multiplier="1" offset="0.03"'),
    "</robot>",
])  # fmt: skip
GRAVITY = np.array([0.0, 0.0, -9.81])
FOLLOW: dict[str, tuple[str, float, float]] = {
    "rod": ("j2", -1.5, 0.3),
    "lever": ("j2", 0.75, -0.35),
    "gas": ("j4", 1.0, 0.0),
    "piston": ("slide", 0.4, 0.05),
}


def read(text: str = PALLET, base: str | None = None, tip: str = "tool0") -> Robot:
    return parse_urdf(
        text.encode(), "pallet.urdf", MeshFiles(Path("/nowhere"), {}), base=base, tip=tip
    )


class Oracle:
    """Pinocchio, which knows nothing of following: all joints are moved, as the file says."""

    def __init__(self, text: str = PALLET) -> None:
        self.model = pin.buildModelFromXML(text, mimic=False)
        self.data = self.model.createData()

    def values(self, robot: Robot, q: Array) -> dict[str, float]:
        own = dict(zip(robot.joint_names, q.tolist(), strict=True))
        rest = {n: factor * own.get(j, 0.0) + shift for n, (j, factor, shift) in FOLLOW.items()}
        return own | rest | {"thumb": 0.03}

    def full(self, values: Mapping[str, float]) -> Array:
        full = pin.neutral(self.model)
        for name, value in values.items():
            at = self.model.joints[self.model.getJointId(name)]
            turn = [np.cos(value), np.sin(value)]
            full[at.idx_q : at.idx_q + at.nq] = turn if at.nq == 2 else value
        return full

    def place(self, robot: Robot, q: Array, frame: str) -> Array:
        pin.framesForwardKinematics(self.model, self.data, self.full(self.values(robot, q)))
        return self.data.oMf[self.model.getFrameId(frame, pin.FrameType.BODY)].homogeneous

    def gravity(self, robot: Robot, q: Array) -> Array:
        """(n,) what the weight exerts on each joint, with those that follow it."""
        tau = -pin.computeGeneralizedGravity(
            self.model, self.data, self.full(self.values(robot, q))
        )
        of = {name: tau[self.model.joints[i].idx_v] for i, name in enumerate(self.model.names) if i}
        found = [of[name] for name in robot.joint_names]
        for name, (leader, factor, _) in FOLLOW.items():
            if leader in robot.joint_names:
                found[robot.joint_names.index(leader)] += factor * of[name]
        return np.array(found)


def configurations(robot: Robot, count: int) -> Array:
    low = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    high = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    return np.random.default_rng(2).uniform(low, high, (count, len(robot.joints)))


def test_every_link_is_where_it_is_with_its_leader() -> None:
    robot, oracle = read(), Oracle()
    q = configurations(robot, 6)
    posture = Posture(robot, q)
    assert {shape.name for shape in robot.collisions} >= {"weight", "lever", "gas", "piston"}
    for i in range(len(q)):
        assert forward_kinematics(robot, q)[i] == pytest.approx(
            oracle.place(robot, q[i], "tool0"), abs=1e-12
        )
        for mass in robot.masses:
            there = oracle.place(robot, q[i], mass.name)
            centre = there @ [*_centre(mass.name), 1.0]
            assert posture.point(mass.center, mass.body)[:, i] == pytest.approx(
                centre[:3], abs=1e-12
            )


def _centre(name: str) -> list[float]:
    text = PALLET[PALLET.index(f'<link name="{name}"') :]
    return [float(v) for v in text.split('xyz="', 1)[1].split('"')[0].split()]


@pytest.mark.parametrize("extra", [False, True], ids=["in joints", "in a link besides"])
def test_weights_pull_on_the_leader(extra: bool) -> None:
    robot, oracle = read(), Oracle()
    springs = joint_springs(robot)
    if extra:
        link = VirtualJoints(("link",), [1], [[1, 0, 0]], [[0, 0, 0.1]], [False])  # type: ignore[arg-type]
        springs = merged(springs, link)
    own = [springs.names.index(name) for name in robot.joint_names]
    arm = ElasticArm(robot, springs, tool(), GRAVITY)
    q = configurations(robot, 5)
    idle = np.zeros((len(q), len(springs)))
    state = linearise(arm, np.ones(len(springs)), q, np.zeros((len(q), 6)), idle)
    # With k = 1 the first step solves (I - H) δ = y.
    step = (np.eye(len(springs)) - state.stiffening) @ state.step[:, :, None]
    for i in range(len(q)):
        assert step[i, own, 0] == pytest.approx(oracle.gravity(robot, q[i]), abs=1e-9)


@pytest.mark.parametrize("moment", [0.0, 50.0])
def test_what_the_load_loses_by_moving_along_is_the_derivative_of_what_it_exerts(
    moment: float,
) -> None:
    robot = read()
    arm = ElasticArm(robot, joint_springs(robot, ["j1", "j2", "slide"]), tool(), GRAVITY)
    q = configurations(robot, 3)
    wrench = np.tile([100.0, -50.0, -300.0, moment, 0.0, -moment], (3, 1))
    eps, zero = 1e-6, np.zeros((3, 3))

    def effort(displacement: Array) -> Array:
        state = linearise(arm, np.ones(3), q, wrench, displacement)
        raw = (np.eye(3) - state.stiffening) @ state.step[:, :, None]
        return raw[:, :, 0] + displacement

    found = linearise(arm, np.ones(3), q, wrench, zero).stiffening
    for j in range(3):
        shift = eps * np.eye(3)[j]
        slope = (effort(zero + shift) - effort(zero - shift)) / (2.0 * eps)
        assert found[:, :, j] == pytest.approx(slope, abs=1e-4)


def tool() -> Tool:
    return Tool("t", np.array([0.1, 0.0, 0.05]), np.array([[0.1, 0.0, 0.0]]), ("m",))


def test_a_base_behind_the_carrier_sees_what_follows_before_it() -> None:
    robot, oracle = read(base="l2"), Oracle()
    q = np.array([[0.2, -0.7]])
    weight = next(mass for mass in robot.masses if mass.name == "weight")
    base = oracle.place(robot, q[0], "l2")
    there = np.linalg.inv(base) @ oracle.place(robot, q[0], "weight")
    here = Posture(robot, q).point(weight.center, weight.body)[:, 0]
    assert here == pytest.approx((there @ [-0.5, 0, 0.1, 1])[:3], abs=1e-12)


def test_followers_before_the_base_are_seen_from_it() -> None:
    """The base is a link that a follower carries; its parents turn the other way then."""
    turn = PALLET.replace('joint="j2" multiplier="-1.5" offset="0.3"', 'joint="jx"')
    more = link("far", 7, "0.2 0 0") + joint("jx", "revolute", "weight far", 'xyz="0 0 1"', "0 1 0")
    text = turn.replace("</robot>", more + "</robot>")
    robot = read(text, base="weight", tip="far")
    assert robot.joint_names == ("jx",)
    oracle = Oracle(text)
    for value in (-0.4, 0.9):
        full = oracle.full({"jx": value, "rod": value, "lever": -0.5 * value - 0.2, "thumb": 0.03,
                            "piston": 0.05})  # fmt: skip
        pin.framesForwardKinematics(oracle.model, oracle.data, full)
        places = oracle.data.oMf
        base, first = (
            places[oracle.model.getFrameId(name, pin.FrameType.BODY)] for name in ("weight", "l1")
        )
        expected = (base.inverse() * first).homogeneous @ [0.1, 0, 0.2, 1]
        mass = next(m for m in robot.masses if m.name == "l1")
        here = Posture(robot, np.array([[value]])).point(mass.center, mass.body)[:, 0]
        assert here == pytest.approx(expected[:3], abs=1e-12)


def test_what_follows_is_said() -> None:
    said = " ".join(read().remarks)
    assert "rod = -1.5 · j2 + 17.19°, lever = 0.75 · j2 - 20.05°, gas = j4" in said
    assert "piston = 0.4 · slide + 50 mm: these follow (mimic)" in said
    assert "finger: not between 'base' and 'tool0', held at zero" in said
    assert "thumb at 30 mm: held there, as what they follow is held at zero" in said


def test_distances_of_what_follows_have_the_gradient_of_differences() -> None:
    robot = read()
    solids = robot_solids(robot, as_capsules=True)
    limits = np.array([[-2, -2, 0, -3], [2, 2, 0.4, 3]])
    pairs, _ = self_pairs(robot, limits, solids, (), margin=0.01)
    watched = {frozenset(s.name for s in pairs.of(p)) for p in range(len(pairs))}
    assert frozenset(("weight", "l2")) in watched
    beside = [s for p in range(len(pairs)) for s in pairs.of(p)[:1] if pairs.of(p)[1].name == "l1"]
    assert all(s.covered for s in beside if s.name == "weight")  # its carrier: the outer part
    clearance = Clearance("itself", pairs, 0.01)
    q = configurations(robot, 40)
    posture = Posture(robot, q)
    _, pull = clearance.at(posture)
    gradient = pull(np.ones(len(q)))
    eps, near = 1e-6, clearance.room(posture) < 0.05
    assert near.sum() > 5
    for j in range(4):
        shift = eps * np.eye(4)[j]
        ahead, behind = (clearance.room(Posture(robot, q + s * shift)) for s in (1, -1))
        off = np.abs((ahead - behind) / (2 * eps) - gradient[j])[near]
        assert np.median(off) < 1e-5


def test_no_point_of_what_follows_moves_faster_than_the_bound() -> None:
    robot = read()
    solids = robot_solids(robot, as_capsules=True)
    pairs, _ = self_pairs(robot, np.array([[-2, -2, 0, -3], [2, 2, 0.4, 3]]), solids, ())
    rng = np.random.default_rng(3)
    starts = configurations(robot, 30)
    way = rng.normal(0.0, 1e-5, starts.shape)
    speed = relative_speed(robot, pairs, starts, starts + way)
    for p in range(len(pairs)):
        one = Clearance("one", type(pairs)(pairs.solids, (pairs.index[p],)), 0.0)
        before, after = (one.room(Posture(robot, q)) for q in (starts, starts + way))
        assert (np.abs(after - before) <= speed[p] * (1 + 1e-6) + 1e-12).all()


def test_pictures_have_what_follows() -> None:
    robot = read()
    parts, remarks = robot_parts(robot)
    assert not remarks
    assert {"weight", "lever", "gas", "piston"} <= {part.name for part in parts}
    q = np.array([0.3, 0.4, 0.1, 0.5])
    frames = rigid_frames(robot, q)
    assert len(frames) == robot.bodies + 1
    arm = ElasticArm(robot, joint_springs(robot), tool())
    assert bent_frames(arm, q, np.zeros(4)) == pytest.approx(frames)
    shift = np.array([0.0, 0.2, 0.0, 0.0])
    assert bent_frames(arm, q, shift) == pytest.approx(rigid_frames(robot, q + shift))
    link = VirtualJoints(("link",), [2], [[1, 0, 0]], [[0, 0, 0]], [False])  # type: ignore[arg-type]
    bent = bent_frames(
        ElasticArm(robot, merged(joint_springs(robot), link), tool()), q, np.zeros(5)
    )
    assert bent == pytest.approx(frames)


def test_lines_and_silhouettes_are_drawn_beside_it() -> None:
    robot, q = read(), np.array([[0.3, 0.4, 0.1, 0.5]])
    (skeleton,) = skeletons(robot, tool(), q)
    assert len(skeleton.centres) == len(skeleton.axes) == 4
    weight = next(shape for shape in robot.visuals if shape.name == "weight")
    middle = solid_points(weight, Posture(robot, q), 0).mean(axis=0)
    there = Oracle().place(robot, q[0], "weight") @ [-0.5, 0, 0.1, 1]
    assert middle == pytest.approx(there[:3])


STUDY = """elastocal: 1
robot: {urdf: pallet.urdf, tip: tool0}
tools: {t: {load_point_mm: [100, 0, 30]}}
test_poses: [{tool: t, q_deg: {j1: 10, j2: -20, j4: 30}, q_mm: {slide: 200}, force_N: [0, 0, -9]}]
experiments: {tool: t, max_force_N: 100, direction: free, count: 4, max_configurations: 2}
identify: [j2, j4]
instrument: {sigma_mm: 0.03}
gravity_m_s2: [0, 0, -9.81]
constraints: {collision: off}
"""


def test_check_draws_and_says_it(tmp_path: Path) -> None:
    (tmp_path / "pallet.urdf").write_text(PALLET)
    study = tmp_path / "study.yaml"
    study.write_text(STUDY)
    picture = tmp_path / "arm.svg"
    done = CliRunner().invoke(app, ["check", str(study), "--picture", str(picture)])
    assert done.exit_code == 0, done.output
    assert "rod = -1.5" in " ".join(done.output.split())
    assert picture.is_file()


WRONG = {
    'joint="lever" multiplier="-1.5" offset="0.3"': "follows in a circle, through joint 'rod'",
    'joint="rod" multiplier="-1.5" offset="0.3"': "follows in a circle, through joint 'rod'",
    'joint="nobody"': "'rod' follows joint 'nobody' (mimic), which is not there",
    'joint="j2" multiplier="fast"': "finite numbers, found 'fast'",
    'joint="j2" offset="1 2"': "'offset' of <mimic> must be a number",
    'multiplier="2"': "<mimic> has no 'joint'",
}  # fmt: skip


@pytest.mark.parametrize("mimic", WRONG)
def test_what_follows_nothing_is_refused(mimic: str) -> None:
    with pytest.raises(InputError) as caught:
        read(PALLET.replace('joint="j2" multiplier="-1.5" offset="0.3"', mimic))
    assert WRONG[mimic] in str(caught.value)
    assert "\n" not in str(caught.value)


def test_lines_of_leaders_may_be_long_but_not_beyond_numbers() -> None:
    text, before = PALLET, "j2"
    for name in (f"f{i}" for i in range(300)):
        mimic = f'joint="{before}" multiplier="0.99"'
        body = joint(name, "continuous", f"l1 of{name}", "", "0 1 0", mimic, limit="")
        text = text.replace("</robot>", link(f"of{name}") + body + "</robot>")
        before = name
    robot = read(text)
    factors = {follower.joint.name: follower.factor for follower in robot.followers}
    assert factors["f299"] == pytest.approx(0.99**300)
    with pytest.raises(InputError, match="beyond all numbers"):
        read(text.replace('"0.99"', '"1e29"'))


def test_a_follower_is_carried_by_what_is_before_it() -> None:
    turn = Joint("a", np.eye(4), np.array([0.0, 0.0, 1.0]))
    rod = Follower(Joint("rod", np.eye(4), np.array([0.0, 1.0, 0.0])), 3, "a", 1.0)
    with pytest.raises(InputError, match="'rod' is carried by body 3, which does not come before"):
        Robot("r", (turn,), followers=(rod,))
    with pytest.raises(InputError, match="no joint 'b'"):
        Robot("r", (turn,), followers=(Follower(rod.joint, 0, "b", 1.0),))
    with pytest.raises(InputError, match="factor and offset"):
        Follower(rod.joint, 0, "a", float("nan"))
