"""`evaluate` of what was measured, and what goes on from there: the campaign as a plan."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.cli.inputs import joint_values
from elastocal.elastic.load_cases import LoadCases
from elastocal.files.measurements.measurement_file import write_measurements
from elastocal.measuring.measurements import Measurements
from elastocal.planning.as_measured import as_measured
from tests.campaigns import measured
from tests.cli.test_commands import run

STUDY = """\
elastocal: 1
robot: three-link
identify: [J2, J3]
test_poses:
  - {tool: tip, q_deg: [0, 60, -45], force_N: [0, 290, -960]}
experiments: {tool: tip, force_N: [0, 0, -1000], count: 6, max_configurations: 2}
instrument: {sigma_mm: 0.1}
constraints: {joint_limits_deg: {J2: [-90, 60]}}
"""
ANGLES = np.radians([[0.0, 55.0, -50.0], [0.0, 10.0, 80.0]])
REPEATS = [2, 4]
COMPLIANCE = np.array([1e-5, 2e-5])


def campaign(force: float = 1000.0, scatter: float = 0.0, angles: np.ndarray = ANGLES) -> LoadCases:
    """Six experiments in two configurations, as a controller and a sensor show them."""
    rng = np.random.default_rng(0)
    q = np.repeat(angles, REPEATS, axis=0)
    wrench = np.tile([0.0, 0.0, -force, 0.0, 0.0, 0.0], (6, 1))
    return LoadCases(
        q + scatter * np.radians(rng.uniform(-0.008, 0.008, q.shape)),
        wrench * (1.0 + scatter * rng.uniform(-0.004, 0.004, (6, 1))),
    )


def write(folder: Path, cases: LoadCases, name: str = "m.csv") -> Measurements:
    study = ec.read_study(folder / "study.yaml")
    data = measured(study.arm, cases, COMPLIANCE, linear=True)
    write_measurements(data, study.robot, folder / name)
    return data


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "study.yaml").write_text(STUDY)
    rows = [
        f"{','.join(f'{v:.6f}' for v in np.degrees(q))},0,0,-1000,{count}"
        for q, count in zip(ANGLES, REPEATS, strict=True)
    ]
    (tmp_path / "plan.csv").write_text(
        "\n".join(["J1 [deg],J2 [deg],J3 [deg],Fx [N],Fy [N],Fz [N],repeats", *rows]) + "\n"
    )
    return tmp_path


def judged(folder: Path, *files: str, code: int = 0) -> dict[str, dict[str, object]]:
    shown = run("evaluate", folder / "study.yaml", *files, "--random", "0", "--json")
    assert shown.exit_code == code, shown.output
    return json.loads(shown.stdout)


def test_what_was_measured_is_judged_as_the_plan_it_was(folder: Path) -> None:
    write(folder, campaign())
    both = judged(folder, str(folder / "plan.csv"), str(folder / "m.csv"))
    plan, done = both["plan.csv"], both["m.csv"]
    assert (plan.pop("measured"), done.pop("measured")) == (False, True)
    assert done["configurations"] == 2
    assert done["experiments"] == 6
    assert done["remarks"] == []
    for key in ("rho0_mm", "efficiency", "standard_error"):
        np.testing.assert_allclose(done[key], plan[key], rtol=1e-6)


def test_what_instruments_scatter_makes_no_other_load_case(folder: Path) -> None:
    write(folder, campaign(scatter=1.0))
    done = judged(folder, str(folder / "m.csv"))["m.csv"]
    assert (done["configurations"], done["experiments"], done["remarks"]) == (2, 6, [])
    assert done["efficiency"] > 0.2


def test_experiments_of_one_load_case_are_told_by_name(folder: Path) -> None:
    study = ec.read_study(folder / "study.yaml")
    cases = campaign()
    q = np.array(cases.q)
    q[1, 0] += 2.0 * np.pi  # the same place a turn further
    wrench = np.array(cases.wrench)
    wrench[2] *= 1.02
    data = measured(study.arm, LoadCases(q, wrench), COMPLIANCE, linear=True)
    done = as_measured(data, study.robot)
    assert done.names == (("E1", "E2"), ("E3",), ("E4", "E5", "E6"))
    np.testing.assert_array_equal(done.repeats, [2, 1, 3])
    np.testing.assert_array_equal(done.cases.q, q[[0, 2, 3]])


def test_what_it_breaks_is_said_and_refused_no_more(folder: Path) -> None:
    lifted = ANGLES + np.radians([[0.0, 10.0, 0.0], [0.0, 0.0, 0.0]])
    write(folder, campaign(1100.0, angles=lifted))
    done = judged(folder, str(folder / "m.csv"))["m.csv"]
    assert done["accepted"]
    assert done["remarks"] == [
        "experiments E1, E2: outside J2 <= 60° by 5°",
        "experiments E1, E2, E3, E4, E5 and 1 more: outside the load of the study by 100 N",
    ]
    shown = run("evaluate", folder / "study.yaml", folder / "m.csv", "--random", "0")
    text = " ".join(shown.stdout.split())
    assert shown.exit_code == 0
    assert "m.csv: a measurement file, whose configurations and loads are judged" in text
    assert "measured" in text
    assert "outside J2 <= 60° by 5°" in text


def test_a_campaign_that_tells_nothing_apart_is_refused(folder: Path) -> None:
    straight = np.radians([[0.0, 50.0, 0.0], [0.0, 50.0, 0.0]])
    write(folder, campaign(angles=straight))
    shown = run("evaluate", folder / "study.yaml", folder / "m.csv", "--random", "0")
    assert shown.exit_code == 4
    assert "m.csv" in shown.stderr


MAPPING = """\
elastocal: 1
columns: {"J1 [deg]": a1, "J2 [deg]": a2, "J3 [deg]": a3, "dx [mm]": x, "dy [mm]": y, "dz [mm]": z}
constants: {"Fx [N]": 0, "Fy [N]": 0, "Fz [N]": -1000}
"""


def foreign(folder: Path) -> None:
    """The same campaign in two foreign files, matched row by row."""
    data = write(folder, campaign(), "own.csv")
    joints, points = ["a1;a2;a3"], ["x;y;z"]
    for q, shift in zip(np.degrees(data.cases.q), 1e3 * data.deflection, strict=True):
        joints.append(";".join(f"{v:.6f}" for v in q).replace(".", ","))
        points.append(";".join(f"{v:.6f}" for v in shift).replace(".", ","))
    (folder / "joints.txt").write_text("sep=;\n" + "\n".join(joints) + "\n")
    (folder / "points.txt").write_text("sep=;\n" + "\n".join(points) + "\n")
    (folder / "mapping.yaml").write_text(MAPPING)


def test_foreign_files_are_judged_through_their_mapping(folder: Path) -> None:
    foreign(folder)
    files = [str(folder / name) for name in ("plan.csv", "joints.txt", "points.txt")]
    both = judged(folder, *files, "--mapping", str(folder / "mapping.yaml"))
    done = both["joints.txt, points.txt"]
    assert done["measured"]
    np.testing.assert_allclose(done["rho0_mm"], both["plan.csv"]["rho0_mm"], rtol=1e-4)


def test_the_rest_of_a_foreign_campaign_is_planned_through_its_mapping(folder: Path) -> None:
    foreign(folder)
    files = ["--after", folder / "joints.txt", "--after", folder / "points.txt"]
    out = folder / "rest.json"
    command = ["plan", folder / "study.yaml", *files, "--mapping", folder / "mapping.yaml"]
    shown = run(*command, "--count", "8", "-o", out)
    assert shown.exit_code == 0, shown.output
    document = json.loads(out.read_text("utf-8"))
    assert document["after"]["experiments"] == 6
    assert document["experiments"] == 2  # eight in all
    few = run(*command, "--count", "6", "-o", out)
    assert few.exit_code == 2
    assert "has 6 experiments, and 6 are wanted in all" in few.stderr
    over = run(*command, "--count", "8", "-o", folder / "mapping.yaml")
    assert over.exit_code == 2


# command line behind the study; what must be in the sentence
BAD = {
    "a mapping for plans": (("plan.csv", "--mapping", "mapping.yaml"), "these files are plans"),
    "both": (("both.csv",), "both.csv, line 1: column 'repeats' is that of a plan and column 'dx'"),
    "neither": (("neither.csv",), "neither.csv, line 1: neither a plan, which has a column"),
    "nothing": (("nothing.csv",), "nothing.csv: the file is empty"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_neither_or_both_gets_one_sentence(name: str, folder: Path) -> None:
    arguments, expected = BAD[name]
    plan = (folder / "plan.csv").read_text().splitlines()
    foreign(folder)
    (folder / "both.csv").write_text("\n".join([f"{plan[0]},dx [mm]", f"{plan[1]},1"]) + "\n")
    (folder / "neither.csv").write_text("a,b\n1,2\n")
    (folder / "nothing.csv").write_text("")
    there = [a if a.startswith("--") else str(folder / a) for a in arguments]
    shown = run("evaluate", folder / "study.yaml", *there, "--random", "0")
    assert shown.exit_code == 2
    assert expected in shown.stderr
    assert shown.stderr.count("\n") == 1


def test_a_mapping_without_what_it_maps_is_refused(folder: Path) -> None:
    shown = run("plan", folder / "study.yaml", "--mapping", folder / "m.yaml")
    assert shown.exit_code == 2
    assert "--mapping belongs to --after" in shown.stderr


def test_a_start_may_have_a_degree_sign(folder: Path) -> None:
    robot = ec.read_study(folder / "study.yaml").robot
    there = joint_values("J1=10° J2=-20deg, J3=3e1°", robot, "start")
    np.testing.assert_allclose(np.degrees(there), [10, -20, 30])
