"""Plans that were edited after they were written: noticed wherever a plan is read."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from elastocal.cli.view import _subject
from elastocal.errors import InputError, PlanFileError
from elastocal.files.study.study_file import read_study
from elastocal.files.texts import text_hash
from tests.cli.test_commands import STUDY, run
from tests.report.examples import visible

TRUTH = '{"compliance": {"J1": {"value": 1e-6, "unit": "rad/(N.m)"}}}'


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a study, its plan, a truth, and studies that name the edited plan."""
    path = tmp_path_factory.mktemp("campaign")
    (path / "study.yaml").write_text(STUDY, encoding="utf-8")
    (path / "truth.json").write_text(TRUTH, encoding="utf-8")
    (path / "prior.yaml").write_text(STUDY + "prior: {plan: edited.json}\n", encoding="utf-8")
    (path / "known.yaml").write_text(
        STUDY + "identify: [J1]\nknown: edited.json\n", encoding="utf-8"
    )
    result = run("plan", path / "study.yaml", "--out", path / "plan.json")
    assert result.exit_code == 0, result.stderr
    return path


def edit(folder: Path, change: Callable[[dict[str, Any]], None]) -> Path:
    """The plan with a change applied to its document."""
    document = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    change(document)
    path = folder / "edited.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def better_instrument(document: dict[str, Any]) -> None:
    text = document["study"]["text"]
    document["study"]["text"] = text.replace("sigma_mm: 0.1", "sigma_mm: 0.01")


def smaller_load(document: dict[str, Any]) -> None:
    text = document["study"]["text"]
    document["study"]["text"] = text.replace("max_force_N: 1000", "max_force_N: 100")


def other_hash(document: dict[str, Any]) -> None:
    document["study"]["sha256"] = "0" * 64


READERS = {
    "evaluate": ("evaluate", "study.yaml", "edited.json", "--random", "0"),
    "report": ("report", "edited.json", "--quick"),
    "report by a study": ("report", "edited.json", "--quick", "--study", "study.yaml"),
    "report beside another": ("report", "plan.json", "--quick", "--vs", "edited.json"),
    "export": ("export", "edited.json", "--to", "csv"),
    "export by a study": ("export", "edited.json", "--to", "csv", "--study", "study.yaml"),
    "simulate": ("simulate", "study.yaml", "edited.json", "--truth", "truth.json"),
    "as a prior": ("check", "prior.yaml"),
    "as what is known": ("check", "known.yaml"),
}


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("change", [better_instrument, smaller_load, other_hash])
def test_a_study_edited_inside_a_plan_is_refused(
    folder: Path, change: Callable[[dict[str, Any]], None], reader: str, monkeypatch: Any
) -> None:
    edit(folder, change)
    monkeypatch.chdir(folder)
    before = {path.name for path in folder.iterdir()}
    result = run(*READERS[reader])
    assert (result.exit_code, result.stdout) == (2, "")
    assert "edited.json: the text of the study in it is not the one its sha256" in result.stderr
    assert result.stderr.count("\n") == 1
    assert {path.name for path in folder.iterdir()} == before


def test_the_live_view_refuses_it_too(folder: Path) -> None:
    plan = edit(folder, better_instrument)
    with pytest.raises(PlanFileError, match="is not the one its sha256 stands for"):
        _subject(read_study(folder / "study.yaml"), plan)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"seed": 0', '"seed": 0, "seed": 1', "key 'seed' appears twice"),
        ('"elastocal": 1', '"elastocal": 1.0', "format version 1.0 is not known"),
        ('"elastocal": 1', '"elastocal": true', "format version True is not known"),
        ('"seed": 0', '"seed": NaN', "expected a finite number, found NaN"),
        ('"seed": 0', '"seed": -Infinity', "expected a finite number, found -Infinity"),
        ('"seed": 0', '"seed": 1e999', "expected a finite number, found 1e999"),
        ('"seed": 0', '"seed": ' + 5000 * "9", "expected a finite number, found 9999"),
        ('"seed": 0', '"seed": "\\ud800"', "is half of a sign"),
    ],
)
def test_json_is_read_strictly(folder: Path, old: str, new: str, words: str) -> None:
    text = (folder / "plan.json").read_text(encoding="utf-8")
    assert old in text
    (folder / "odd.json").write_text(text.replace(old, new, 1), encoding="utf-8")
    result = run("evaluate", folder / "study.yaml", folder / "odd.json", "--random", "0")
    assert (result.exit_code, result.stdout) == (2, "")
    assert words in result.stderr
    assert result.stderr.count("\n") == 1


SENSELESS = {
    "certificate.efficiency": (-0.5, 1.5),
    "certificate.fresh_starts": (-1, 600.5),
    "certificate.attained": (-1, "many"),
    "certificate.narrow_starts": (-1,),
    "certificate.narrow_attained": (-3,),
    "certificate.rarest": (-1, 1e3),
    "certificate.missed": (-0.1, 7),
    "certificate.peak.ratio": (-1,),
    "certificate.continuous_design, entry 1.weight": (-0.5,),
    "seed": (-1,),
    "experiments": (-12,),
    "searches.count": (-1, 1.5),
    "searches.apart": (-1e-3,),
    "schedule.hours": (-2,),
    "rho0_mm": (-0.01,),
    "standard_error.J2.value": (-1e-9,),
    "load_cases, entry 1.done_after_min": (-5,),
}


@pytest.mark.parametrize("key", SENSELESS)
def test_numbers_that_mean_nothing_are_refused_by_their_key(folder: Path, key: str) -> None:
    *way, last = key.replace(", entry 1", ".0").split(".")
    for value in SENSELESS[key]:

        def change(document: dict[str, Any], value: Any = value) -> None:
            inner: Any = document
            for part in way:
                inner = inner[int(part) if part.isdigit() else part]
            assert last in inner
            inner[last] = value

        plan = edit(folder, change)
        for command in (
            ("export", plan, "--to", "csv", "-o", folder),
            ("evaluate", folder / "study.yaml", plan, "--random", "0"),
        ):
            result = run(*command)
            assert (result.exit_code, result.stdout) == (2, ""), (key, value, result.stdout)
            shown = key.replace(", entry 1", "")
            assert f"edited.json: {shown}: expected " in result.stderr, result.stderr
            assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("key", "among"),
    [
        ("attained", ("fresh_starts",)),
        ("narrow_attained", ("narrow_starts",)),
        ("rarest", ("fresh_starts", "narrow_starts")),
    ],
)
def test_no_more_starts_reach_it_than_there_were(
    folder: Path, key: str, among: tuple[str, ...]
) -> None:
    def change(document: dict[str, Any]) -> None:
        document["certificate"][key] = 10_000

    plan = edit(folder, change)
    certificate = json.loads(plan.read_text("utf-8"))["certificate"]
    starts = sum(certificate[name] for name in among)
    result = run("export", plan, "--to", "csv", "-o", folder)
    assert (result.exit_code, result.stdout) == (2, "")
    said = f"edited.json: certificate: {key} is 10000, of only {starts} starts"
    assert said in result.stderr


def test_a_bound_below_zero_is_refused(folder: Path) -> None:
    def change(document: dict[str, Any]) -> None:
        document["certificate"]["rho0_lower_bound_mm"] = -1.0

    result = run("export", edit(folder, change), "--to", "csv", "-o", folder)
    assert (result.exit_code, result.stdout) == (2, "")
    assert "certificate: rho0_lower_bound_mm: expected 0 or a positive number, found -1" in (
        result.stderr
    )


def other_angle(document: dict[str, Any]) -> None:
    document["load_cases"][0]["q_deg"]["J2"] += 5.0


def once_more(document: dict[str, Any]) -> None:
    document["load_cases"][0]["repeats"] += 1


def better(document: dict[str, Any]) -> None:
    document["rho0_mm"] *= 0.9


def better_in_another_unit(document: dict[str, Any]) -> None:
    document["standard_error"]["J2"]["unit"] = "mrad/(N.m)"


def too_good_to_be_true(document: dict[str, Any]) -> None:
    document["certificate"]["efficiency"] = 2.0


def refuted_bound(document: dict[str, Any]) -> None:
    document["certificate"]["rho0_lower_bound_mm"] = 1.1 * document["rho0_mm"]


JUDGES = {
    name: command
    for name, command in READERS.items()
    if name not in ("as a prior", "as what is known")
}
FALSE = {
    other_angle: "it claims ",
    once_more: "it claims 3 experiments but has 4",
    better: "it claims ρ0 =",
    better_in_another_unit: "it claims a standard error of",
    too_good_to_be_true: "certificate.efficiency: expected a share from 0 to 1, found 2",
    refuted_bound: "it claims that no plan is better than",
}


@pytest.mark.parametrize("reader", JUDGES)
@pytest.mark.parametrize("change", FALSE)
def test_a_plan_that_claims_what_does_not_hold_is_refused(
    folder: Path, change: Callable[[dict[str, Any]], None], reader: str, monkeypatch: Any
) -> None:
    edit(folder, change)
    monkeypatch.chdir(folder)
    before = {path.name for path in folder.iterdir()}
    result = run(*JUDGES[reader])
    assert result.exit_code == 2
    assert f"error: edited.json: {FALSE[change]}" in result.stderr
    edited = "note: edited.json has other load cases than it was written with" in result.stderr
    assert edited == (change in (other_angle, once_more))
    assert {path.name for path in folder.iterdir()} == before


def test_the_live_view_refuses_false_claims_too(folder: Path) -> None:
    with pytest.raises(InputError, match="it claims ρ0 ="):
        _subject(read_study(folder / "study.yaml"), edit(folder, better))


def test_load_cases_changed_by_hand_are_a_run_sheet(folder: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(folder)
    sheet = Path("plan.csv").read_text(encoding="utf-8").splitlines()
    cells = sheet[1].split(",")
    cells[2] = f"{float(cells[2]) + 5.0:.4f}"
    Path("by_hand.csv").write_text("\n".join([sheet[0], ",".join(cells), *sheet[2:]]) + "\n")
    (folder / "out").mkdir()
    result = run("export", "by_hand.csv", "--to", "csv", "--study", "study.yaml", "-o", "out")
    assert result.exit_code == 0, result.stderr
    assert "Checked by study.yaml" in result.stdout
    result = run("export", "by_hand.csv", "--to", "csv", "-o", "out")
    assert result.exit_code == 2
    assert "a run sheet has no study in it; name the study with --study" in result.stderr


def test_text_and_hash_changed_together_are_another_study(folder: Path, monkeypatch: Any) -> None:
    """Who changes both has another study: each command says by which one it judges."""

    def change(document: dict[str, Any]) -> None:
        text = document["study"]["text"] + "# mine\n"
        document["study"] |= {"text": text, "sha256": text_hash(text)}

    edit(folder, change)
    monkeypatch.chdir(folder)
    for reader in ("evaluate", "export by a study", "simulate", "report by a study"):
        (folder / "out").mkdir(exist_ok=True)
        end = ("-o", "out") if "export" in reader else ()
        end = ("-o", "out/m.csv") if reader == "simulate" else end
        result = run(*READERS[reader], *end)
        assert "note: edited.json was made from another version of the study" in result.stderr
    result = run(*READERS["export"], "-o", "out", "--force")
    assert "Checked by the study in edited.json" in result.stdout
    document = json.loads(run(*READERS["export"], "-o", "out", "--force", "--json").stdout)
    assert document["checked_by"]["file"] == "edited.json"


def test_what_another_plan_knew_is_said_beside_the_one_shown(tmp_path: Path) -> None:
    truth = '{"compliance": {"J2": {"value": 2e-6, "unit": "rad/(N.m)", "standard_error": 1e-8}}}'
    (tmp_path / "first.json").write_text(truth, encoding="utf-8")
    study, plain, knows = (tmp_path / n for n in ("study.yaml", "plain.json", "knows.json"))
    study.write_text(STUDY + "identify: [J1, J3]\n", encoding="utf-8")
    assert run("plan", study, "-o", plain).exit_code == 0
    assert run("plan", study, "--known", tmp_path / "first.json", "-o", knows).exit_code == 0
    out = tmp_path / "page.html"
    for shown, other, words in (
        (plain, knows, "knows.json was made by what first.json knows of J2; it is judged as if"),
        (knows, plain, "plain.json was made as if J2 did not bend; it is judged by what first"),
    ):
        result = run("report", shown, "--quick", "--vs", other, "-o", out, "--force")
        assert result.exit_code == 0, result.stderr
        assert words in result.stderr


def far_via_point(document: dict[str, Any]) -> None:
    document["via"] = [{"to": 2, "q_deg": {"J1": 0, "J2": 500, "J3": 0}}]


def test_what_must_not_be_run_is_said_where_it_is_shown(
    folder: Path, monkeypatch: Any, capsys: Any
) -> None:
    """A via point beyond a limit: refused as motion, and where the plan is only shown, said."""
    edit(folder, far_via_point)
    monkeypatch.chdir(folder)
    refused = run("export", "edited.json", "--to", "csv")
    assert refused.exit_code == 3
    sentence = refused.stderr.splitlines()[-1].removeprefix("error: edited.json: ")
    assert sentence.startswith("via point 1 from configuration 1 to configuration 2 breaks J2 <= ")
    shown = run("report", "edited.json", "--quick", "-o", "edited.html")
    assert shown.exit_code == 0
    assert f"note: edited.json must not be run: {sentence}" in shown.stderr
    page = visible((folder / "edited.html").read_text(encoding="utf-8"))
    assert "This plan breaks its constraints. Do not run it." in page
    assert "via point 1 from configuration 1 to configuration 2 breaks J2" in page
    _subject(read_study("study.yaml"), Path("edited.json"))
    assert f"note: edited.json must not be run: {sentence}" in capsys.readouterr().err
    _subject(read_study("study.yaml"), Path("plan.json"))
    assert "must not be run" not in capsys.readouterr().err


def test_a_prior_plan_with_other_load_cases_is_refused(folder: Path, monkeypatch: Any) -> None:
    """What is said to have been carried out is what was planned; else it is a run sheet."""

    def turned(document: dict[str, Any]) -> None:
        document["load_cases"][0]["q_deg"]["J2"] += 20.0

    edit(folder, turned)
    monkeypatch.chdir(folder)
    result = run("check", "prior.yaml")
    assert (result.exit_code, result.stdout) == (2, "")
    assert "prior plan: edited.json: has other load cases than it was written with" in result.stderr
    assert result.stderr.count("\n") == 1
