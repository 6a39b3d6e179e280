"""A campaign of poses on the command line: planned for, simulated, identified, validated, shown."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from elastocal.files.study.study_file import read_study
from elastocal.identification.identify import identify
from elastocal.identification.validation import leave_one_out
from elastocal.report import html
from elastocal.report.contents import Contents
from elastocal.simulation.virtual_campaign import simulate
from tests.cli.test_commands import run
from tests.kr270 import FOLDER, kr270_truth, published_cases

PLAN = FOLDER / "published" / "m4-times-3.csv"
TRUTH = FOLDER / "truth.json"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of poses, two campaigns and a model of the first."""
    at = tmp_path_factory.mktemp("poses")
    text = (FOLDER / "study.yaml").read_text()
    probe = "instrument: {measures: pose, sigma_mm: 0.03, sigma_mrad: 0.05}\n"
    (at / "study.yaml").write_text(re.sub(r"instrument:.*\n", probe, text))
    for name, seed in (("m.csv", 1), ("v.csv", 2)):
        made = run(
            "simulate", at / "study.yaml", PLAN, "--truth", TRUTH, "-o", at / name, "--seed", seed
        )
        assert made.exit_code == 0, made.stderr
        assert "24 readings" in made.stdout
        assert "rotations up to 7." in made.stdout
    found = run(
        "identify", at / "study.yaml", at / "m.csv", "-o", at / "model.json", "--known", TRUTH
    )
    assert found.exit_code == 0, found.stderr
    assert "of the rotations root mean square" in " ".join(found.stdout.split())
    assert re.search(r"of positions, \S+ of rotations", " ".join(found.stdout.split()))
    return at


def test_check_says_what_is_measured(folder: Path) -> None:
    words = " ".join(run("check", folder / "study.yaml").stdout.split())
    assert "measured: M1 611.5 0 -460 mm, and the rotation of the flange" in words
    assert "σ = 0.03 mm per coordinate; rotation σ = 0.05 mrad per axis" in words


def test_check_says_what_was_read(folder: Path) -> None:
    args = ("check", folder / "study.yaml", "--measurements", folder / "m.csv")
    words = " ".join(run(*args).stdout.split())
    assert "M1 12×, rotation 12×" in words
    assert "0.03 … 0.03 mm and 0.05 … 0.05 mrad" in words
    assert "rotation mrad" in words
    told = json.loads(run(*args, "--json").stdout)
    assert told["largest_deflection_mm"] == pytest.approx(9.78, abs=0.05)
    assert told["largest_rotation_mrad"] == pytest.approx(7.42, abs=0.05)


def test_positions_alone_say_nothing_of_rotations(folder: Path) -> None:
    args = ("check", FOLDER / "study.yaml", "--measurements", folder / "m.csv")
    words = " ".join(run(*args).stdout.split())
    assert "columns drx" not in words
    assert "are a rotation and not used" in words
    told = json.loads(run(*args, "--json").stdout)
    assert told["readings"] == 12
    assert "largest_rotation_mrad" not in told


def test_the_model_tells_positions_and_rotations_apart(folder: Path) -> None:
    told = json.loads((folder / "model.json").read_text())["diagnostics"]
    assert told["rms_residual_mm"] == pytest.approx(0.05, abs=0.02)
    assert told["rms_residual_mrad"] == pytest.approx(0.085, abs=0.03)
    kinds = told["scale_of_noise_by_kind"]
    assert list(kinds) == ["position", "rotation"]
    assert min(kinds.values()) <= told["scale_of_noise"] <= max(kinds.values())
    assert {"left_out_error_mm", "left_out_error_mrad"} <= told["experiments"][0].keys()


def test_validation_in_both_units(folder: Path) -> None:
    args = ("validate", folder / "study.yaml", folder / "model.json", folder / "v.csv")
    words = run(*args).stdout
    assert "kept aside: deflection before and after the model" in words
    assert "kept aside: rotation before and after the model" in words
    told = json.loads(run(*args, "--json").stdout)
    assert told["coordinates"] == 72
    assert told["share_inside"] > 0.85
    assert told["before_mm"]["rms"] == pytest.approx(6.0, abs=2.0)
    assert told["after_mm"]["rms"] < 0.08
    assert told["before_mrad"]["rms"] == pytest.approx(6.5, abs=1.0)
    assert told["after_mrad"]["rms"] < 0.13
    assert {"before_mrad", "after_mrad"} <= told["each"][0].keys()


def test_the_report_shows_both(folder: Path) -> None:
    """Never summed: two strips, two tables, each with its unit; of rotations alone one."""
    study = read_study(folder / "study.yaml")
    truth = kr270_truth(study)
    rng, repeats = np.random.default_rng(1), np.array([3, 3, 3, 3])
    data = simulate(study, truth, published_cases(4), repeats, rng)
    for part in ("both", "rotations"):
        if part == "rotations":
            own = data.rotations
            data = type(data)(
                data.tool, data.cases, data.names, data.case[own], data.marker[own],
                data.deflection[own], data.covariance[own],
            )  # fmt: skip
        found = identify(study.arm, data, known=truth)
        page = html(Contents(identification=found, validation=leave_one_out(found)))
        text = " ".join(re.sub(r"<[^>]+>", " ", page).split())
        assert ("of the deflection removed:" in text) == (part == "both")
        assert "of the rotation removed:" in text
        assert ("error [µm]" in text) == (part == "both")
        assert "error of the rotation [µrad]" in text
        assert "Rotations explained" in text
