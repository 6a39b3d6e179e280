"""Obstacles in the report: drawn where they are, of the size they have; via points on the sheet."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from elastocal.constraints import Clearance
from elastocal.constraints.cell import CollisionRules, clearances
from elastocal.drawing.obstacles import solid_of
from elastocal.report import html
from elastocal.report.contents import Contents
from elastocal.report.planned_stage import planned_stage
from elastocal.report.scene import scene
from elastocal.robot.chain import transform
from elastocal.robot.shapes import Shape
from tests.arms import random_rotation
from tests.report.examples import kuka_plan, visible

SHAPES = {
    "box": [1.0, 0.6, 0.4],
    "cylinder": [0.3, 1.2],
    "capsule": [0.3, 1.2],
    "sphere": [0.5],
    "mesh": [1e-3, 1e-3, 1e-3],
}
VOLUMES = {
    "box": 0.24,
    "cylinder": np.pi * 0.09 * 1.2,
    "capsule": np.pi * 0.09 * 1.2 + 4.0 / 3.0 * np.pi * 0.027,
    "sphere": 4.0 / 3.0 * np.pi * 0.125,
    "mesh": 0.12,
}


@pytest.fixture
def mesh(tmp_path: Path) -> Path:
    trimesh.creation.box((400.0, 500.0, 600.0)).export(tmp_path / "box.stl")
    return tmp_path / "box.stl"


@pytest.mark.parametrize("kind", SHAPES)
def test_what_is_drawn_has_place_and_size_of_the_obstacle(kind: str, mesh: Path) -> None:
    pose = transform(random_rotation(np.random.default_rng(0)), (1.0, -2.0, 0.5))
    solid, lines = solid_of(Shape(kind, np.array(SHAPES[kind]), pose, 0, kind, mesh))
    hull = trimesh.Trimesh(solid.vertices, solid.triangles).convex_hull
    assert hull.volume == pytest.approx(VOLUMES[kind], rel=0.1)
    assert hull.centroid == pytest.approx([1.0, -2.0, 0.5], abs=0.02)
    for line in lines:
        assert trimesh.proximity.signed_distance(hull, line).min() > -0.03


def plan_in_a_cell(mesh: Path):
    plan = kuka_plan()
    study = plan.study
    shapes = [
        Shape("box", np.array([0.4, 0.4, 0.4]), transform(None, (-1.5, 0, 0.2)), 0, "crate <b>"),
        Shape("mesh", np.full(3, 1e-3), transform(None, (-1.5, 2.0, 0.3)), 0, "drum", mesh),
    ]
    found = clearances(study.robot, study.experiments.tool, study.limits, shapes, CollisionRules())
    study = replace(study, constraints=(*study.constraints, *found))
    via = [np.zeros((0, 6)) for _ in range(len(plan.load_cases) + 1)]
    via[1], via[-1] = np.radians([[10.0, -90.0, 80.0, 0, 0, 5.0]]), np.radians([[33.0] + [0.0] * 5])
    return replace(plan, study=study, via=tuple(via))


def test_obstacles_are_in_the_scene_with_their_names(mesh: Path) -> None:
    plan = plan_in_a_cell(mesh)
    drawn = scene(plan, planned_stage(plan))
    texts = [text for trace in drawn["data"] for text in trace.get("text", [])]
    assert "crate ‹b›" in texts
    assert "drum" in texts
    assert planned_stage(plan).lower[0] <= -1.7
    assert any(isinstance(c, Clearance) and c.obstacle is None for c in plan.study.constraints)


def test_via_points_are_on_the_run_sheet(mesh: Path) -> None:
    words = " ".join(visible(html(Contents(plan_in_a_cell(mesh)))).split())
    assert "On the way there pass, without stopping: A1 10" in words
    assert "On the way home pass, without stopping: A1 33" in words
    assert "without stopping" not in visible(html(Contents(kuka_plan())))
