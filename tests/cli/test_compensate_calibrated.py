"""`compensate` with a calibrated robot on the command line: where its tool comes to."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.arrays import Array
from elastocal.calibration.placed import carried_point
from elastocal.errors import PathFileError
from elastocal.files.tables.csv_table import read_table
from elastocal.robot.rotations import rotation_vectors
from tests.calibration.random_calibrated import TOOL
from tests.cli.test_commands import run
from tests.cli.test_export_calibrated import Case, case_of
from tests.compensation.test_calibrated import bent, flange
from tests.programs.writers.parsers import PARSERS

KR270 = ec.load_robot("kuka-kr270")
NAMES = KR270.joint_names
Q = np.radians([[0.0, -70.0, 80.0, 10.0, -30.0, 20.0], [5.0, -72.0, 82.0, 12.0, -32.0, 25.0]])


@pytest.fixture
def case(tmp_path: Path) -> Case:
    return case_of(None, tmp_path)


def joint_path(case: Case) -> Path:
    path = case.model.parent / "path.csv"
    rows = [",".join(f"{np.degrees(v):.12f}" for v in q) + ",100,0,-300" for q in Q]
    header = ",".join([*(f"{n} [deg]" for n in NAMES), "Fx [N]", "Fy [N]", "Fz [N]"])
    path.write_text("\n".join([header, *rows]) + "\n", "utf-8")
    return path


def compensate(case: Case, path: Path, *more: object) -> Path:
    out = path.parent / "corrected.csv"
    done = run("compensate", case.study, case.model, path, "-o", out, *more)
    assert done.exit_code == 0, done.stderr
    return out


def corrected(path: Path) -> Array:
    table = read_table(path, PathFileError)
    return np.radians(table.numbers(NAMES, {"deg": 1.0}))


def wanted(point: Array) -> Array:
    return np.array([(flange(KR270, q) @ [*point, 1.0])[:3] for q in Q])


def test_joint_values_are_those_of_the_drawing(case: Case) -> None:
    q = corrected(compensate(case, joint_path(case), "--payload", "gripper"))
    point = carried_point(case.calibrated).point
    wrench = np.array([100.0, 0.0, -300.0, 0.0, 0.0, 0.0])
    reached = np.array([(bent(case.calibrated, one, wrench, 0) @ [*point, 1.0])[:3] for one in q])
    # Seven decimals of a degree, 3 m away from the base.
    assert np.abs(reached - wanted(TOOL.tcp)).max() < 2e-8


def test_poses_in_the_frame_of_the_tracker(case: Case) -> None:
    """A reflector, without loads but weights: the station sees it where the path says."""
    base = case.calibrated.state.base[0]
    places = wanted(TOOL.markers[1]) @ base[:3, :3].T + base[:3, 3]
    turns = np.array([base[:3, :3] @ flange(KR270, q)[:3, :3] for q in Q])
    rows = np.hstack([1e3 * places, np.degrees(rotation_vectors(turns))])
    path = case.model.parent / "poses.csv"
    header = "x [mm],y [mm],z [mm],rx [deg],ry [deg],rz [deg]"
    text = "\n".join(",".join(f"{v:.12f}" for v in row) for row in rows)
    path.write_text(f"{header}\n{text}\n", "utf-8")
    start = " ".join(f"{n}={np.degrees(v):.3f}deg" for n, v in zip(NAMES, Q[0], strict=True))
    q = corrected(compensate(case, path, "--tracker", "--point", "R2", "--start", start))
    marker = case.calibrated.state.markers[0, 1]
    for one, place in zip(q, places, strict=True):
        T = base @ bent(case.calibrated, one, np.zeros(6), -1)
        assert (T @ [*marker, 1.0])[:3] == pytest.approx(place, abs=3e-8)


def test_what_is_said(case: Case) -> None:
    done = run("compensate", case.study, case.model, joint_path(case), "--json",
               "-o", case.model.parent / "c.csv")  # fmt: skip
    assert done.exit_code == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["rule"] == "calibrated"
    point = document["points"][0]
    assert np.linalg.norm(point["after_mm"]) < 1e-6
    assert point["expected_mm"] > point["rho0_mm"] > 0.0
    done = run("compensate", case.study, case.model, joint_path(case),
               "-o", case.model.parent / "c.csv")  # fmt: skip
    for words in ("2 of 2 points", "geometry and compliances of A1", "what was calibrated is"):
        assert words in " ".join(done.stdout.split())


def test_a_program_beside(case: Case) -> None:
    out = compensate(case, joint_path(case), "--to", "krl")
    files = {p.name: p.read_text() for p in out.parent.iterdir() if p.suffix in (".src", ".dat")}
    moves = [value for kind, value in PARSERS["krl"](files) if kind == "move"]
    assert np.array(moves)[-2:] == pytest.approx(np.degrees(corrected(out)), abs=1e-4)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--rule", "linear"], "--rule does not go with a calibrated robot"),
        (["--payload", "plate"], "no payload 'plate'; there are gripper, none"),
        (["--station", "far"], "no station 'far'"),
        (["--point", "R7"], "no reflector 'R7' was read"),
        (["--tracker"], "joint values are in no frame"),
    ],
)
def test_what_is_refused(case: Case, arguments: list[str], message: str) -> None:
    path = joint_path(case)
    done = run("compensate", case.study, case.model, path, "-o", path.parent / "c.csv", *arguments)
    assert done.exit_code == 2
    assert message in " ".join(done.stderr.split())
    assert not (path.parent / "c.csv").exists()


def test_options_of_calibrated_robots_are_theirs(tmp_path: Path) -> None:
    study = Path(ec.__file__).parents[2] / "examples" / "kr270"
    done = run("compensate", study / "study.yaml", study / "truth.json", study / "path.csv",
               "--point", "R1", "-o", tmp_path / "c.csv")  # fmt: skip
    assert done.exit_code == 2
    assert "--point is for calibrated robots" in " ".join(done.stderr.split())
