"""Measuring in the test poses: the baseline of section 5 of the paper."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import elastocal as ec
from elastocal.cli import app
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection
from elastocal.errors import InputError
from elastocal.study.study import Study
from elastocal.study.test_path import test_path as path_of
from tests.paper.problems import three_link_study

EXAMPLES = Path(__file__).parents[2] / "examples"
THREE_LINK = EXAMPLES / "three-link"


@pytest.mark.parametrize("m", [1, 2, 4, 12])
def test_it_has_one_unknown_s_error_for_each(m: int) -> None:
    """ρ0² = 3 σ²/m: where the task is calibrated with its own load every unknown costs σ²."""
    study = ec.read_study(THREE_LINK / "study.yaml")
    cases, repeats = ec.in_test_poses(study, m)
    worth = ec.assess(study, cases, repeats)
    assert not worth.violations
    assert (worth.rho0 / study.sigma) ** 2 == pytest.approx(3.0 / m, rel=1e-5)
    assert repeats.tolist() == [m]


def test_a_free_load_has_the_direction_of_the_task_and_the_size_of_the_study() -> None:
    study = three_link_study(4)
    pose = study.test_poses[0]
    assert pose.cases is not None
    big = replace(study.experiments, force=FreeDirection(7.0, np.array([0.0, 0.0, 1.0])))
    cases, _ = ec.in_test_poses(replace(study, experiments=big), 4)
    force = pose.cases.wrench[0, :3]
    np.testing.assert_allclose(cases.wrench[0, :3], 7.0 * force / np.linalg.norm(force))
    np.testing.assert_array_equal(cases.q, pose.cases.q)
    assert not cases.wrench[0, 3:].any()
    fixed = replace(study.experiments, force=FixedVector([1.0, 2.0, 3.0]), moment=big.force)
    cases, _ = ec.in_test_poses(replace(study, experiments=fixed), 4)
    assert cases.wrench[0].tolist() == [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]


def with_path(points: int, weight: float = 1.0) -> Study:
    study = three_link_study(4)
    q = np.linspace([0.0, 0.1, 0.2], [0.9, 1.0, 1.1], points)
    wrench = np.tile([0.0, 0.0, -1.0, 0.0, 0.0, 0.0], (points, 1))
    path = path_of(study.arm, ec.LoadCases(q, wrench), weight, "seam")
    return replace(study, test_poses=(*study.test_poses, path))


@pytest.mark.parametrize(
    ("points", "count", "taken", "repeats"),
    [
        (2, 3, [0, 1, 2], [1, 1, 1]),
        (2, 8, [0, 1, 2], [3, 3, 2]),
        (100, 4, [0, 33, 67, 100], [1, 1, 1, 1]),
    ],
)
def test_experiments_are_spread_over_poses_and_paths(
    points: int, count: int, taken: list[int], repeats: list[int]
) -> None:
    study = with_path(points)
    q = np.concatenate([place.cases.q for place in study.test_poses if place.cases is not None])
    cases, times = ec.in_test_poses(study, count)
    np.testing.assert_array_equal(cases.q, q[taken])
    assert times.tolist() == repeats


def test_what_is_only_judged_is_not_measured() -> None:
    cases, repeats = ec.in_test_poses(with_path(9, weight=0.0), 4)
    assert (len(cases), repeats.tolist()) == (1, [4])


def test_a_matrix_is_no_place_to_measure_in() -> None:
    study = three_link_study(4)
    matrix = replace(study.test_poses[0], case=None)
    with pytest.raises(InputError, match="'task' is given as a matrix: it has no config"):
        ec.in_test_poses(replace(study, test_poses=(matrix,)), 4)


def evaluated(*words: str | Path, code: int = 0) -> str:
    result = CliRunner().invoke(app, ["evaluate", *map(str, words), "--random", "0"])
    assert result.exit_code == code, result.output
    return " ".join(result.stdout.split()) if code == 0 else result.stderr


def test_evaluate_says_how_much_better_a_plan_is() -> None:
    """The factor of two of section 5, in ρ0², of the published plans."""
    plans = [THREE_LINK / "published" / f"opt{m}.csv" for m in (1, 4)]
    said = evaluated(THREE_LINK / "study.yaml", *plans, "--at-test-poses")
    assert "opt1.csv: ρ0 1.25× smaller than in the test poses, worth 1.56× as many" in said
    assert "opt4.csv: ρ0 1.39× smaller than in the test poses, worth 1.93× as many" in said
    assert re.search(r"in the test poses, m = 4 .*86\.6 µm.*60\.73 µm.*0\.4918.*holds", said)
    assert "test poses" not in evaluated(THREE_LINK / "study.yaml", *plans)


def test_a_baseline_that_is_not_allowed_is_said_and_refuses_no_plan(tmp_path: Path) -> None:
    text = (THREE_LINK / "study.yaml").read_text("utf-8")
    study = tmp_path / "study.yaml"
    study.write_text(
        text.replace("{collision", "{workspace: {min_radius_mm: 1800}, collision"), "utf-8"
    )
    plan = THREE_LINK / "published" / "opt1.csv"
    found = json.loads(evaluated(study, plan, "--at-test-poses", "--json"))
    baseline = found["in the test poses"]
    assert not baseline["accepted"]
    assert [doubt["code"] for doubt in baseline["doubts"]] == ["constraint-broken"]
    assert found["opt1.csv"]["accepted"]


def test_one_configuration_does_not_show_five_compliances() -> None:
    study = ec.read_study(EXAMPLES / "kr270" / "published" / "study.yaml")
    worth = ec.assess(study, *ec.in_test_poses(study, 12))
    assert not worth.identifiable
    assert worth.rho0 == np.inf
    assert [doubt.code for doubt in worth.violations] == ["constraint-broken"]
    published = EXAMPLES / "kr270" / "published"
    refused = evaluated(
        published / "study_table_7.yaml", published / "m3.csv", "--at-test-poses", code=2
    )
    assert "'milling' is given as a matrix" in refused
