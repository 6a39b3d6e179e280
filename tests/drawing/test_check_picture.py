"""The picture of `check`: every joint with its direction, nothing hostile, nothing outside."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from typer.testing import CliRunner

from elastocal.cli import app
from elastocal.drawing.check_picture import check_page, check_picture
from elastocal.drawing.joint_glyphs import glyphs
from elastocal.drawing.projection import Projection
from elastocal.drawing.silhouette import hull, solid_points
from elastocal.files.study.study_file import parse_study, read_study
from elastocal.robot.posture import Posture
from elastocal.robot.shapes import Shape
from elastocal.robot.sources import three_link
from tests.robot.sources.oracle import ROOT

EXAMPLES = sorted((ROOT / "examples" / "robots").glob("*/study.yaml"))
KR270 = ROOT / "examples" / "robots" / "kr270" / "study.yaml"


def words(picture: str, class_: str) -> list[str]:
    root = ET.fromstring(picture)
    return [e.text or "" for e in root.iter() if e.get("class") == class_]


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_every_joint_is_named_in_every_pose(path: Path) -> None:
    study = read_study(path)
    picture = check_picture(study)
    poses = 1 + len(study.test_poses)
    for name in study.robot.joint_names:
        assert words(picture, "joint-name").count(f"{name} +") == poses
    assert picture.count('class="turn-head"') == poses * len(study.robot.joints)
    assert picture.count('class="solid"') == poses * len(study.robot.visuals)
    assert len(words(picture, "force-name")) == len(study.test_poses)
    assert "nan" not in picture


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_words_stay_in_the_picture(path: Path) -> None:
    root = ET.fromstring(check_picture(read_study(path)))
    width = float(root.get("width", "0"))
    for element in root.iter("{http://www.w3.org/2000/svg}text"):
        wide, x = 7.4 * len(element.text or ""), float(element.get("x", "nan"))
        share = {"middle": 0.5, "end": 1.0}.get(element.get("text-anchor", ""), 0.0)
        assert x - share * wide > -10.0
        if element.get("class") not in ("note", "heading"):
            assert x + (1.0 - share) * wide < width


@pytest.mark.parametrize("seed", range(10))
def test_arrows_follow_the_right_hand_rule(seed: int) -> None:
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(2, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    view = Projection(rng.normal(size=(9, 3)), 600.0)
    turn, slide = glyphs(("J1", "J2"), np.zeros((2, 3)), axes, np.array([False, True]), 0.1, view)
    arms = turn.arrow - turn.centre
    assert np.linalg.norm(arms, axis=1) == pytest.approx(np.full(len(arms), 0.1))
    assert np.cross(arms[:-1], arms[1:]) @ axes[0] == pytest.approx(
        np.full(len(arms) - 1, 0.01 * np.sin(np.radians(290.0) / (len(arms) - 1)))
    )
    way = slide.arrow[-1] - slide.arrow[0]
    assert way / np.linalg.norm(way) == pytest.approx(axes[1])


def test_glyphs_of_joints_at_one_point_are_apart() -> None:
    view = Projection(np.array([[-1.0, -1, 0], [1, 1, 2]]), 600.0)
    marks = glyphs(("a", "b", "c"), np.zeros((3, 3)), np.eye(3), np.zeros(3, bool), 0.1, view)
    seen = view(np.array([mark.centre for mark in marks]))
    for i in range(3):
        for j in range(i):
            assert np.linalg.norm(seen[i] - seen[j]) > 0.1 * view.scale


def test_the_hull_is_the_convex_hull() -> None:
    points = np.random.default_rng(0).uniform(0, 500, (200, 2))
    corners = hull(points)
    x, y = corners.T
    area = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    assert area == pytest.approx(ConvexHull(points).volume, rel=1e-3)
    assert len(hull(np.zeros((5, 2)))) == 1


@pytest.mark.parametrize(
    ("kind", "size", "extent"),
    [
        ("box", [1, 2, 3], [1, 2, 3]),
        ("cylinder", [0.5, 2], [1, 1, 2]),
        ("sphere", [0.5], [1, 1, 1]),
        ("capsule", [0.5, 2], [1, 1, 3]),
    ],
)
def test_solids_have_their_size(kind: str, size: list[float], extent: list[float]) -> None:
    shape = Shape(kind, np.array(size), np.eye(4), 0)
    points = solid_points(shape, Posture(three_link(), np.zeros((1, 3))), 0)
    assert np.ptp(points, axis=0) == pytest.approx(extent, rel=0.02)


def test_hostile_names_are_shown_as_they_are() -> None:
    text = KR270.read_text().replace("name: milling", "name: '<script>alert(1)</script>'")
    study = parse_study(text, KR270)
    for drawn in (check_picture(study), check_page(study)):
        assert "<script>" not in drawn
    assert words(check_picture(study), "title")[1] == "Test pose <script>alert(1)</script>"


def test_the_controller_has_its_column() -> None:
    text = KR270.read_text().replace("check_poses", "controller: {signs: {A1: -1}}\ncheck_poses")
    picture = check_picture(parse_study(text, KR270))
    assert words(picture, "head") == ["joint", "model", "controller"] * 2
    assert "The controller counts A1 the other way." in picture


def test_check_writes_the_picture_and_refuses_other_names(tmp_path: Path) -> None:
    runner = CliRunner()
    for name in ("a.svg", "a.html"):
        done = runner.invoke(app, ["check", str(KR270), "--picture", str(tmp_path / name)])
        assert done.exit_code == 0, done.output
        assert "A1 +" in (tmp_path / name).read_text("utf-8")
    for wrong in (str(tmp_path / "a.png"), str(KR270), str(tmp_path / "none" / "a.svg")):
        done = runner.invoke(app, ["check", str(KR270), "--picture", wrong])
        assert done.exit_code == 2
