"""Bad obstacles and meshes: each gets one sentence that names the line, and exit code 2 or 3."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from elastocal.cli import app
from elastocal.errors import Doubt
from elastocal.files.study.study_file import read_study
from elastocal.planning.study_check import HEAD
from elastocal.planning.study_check import check as checkup
from tests.cli.test_bad_studies import GOOD, TRACKER, run

TABLE = "{name: table, box_mm: [1200, 1600, 700], center_mm: [1700, 0, 350]}"
MESH = "{name: cage, mesh: cage.stl, mesh_unit: mm, center_mm: [3000, 0, 0]}"
HOME = "motion: {home_deg: [0, -90, 90, 0, 0, 0]}\n"
CELL = GOOD.replace("  collision: off\n  floor: off\n", "")
CELL += f"  obstacles:\n    - {TABLE}\n    - {MESH}\n  collision: {{margin_mm: 20}}\n{HOME}"

# what is edited: (old, new); what must be in the sentence; exit code
CASES: dict[str, tuple[str, str, list[str], int]] = {
    "no shape": (
        "box_mm: [1200, 1600, 700], ", "", ["line 18", "exactly one of box_mm", "none"], 2),
    "two shapes": (
        "name: table,", "name: table, sphere_radius_mm: 5,",
        ["line 18", "box_mm and sphere_radius_mm"], 2),
    "no place": (", center_mm: [1700, 0, 350]", "", ["line 18", "'center_mm' is missing"], 2),
    "no name": ("name: table, ", "", ["line 18", "'name' is missing"], 2),
    "no unit": ("box_mm", "box", ["line 18", "no unit", "'box_mm'"], 2),
    "place without unit": ("center_mm: [1700", "center: [1700", ["'center_mm'"], 2),
    "flat box": ("1600, 700]", "1600, 0]", ["line 18", "three sides", "positive"], 2),
    "two sides": ("1600, 700]", "1600]", ["line 18", "three numbers"], 2),
    "cylinder without length": (
        "box_mm: [1200, 1600, 700]", "cylinder_mm: {radius: 5}", ["line 18", "'length'"], 2),
    "negative radius": (
        "box_mm: [1200, 1600, 700]", "sphere_radius_mm: -5", ["line 18", "positive"], 2),
    "same name": ("name: cage", "name: table", ["line 18", "two obstacles", "'table'"], 2),
    "name of a joint": ("name: table", "name: A3", ["line 18", "part of the robot"], 2),
    "obstacles as a section": (f"    - {TABLE}\n    - {MESH}\n", "    a: 1\n", ["a list"], 2),
    "mesh without unit": ("mesh_unit: mm, ", "", ["line 19", "mesh_unit"], 2),
    "unit of no mesh": ("[1700, 0, 350]", "[1700, 0, 350], mesh_unit: mm", ["line 18", "mesh"], 2),
    "unit said twice": ("cage.stl", "cage.dae", ["line 19", "says its unit itself"], 2),
    "unknown unit": ("mesh_unit: mm", "mesh_unit: cm", ["line 19", "'mm', 'm' or 'inch'"], 2),
    "mesh elsewhere": ("cage.stl", "../cage.stl", ["line 19", "outside the folder"], 2),
    "mesh at the root": ("cage.stl", "/etc/passwd", ["line 19", "outside the folder"], 2),
    "mesh that is not there": ("cage.stl", "coop.stl", ["line 19", "coop.stl: no such"], 2),
    "mesh format": ("cage.stl", "cage.step", ["line 19", "'.step'", "name cage.stl instead"], 2),
    "mesh in metres": ("mesh_unit: mm", "mesh_unit: m", ["line 19", "in millimetres"], 2),
    "negative margin": ("margin_mm: 20", "margin_mm: -1", ["line 20", "not be negative"], 2),
    "motions keep as much": (
        "{margin", "{motion_margin_mm: 20, margin", ["line 20", "at least 2 mm less"], 2),
    "no margin at all": ("margin_mm: 20", "margin_mm: 0", ["line 20", "at least 2 mm less"], 2),
    "margin without unit": ("margin_mm: 20", "margin: 20", ["'margin_mm'"], 2),
    "unknown in ignore": ("{margin", "{ignore: [[A1, A9]], margin", ["line 20", "'A9'"], 2),
    "three in ignore": ("{margin", "{ignore: [[A1, A2, A3]], margin", ["line 20", "two names"], 2),
    "radius of no joint": (
        "{margin", "{link_radius_mm: {A9: 5}, margin", ["line 20", "no joint 'A9'"], 2),
    "obstacle everywhere": (
        "box_mm: [1200, 1600, 700]", "box_mm: [9000, 9000, 9000]",
        ["no feasible configuration", "from table >= 20 mm"], 3),
    "empty name": ("name: table", "name: ''", ["line 18", "expected a name"], 2),
    "quoted flag": ("{margin", "{self: 'no', margin", ["line 20", "true or false"], 2),
    "nul in a name": ("cage.stl", '"ca\\0ge.stl"', ["line 19", "U+0000, at place 3"], 2),
}  # fmt: skip


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    trimesh.creation.box((1000.0, 1000.0, 2000.0)).export(tmp_path / "cage.stl")
    (tmp_path / "cage.step").write_text("ISO-10303-21;")
    return tmp_path


def check(folder: Path, text: str) -> tuple[int, str]:
    study = folder / "study.yaml"
    study.write_text(text, encoding="utf-8")
    code, said = run("check", study)
    assert said.count("\n") == (1 if code else 0), said
    return code, said


@pytest.mark.parametrize("name", CASES)
def test_bad_cell_gets_one_sentence(name: str, folder: Path) -> None:
    old, new, expected, code = CASES[name]
    assert CELL.count(old) >= 1, "the case edits nothing"
    found, said = check(folder, CELL.replace(old, new, 1))
    assert found == code, said
    for words in expected:
        assert words in said, said


def test_the_good_cell_is_good(folder: Path) -> None:
    assert check(folder, CELL) == (0, "")


def stl(*triangles: tuple[float, ...]) -> bytes:
    """A binary STL of triangles of nine numbers."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *t, 0) for t in triangles)
    return bytes(80) + struct.pack("<I", len(triangles)) + body


FINE = (0.0, 0.0, 0.0, 900.0, 0.0, 0.0, 0.0, 900.0, 900.0)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "no triangles"),
        (b"solid nothing\nendsolid nothing\n", "stl"),
        (bytes(200), "no triangles"),
        (stl(FINE)[:100], "no triangles"),
        (bytes(80) + struct.pack("<I", 4_000_000_000) + bytes(50), "no triangles"),
        (stl(FINE, (float("nan"),) * 9), "not finite"),
        (stl((1e30, 0.0, 0.0, 0.0, 1e30, 0.0, 0.0, 0.0, 1e30)), "across"),
        (stl((0.1, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1)), "in metres"),
        (b"#" * (33 * 1024 * 1024), "more than"),
        (b"\xff\xfe garbage" * 20, "stl"),
    ],
)
def test_hostile_meshes_are_refused(content: bytes, expected: str, folder: Path) -> None:
    (folder / "cage.stl").write_bytes(content)
    code, said = check(folder, CELL)
    assert code == 2, said
    assert "line 19" in said
    assert "cage.stl" in said
    assert expected in said


def test_a_mesh_does_not_open_other_files(folder: Path) -> None:
    secret = folder / "secret.mtl"
    secret.write_text("newmtl a\nmap_Kd /etc/passwd\n")
    box = "mtllib secret.mtl\n" + trimesh.creation.box((900.0, 900.0, 900.0)).export(
        file_type="obj"
    )
    (folder / "cage.obj").write_text(box)
    assert check(folder, CELL.replace("cage.stl", "cage.obj"))[0] == 0


def test_a_sheet_without_thickness_is_an_obstacle(folder: Path) -> None:
    (folder / "cage.stl").write_bytes(stl((*FINE[:6], 0.0, 900.0, 0.0)))
    assert check(folder, CELL)[0] == 0


def test_a_link_out_of_the_folder_is_refused(folder: Path, tmp_path_factory) -> None:
    elsewhere = tmp_path_factory.mktemp("elsewhere") / "cage.stl"
    (folder / "cage.stl").rename(elsewhere)
    (folder / "cage.stl").symlink_to(elsewhere)
    code, said = check(folder, CELL)
    assert (code, "outside the folder" in said) == (2, True)


def test_home_in_an_obstacle_is_said_before_planning(folder: Path) -> None:
    block = "{name: block, box_mm: [400, 400, 400], center_mm: [1500, 0, 1900]}"
    code, said = check(folder, CELL.replace(TABLE, block))
    assert code == 3
    assert "home is no place to start from: the robot hits block" in said


@pytest.mark.parametrize(
    ("old", "new", "doubt"),
    [
        (
            TABLE,
            "{name: step, box_mm: [1.2, 1.6, 0.7], center_mm: [3000, 0, 0]}",
            Doubt("small-obstacle", ("step",), (), {"size": 0.0016}),
        ),
        (
            "{margin",
            "{link_radius_mm: 0.12, margin",
            Doubt("thin-links", (), (), {"radius": pytest.approx(0.00012)}),
        ),
        (
            "{sigma_mm: 0.03}",
            TRACKER.replace("900]", "900], range_mm: [0.8, 8]"),
            Doubt("short-range", ("range of M1 <= 8 mm",), (), {"bound": 0.008}),
        ),
        (
            "{sigma_mm: 0.03}",
            TRACKER.replace("3000, 0, 900", "3, 0, 0.9"),
            Doubt("near-tracker", (), (), {"distance": pytest.approx(np.hypot(3e-3, 0.9e-3))}),
        ),
    ],
)
def test_metres_under_a_key_in_millimetres_are_remarked(
    old: str, new: str, doubt: Doubt, folder: Path
) -> None:
    assert old in CELL
    study = folder / "study.yaml"
    study.write_text(CELL.replace(old, new), encoding="utf-8")
    study = read_study(study)
    # With links as thin as needles the forearm cannot pass the elbow, nor touch it at all times.
    aside = ("no-task", "taken-as-rigid", "rigid-at-test-pose", "out-of-reach")
    doubts = [found for found in checkup(study).doubts if found.code not in aside]
    assert doubts == [doubt]


def test_what_the_head_stands_in_is_said(folder: Path) -> None:
    study = folder / "study.yaml"
    inside = TRACKER.replace("3000, 0, 900", "1700, 0, 350")
    study.write_text(CELL.replace("{sigma_mm: 0.03}", inside), encoding="utf-8")
    said = checkup(read_study(study)).unwatched
    assert Doubt("not-watched", ("beam to M1–table",), (HEAD,)) in said


def test_a_remark_that_asks_ends_with_its_question_mark(folder: Path) -> None:
    study = folder / "study.yaml"
    thin = CELL.replace("{margin", "{self: false, link_radius_mm: 0.12, margin")
    study.write_text(thin, encoding="utf-8")
    shown = " ".join(CliRunner().invoke(app, ["check", str(study)]).stdout.split())
    assert "were metres meant?" in shown
    assert "meant?." not in shown
