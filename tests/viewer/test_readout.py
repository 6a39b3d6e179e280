"""What the view says of a configuration, without any web server."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.cartesian import cartesian_compliance
from elastocal.elastic.deflections import loaded_deflection
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import deflection
from elastocal.planning.plan import plan
from elastocal.planning.sensitivity import sensitivity, worth
from elastocal.robot.posture import Posture, forward_kinematics
from elastocal.viewer.frames import bent_frames, magnified, rigid_frames, suitable_factor
from elastocal.viewer.readout import NEAR, Bending, Room, bending, read_out, watched
from elastocal.viewer.readout_html import heading_html, readout_html, room_words, worth_words
from elastocal.viewer.subject import Subject, stops_of, way
from elastocal.viewer.travel import SECONDS, Travel
from elastocal.wording.stiffness import plus_minus
from tests.elastic.test_equilibrium import random_arm
from tests.report.examples import three_link_plan
from tests.viewer.examples import kr270, rigid, tracked


def test_deflection_is_that_of_the_equilibrium_and_near_the_linear_one() -> None:
    subject = kr270()
    model = subject.model
    assert model is not None
    for stop in subject.stops:
        found = read_out(subject, stop.tool, stop.q, stop.wrench).bending
        assert found is not None
        assert not found.problem
        tool = watched(subject, stop.tool)
        case = LoadCases(stop.q[None], stop.wrench[None])
        linear = deflection(
            replace(subject.study.arm, springs=model.springs, tool=tool), model.compliance, case
        )[:, :3]
        assert found.deflection.ravel() == pytest.approx(linear.ravel(), rel=0.05, abs=2e-4)


def test_position_and_margins_are_those_of_the_constraints() -> None:
    subject = kr270()
    stop = subject.stops[1]
    readout = read_out(subject, stop.tool, stop.q, stop.wrench)
    flange = forward_kinematics(subject.study.robot, stop.q[None])[0]
    assert readout.position == pytest.approx((flange @ [*stop.tool.markers[0], 1.0])[:3])
    posture = Posture(subject.study.robot, stop.q[None])
    for room, constraint in zip(readout.rooms, subject.study.constraints, strict=False):
        assert room.name == constraint.names_at(posture)[0]
        assert room.margin == pytest.approx(float(constraint.room(posture)[0]))
    joints = readout.rooms[len(subject.study.constraints) :]
    assert len(joints) == len(subject.study.robot.joints)
    low, high = subject.study.limits
    nearer = np.minimum(stop.q - low, high - stop.q)
    assert [room.margin for room in joints] == pytest.approx(nearer)


def test_a_test_pose_has_its_own_tool_and_only_joint_limits() -> None:
    subject = kr270()
    stop = subject.stops[-1]
    assert stop.kind == "test"
    readout = read_out(subject, stop.tool, stop.q, stop.wrench)
    assert readout.place == "TCP"
    assert len(readout.rooms) == 6
    assert readout.worth is None


def test_states_of_margins() -> None:
    assert Room("a", -1e-3, "m").state == "broken"
    assert Room("a", 0.0, "m").state == "near"
    assert Room("a", NEAR["m"] + 1e-6, "m").state == "free"
    assert Room("a", NEAR["rad"] / 2, "rad").state == "near"
    assert room_words(Room("a", np.radians(3.25), "rad")) == "3.2°"
    assert room_words(Room("a", -0.0125, "m")) == "−12 mm"


def test_an_arm_that_gives_way_is_said_and_not_drawn() -> None:
    subject = kr270()
    stop, model = subject.stops[0], subject.model
    assert model is not None
    soft = replace(subject, model=replace(model, compliance=1e4 * model.compliance))
    found = bending(soft, stop.tool, stop.q, stop.wrench)
    assert found is not None
    assert "gives way" in found.problem
    assert not found.deflection.any()
    html = readout_html(read_out(soft, stop.tool, stop.q, stop.wrench), stop.wrench, 20.0)
    assert "no stable equilibrium" in html


def test_stiffness_is_that_of_the_tcp_in_this_configuration() -> None:
    subject = kr270()
    assert subject.model is not None
    stop = subject.stops[-1]
    readout = read_out(subject, stop.tool, stop.q, stop.wrench)
    arm = replace(subject.study.arm, tool=stop.tool)
    (expected,) = cartesian_compliance(arm, subject.model, stop.q[None])
    assert readout.cartesian is not None
    np.testing.assert_array_equal(readout.cartesian.matrix, expected.matrix)
    page = readout_html(readout, stop.wrench, 1.0)
    assert page.count("data-readout='stiffness'") == 4
    assert plus_minus(expected.axes[2].stiffness, 1e-6) in page
    assert "which is along" in page
    without = read_out(replace(subject, model=None), stop.tool, stop.q, stop.wrench)
    assert without.cartesian is None
    assert "N/µm" not in readout_html(without, stop.wrench, 1.0)


def test_without_compliances_no_deflection_is_shown() -> None:
    subject = rigid(kr270())
    stop = subject.stops[0]
    readout = read_out(subject, stop.tool, stop.q, stop.wrench)
    assert readout.bending is None
    assert "Deflection" not in readout_html(readout, stop.wrench, 1.0)


def test_bent_frames_move_the_marker_by_the_deflection() -> None:
    subject = kr270()
    stop, model = subject.stops[0], subject.model
    assert model is not None
    arm = ElasticArm(subject.study.robot, model.springs, stop.tool, subject.study.gravity)
    found = bending(subject, stop.tool, stop.q, stop.wrench)
    assert found is not None
    straight = rigid_frames(subject.study.robot, stop.q)
    bent = bent_frames(arm, stop.q, magnified(found.idle, found.displacement, 1.0))
    point = np.array([*stop.tool.markers[0], 1.0])
    moved = (bent[-1] @ point - straight[-1] @ point)[:3]
    case = LoadCases(stop.q[None], stop.wrench[None])
    wanted = loaded_deflection(arm, model.compliance, case)[0, :3]
    assert moved == pytest.approx(wanted, abs=1e-12)
    assert bent_frames(arm, stop.q, magnified(found.idle, found.displacement, 0.0)) == (
        pytest.approx(straight)
    )


@pytest.mark.parametrize("seed", range(4))
def test_springs_in_links_and_base_leave_every_body_in_its_place(seed: int) -> None:
    rng = np.random.default_rng(seed)
    arm = random_arm(rng, [False, True, False, False])
    assert (arm.springs.joint < 0).any()
    q = rng.normal(size=4)
    straight = rigid_frames(arm.robot, q)
    p = len(arm.springs)
    assert bent_frames(arm, q, np.zeros(p)) == pytest.approx(straight, abs=1e-12)
    bent = bent_frames(arm, q, 1e-3 * rng.normal(size=p))
    assert bent[0] == pytest.approx(np.eye(4))
    assert np.abs(bent - straight).max() < 0.05
    assert np.abs(bent[-1] - straight[-1]).max() > 1e-5


def test_magnification_suits_the_robot() -> None:
    assert suitable_factor(0.013, 3.0) == 20.0
    assert suitable_factor(1e-5, 1.0) == 10000.0
    assert suitable_factor(1.0, 1.0) == 1.0
    assert suitable_factor(0.0, 1.0) == 1.0


def test_worth_is_one_on_the_support_and_less_elsewhere() -> None:
    study = replace(three_link_plan().study, constraints=())
    made = plan(study, seed=1)
    proof = made.certificate
    assert proof.support is not None
    assert proof.weights is not None
    assert proof.peak is not None
    weights = proof.weights / proof.weights.sum()
    known = sensitivity(made.study, proof.support, weights, proof.peak)
    assert known is not None
    assert worth(made.study, known, proof.support) == pytest.approx(1.0, abs=0.02)
    rng = np.random.default_rng(0)
    anywhere = made.study.space.load_cases(made.study.space.sample(500, rng))
    shares = worth(made.study, known, anywhere)
    assert shares.max() <= 1.02
    assert shares.min() < 0.5
    subject = Subject(made.study, stops_of(made.study, anywhere), sensitivity=known)
    stop = subject.stops[7]
    readout = read_out(subject, stop.tool, stop.q, stop.wrench)
    assert readout.worth == pytest.approx(shares[7])
    assert "Worth" in readout_html(readout, stop.wrench, 1.0)


def test_no_worth_without_a_gradient() -> None:
    study = three_link_plan().study
    one = three_link_plan().load_cases
    alone = LoadCases(one.q[:1] * 0.0, one.wrench[:1] * [0, 0, 1, 0, 0, 0])
    assert sensitivity(study, alone, np.ones(1), alone) is None
    assert sensitivity(replace(study, criterion="O2"), one, np.ones(3) / 3.0, one) is None


def test_stops_are_the_plan_then_the_test_poses() -> None:
    labels = [stop.label for stop in kr270().stops]
    assert labels == [
        "pose 1 of 3, measured 4×",
        "pose 2 of 3, measured 4×",
        "pose 3 of 3, measured 4×",
        "test pose milling",
    ]
    assert tracked().stops[0].kind == "middle"
    assert tracked().stops[0].wrench == pytest.approx([0, 0, -2500, 0, 0, 0])
    limits = kr270().slider_limits
    for stop in kr270().stops:
        assert (limits[0] <= stop.q).all()
        assert (stop.q <= limits[1]).all()


def test_labels_that_would_repeat_are_told_apart() -> None:
    study = kr270().study
    stops = stops_of(replace(study, test_poses=(study.test_poses[0],) * 2))
    assert len({stop.label for stop in stops}) == len(stops)


def test_via_points_are_passed_both_ways_and_not_from_elsewhere() -> None:
    study = kr270().study
    cases = LoadCases(kr270().stops[0].q + 0.1 * np.arange(3)[:, None], np.zeros((3, 6)))
    passed = np.array([cases.q[0] + 0.03, cases.q[0] + 0.07])
    nothing = np.zeros((0, 6))
    stops = stops_of(study, cases, via=(passed, passed, nothing, nothing))
    assert way(stops, 0, 1) == pytest.approx(passed)
    assert way(stops, 1, 0) == pytest.approx(passed[::-1])
    assert len(way(stops, 1, 2)) == 0
    assert len(way(stops, 2, 0)) == 0
    assert len(stops[0].via) == 0  # the way from home is not shown


def test_a_travel_begins_and_ends_exactly_and_never_jumps() -> None:
    path = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]])
    loads = np.array([np.zeros(6), np.full(6, 7.0)])
    travel = Travel(path, loads, since=10.0)
    assert travel.ends == pytest.approx(10.0 + 2 * SECONDS)
    times = np.linspace(9.0, travel.ends + 1.0, 400)
    places = np.array([travel.at(t)[0] for t in times])
    assert (places[0] == path[0]).all()
    assert (places[-1] == path[-1]).all()
    assert np.abs(np.diff(places, axis=0)).max() < 0.03
    assert (travel.at(travel.ends)[1] == loads[1]).all()
    on_path = (np.abs(places[:, 1]) < 1e-12) | (np.abs(places[:, 0] - 1.0) < 1e-12)
    assert on_path.all()


def test_texts_from_files_are_escaped() -> None:
    subject = tracked()
    named = replace(subject, study=replace(subject.study, name="<script>alert(1)</script>"))
    assert "<script>" not in heading_html(named, ["<img src=x>"])
    assert "<img" not in heading_html(named, ["<img src=x>"])
    stop = subject.stops[0]
    readout = read_out(subject, stop.tool, stop.q, stop.wrench)
    bad = replace(readout, rooms=(Room("<i>", 1.0, "m"),), place="<u>")
    nothing = np.zeros(3)
    bad = replace(bad, bending=Bending(("<s>",), np.zeros((1, 3)), nothing, nothing))
    html = readout_html(bad, stop.wrench, 5.0)
    for tag in ("<i>", "<u>", "<s>"):
        assert tag not in html


def test_words_say_what_is_meant() -> None:
    assert worth_words(1.0003) == "as much as anywhere"
    assert worth_words(0.734) == "73 % of the best place"
    assert worth_words(0.0123) == "1.2 % of the best place"
    stop = kr270().stops[0]
    html = readout_html(read_out(kr270(), stop.tool, stop.q, stop.wrench), stop.wrench, 20.0)
    assert "2500 N [0.0, 0.0, −2500]" in html
    assert "shown 20×" in html
    assert "all hold" in html


def test_what_is_broken_comes_first_and_is_counted() -> None:
    stop = kr270().stops[0]
    q = np.array(stop.q)
    q[4] = 3.0  # A5 beyond its limit
    html = readout_html(read_out(kr270(), stop.tool, q, stop.wrench), stop.wrench, 20.0)
    rows = html.split("<tr data-state=")[1:]
    states = [row[1 : row.index("'", 1)] for row in rows]
    assert states.count("broken") >= 1
    assert states[: states.count("broken")] == ["broken"] * states.count("broken")
    assert f"{states.count('broken')} broken" in html
    assert "✕" in rows[0]
