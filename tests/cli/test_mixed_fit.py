"""The commands with nuisance in the study: mixed fit, the joints alone, the file between them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from elastocal.cli import app
from elastocal.errors import IdentifiabilityError, ModelFileError
from elastocal.files.measurements.measurement_file import read_measurements, write_measurements
from elastocal.files.models.model_file import read_model
from elastocal.files.models.writing import write_model
from elastocal.files.study.study_file import read_study
from elastocal.identification.doubts import doubts
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.report import html
from elastocal.report.contents import Contents
from elastocal.wording import worded
from tests.campaigns import FREE_FORCES, NAMES, arm, measured, sideways

STUDY = FREE_FORCES + "nuisance: typical\n"
EVERY = ("A1", *NAMES)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Study, readings and a model identified from them."""
    made = tmp_path_factory.mktemp("mixed")
    (made / "study.yaml").write_text(STUDY)
    truth = np.array([0.623, 0.302, 0.406, 3.002, 3.303, 2.365]) * 1e-6
    data = measured(arm(EVERY), sideways(24), truth, rng=np.random.default_rng(1))
    write_measurements(data, read_study(made / "study.yaml").robot, made / "readings.csv")
    result = run(made, "identify", "study.yaml", "readings.csv", "-o", "model.json")
    assert "fitted along" in result
    assert "known together" in result
    return made


def run(folder: Path, command: str, *words: str) -> str:
    files = [str(folder / word) if "." in word else word for word in words]
    result = CliRunner().invoke(app, [command, *files])
    assert result.exit_code == 0, result.output
    return " ".join(result.output.split())


def test_the_model_has_the_springs_that_were_fitted_along(folder: Path) -> None:
    document = json.loads((folder / "model.json").read_text())
    assert "tool sliding x" in {entry["name"] for entry in document["identification"]["nuisance"]}
    assert set(document["springs"]) < set(document["compliance"])
    alone = document["identification"]["joints_alone"]["compliance"]
    assert list(alone) == list(EVERY)
    error = {name: document["compliance"][name]["standard_error"] for name in EVERY}
    less = document["identification"]["joints_alone"]["standard_error"]
    assert all(error[name] > less[name] for name in EVERY)


def test_validation_finds_the_same_model(folder: Path) -> None:
    said = run(folder, "validate", "study.yaml", "model.json", "readings.csv")
    assert "left out in turn" in said


def test_the_report_shows_what_was_fitted_along(folder: Path) -> None:
    study = read_study(folder / "study.yaml")
    data = read_measurements(folder / "readings.csv", study)
    found = identify(study.arm, data, nuisance=study.nuisance)
    page = html(Contents(identification=found))
    assert 'id="nuisance"' in page
    assert "tool sliding x" in page
    assert "With the joints alone" in page


def test_the_joints_alone_stay_by_their_name(folder: Path) -> None:
    said = run(folder, "identify", "study.yaml", "readings.csv", "--fit", "joints",
               "-o", "joints.json")  # fmt: skip
    assert "fitted along" not in said
    whole = json.loads((folder / "model.json").read_text())
    alone = json.loads((folder / "joints.json").read_text())
    assert alone["identification"]["fitted"] == "joints"
    for name, value in whole["identification"]["joints_alone"]["compliance"].items():
        assert alone["compliance"][name]["value"] == pytest.approx(value, rel=1e-12)
    run(folder, "validate", "study.yaml", "joints.json", "readings.csv")


def test_an_edited_interval_of_a_mixed_fit_is_refused(folder: Path) -> None:
    document = json.loads((folder / "model.json").read_text())
    document["identification"]["interval"]["A2"][1] *= 0.5
    (folder / "edited.json").write_text(json.dumps(document))
    robot = read_study(folder / "study.yaml").robot
    read_model(folder / "model.json", robot)
    with pytest.raises(ModelFileError, match="A2"):
        read_model(folder / "edited.json", robot)


def test_the_model_is_known_to_a_second_campaign(folder: Path) -> None:
    """Springs made of fewer unknowns are known with their tie, and are no nuisance any more."""
    second = STUDY.replace("[A1, A2, A3, A4, A5, A6]", "[A1]").replace(
        "max_force_N: 2500, direction: free, count: 24",
        "force_N: [0, 1000, 0], count: 4, max_configurations: 2",
    )
    (folder / "second.yaml").write_text(second)
    first = json.loads((folder / "model.json").read_text())
    unit = "rad/(N·m)"
    truth = {name: {"value": 1e-6 * (i + 1), "unit": unit} for i, name in enumerate(EVERY)}
    (folder / "truth.json").write_text(json.dumps({"compliance": truth}))
    known = "--known", "model.json"
    run(folder, "plan", "second.yaml", *known, "--seconds", "2", "-o", "plan.json")
    run(folder, "simulate", "second.yaml", "plan.json", "--truth", "truth.json", "-o", "side.csv")
    told = run(folder, "identify", "second.yaml", "side.csv", *known, "-o", "both.json")
    assert "load gain" in told
    assert "fitted along: A2, A3, A4, A5, A6, 20 springs besides" in told
    assert "told apart by no more than joint values" not in told
    assert "Left out one after the other with their repeats, experiments" in told
    assert "with the joints alone to" in told
    whole = json.loads((folder / "both.json").read_text())
    both = whole["diagnostics"], whole["identification"]["joints_alone"]
    assert [one["left_out"]["of"] for one in both] == ["load-cases", "load-cases"]
    found = whole["compliance"]
    assert set(found) == set(first["compliance"])
    tied = [found[f"tilt A5 about {axis}"]["value"] for axis in "xy"]
    assert tied[0] == pytest.approx(tied[1], rel=0.02, abs=1e-9)
    run(folder, "validate", "second.yaml", "both.json", "side.csv", *known)


def test_errors_of_load_cases_alone(folder: Path, tmp_path: Path) -> None:
    """A nuisance without springs has nothing to fit along, and weighs the readings all the same."""
    bare = STUDY.replace("nuisance: typical", "nuisance: {friction: .08}")
    (folder / "bare.yaml").write_text(bare)
    told = run(folder, "identify", "bare.yaml", "readings.csv", "-o", str(tmp_path / "model.json"))
    assert "fitted along" not in told
    study = read_study(folder / "bare.yaml")
    data = read_measurements(folder / "readings.csv", study)
    found = identify(study.arm, data, nuisance=study.nuisance)
    assert found.nuisance is not None
    assert found.alone is not None
    assert (found.standard_error > found.alone.standard_error).all()
    assert "Left out, predicted" in html(Contents(identification=found))


def test_what_is_judged_by_the_joints_alone_says_so(folder: Path) -> None:
    """A sign that the mixed fit does not show is no riddle, nor a σ that is not found."""
    study = read_study(folder / "study.yaml")
    data = read_measurements(folder / "readings.csv", study)
    wrong = replace(data, deflection=-data.deflection)
    found = identify(study.arm, wrong, nuisance=study.nuisance)
    (doubt,) = (d for d in doubts(found) if d.code == "all-negative")
    assert worded(doubt).startswith("with the joints alone, all compliances are negative")
    with pytest.raises(IdentifiabilityError, match="show the noise nowhere by itself"):
        identify(study.arm, data, Fit(sigma="estimated"), nuisance=study.nuisance)


def test_a_coupling_below_zero_is_no_arm_that_moves_against_the_load(
    folder: Path, tmp_path: Path
) -> None:
    """Springs of a tensor may be negative: the model is a truth, and corrects the right way."""
    robot = read_study(folder / "study.yaml").robot
    model = read_model(folder / "model.json", robot)
    names = model.names
    compliance = np.abs(model.compliance)
    compliance[[names.index(f"tilt A2 about {end}") for end in ("x", "y", "between")]] = (
        np.array([0.3, 0.2, -0.1]) * 1e-6
    )
    write_model(replace(model, compliance=compliance), tmp_path / "truth.json", robot)
    truth, out = str(tmp_path / "truth.json"), str(tmp_path / "out.csv")
    run(folder, "plan", "study.yaml", "--seconds", "1", "-o", "whole.json")
    run(folder, "simulate", "study.yaml", "whole.json", "--truth", truth, "-o", out)


def test_a_pose_probe_with_errors_of_load_cases_has_one_noise(folder: Path, tmp_path: Path) -> None:
    """No noise of positions and of rotations can be told apart there, and none is not a number."""
    probe = "{measures: pose, sigma_mm: 0.03, sigma_mrad: 0.05}"
    study = STUDY.replace("{sigma_mm: 0.03}", probe)
    study = study.replace("count: 24", "count: 12, max_configurations: 3")
    (folder / "pose.yaml").write_text(study)
    truth = {name: {"value": 1e-6, "unit": "rad/(N·m)"} for name in EVERY}
    (tmp_path / "truth.json").write_text(json.dumps({"compliance": truth}))
    run(folder, "plan", "pose.yaml", "--seconds", "1", "-o", "pose.json")
    made = "--truth", str(tmp_path / "truth.json"), "-o", "rotations.csv"
    run(folder, "simulate", "pose.yaml", "pose.json", *made)
    told = run(folder, "identify", "pose.yaml", "rotations.csv", "-o", str(tmp_path / "model.json"))
    assert "nan" not in told
    posed = read_study(folder / "pose.yaml")
    data = read_measurements(folder / "rotations.csv", posed)
    found = identify(posed.arm, data, nuisance=posed.nuisance)
    assert [noise.scale for noise in found.noise_of_kinds] == [found.scale] * 2
