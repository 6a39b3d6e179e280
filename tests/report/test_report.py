"""The report: complete, self-contained, and safe against what users name things."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser

import numpy as np
import pytest

from elastocal import report
from elastocal.constraints import HalfSpace
from elastocal.drawing.skeleton import skeletons
from elastocal.drawing.svg import Scale
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.assessment import assess
from elastocal.planning.certificate import Certificate
from elastocal.report.contents import Contents
from elastocal.robot.chain import Robot
from elastocal.robot.posture import forward_kinematics
from elastocal.robot.sources import three_link
from elastocal.wording import worded
from elastocal.wording.numbers import direction, length, number, percent
from tests.report.examples import (
    HOSTILE,
    PLANS,
    kuka_plan,
    make_plan,
    three_link_plan,
    trade_off_of,
    visible,
    without_plotly,
)

SECTIONS = (
    "verdict",
    "robot",
    "worth",
    "effort",
    "errors",
    "blind",
    "certificate",
    "constraints",
    "criteria",
    "run-sheet",
    "provenance",
)


@cache
def page_of(name: str) -> str:
    plan = PLANS[name]()
    random = plan.assessment.rho0 * np.array([1.5, 2.0, 2.5, 3.0, np.inf])
    page = report.html(
        Contents(
            plan, trade_off=trade_off_of(plan), random=random, others={"last year": plan.assessment}
        )
    )
    return without_plotly(page)


@pytest.mark.parametrize("name", PLANS)
class TestEveryRobot:
    def test_all_sections_are_there(self, name: str) -> None:
        assert re.findall(r'<(?:section|header)[^>]* id="([\w-]+)"', page_of(name)) == [*SECTIONS]

    def test_nothing_is_fetched(self, name: str) -> None:
        page = page_of(name)
        assert not re.findall(r"""(?:src|href)\s*=\s*["']?\s*(?:https?:|//)""", page)
        assert not re.findall(r"@import|url\((?!#)", page)
        assert '<link rel="icon" href="data:,">' in page

    def test_elements_are_closed(self, name: str) -> None:
        open_elements: list[str] = []
        alone = {"meta", "link", "input", "img"}

        class Checker(HTMLParser):
            def handle_starttag(self, tag: str, attrs: object) -> None:
                if tag not in alone:
                    open_elements.append(tag)

            def handle_endtag(self, tag: str) -> None:
                assert open_elements.pop() == tag

        Checker().feed(page_of(name))
        assert open_elements == []

    def test_run_sheet_has_a_box_for_every_experiment(self, name: str) -> None:
        plan = PLANS[name]()
        sheet = page_of(name).split('id="run-sheet"')[1].split("</section>")[0]
        assert sheet.count('<input type="checkbox">') == plan.count
        assert sheet.count('<article class="run">') == len(plan.load_cases)

    def test_scene_shows_every_configuration(self, name: str) -> None:
        plan = PLANS[name]()
        data = re.search(r'id="robot-scene">(.*?)</script>', page_of(name), re.S)
        assert data is not None
        scene = json.loads(data.group(1))
        solid = {t["meta"]["group"] for t in scene["data"] if t["meta"]["role"] == "solid"}
        assert solid == set(range(len(plan.load_cases)))
        assert scene["count"] == len(plan.load_cases)
        assert scene["layout"]["scene"]["aspectmode"] == "data"

    def test_without_anything_to_compare_with(self, name: str) -> None:
        page = report.html(Contents(PLANS[name]()))
        assert 'id="effort"' not in page
        assert 'id="worth"' in page


def test_units_of_joints() -> None:
    page = visible(page_of("gantry"))
    assert "X [mm]" in page
    assert "1000.00" in page
    assert "R [°]" in page
    assert "17.189" in page
    assert "nm/N" in page
    assert "nrad/(N·m)" in page


def test_the_verdict_in_words() -> None:
    page = visible(page_of("kuka-kr270"))
    assert "6 experiments in 3 configurations" in page
    assert "300 distinct random starts" in page
    assert "41 of them reached the same maximum" in page
    assert "no better maximum is reached from more than 0.99 % of random starts" in page
    assert "tilt of z ≤ 60°" in page
    assert "straight down" in page


def test_constraints_are_drawn() -> None:
    data = re.search(r'id="robot-scene">(.*?)</script>', page_of("kuka-kr270"), re.S)
    assert data is not None
    roles = [t["meta"]["role"] for t in json.loads(data.group(1))["data"] if t["type"] == "mesh3d"]
    assert roles.count("limit") == 2  # plane and cylinder
    assert roles.count("limit-detail") == 6  # fan and cone at each of three configurations


def test_no_certificate_is_said() -> None:
    plan = three_link_plan()
    study = replace(plan.study, criterion="O2")
    plain = replace(plan, study=study, criterion="O2", certificate=Certificate("O2", "none"))
    page = visible(report.html(Contents(plain)))
    assert "Criterion O2 has no certificate" in page
    assert "Lower bound" not in page
    assert "Efficiency" not in page


def test_floor_is_said() -> None:
    plan = three_link_plan()
    floored = replace(plan, certificate=replace(plan.certificate, floored=True))
    page = visible(report.html(Contents(floored)))
    assert "A small floor keeps all of them identifiable. The bound itself is" in page


def test_bound_of_another_criterion_is_not_drawn_as_rho0() -> None:
    plan = three_link_plan()
    other = replace(plan.certificate, criterion="D", lower_bound=1e-8)
    page = visible(report.html(Contents(replace(plan, criterion="D", certificate=other))))
    assert "Lower bound" not in page
    assert "under criterion D" in page


def test_violations_are_shown() -> None:
    plan = kuka_plan()
    assert plan.assessment.violations
    page = visible(page_of("kuka-kr270"))
    assert "Do not run it" in page
    for sentence in map(worded, plan.assessment.violations):
        assert sentence.replace(">=", "≥").replace("<=", "≤") in page
    assert "Do not run it" not in visible(page_of("three-link"))


def test_unidentifiable_plan_is_reported() -> None:
    plan = three_link_plan()
    one = LoadCases(plan.load_cases.q[:1], plan.load_cases.wrench[:1])
    assessment = assess(plan.study, one, np.array([0]))
    poor = replace(plan, load_cases=one, repeats=np.array([0]), assessment=assessment)
    page = visible(
        report.html(Contents(poor, trade_off=trade_off_of(plan), random=np.array([np.inf])))
    )
    assert "do not tell all compliances apart" in page
    assert "ρ 0 is infinite" in page


def test_hostile_text_is_escaped() -> None:
    robot = three_link()
    joints = tuple(replace(joint, name=f"{HOSTILE}{i}") for i, joint in enumerate(robot.joints))
    tool = replace(robot.tools["tip"], name=HOSTILE, marker_names=(HOSTILE,))
    hostile = Robot(HOSTILE, joints, robot.T_tip_flange, {})
    plan = make_plan(
        hostile,
        tool,
        three_link_plan().load_cases.q,
        (0.0, 0.0, -100.0),
        constraints=(HalfSpace(HOSTILE, tool.load_point, [0, 0, 1], 0.9),),
        name=HOSTILE,
        text=HOSTILE,
    )
    posed = replace(plan.study.test_poses[0], name=HOSTILE)
    study = replace(plan.study, test_poses=(posed, replace(posed, case=None)))
    plan = replace(plan, study=study, assessment=assess(study, plan.load_cases, plan.repeats))
    page = without_plotly(report.html(Contents(plan, others={HOSTILE: plan.assessment})))
    assert page.count("<script") == page.count("</script>") == 3
    assert "<img" not in page
    assert page.count("alert(&#39;x&#39;)") > 8


def test_same_plan_same_report() -> None:
    assert report.html(Contents(three_link_plan())) == report.html(Contents(three_link_plan()))


def test_skeleton_ends_where_kinematics_says() -> None:
    plan = kuka_plan()
    robot, tool, q = plan.study.robot, plan.study.experiments.tool, plan.load_cases.q
    flange = forward_kinematics(robot, q)
    for i, skeleton in enumerate(skeletons(robot, tool, q)):
        assert np.allclose(skeleton.arm[-1], flange[i, :3, 3], atol=1e-9)
        load_point = flange[i] @ np.append(tool.load_point, 1.0)
        assert np.allclose(skeleton.tool[0][-1], load_point[:3], atol=1e-9)


@pytest.mark.parametrize(
    ("value", "shown"),
    [(2.7954e-6, "2.80 µm"), (9.996e-4, "1000 µm"), (0.00123, "1.23 mm"), (np.inf, "∞")],
)
def test_lengths(value: float, shown: str) -> None:
    assert length(value) == shown


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"),
        (-1234.5, "−1230"),
        (0.00239, "0.00239"),
        (9.999, "10.0"),
        (2.5e-9, "2.50×10⁻⁹"),
        (np.nan, "–"),
        (3.21e12, "3.21×10¹²"),
    ],
)
def test_numbers(value: float, shown: str) -> None:
    assert number(value) == shown


def test_efficiency_keeps_its_distance_from_one() -> None:
    assert percent(0.9999999) == "> 99.99 %"
    assert percent(0.9899) == "99.0 %"
    assert percent(0.81) == "81 %"
    assert percent(float("nan")) == "–"


def test_directions() -> None:
    assert direction(np.array([0.0, 0.0, -5.0])) == "straight down"
    assert direction(np.array([0.0, 3.0, 0.0])) == "along +y"
    assert direction(np.array([1.0, 1.0, 0.0])) == ""


@pytest.mark.parametrize(("low", "high"), [(2.5, 12.0), (1.0, 1e5), (3.0, 3.4), (0.8, 1.3)])
def test_log_ticks_lie_on_the_axis(low: float, high: float) -> None:
    ticks = Scale(low, high, 0.0, 100.0, log=True).ticks()
    assert 2 <= len(ticks) <= 9
    assert all(low * 0.999 <= tick <= high * 1.001 for tick in ticks)
