"""A study with nuisance from the command line: what is said, written, read back and refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.campaigns import FIRST_STEP
from tests.cli.test_commands import run
from tests.cli.test_two_steps import TRUTH, done, flat
from tests.report.examples import visible

NUISANCE = (
    "nuisance: {preset: typical, compliance_urad_per_Nm: {J1: 2, J2: 3, J3: 5}, "
    "repeatability_mm: .01}\n"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study, its plan, and what one campaign read."""
    path = tmp_path_factory.mktemp("nuisance")
    (path / "study.yaml").write_text(FIRST_STEP + NUISANCE, encoding="utf-8")
    (path / "truth.yaml").write_text(TRUTH, encoding="utf-8")
    truth = ("--truth", path / "truth.yaml")
    done("plan", path / "study.yaml", "-o", path / "plan.json")
    done("simulate", path / "study.yaml", path / "plan.json", *truth, "-o", path / "m.csv")
    return path


def test_check_says_where_every_spring_is(folder: Path) -> None:
    said = done("check", folder / "study.yaml")
    rows = [line for line in said.splitlines() if line.strip().startswith("foot turning")]
    assert "turns about" in rows[0]
    assert any("base" in row for row in rows)  # narrow, the table has two parts
    assert "repeatability 0.01 mm" in flat(said)
    found = json.loads(done("check", folder / "study.yaml", "--json"))["nuisance"]
    assert {entry["moves"] for entry in found} == {"turns", "slides"}
    assert all(entry["source"] for entry in found)


def test_a_plan_says_what_it_promises_and_without(folder: Path) -> None:
    said = flat(done("plan", folder / "study.yaml", "-o", folder / "again.json"))
    plan = json.loads((folder / "plan.json").read_text("utf-8"))
    promise = plan["promise"]
    assert promise["rho0_mm"] > plan["rho0_mm"] > promise["without_mm"] > 0.0
    assert promise["uncompensated_mm"] > promise["without_mm"]
    assert promise["repeatability_mm"] == pytest.approx(0.01 * 3**0.5)
    assert set(plan["standard_error"]) == set(promise["standard_error"]) == {"J2", "J3"}
    assert plan["covariance"]["order"][:2] == ["J2", "J3"]
    assert "ρ0 counts the springs of the nuisance without these errors" in said
    assert "Plans are made for the promise, and bound and efficiency speak of it." in said
    assert promise["optimised"] == "promise"
    assert "Without nuisance the same plan would claim" in said
    assert "no calibration takes from the task: friction" in said


def test_it_is_believed_as_far_as_it_is_true(folder: Path, tmp_path: Path) -> None:
    study, plan = folder / "study.yaml", folder / "plan.json"
    said = flat(done("evaluate", study, plan, "--random", "0"))
    assert "promised" in said
    one = json.loads(done("evaluate", study, plan, "--random", "0", "--json"))["plan.json"]
    assert one["accepted"]
    assert one["promise"]["rho0_mm"] == pytest.approx(
        json.loads(plan.read_text("utf-8"))["promise"]["rho0_mm"]
    )
    for key, name in (("rho0_mm", "rho0"), ("limit_95_mm", "limit")):
        document = json.loads(plan.read_text("utf-8"))
        document["promise"][key] *= 0.5
        (tmp_path / "better.json").write_text(json.dumps(document), encoding="utf-8")
        result = run("evaluate", study, tmp_path / "better.json", "--random", "0")
        assert result.exit_code
        assert f"of its promise, {name}: it claims" in flat(result.output)


def test_the_rest_of_a_campaign_counts_it(folder: Path, tmp_path: Path) -> None:
    rest = ("--after", folder / "m.csv", "--count", "8", "-o", folder / "rest.json")
    said = flat(done("plan", folder / "study.yaml", *rest))
    assert "Promised" in said
    assert "noise of its instrument alone" not in said
    done("evaluate", folder / "study.yaml", folder / "rest.json", "--random", "0")
    document = json.loads((folder / "rest.json").read_text("utf-8"))
    assert sum(entry["repeats"] for entry in document["after"]["configurations"]) == 4
    document["after"]["precisions_per_m2"][0][0][0] *= 2.0
    (tmp_path / "m.csv").write_bytes((folder / "m.csv").read_bytes())
    (tmp_path / "better.json").write_text(json.dumps(document), encoding="utf-8")
    result = run("evaluate", folder / "study.yaml", tmp_path / "better.json", "--random", "0")
    assert result.exit_code == 2
    assert "their repeats or precisions_per_m2 are not what" in flat(result.stderr)


def test_a_second_campaign_knows_what_is_asked_for_alone(folder: Path, tmp_path: Path) -> None:
    text = FIRST_STEP.replace("[J2, J3]", "[J1]").replace("0, 0, -1000", "300, 900, -300")
    (tmp_path / "two.yaml").write_text(text, encoding="utf-8")
    out = tmp_path / "two.json"
    done("plan", tmp_path / "two.yaml", "--known", folder / "plan.json", "-o", out)
    second = json.loads(out.read_text("utf-8"))
    assert second["covariance"]["order"] == ["J1", "J2", "J3"]
    promised = json.loads((folder / "plan.json").read_text("utf-8"))["promise"]["standard_error"]
    for i, name in enumerate(second["known"]["covariance"]["order"]):
        error = second["known"]["covariance"]["matrix"][i][i] ** 0.5
        assert error == pytest.approx(promised[name]["value"], rel=1e-9)


def test_virtual_campaigns_are_on_robots_with_it(folder: Path, tmp_path: Path) -> None:
    given = ("--truth", folder / "truth.yaml", "--campaigns", "10", "-o", tmp_path / "c.json")
    promise = json.loads((folder / "plan.json").read_text("utf-8"))["promise"]
    for options, expected in (((), "rho0_mm"), (("--no-nuisance",), "without_mm")):
        result = run("simulate", folder / "study.yaml", folder / "plan.json", *given, *options)
        assert result.exit_code == 0, result.stderr
        found = json.loads((tmp_path / "c.json").read_text("utf-8"))
        assert found["nuisance"] == (not options)
        (one,) = found["plans"].values()
        assert one["rho0_mm"] == pytest.approx(promise[expected], rel=1e-6)
        assert ("on a robot of its own" in flat(result.stdout)) == (not options)
        assert "with 95 % below" in flat(result.stdout)


def test_the_robot_that_was_drawn_is_kept(folder: Path, tmp_path: Path) -> None:
    """With it as truth the next campaign is on the same robot, and so is compensation."""
    truth = json.loads((folder / "m_truth.json").read_text("utf-8"))
    assert set(truth["true_loads"]) == {"gain", "process_gain", "turn_deg"}
    assert "tool sliding x" in truth["compliance"]
    out = tmp_path / "again.csv"
    ask = ["simulate", folder / "study.yaml", folder / "plan.json", "-o", out, "--seed", "0"]
    said = done(*ask, "--truth", folder / "m_truth.json")
    assert "truth" not in said
    assert not (tmp_path / "again_truth.json").exists()
    assert out.read_text("utf-8") == (folder / "m.csv").read_text("utf-8")
    result = run(*ask, "--truth", folder / "m_truth.json", "--truth-out", tmp_path / "t.json")
    assert result.exit_code == 2
    assert "nothing is drawn" in result.stderr
    bare = done(*ask, "--truth", folder / "truth.yaml", "--no-nuisance")
    assert "truth" not in bare
    assert out.read_text("utf-8") != (folder / "m.csv").read_text("utf-8")
    result = run(*ask, "--truth", folder / "truth.yaml", "--no-nuisance", "--truth-out", out)
    assert result.exit_code == 2


@pytest.mark.parametrize(
    ("loads", "wrong"),
    [("{gain: .7}", "share"), ("{turn_deg: [0, 0, 100]}", "at most 90"), ("{gian: 0}", "gian")],
)
def test_loads_that_cannot_be_true_are_refused(
    folder: Path, tmp_path: Path, loads: str, wrong: str
) -> None:
    (tmp_path / "t.yaml").write_text(f"{TRUTH}\ntrue_loads: {loads}\n", encoding="utf-8")
    result = run(
        "simulate", folder / "study.yaml", folder / "plan.json", "--truth", tmp_path / "t.yaml",
        "-o", tmp_path / "m.csv",
    )  # fmt: skip
    assert result.exit_code == 2
    assert wrong in result.stderr


def test_the_report_shows_it(folder: Path, tmp_path: Path) -> None:
    done("report", folder / "plan.json", "-o", tmp_path / "r.html")
    shown = flat(visible((tmp_path / "r.html").read_text("utf-8")))
    assert "Without nuisance the same plan would claim" in shown
    assert "It is what is promised" in shown
    assert "0.3 of the stiffest joint: a slab on its bed" in shown


def test_a_plan_without_says_so(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text(FIRST_STEP, encoding="utf-8")
    said = flat(done("plan", tmp_path / "study.yaml", "-o", tmp_path / "p.json"))
    assert "No nuisance counts" in said
    assert "promise" not in json.loads((tmp_path / "p.json").read_text("utf-8"))
    assert "No nuisance counts" in flat(
        done("evaluate", tmp_path / "study.yaml", tmp_path / "p.json", "--random", "0")
    )
