"""Made-up campaigns for tests: load cases, deflections from an independent route, noise."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.deflections import loaded_deflection
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import deflection
from elastocal.elastic.springs import joint_springs
from elastocal.measuring.measurements import Measurements
from elastocal.robot.chain import Tool
from elastocal.robot.sources import kuka_kr270

NAMES = ("A2", "A3", "A4", "A5", "A6")
TRUTH = np.array([0.302, 0.406, 3.002, 3.303, 2.365]) * 1e-6
SIGMA = 3e-5
FIRST_STEP = """\
elastocal: 1
robot: three-link
identify: [J2, J3]
test_poses:
  - {name: task, tool: tip, q_deg: [0, 60, -45], force_N: [0, 290, -960]}
experiments: {tool: tip, force_N: [0, 0, -1000], count: 4}
instrument: {sigma_mm: 0.1}
constraints: {collision: off, floor: off}
"""
"""A study of the three-link arm that leaves J1 to a second campaign."""
FREE_FORCES = """\
elastocal: 1
robot: kuka-kr270
identify: [A1, A2, A3, A4, A5, A6]
tools:
  milling: {tcp_mm: [986, 0, 0]}
  calibration: {load_point_mm: [611.5, 0, -460], markers_mm: {M1: [611.5, 0, -460]}}
test_poses:
  - {name: milling, tool: milling, q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2], force_N: [0, 280, -180]}
experiments: {tool: calibration, max_force_N: 2500, direction: free, count: 24}
instrument: {sigma_mm: 0.03}
"""
"""A study of the KR 270 pulled in any direction: what `sideways` loads."""
MARKERS = Tool(
    "cross",
    np.array([0.6115, 0.0, -0.46]),
    np.array([[0.6115, 0.0, -0.46], [0.2, 0.3, 0.1], [0.2, -0.3, 0.1]]),
    ("M1", "M2", "M3"),
)


def arm(names: tuple[str, ...] = NAMES, tool: Tool | None = None) -> ElasticArm:
    """The KR 270 with springs in the joints called `names`."""
    robot = kuka_kr270()
    return ElasticArm(robot, joint_springs(robot, names), tool or robot.tools["calibration"])


def hung(count: int, seed: int = 0, force: float = 2500.0, repeats: int = 1) -> LoadCases:
    """Random configurations within the joint limits with a weight hung from the load point."""
    rng = np.random.default_rng(seed)
    robot = kuka_kr270()
    q = np.repeat(rng.uniform(robot.lower, robot.upper, (count, 6)), repeats, axis=0)
    wrench = np.tile([0.0, 0.0, -force, 0.0, 0.0, 0.0], (len(q), 1))
    return LoadCases(q, wrench)


def sideways(count: int, seed: int = 0) -> LoadCases:
    """Forces in all directions, which A1 feels as well."""
    rng = np.random.default_rng(seed + 100)
    cases = hung(count, seed)
    force = rng.normal(size=(count, 3))
    force *= 2000.0 / np.linalg.norm(force, axis=1)[:, None]
    return LoadCases(cases.q, np.hstack([force, np.zeros((count, 3))]))


def measured(
    bent: ElasticArm,
    cases: LoadCases,
    truth: Array = TRUTH,
    *,
    rng: np.random.Generator | None = None,
    linear: bool = False,
    promised: float = SIGMA,
    noise: float = SIGMA,
) -> Measurements:
    """Every marker once in every load case; without noise if there is no `rng`."""
    count, markers = len(cases), len(bent.tool.markers)
    if linear:
        exact = deflection(bent, truth, cases)[:, :-3]
    else:
        exact = loaded_deflection(bent, truth, cases)
    values = exact.reshape(-1, 3)
    if rng is not None:
        values = values + noise * rng.normal(size=values.shape)
    return Measurements(
        tool=bent.tool,
        cases=cases,
        names=tuple(f"E{i + 1}" for i in range(count)),
        case=np.repeat(np.arange(count), markers),
        marker=np.tile(np.arange(markers), count),
        deflection=values,
        covariance=np.tile(promised**2 * np.eye(3), (len(values), 1, 1)),
        source="test",
    )
