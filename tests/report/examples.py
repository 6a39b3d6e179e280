"""Plans and campaigns by hand, for the tests of the report; and pages as readers see them."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser

import numpy as np

from elastocal import report
from elastocal.compensation.compensate import Compensation, compensate, residual
from elastocal.constraints import Elevation, HalfSpace, MinRadius, Tilt
from elastocal.elastic.allowed_loads import FixedVector
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.identification.identify import identify
from elastocal.identification.result import Identification
from elastocal.identification.validation import Validation, validate
from elastocal.measuring.instrument import Isotropic
from elastocal.measuring.measurements import Measurements
from elastocal.planning.assessment import assess
from elastocal.planning.certificate import Certificate
from elastocal.planning.plan import Plan
from elastocal.planning.trade_off import TradeOff
from elastocal.report.contents import Contents
from elastocal.robot.chain import Joint, Robot, Tool, transform
from elastocal.robot.sources import kuka_kr270, three_link
from elastocal.simulation.campaigns import MonteCarlo
from elastocal.simulation.monte_carlo import campaigns
from elastocal.simulation.virtual_campaign import simulate
from elastocal.study.study import Experiments, Study, springs_of
from elastocal.study.study import test_pose as pose_of

HOSTILE = "</script><script>alert('x')</script><img src=x onerror=alert(1)>&\"'"


def make_plan(robot: Robot, tool: Tool, q: np.ndarray, force: tuple[float, ...], **changes) -> Plan:
    """A plan by hand: `q` (S, n) under one force, measured 1, 2, ... times, certified by hand."""
    springs = springs_of(robot, None if "springs" not in changes else changes.pop("springs"))
    cases = LoadCases(q, np.tile([*force, 0.0, 0.0, 0.0], (len(q), 1)))
    arm = ElasticArm(robot, springs, tool)
    task = pose_of(arm, LoadCases(q[:1], cases.wrench[:1]), 1.0, "milling")
    study = Study(
        robot,
        springs,
        (task,),
        Experiments(tool, FixedVector(np.array(force)), 6),
        Isotropic(3e-5),
        **{"name": "cell 7", "text": "elastocal: 1", **changes},
    )
    repeats = np.arange(1, len(q) + 1)
    assessment = assess(study, cases, repeats)
    certificate = Certificate(
        "test-pose",
        "numerical",
        0.9 * assessment.rho0,
        0.81,
        300,
        41,
        cases,
        np.full(len(q), 1.0 / len(q)),
        LoadCases(q[:1], cases.wrench[:1]),
        1.00002,
        rarest=9,
    )
    return Plan(cases, repeats, assessment, certificate, "test-pose", 5, study)


@cache
def three_link_plan() -> Plan:
    robot = three_link()
    q = np.array([[0.1, 0.4, 0.5], [1.2, -0.3, 0.9], [-0.8, 0.9, -1.1]])
    return make_plan(robot, robot.tools["tip"], q, (300.0, 200.0, -800.0))


@cache
def kuka_plan() -> Plan:
    robot = kuka_kr270()
    tool = robot.tools["calibration"]
    constraints = (
        HalfSpace("height of M1 >= 800 mm", tool.load_point, [0, 0, 1], 0.8),
        MinRadius("radius of M1 >= 600 mm", tool.load_point, 0.6),
        Elevation("elevation of z <= 30°", [0, 0, 1], np.radians(30)),
        Tilt("tilt of z <= 60°", [0, 0, 1], [0, 0, 1], np.radians(60)),
    )
    q = np.radians(
        [
            [0, -51, 63, -147, -102, -86],
            [20, -55, -72, 119, -57, 179],
            [-40, -2, -4, -122, -40, 11],
        ]
    )
    names = ["A2", "A3", "A4", "A5", "A6"]
    return make_plan(robot, tool, q, (0.0, 0.0, -2500.0), constraints=constraints, springs=names)


@cache
def gantry_plan() -> Plan:
    robot = Robot(
        "gantry",
        (
            Joint("X", transform(None, (0, 0, 1.5)), np.array([1, 0, 0]), True, 0.0, 2.0),
            Joint("Y", transform(None, (0, 0.2, 0)), np.array([0, 1, 0]), True, -0.5, 0.5),
            Joint("R", transform(None, (0, 0, 0.4)), np.array([0, 0, 1])),
        ),
        transform(None, (0.4, 0, 0)),
    )
    tool = Tool("probe", np.array([0.1, 0, 0]), np.array([[0.1, 0, 0], [0, 0.1, 0]]), ("M1", "M2"))
    q = np.array([[1.0, 0.1, 0.3], [0.4, -0.2, -1.0], [1.5, 0.3, 2.0]])
    return make_plan(robot, tool, q, (100.0, -50.0, 20.0))


PLANS = {"three-link": three_link_plan, "kuka-kr270": kuka_plan, "gantry": gantry_plan}


def trade_off_of(plan: Plan) -> TradeOff:
    rho0 = plan.assessment.rho0 * np.array([2.0, 1.4, 1.0, 0.7])
    return TradeOff(np.array([2, 3, 6, 12]), rho0, 0.95 * rho0, np.array([2, 3]), rho0[:2])


def without_plotly(page: str) -> str:
    """The page without the plotly library in it."""
    from plotly.offline import get_plotlyjs

    assert page.count(get_plotlyjs()) == 1
    return page.replace(get_plotlyjs(), "")


def visible(page: str) -> str:
    """The words a reader sees."""

    class Words(HTMLParser):
        def __init__(self) -> None:
            super().__init__()
            self.words: list[str] = []

        def handle_data(self, data: str) -> None:
            if self.cdata_elem is None:
                self.words.append(data)

    parser = Words()
    parser.feed(page)
    return re.sub(r"\s+", " ", " ".join(parser.words))


def truth_of(plan: Plan) -> ComplianceModel:
    """Compliances of the springs of a plan, of usual sizes."""
    springs = plan.study.springs
    sizes = np.where(springs.prismatic, 4e-8, 1.5e-6) * (1.0 + 0.3 * np.arange(len(springs)))
    return ComplianceModel(springs, sizes, source="made up")


@cache
def measured(name: str, repeats: int = 2, seed: int = 1) -> Measurements:
    """A simulated campaign of a plan: every load case `repeats` times."""
    plan = PLANS[name]()
    counts = np.full(len(plan.load_cases), repeats)
    rng = np.random.default_rng(seed)
    return simulate(plan.study, truth_of(plan), plan.load_cases, counts, rng)


@cache
def identified(name: str) -> Identification:
    """What that campaign says."""
    return identify(PLANS[name]().study.arm, measured(name))


@cache
def validated(name: str) -> Validation:
    """The model against a second campaign."""
    found = identified(name)
    return validate(PLANS[name]().study.arm, found.model, measured(name, 1, 2))


@cache
def compensated(name: str) -> Compensation:
    """A path of 30 points through the configurations of a plan, corrected."""
    plan = PLANS[name]()
    found = identified(name)
    way = np.linspace(0.0, 1.0, 30)[:, None]
    first, last = plan.load_cases.q[0], plan.load_cases.q[1]
    wrench = np.tile(plan.load_cases.wrench[0], (30, 1))
    task = plan.study.test_poses[0].tool
    assert task is not None
    arm = replace(plan.study.arm, tool=task)
    return compensate(arm, found.model, LoadCases(first + 0.2 * way * (last - first), wrench))


@cache
def judged(name: str, sign: float = 1.0) -> np.ndarray:
    """What remains if the robot is as the truth says; with -1 corrected to the wrong side."""
    done = compensated(name)
    wanted = done.cases.q
    driven = replace(done, q=wanted + sign * (done.q - wanted))
    return residual(done.arm, truth_of(PLANS[name]()), driven)


@cache
def simulated(name: str) -> MonteCarlo:
    """Virtual campaigns of a plan and of one with a third of its experiments."""
    plan = PLANS[name]()
    cases, repeats = plan.load_cases, 2 * plan.repeats
    plans = {"twice": (cases, repeats), "once": (cases, np.ones_like(repeats))}
    return campaigns(plan.study, truth_of(plan), plans, 200, seed=3)


@cache
def campaign_page(name: str) -> str:
    """The page of a campaign with all its stages."""
    plan = PLANS[name]()
    return report.html(
        Contents(
            plan,
            identification=identified(name),
            references={"made up": truth_of(plan)},
            validation=validated(name),
            compensation=compensated(name),
            judged=judged(name),
            control=judged(name, -1.0),
            monte_carlo=simulated(name),
        )
    )
