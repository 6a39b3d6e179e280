"""A plan in a cell: every pose and motion checked again by Pinocchio and coal; a moved obstacle."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path

import coal
import numpy as np
import pytest

from elastocal.design.exact import Effort
from elastocal.errors import InfeasibleError
from elastocal.files.plans.plan_file import write_plan, write_run_sheet
from elastocal.files.plans.proposal_file import read_proposal
from elastocal.files.study.study_file import parse_study, read_study
from elastocal.motion.margins import legs_of, motion_violations
from elastocal.motion.via_points import UnreachableError
from elastocal.motion.within_reach import out_of_reach
from elastocal.planning import plan as planning
from elastocal.planning.plan import Plan, plan
from elastocal.planning.study_check import check
from elastocal.robot.chain import transform
from tests.cli.test_bad_studies import GOOD, run
from tests.constraints.collision.oracle import CellOracle

BOXES = {
    "table": (np.array([1.2, 1.6, 0.7]), transform(None, (1.7, 0.0, 0.35))),
    "wall": (np.array([5.0, 0.1, 3.0]), transform(None, (0.0, 1.2, 1.5))),
    "screen": (np.array([1.8, 0.1, 2.4]), transform(None, (1.6, -0.9, 1.2))),
}
CELL = (
    GOOD.replace("count: 12", "count: 12\n  max_configurations: 3").replace(": off", ": {}", 1)
    + """\
  obstacles:
    - {name: table, box_mm: [1200, 1600, 700], center_mm: [1700, 0, 350]}
    - {name: wall, box_mm: [5000, 100, 3000], center_mm: [0, 1200, 1500]}
    - {name: screen, box_mm: [1800, 100, 2400], center_mm: [1600, -900, 1200]}
motion: {home_deg: [0, -120, 120, 0, 0, 0]}
"""
)


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> tuple[Path, Plan]:
    folder = tmp_path_factory.mktemp("cell")
    (folder / "study.yaml").write_text(CELL, encoding="utf-8")
    found = plan(read_study(folder / "study.yaml"), seed=2, effort=Effort(24, 2, 1, 1))
    write_plan(found, folder / "plan.json")
    write_run_sheet(found, folder / "plan.csv")
    return folder, found


def test_no_pose_and_no_motion_collides(made: tuple[Path, Plan]) -> None:
    found = made[1]
    study = found.study
    oracle = CellOracle(study.robot, study.experiments.tool, BOXES, 0.02)
    left = {frozenset((x.first, x.second)) for c in study.constraints[-1:] for x in c.unwatched}
    left |= {frozenset(p) for p in (("A4", "A6"), ("A5", "A6"), ("A6", "tool"))}

    def room(q: np.ndarray) -> float:
        return min(oracle.itself(q, left), *(oracle.obstacle(q, name) for name in BOXES))

    for q in found.load_cases.q:
        assert room(q) > 0.02 - 1e-5
    via = found.via or ((),) * (len(found.load_cases) + 1)
    stops = [study.pace.home]
    for i, between in enumerate(via):
        stops += [*between, study.pace.home if i == len(via) - 1 else found.load_cases.q[i]]
    for a, b in pairwise(stops):
        for share in np.linspace(0.0, 1.0, 120):
            assert room(a + share * (b - a)) > 0.0099
    inside = (stops >= study.limits[0] - 1e-9) & (stops <= study.limits[1] + 1e-9)
    assert inside.all()


def test_via_points_are_needed_here_and_survive_the_files(made: tuple[Path, Plan]) -> None:
    folder, found = made
    assert sum(map(len, found.via)) > 0, "the cell needs no way around: choose another one"
    for name, tolerance in (("plan.json", 1e-12), ("plan.csv", 1e-6)):
        read = read_proposal(folder / name, found.study)
        assert [len(points) for points in read.via] == [len(points) for points in found.via]
        for ours, theirs in zip(found.via, read.via, strict=True):
            assert theirs == pytest.approx(ours, abs=tolerance)


def test_the_plan_holds(made: tuple[Path, Plan]) -> None:
    folder, _ = made
    both = ("evaluate", folder / "study.yaml", folder / "plan.json", folder / "plan.csv")
    assert run(*both, "--random", "0") == (0, "")


def judged(folder: Path, text: str) -> tuple[int, str]:
    moved = folder / "moved.yaml"
    moved.write_text(text, encoding="utf-8")
    code, said = run("evaluate", moved, folder / "plan.json", "--random", "0")
    return code, said.splitlines()[-1]


def test_an_obstacle_moved_into_a_pose_is_refused(made: tuple[Path, Plan]) -> None:
    folder, found = made
    tip = CellOracle(found.study.robot, found.study.experiments.tool, BOXES, 0.02).capsules(
        found.load_cases.q[1]
    )[-1][2]
    at = ", ".join(f"{1e3 * v:.0f}" for v in tip)
    extra = f"    - {{name: ladder, sphere_radius_mm: 60, center_mm: [{at}]}}\nmotion:"
    code, said = judged(folder, CELL.replace("motion:", extra))
    assert code == 3, said
    assert "load case 2 breaks clearance of tool from ladder >= 20 mm by" in said


def test_an_obstacle_moved_into_a_motion_is_refused(made: tuple[Path, Plan]) -> None:
    folder, found = made
    oracle = CellOracle(found.study.robot, found.study.experiments.tool, BOXES, 0.02)
    stops = [found.study.pace.home, *found.load_cases.q]

    def room(q: np.ndarray, ball: np.ndarray) -> float:
        oracle.boxes["ball"] = (coal.Sphere(0.05), transform(None, ball))
        return oracle.obstacle(q, "ball")

    legs = legs_of(found.study.pace.home, found.load_cases.q, found.via)
    middles = [0.5 * (a + b) for leg in legs for a, b in pairwise(leg)]
    tips = [oracle.capsules(q)[-1][2] for q in middles]
    tip = next(p for p in tips if min(room(q, p) for q in stops) > 0.1)
    at = ", ".join(f"{1e3 * v:.0f}" for v in tip)
    extra = f"    - {{name: ball, sphere_radius_mm: 50, center_mm: [{at}]}}\nmotion:"
    code, said = judged(folder, CELL.replace("motion:", extra))
    assert code == 3, said
    assert re.search(r"the motion from .* hits ball with \w+ by \d+ mm at \d+ %", said)


def test_a_plan_without_its_ways_around_is_refused(made: tuple[Path, Plan]) -> None:
    folder, _ = made
    document = json.loads((folder / "plan.json").read_text())
    del document["via"]
    (folder / "straight.json").write_text(json.dumps(document))
    code, said = run("export", folder / "straight.json", "--to", "krl", "--out", folder / "a.src")
    assert code == 3, said
    assert "the motion from" in said


BROKEN = [
    ([{"to": 9, "q_deg": {}}], "'to' must be home or a load case from 1 to 3, found 9"),
    ([{"to": True, "q_deg": {}}], "'to' must be"),
    ([{"to": 1, "q_deg": {"A1": 0}}], "via 1: joint 'A2' has no value"),
    ([{"to": 1, "q_deg": {"A1": float("nan")}}], "finite"),
    ([{"to": 1, "q_deg": 5}], "by joint name"),
    ([5], "expected a section"),
    ("no", "must be a list"),
]


@pytest.mark.parametrize(("via", "expected"), BROKEN)
def test_broken_via_points_get_a_sentence(
    via: object, expected: str, made: tuple[Path, Plan]
) -> None:
    folder, _ = made
    document = json.loads((folder / "plan.json").read_text())
    document["via"] = via
    (folder / "broken.json").write_text(json.dumps(document))
    code, said = run("evaluate", folder / "study.yaml", folder / "broken.json")
    assert code == 2
    assert expected in said
    assert said.count("\n") == 1


def test_what_cannot_be_reached_is_planned_around(monkeypatch) -> None:
    """The first plan's second configuration is said to be out of reach: the next keeps away."""
    study = parse_study(GOOD.replace("count: 12", "count: 12\n  max_configurations: 2"), Path("s"))
    asked: list[np.ndarray] = []

    def blocked_once(_, q: np.ndarray, *, seed: int) -> tuple[np.ndarray, ...]:
        asked.append(q)
        if len(asked) == 1:
            raise UnreachableError("blocked", q[1])
        return ()

    monkeypatch.setattr(planning, "detours", blocked_once)
    found = plan(study, effort=Effort(24, 2, 1, 1))
    away = found.load_cases.q - asked[0][1]
    away -= 2.0 * np.pi * np.round(away / (2.0 * np.pi))
    counts = np.array([name not in found.free_joints for name in study.robot.joint_names])
    assert np.linalg.norm(away * counts, axis=1).min() > 0.5 - 1e-6
    assert 0.5 < found.certificate.efficiency <= 1.0


def test_a_plan_out_of_reach_is_refused(monkeypatch) -> None:
    study = parse_study(GOOD.replace("count: 12", "count: 12\n  max_configurations: 2"), Path("s"))

    def blocked(_, q: np.ndarray, *, seed: int) -> tuple[np.ndarray, ...]:
        raise UnreachableError("the motion hits the wall", q[0])

    monkeypatch.setattr(planning, "detours", blocked)
    monkeypatch.setattr(planning, "AGAIN", 1)
    told: list[str] = []
    with pytest.raises(InfeasibleError, match="hits the wall"):
        plan(study, effort=Effort(24, 2, 1, 1), progress=lambda what, _: told.append(what))
    assert any("search 2 of at most 2 for want of ways" in what for what in told)
    assert told[-1] == "ways between configurations"


def test_ranges_beyond_a_closed_value_are_not_planned_in() -> None:
    """Walls at both sides, outward from near the axis of A1: A1 cannot turn past them."""
    walls = "\n".join(
        f"    - {{name: W{y}, box_mm: [100, 4000, 9000], center_mm: [0, {y}, 0]}}"
        for y in (-2450, 2450)
    )
    text = CELL[: CELL.index("  obstacles:")] + f"  obstacles:\n{walls}\n"
    text += "motion: {home_deg: [0, -120, 120, 0, 0, 0]}\n"
    study = parse_study(text, Path("study.yaml"))
    (doubt,) = out_of_reach(study.motion_space)
    assert doubt.about == ("A1",)
    assert np.degrees(list(doubt.numbers.values())) == pytest.approx([-90.0, 90.0], abs=5.0)
    found = plan(study, effort=Effort(24, 2, 1, 1))
    a1 = found.load_cases.q[:, 0]
    assert (a1 >= doubt.numbers["lower"]).all()
    assert (a1 <= doubt.numbers["upper"]).all()
    assert doubt in found.doubts
    assert doubt in check(study).doubts
    assert motion_violations(study.motion_space, found.load_cases.q, found.via) == ()


def test_a_box_around_home_is_named() -> None:
    walls = "\n".join(
        f"    - {{name: {n}, box_mm: [{s}], center_mm: [{c}]}}"
        for n, s, c in (
            ("front", "100, 9000, 9000", "900, 0, 0"),
            ("back", "100, 9000, 9000", "-1200, 0, 0"),
        )
    )
    text = CELL[: CELL.index("  obstacles:")] + f"  obstacles:\n{walls}\n"
    text += "motion: {home_deg: [0, -120, 120, 0, 0, 0]}\n"
    with pytest.raises(InfeasibleError, match=r"front|back"):
        plan(parse_study(text, Path("study.yaml")), effort=Effort(24, 2, 1, 1))
