"""Two campaigns from the command line: what is said, written and refused."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from tests.campaigns import FIRST_STEP
from tests.cli.test_commands import run

SECOND = FIRST_STEP.replace("[J2, J3]", "[J1]").replace("0, 0, -1000", "300, 900, -300")
TRUTH = "compliance: {J1: {value: 2.0e-6, unit: rad/(N.m)}, J2: {value: 3.0e-6, unit: rad/(N.m)}, "
TRUTH += "J3: {value: 5.0e-6, unit: rad/(N.m)}}\n"


def done(*arguments: str | Path) -> str:
    result = run(*arguments)
    assert result.exit_code == 0, result.output
    return str(result.output)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Both campaigns, done."""
    path = tmp_path_factory.mktemp("steps")
    for name, text in (("one.yaml", FIRST_STEP), ("two.yaml", SECOND), ("truth.yaml", TRUTH)):
        (path / name).write_text(text, encoding="utf-8")
    done("plan", path / "one.yaml", "-o", path / "one.json")
    truth = ("--truth", path / "truth.yaml")
    done("simulate", path / "one.yaml", path / "one.json", *truth, "-o", path / "one_m.csv")
    done("identify", path / "one.yaml", path / "one_m.csv", "-o", path / "first.json")
    known = ("--known", path / "first.json")
    done("plan", path / "two.yaml", *known, "-o", path / "two.json")
    done("simulate", path / "two.yaml", path / "two.json", *truth, "-o", path / "two_m.csv")
    done("identify", path / "two.yaml", path / "two_m.csv", *known, "-o", path / "model.json")
    return path


def flat(text: str) -> str:
    return " ".join(text.split())


def test_promise_and_result_are_the_whole_error(folder: Path) -> None:
    plan = json.loads((folder / "two.json").read_text("utf-8"))
    model = json.loads((folder / "model.json").read_text("utf-8"))
    (pose,) = model["diagnostics"]["test_poses"]
    assert pose["rho0_mm"] == pytest.approx(plan["rho0_mm"], rel=0.05)
    assert model["identification"]["identified"] == ["J1"]
    assert list(model["compliance"]) == ["J1", "J2", "J3"]
    names = [entry["name"] for entry in model["provenance"]["models"]]
    assert names == ["first.json"]


def test_what_is_known_is_said(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "plan.json"
    said = flat(done("plan", folder / "two.yaml", "--known", folder / "one.json", "-o", out))
    assert "J2, J3: known as well as one.json promises; errors count in every number." in said
    assert "taken as rigid" not in said
    said = flat(done("plan", folder / "one.yaml", "-o", out))
    assert "J1 is taken as rigid, but bent at test pose 'task': its error comes on top" in said
    said = flat(
        done(
            "identify", folder / "two.yaml", folder / "two_m.csv", "--known",
            folder / "first.json", "-o", tmp_path / "m.json",
        )
    )  # fmt: skip
    assert "Known from before, and fitted along: J2, J3" in said
    assert "by the uncertainty of J1, J2, J3; no nuisance counts." in said
    assert "Stiffness at 'task': TCP of 'tip', base axes" in said
    said = flat(done("evaluate", folder / "two.yaml", folder / "two.json", "--random", "0"))
    assert "note: two.json counts what first.json knows of J2, J3" in said


def test_another_model_under_the_same_name_is_noticed(folder: Path, tmp_path: Path) -> None:
    model = json.loads((folder / "first.json").read_text("utf-8"))
    for row in model["covariance"]["matrix"]:
        row[:] = [4.0 * value for value in row]
    for entry in model["compliance"].values():
        entry["standard_error"] *= 2.0
    (tmp_path / "first.json").write_text(json.dumps(model), encoding="utf-8")
    study = tmp_path / "two.yaml"
    study.write_text(SECOND + "known: first.json\n", encoding="utf-8")
    result = run("evaluate", study, folder / "two.json", "--random", "0")
    assert result.exit_code == 2  # its intervals are those of the model as it was
    assert "is not the interval of" in flat(result.output)
    del model["identification"], model["diagnostics"]
    (tmp_path / "first.json").write_text(json.dumps(model), encoding="utf-8")
    result = run("evaluate", study, folder / "two.json", "--random", "0")
    said = flat(result.output)
    assert "two.json was made when first.json was another file" in said
    assert "it claims ρ0 =" in said
    assert result.exit_code == 2


def test_validation_in_turn_needs_what_was_known(folder: Path) -> None:
    arguments = ("validate", folder / "two.yaml", folder / "model.json", folder / "two_m.csv")
    assert "left out in turn" in done(*arguments, "--known", folder / "first.json")
    result = run(*arguments)
    assert result.exit_code == 2
    assert "with a prior or known joints" in result.output


def test_campaigns_of_a_second_plan_know_the_first(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "campaigns.json"
    done(
        "simulate", folder / "two.yaml", folder / "two.json", "--truth", folder / "truth.yaml",
        "--campaigns", "1000", "-o", out,
    )  # fmt: skip
    document = json.loads(out.read_text("utf-8"))
    (plan,) = document["plans"].values()
    assert plan["rms_mm"] == pytest.approx(plan["rho0_mm"], rel=0.06)
    assert list(plan["compliance"]) == ["J1", "J2", "J3"]
    assert document["taken_as_known"] == []


@pytest.mark.parametrize("command", ["plan", "identify"])
def test_what_is_known_is_not_overwritten(folder: Path, tmp_path: Path, command: str) -> None:
    known = tmp_path / "first.json"
    known.write_bytes((folder / "first.json").read_bytes())
    study = tmp_path / "two.yaml"
    study.write_text(SECOND + "known: first.json\n", encoding="utf-8")
    data = [folder / "two_m.csv"] if command == "identify" else []
    for arguments in ((study,), (folder / "two.yaml", "--known", known)):
        result = run(command, arguments[0], *data, *arguments[1:], "-o", known)
        assert result.exit_code == 2
        assert "would be written over the file it is made from" in result.output
    assert known.read_bytes() == (folder / "first.json").read_bytes()


def test_a_plan_cannot_be_fitted_with(folder: Path, tmp_path: Path) -> None:
    arguments = ("identify", folder / "two.yaml", folder / "two_m.csv")
    result = run(*arguments, "--known", folder / "one.json", "-o", tmp_path / "m.json")
    assert result.exit_code == 2
    assert "a plan has no compliances of J2, J3; name the model" in flat(result.output)


def test_a_joint_that_nothing_moves_is_shown_the_way_out(tmp_path: Path) -> None:
    study = tmp_path / "study.yaml"
    study.write_text(FIRST_STEP.replace("[J2, J3]", "[J1, J2, J3]"), encoding="utf-8")
    result = run("plan", study, "-o", tmp_path / "plan.json")
    assert result.exit_code == 4
    assert "J1: no allowed experiment deflects a marker through this joint" in result.output
    assert "by a second campaign, see 'Joint 1 by a second campaign'" in flat(result.output)


def test_a_file_of_the_command_line_has_no_line_in_the_study(folder: Path) -> None:
    result = run("plan", folder / "two.yaml", "--known", folder / "nothing.json")
    assert result.exit_code == 2
    assert flat(result.output) == f"error: {folder / 'nothing.json'}: no such file"


@pytest.mark.parametrize("option", ["--prior", "--known"])
def test_readings_are_not_counted_twice(folder: Path, tmp_path: Path, option: str) -> None:
    """A model that was fitted to the same readings is nothing that was known before."""
    arguments = (folder / "two.yaml", folder / "two_m.csv", "-o", tmp_path / "m.json")
    result = run("identify", *arguments, option, folder / "model.json")
    assert result.exit_code == 2
    said = flat(result.output)
    assert "model.json: has the readings of" in said
    assert "two_m.csv in it already, so they would count twice" in said
    assert not (tmp_path / "m.json").exists()
    study = tmp_path / "two.yaml"
    study.write_text(SECOND + "known: model.json\n", encoding="utf-8")
    (tmp_path / "model.json").write_bytes((folder / "model.json").read_bytes())
    result = run("identify", study, folder / "two_m.csv", "-o", tmp_path / "m.json")
    assert result.exit_code == 2
    assert "would count twice" in flat(result.output)


def test_readings_are_not_counted_twice_however_far_back(folder: Path, tmp_path: Path) -> None:
    """The second model was made with the first, so it has the readings of the first campaign."""
    one = (folder / "one.yaml", folder / "one_m.csv", "-o", tmp_path / "m.json")
    provenance = json.loads((folder / "model.json").read_text("utf-8"))["provenance"]
    files = [folder / "one_m.csv", folder / "two_m.csv"]
    assert provenance["readings"] == sorted(
        hashlib.sha256(file.read_bytes()).hexdigest() for file in files
    )
    result = run("identify", *one, "--prior", folder / "model.json")
    assert result.exit_code == 2
    assert "one_m.csv in it already" in flat(result.output)
    result = run("identify", *one, "--prior", folder / "first.json")
    assert result.exit_code == 2
    # Through a mapping, and beside another file, they are still the same readings.
    names = ["experiment", "marker", "J1", "J2", "J3", "Fx", "Fy", "Fz", "dx", "dy", "dz"]
    columns = "".join(f"  {name}: {name}\n" for name in names)
    (tmp_path / "map.yaml").write_text(f"elastocal: 1\ncolumns:\n{columns}")
    again = (*one, "--mapping", tmp_path / "map.yaml")
    assert run("identify", *again).exit_code == 0
    (tmp_path / "m.json").unlink()
    result = run("identify", *again, "--prior", folder / "model.json")
    assert result.exit_code == 2
    assert "one_m.csv" in flat(result.output)
    assert not (tmp_path / "m.json").exists()


def test_the_rest_of_a_campaign_does_not_know_it_already(folder: Path, tmp_path: Path) -> None:
    """`plan --after` adds the readings to what is known, which must not have them."""
    rest = ("--count", "20", "-o", tmp_path / "rest.json", "--after", folder / "two_m.csv")
    plain = ("plan", folder / "two.yaml", *rest)
    result = run(*plain, "--known", folder / "model.json")
    assert result.exit_code == 2, result.output
    done(*plain, "--known", folder / "first.json")
    text = (folder / "two_m.csv").read_text("utf-8")
    (tmp_path / "copy.csv").write_text(text, "utf-8")
    result = run(*plain, "--after", tmp_path / "copy.csv")
    assert result.exit_code == 2
    assert "copy.csv: has the content of" in flat(result.output)


@pytest.mark.parametrize("section", [[], "x", None, 3, True, {"measurements": []}, {"models": 3}])
def test_a_section_of_another_kind_is_named(folder: Path, tmp_path: Path, section: object) -> None:
    model = json.loads((folder / "first.json").read_text("utf-8"))
    path = tmp_path / "first.json"
    for key in ("provenance", "identification", "diagnostics"):
        path.write_text(json.dumps(model | {key: section}), encoding="utf-8")
        result = run("validate", folder / "one.yaml", path, folder / "one_m.csv")
        said = key != "provenance" and isinstance(section, dict)
        harmless = section is None or said
        assert result.exit_code == (0 if harmless else 2), result.output
        assert harmless or f"first.json, line 1: {key}" in result.stderr


def test_a_plan_that_took_the_others_as_rigid_is_said_beside_one_that_did_not(
    folder: Path, tmp_path: Path
) -> None:
    done("plan", folder / "two.yaml", "-o", tmp_path / "rigid.json")
    both = (folder / "two.json", tmp_path / "rigid.json")
    result = run("evaluate", folder / "two.yaml", *both, "--random", "0")
    said = flat(result.output)
    assert "rigid.json was made as if J2, J3 did not bend; it is judged by what first.json" in said
    assert said.count("was made as if") == 1


def test_nothing_is_written_over_what_a_study_names(folder: Path, tmp_path: Path) -> None:
    """A run sheet beside m.json is m.csv: it may be a path, or readings, that exist once."""
    path = "J1 [deg],J2 [deg],J3 [deg],Fx [N],Fy [N],Fz [N]\n0,60,-45,0,290,-960\n"
    study = tmp_path / "study.yaml"
    text = FIRST_STEP.replace("q_deg: [0, 60, -45], force_N: [0, 290, -960]", "path: m.csv")
    study.write_text(text + "prior: {plan: first.json}\n", encoding="utf-8")
    (tmp_path / "m.csv").write_text(path, encoding="utf-8")
    plan, truth = tmp_path / "first.json", folder / "truth.yaml"
    plan.write_bytes((folder / "one.json").read_bytes())
    before = {file: file.read_bytes() for file in (tmp_path / "m.csv", plan)}
    model, data = folder / "first.json", tmp_path / "one_m.csv"
    data.write_bytes((folder / "one_m.csv").read_bytes())
    for arguments in (
        ("plan", study, "-o", tmp_path / "m.json"),
        ("plan", study, "-o", plan),
        (
            "plan",
            folder / "one.yaml",
            "--after",
            data,
            "--count",
            6,
            "-o",
            data.with_suffix(".json"),
        ),
        ("simulate", study, plan, "--truth", truth, "-o", tmp_path / "m.csv"),
        ("identify", study, data, "-o", plan),
        ("compensate", study, model, folder / "path.csv", "-o", tmp_path / "m.csv"),
    ):
        (folder / "path.csv").write_text(path, encoding="utf-8")
        result = run(*arguments)
        assert result.exit_code == 2, arguments
        assert "would be written over the file it is made from" in flat(result.output), arguments
    assert before == {file: file.read_bytes() for file in before}
    assert data.read_bytes() == (folder / "one_m.csv").read_bytes()
    # What is named in place of the study's own may have the name of what is written.
    done("plan", folder / "two.yaml", "--known", folder / "one.json", "-o", tmp_path / "one.json")


def test_what_was_known_before_was_no_experiment_of_this_plan(folder: Path, tmp_path: Path) -> None:
    """Errors then do not go down as one over the root of the count; nobody says that they do."""
    page, claim = tmp_path / "r.html", "of the experiments could be saved"
    done("report", folder / "one.json", "--quick", "-o", page)
    assert claim in page.read_text("utf-8")
    assert "times as many experiments" in page.read_text("utf-8")
    done("report", folder / "two.json", "--quick", "-o", page)
    text = page.read_text("utf-8")
    assert claim not in text
    assert "times as many experiments" not in text
    assert "J2, J3 bend as well: their errors, as found in first.json, count" in text
    assert "What was known before these experiments" not in text
    assert hashlib.sha256((folder / "first.json").read_bytes()).hexdigest() in text
    random = ("--random", "0", "--at-test-poses")
    assert ", worth" in flat(done("evaluate", folder / "one.yaml", folder / "one.json", *random))
    said = flat(done("evaluate", folder / "two.yaml", folder / "two.json", *random))
    assert "smaller than in the test poses" in said
    assert "worth" not in said
