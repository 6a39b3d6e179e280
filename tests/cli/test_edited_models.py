"""Models that were edited after they were written: noticed by what is read of them."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from elastocal.cli.common import CONTROLLERS
from elastocal.programs.writers import WRITERS
from tests.cli.test_commands import run
from tests.cli.test_report import PATH, STUDY, TRUTH

Change = Callable[[dict[str, Any]], None]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign: study, plan, readings of two seeds, their model, a path."""
    path = tmp_path_factory.mktemp("campaign")
    (path / "study.yaml").write_text(STUDY, encoding="utf-8")
    (path / "path.csv").write_text(PATH, encoding="utf-8")
    truth = {name: {"value": value, "unit": "rad/(N·m)"} for name, value in TRUTH.items()}
    (path / "truth.json").write_text(json.dumps({"compliance": truth}), encoding="utf-8")
    study, plan = path / "study.yaml", path / "plan.json"
    simulated = ("simulate", study, plan, "--truth", path / "truth.json")
    for arguments in (
        ("plan", study, "-o", plan),
        (*simulated, "-o", path / "m.csv"),
        (*simulated, "--seed", "1", "-o", path / "v.csv"),
        ("identify", study, path / "m.csv", "-o", path / "model.json"),
    ):
        result = run(*arguments)
        assert result.exit_code == 0, result.stderr
    return path


def edit(folder: Path, change: Change) -> Path:
    document = json.loads((folder / "model.json").read_text(encoding="utf-8"))
    change(document)
    path = folder / "edited.json"
    path.write_text(json.dumps(document, indent=1), encoding="utf-8")
    return Path(path.name)


@pytest.fixture(autouse=True)
def there(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files are named as people name them."""
    monkeypatch.chdir(folder)


def value(factor: float) -> Change:
    def change(document: dict[str, Any]) -> None:
        document["compliance"]["J2"]["value"] *= factor

    return change


def entry(key: str, what: Any) -> Change:
    def change(document: dict[str, Any]) -> None:
        document["compliance"]["J2"][key] = what

    return change


def top(key: str, what: Any) -> Change:
    def change(document: dict[str, Any]) -> None:
        document[key] = what

    return change


def smaller_spread(document: dict[str, Any]) -> None:
    """Consistent, and ten times too good."""
    for one in document["compliance"].values():
        one["standard_error"] /= 10.0
    matrix = document["covariance"]["matrix"]
    document["covariance"]["matrix"] = [[v / 100.0 for v in row] for row in matrix]


def less_correlated(document: dict[str, Any]) -> None:
    matrix = document["covariance"]["matrix"]
    matrix[1][2] = matrix[2][1] = 0.5 * matrix[1][2]


def negative_variance(document: dict[str, Any]) -> None:
    document["covariance"]["matrix"][1][1] *= -1.0


def wrong_name(document: dict[str, Any]) -> None:
    document["compliance"]["J4"] = document["compliance"].pop("J2")


def lost(document: dict[str, Any]) -> None:
    del document["compliance"]["J2"]
    matrix, order = document["covariance"]["matrix"], document["covariance"]["order"]
    i = order.index("J2")
    del order[i], matrix[i]
    for row in matrix:
        del row[i]


NOT_FOUND = {
    "ten times": (value(10.0), "is not the model that m.csv gives; J2 is"),
    "a little": (value(1.0001), "is not the model that m.csv gives; J2 is"),
    "1e20": (entry("value", 1e20), "is not the model that m.csv gives; J2 is 1e+20 there"),
    "lost": (lost, "is not the model that m.csv gives; it has no compliance of J2"),
    "spread": (smaller_spread, "is not the model that m.csv gives; the standard error of J1"),
    "correlation": (
        less_correlated,
        "is not the model that m.csv gives; the covariance of J2 and J3",
    ),
    "dof": (top("dof", 7), "is not the model that m.csv gives; it claims 7 degrees of freedom"),
}
WRONG = {
    "text": (entry("value", "much"), ": compliance.J2.value: expected a number"),
    "NaN": (entry("value", float("nan")), "expected a finite number, found NaN"),
    "unit": (entry("unit", "m/N"), "'m/N' is that of a compliance of a linear spring"),
    "smaller unit": (entry("unit", "urad/(N.m)"), "contradicts the standard errors"),
    "negative variance": (negative_variance, "negative eigenvalue"),
    "joint": (wrong_name, "has no joint or spring 'J4'"),
    "standard error": (entry("standard_error", 1e-30), "contradicts the standard errors"),
    "standard error +1 %": (
        lambda d: d["compliance"]["J2"].update(
            standard_error=1.01 * d["compliance"]["J2"]["standard_error"]
        ),
        "contradicts the standard errors: that of J2 is",
    ),
    "robot": (
        top("robot", "kuka-kr270"),
        "robot: this is a model of 'kuka-kr270', not of 'three-link'",
    ),
    "geometry": (top("geometry_sha256", 64 * "0"), "joint axes are elsewhere than those of"),
}
CLAIMS = {
    "ten times": (value(10.0), "identification.interval.J2", "is not the interval of"),
    "spread": (smaller_spread, "identification.interval.J1", "is not the interval of"),
    "dof": (top("dof", 7), "identification.interval.J1", "is not the interval of"),
    "interval": (
        lambda d: d["identification"]["interval"]["J3"].__setitem__(0, 0.0),
        "identification.interval.J3",
        "is not the interval of",
    ),
    "correlation": (less_correlated, "diagnostics.correlation", "of J2 and J3 is not that of"),
    "another spring": (
        lambda d: d["identification"]["identified"].append("J9"),
        "identification",
        "no compliance of 'J9'",
    ),
}


def origin(**parts: str) -> Change:
    """Other measurements named as those that the model was made from."""

    def change(document: dict[str, Any]) -> None:
        document["provenance"]["measurements"].update(parts)
        if "sha256" in parts:
            document["provenance"]["readings"] = [parts["sha256"]]

    return change


def test_a_hash_that_is_not_among_the_readings_is_refused(folder: Path) -> None:
    def change(document: dict[str, Any]) -> None:
        document["provenance"]["measurements"]["sha256"] = 64 * "1"

    model, words = edit(folder, change), "is not among the readings; one of them was changed"
    place = "edited.json, line "
    for command in (
        ("validate", "study.yaml", model, "m.csv"),
        ("validate", "study.yaml", model, "v.csv"),
        ("identify", "study.yaml", "v.csv", "--prior", model, "-o", "new.json"),
        ("compensate", "study.yaml", model, "path.csv"),
    ):
        refused(run(*command), place, "provenance: ", words)


def test_measurements_of_another_content_are_noticed(folder: Path) -> None:
    def change(document: dict[str, Any]) -> None:
        origin(sha256=64 * "1")(document)
        document["provenance"]["marks"] = []  # nor does it know any of these readings

    model = edit(folder, change)
    result = run("validate", "study.yaml", model, "m.csv")
    assert result.exit_code == 0, result.stderr
    assert "note: edited.json was made from another content of m.csv than it has now" in (
        result.stderr
    )
    page = ("report", "plan.json", "--quick", "-o", "noted.html", "--force", "--model", model)
    result = run(*page, "--measurements", "m.csv")
    assert result.exit_code == 0, result.stderr
    assert "note: edited.json follows from m.csv, but names other measurements" in result.stderr
    result = run(*page, "--validation", "m.csv")
    assert "note: edited.json was made from another content of m.csv" in result.stderr
    assert "other" not in run("validate", "study.yaml", model, "v.csv").stderr


def test_readings_that_a_model_counts_are_no_test_of_it(folder: Path) -> None:
    made = run("identify", "study.yaml", "v.csv", "--prior", "model.json", "-o", "both.json")
    assert made.exit_code == 0, made.stderr
    said = "note: both.json counts readings of m.csv already: they are no test of it"
    assert said in run("validate", "study.yaml", "both.json", "m.csv").stderr
    page = ("report", "plan.json", "--quick", "-o", "both.html")
    result = run(*page, "--model", "model.json", "--validation", "m.csv")
    refused(result, "m.csv: these are the measurements model.json was made from; name them with")


@pytest.mark.parametrize(
    ("section", "key", "value"),
    [
        ("identification", "confidence", 1.5),
        ("identification", "iterations", -1),
        ("identification", "experiments", -3),
        ("identification", "readings", 2.5),
        ("diagnostics", "scale_of_noise", -1.0),
        ("diagnostics", "chi_square", -4),
        ("diagnostics", "degrees_of_freedom", -4),
        ("diagnostics", "rms_residual_mm", -0.1),
        ("diagnostics", "singular_values", [1.0, -1.0]),
    ],
)
def test_numbers_that_mean_nothing_are_refused_by_their_key(
    folder: Path, section: str, key: str, value: Any
) -> None:
    def change(document: dict[str, Any]) -> None:
        document[section][key] = value

    model = edit(folder, change)
    for command in (
        ("validate", "study.yaml", model, "m.csv"),
        ("compensate", "study.yaml", model, "path.csv"),
    ):
        refused(run(*command), "edited.json, line ", f"{section}.{key}", ": expected ")


def refused(result: Any, *words: str) -> None:
    assert (result.exit_code, result.stdout) == (2, ""), result.stderr
    assert result.stderr.count("\n") == 1
    for word in words:
        assert word in result.stderr


@pytest.mark.parametrize("name", NOT_FOUND | WRONG)
def test_validation_in_turn_is_of_the_model_that_is_named(folder: Path, name: str) -> None:
    change, words = (NOT_FOUND | WRONG)[name]
    model = edit(folder, change)
    result = run("validate", "study.yaml", model, "m.csv")
    refused(result, "edited.json", words)
    out = Path("edited.html")
    result = run(
        "report", "plan.json", "--quick", "--model", model,
        "--measurements", "m.csv", "-o", out,
    )  # fmt: skip
    refused(result, "edited.json", words)
    assert not out.exists()


@pytest.mark.parametrize("name", WRONG)
def test_what_contradicts_itself_is_not_used(folder: Path, name: str) -> None:
    change, words = WRONG[name]
    model, study = edit(folder, change), "study.yaml"
    for arguments in (
        ("compensate", study, model, "path.csv", "-o", "c.csv"),
        ("validate", study, model, "v.csv"),
        ("identify", study, "v.csv", "--prior", model, "-o", "n.json"),
        ("simulate", study, "plan.json", "--truth", model, "-o", "s.csv"),
    ):
        refused(run(*arguments), "edited.json", words)


@pytest.mark.parametrize("name", CLAIMS)
def test_what_is_claimed_of_the_compliances_is_compared(folder: Path, name: str) -> None:
    change, where, words = CLAIMS[name]
    model = edit(folder, change)
    out = Path("claims.csv")
    result = run("compensate", "study.yaml", model, "path.csv", "-o", out)
    refused(result, "edited.json, line", where, words)
    assert not out.exists()


def test_a_model_changed_by_hand_says_less(folder: Path) -> None:
    def change(document: dict[str, Any]) -> None:
        value(10.0)(document)
        del document["identification"], document["diagnostics"]

    model = edit(folder, change)
    out = "by_hand.csv"
    result = run("compensate", "study.yaml", model, "path.csv", "-o", out)
    assert result.exit_code == 0, result.stderr


def test_another_study_than_the_model_was_made_with_is_said(folder: Path) -> None:
    study = Path("other.yaml")
    study.write_text(STUDY + "name: other\n", encoding="utf-8")
    result = run("validate", study, "model.json", "v.csv")
    assert result.exit_code == 0
    assert "note: model.json was made with another version of the study" in result.stderr
    result = run("validate", "study.yaml", "model.json", "v.csv")
    assert result.stderr == ""


@pytest.mark.parametrize("error", [1e-160, 1e-31])
def test_a_standard_error_too_small_to_reckon_with_is_named(folder: Path, error: float) -> None:
    entry = {"value": 2e-6, "unit": "rad/(N.m)", "standard_error": error}
    Path("tiny.json").write_text(json.dumps({"compliance": {"J2": entry}}), encoding="utf-8")
    result = run("identify", "study.yaml", "m.csv", "--prior", "tiny.json", "-o", "tiny_m.json")
    refused(result, "tiny.json, line 1: the standard error of J2 is 1e-", "at least 1e-30 in SI")


def test_validation_on_the_load_cases_of_the_identification_is_said(folder: Path) -> None:
    result = run("validate", "study.yaml", "model.json", "v.csv", "--json")
    document = json.loads(result.stdout)
    assert document["repeated_load_cases"] == document["experiments"] == 6
    result = run("report", "plan.json", "--quick", "--model", "model.json", "--validation", "v.csv",
                 "-o", "same.html")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert "all 6 experiments repeat load cases" in Path("same.html").read_text("utf-8")


def test_a_model_without_any_compliance_compensates_nothing(folder: Path) -> None:
    held = {name: {"value": 0.0, "unit": "rad/(N·m)"} for name in TRUTH}
    Path("held.json").write_text(json.dumps({"compliance": held}), encoding="utf-8")
    result = run("compensate", "study.yaml", "held.json", "path.csv", "-o", "held.csv")
    refused(result, "held.json: all compliances are zero")


def test_help_names_every_controller() -> None:
    assert set(CONTROLLERS.replace(" or ", ", ").split(", ")) == set(WRITERS)


def test_home_of_a_held_joint_is_where_it_is_held(folder: Path) -> None:
    held = "constraints: {joint_limits_deg: {J1: [30, 30]}, "
    text = STUDY.replace("constraints: {", held)
    assert held in text
    Path("held.yaml").write_text(text + "motion: {home_deg: [0, 0, 0]}\n", encoding="utf-8")
    refused(run("check", "held.yaml"), "held.yaml, line", "J1 at 0°, but", "holds it at 30°")
    Path("held.yaml").write_text(text + "motion: {home_deg: [30, 0, 0]}\n", encoding="utf-8")
    assert "holds it" not in run("check", "held.yaml").stderr


def test_what_is_known_of_identified_springs_is_said_to_be_left_out(folder: Path) -> None:
    Path("two.yaml").write_text(STUDY + "identify: [J1, J2]\nknown: model.json\n", encoding="utf-8")
    said = " ".join(run("check", "two.yaml").stdout.split())
    assert "what it tells of J1, J2 is left out" in said


def test_a_path_without_loads_is_said(folder: Path) -> None:
    rows = "J1 [deg],J2 [deg],J3 [deg]\n0,60,-45\n1,60,-45\n"
    Path("idle.csv").write_text(rows, encoding="utf-8")
    result = run(
        "evaluate", "study.yaml", "plan.json", "--random", "0", "--path", "idle.csv",
        "--force-n", "0", "0", "0",
    )  # fmt: skip
    assert "note: idle.csv has no loads, so nothing is deflected along it" in result.stderr
