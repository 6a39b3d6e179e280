"""`elastocal simulate`: one campaign as a measurement file, many as a comparison of plans."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.files.models.campaign_file import QUANTILES
from elastocal.files.plans.proposal_file import read_proposal
from elastocal.identification.identify import identify
from elastocal.simulation.virtual_campaign import simulate
from tests.cli.test_commands import run
from tests.kr270 import FOLDER, kr270_study, kr270_truth
from tests.paper.published import TABLE_5

STUDY, TRUTH = FOLDER / "study.yaml", FOLDER / "truth.json"


@pytest.fixture(scope="module")
def plans(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    """Published plans of 12 experiments, as tables."""
    folder = tmp_path_factory.mktemp("plans")
    joints = ",".join(f"A{i} [deg]" for i in range(1, 7))
    found = {}
    for m in (3, 4):
        rows = [f"{joints},Fx [N],Fy [N],Fz [N],repeats"]
        rows += [f"0,{','.join(map(str, q))},0,0,-2500,{12 // m}" for q in TABLE_5[m]]
        found[m] = folder / f"plan{m}.csv"
        found[m].write_text("\n".join(rows), encoding="utf-8")
    return found


def test_a_campaign_is_written_like_a_real_one(plans: dict[int, Path], tmp_path: Path) -> None:
    out = tmp_path / "measurements.csv"
    result = run("simulate", STUDY, plans[3], "--truth", TRUTH, "-o", out, "--seed", 5)
    assert result.exit_code == 0, result.stderr
    assert "12 experiments, 12 readings, deflections up to 8.4" in result.stdout
    study = kr270_study()
    back = read_measurements(out, study)
    proposal = read_proposal(plans[3], study)
    rng = np.random.default_rng(5)
    made = simulate(study, kr270_truth(study), proposal.load_cases, proposal.repeats, rng)
    np.testing.assert_allclose(back.deflection, made.deflection, atol=1e-12)
    np.testing.assert_allclose(back.cases.q, made.cases.q, atol=1e-12)
    assert back.remarks == back.doubts == ()
    found = identify(study.arm, back)
    off = np.abs(found.compliance - kr270_truth(study).compliance[1:]) / found.standard_error
    assert off.max() < 3.5


def test_errors_are_put_in_where_asked(plans: dict[int, Path], tmp_path: Path) -> None:
    def readings(*options: object) -> np.ndarray:
        out = tmp_path / "m.csv"
        result = run("simulate", STUDY, plans[4], "--truth", TRUTH, "-o", out, *map(str, options))
        assert result.exit_code == 0, result.stderr
        return read_measurements(out, kr270_study()).deflection

    plain = readings()
    np.testing.assert_array_equal(readings(), plain)
    assert np.all(readings("--seed", 1) != plain)
    gross = np.linalg.norm(readings("--outliers-percent", 30, "--outlier-mm", 2) - plain, axis=1)
    np.testing.assert_allclose(gross[gross > 1e-9], 2e-3, atol=1e-10)
    assert 0 < (gross > 1e-9).sum() < 12
    for option, size in (("--load-error-percent", 1), ("--load-direction-deg", 0.3)):
        change = np.linalg.norm(readings(option, size) - plain, axis=1)
        assert 1e-6 < change.max() < 1e-3
    assert 1e-6 < np.abs(readings("--linear") - plain).max() < 1e-3


def test_many_campaigns_compare_plans(plans: dict[int, Path], tmp_path: Path) -> None:
    out = tmp_path / "campaigns.json"
    ask = ["simulate", STUDY, plans[3], plans[4], "--truth", TRUTH, "--campaigns", 300, "-o", out]
    result = run(*ask)
    assert result.exit_code == 0, result.stderr
    for word in ("plan3.csv", "plan4.csv", "A1: not identified in this study", "median"):
        assert word in result.stdout
    assert "held the truth in only" not in result.stdout
    document = json.loads(out.read_text(encoding="utf-8"))
    assert document["kind"] == "campaigns"
    for name in ("plan3.csv", "plan4.csv"):
        plan = document["plans"][name]
        assert plan["experiments"] == 12
        assert plan["rms_mm"] == pytest.approx(plan["rho0_mm"], rel=0.1)
        assert list(plan["quantiles_mm"]) == [f"{q:g}" for q in QUANTILES]
        assert len(plan["errors_mm"]) == 300
        assert plan["covariance_test"]["p_value"] > 1e-3
        assert plan["compliance"]["A2"]["unit"] == "rad/(N·m)"
    printed = run(*ask, "--json", "--workers", 2)
    assert json.loads(printed.stdout) == document


def test_a_prior_that_campaigns_leave_out_is_said(plans: dict[int, Path], tmp_path: Path) -> None:
    knowing = tmp_path / "study.yaml"
    prior = "prior: {standard_error_rad_per_Nm: {A2: 1.0e-9}}\n"
    knowing.write_text(STUDY.read_text("utf-8") + prior, encoding="utf-8")
    for study, said in ((knowing, True), (STUDY, False)):
        result = run(
            "simulate", study, plans[3], "--truth", TRUTH, "--campaigns", 30,
            "-o", tmp_path / "campaigns.json",
        )  # fmt: skip
        assert result.exit_code == 0, result.stderr
        assert ("fitted without the prior of the study" in result.stderr) == said


def test_a_fit_that_leaves_something_out_is_said(plans: dict[int, Path], tmp_path: Path) -> None:
    out = tmp_path / "campaigns.json"
    ask = ["simulate", STUDY, plans[3], "--truth", TRUTH, "--campaigns", 300, "-o", out]
    result = run(*ask, "--fit", "linear")
    assert result.exit_code == 0, result.stderr
    assert "of the campaigns; the fit leaves something out" in " ".join(result.stdout.split())
    silent = run(*ask, "--fit", "linear", "--linear", "--sigma", "estimated")
    assert "leaves something out" not in silent.stdout


def test_what_cannot_be_is_refused(plans: dict[int, Path], tmp_path: Path) -> None:
    out = tmp_path / "m.csv"
    model = tmp_path / "model.json"
    model.write_text('{"compliance": {"A1": {"value": 1e-7, "unit": "rad/(N.m)"}}}')
    soft = tmp_path / "soft.json"
    text = TRUTH.read_text(encoding="utf-8").replace("e-6", "e-3")
    soft.write_text(text, encoding="utf-8")
    cases = [
        ((plans[3], plans[4], "--truth", TRUTH), "one campaign needs one plan, found 2"),
        ((plans[3], "--truth", tmp_path / "none.json"), "no such file"),
        ((plans[3], "--truth", soft), "no stable equilibrium"),
        ((plans[3], "--truth", TRUTH, "--load-error-percent", 150), "load error: size"),
    ]
    for arguments, message in cases:
        result = run("simulate", STUDY, *arguments, "-o", out)
        assert result.exit_code == 2
        assert message in result.stderr
        assert not out.exists()
    many = ("--campaigns", 10, "-o", tmp_path / "c.json")
    for arguments, message in (
        (("--truth", model), "the truth says nothing of A2"),
        (("--truth", TRUTH, "--fit", "quick"), "model 'quick' is not known"),
        (("--truth", TRUTH, "--campaigns", 1), "at least 2, found 1"),
    ):
        result = run("simulate", STUDY, plans[3], *many, *arguments)
        assert result.exit_code == 2
        assert message in result.stderr
    assert run("simulate", STUDY, plans[3], "--truth", TRUTH, "-o", STUDY).exit_code == 2
    assert (
        run("simulate", STUDY, plans[3], "--truth", TRUTH, "-o", tmp_path / "m.json").exit_code == 2
    )
