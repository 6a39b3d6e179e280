"""`check --measurements`: what was understood of a file, for people and for programs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from elastocal.errors import Doubt
from elastocal.files.measurements.mapping import read_mapping
from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.files.study.study_file import read_study
from elastocal.robot.sources import load
from tests.cli.test_commands import run
from tests.files.absolute_campaign import HEADER, rows, table, truth
from tests.files.campaign import STUDY_TEXT
from tests.files.measurements.test_bad_measurements import GOOD
from tests.test_examples import ROOT


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "study.yaml").write_text(STUDY_TEXT)
    (tmp_path / "m.csv").write_text(GOOD.replace(",-60,", ",-160,"))
    return tmp_path


def test_it_says_what_was_understood(folder: Path) -> None:
    shown = run("check", folder / "study.yaml", "--measurements", folder / "m.csv")
    assert shown.exit_code == 0
    text = " ".join(shown.output.split())
    for part in ("6 readings of 3 experiments", "M1 3×, M2 3×", "0 0 -2500", "3.625"):
        assert part in text
    assert "Note: experiment 1: A2 is beyond its limits" in text


def test_for_programs(folder: Path) -> None:
    shown = run("check", folder / "study.yaml", "--measurements", folder / "m.csv", "--json")
    found = json.loads(shown.output)
    assert (found["experiments"], found["readings"], found["own_uncertainty"]) == (3, 6, True)
    assert found["largest_deflection_mm"] == pytest.approx(3.6249, abs=1e-4)
    assert len(found["remarks"]) == 1


ABSOLUTE = """\
elastocal: 1
robot: kuka-kr270
identify: [base, tool, A2, A3]
tools:
  plate: {load_point_mm: [600, 0, -460], markers_mm: {M1: [600, 0, -460], M2: [500, 150, -300]}}
payloads: {plates: {mass_kg: 120, center_mm: [300, 0, 0]}}
instrument: {sigma_mm: 0.03}
"""


def test_absolute_readings(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text(ABSOLUTE)
    cells = [[*row, "A" if i < 12 else "B"] for i, row in enumerate(rows(truth(12)))]
    (tmp_path / "m.csv").write_text(table([*HEADER, "series"], cells))
    files = tmp_path / "study.yaml", "--measurements", tmp_path / "m.csv"
    shown = run("check", *files)
    assert shown.exit_code == 0, shown.output
    text = " ".join(shown.output.split())
    parts = ["24 readings of 12 poses", "M1 12×, M2 12×", "Stations: A, B", "nothing in 12 poses"]
    for part in [*parts, "from where the joint values put the arm as drawn"]:
        assert part in text, text
    found = json.loads(run("check", *files, "--json").output)
    assert (found["poses"], found["readings"], found["stations"]) == (12, 24, ["A", "B"])
    assert found["from_drawing_mm"] < 1e-3
    (tmp_path / "m.csv").write_text(table([*HEADER[:-1], "height"], rows(truth(12))))
    refused = run("check", *files)
    assert refused.exit_code == 2
    assert "column 'z [mm]' is missing" in refused.stderr


def test_bad_files_are_bad_input(folder: Path) -> None:
    (folder / "m.csv").write_text(GOOD.replace("Fz [N]", "Fz"))
    shown = run("check", folder / "study.yaml", "--measurements", folder / "m.csv")
    assert shown.exit_code == 2
    assert "m.csv, line 1: column 'Fz' has no unit" in shown.stderr
    assert run("check", folder / "study.yaml", "--mapping", "m.yaml").exit_code == 2


def test_the_example_of_a_mapping_fits_a_tracker_export(tmp_path: Path) -> None:
    example = ROOT / "examples" / "kr270" / "tracker_mapping.yaml"
    study = read_study(ROOT / "examples" / "kr270" / "study.yaml")
    assert read_mapping(example, load("kuka-kr270")).controller
    head = "X  [mm],Y  [mm],Z  [mm],U(95)  [mm],U(95) X  [mm],U(95) Y  [mm],U(95) Z  [mm],"
    tracker = (
        f"{head}Image RMS  [µm],Target,Time Stamp,Delete\n"
        "-2000.0,1000.0,1500.0,0.09,0.04,0.06,0.08,1.2,P1,'11.10.2022 15:06:48.043,\n"
        "-2000.2,1000.3,1497.0,0.09,0.04,0.06,0.08,1.2,P1,'11.10.2022 15:09:48.043,\n"
    )
    joints = (
        "Pose;Weight;A1;A2;A3;A4;A5;A6;Load\n"
        "1;off;0,0;-60,0;80,0;30,0;40,0;50,0;0\n"
        "1;on;0,0;-60,0;80,0;30,0;40,0;50,0;255\n"
    )
    (tmp_path / "tracker.csv").write_bytes(tracker.encode("cp1252"))
    (tmp_path / "joints.csv").write_text(joints)
    found = read_measurements([tmp_path / "tracker.csv", tmp_path / "joints.csv"], study, example)
    assert found.deflection[0] == pytest.approx([2e-4, -3e-4, -3e-3])
    assert found.cases.wrench[0, 2] == pytest.approx(-255 * 9.80665)
    assert found.remarks == ()
    left, rest = found.doubts
    assert left.code == "columns-not-used"
    assert "U(95) [mm]" in left.about
    assert rest == Doubt("unfinished", (), (), {"experiments": 1, "planned": 12})
