"""`--prove`: what is proved is said, kept and found again; what cannot be proved is refused."""

from __future__ import annotations

import hashlib
import json
import signal
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastocal.cli.planning as planning
import elastocal.cli.proving as proving
from elastocal.cli.view import _subject
from elastocal.core.library import library
from elastocal.errors import InputError
from elastocal.files.plans.plan_file import read_plan
from elastocal.files.study.study_file import read_study
from elastocal.planning.assessment import assess
from elastocal.planning.certificate import Bound, lower_bound
from elastocal.planning.plan import Plan
from elastocal.proof import prove as engine
from elastocal.proof.posing import refuse
from elastocal.viewer.readout_html import heading_html
from tests.calibration.test_absolute_plan import STUDY as ABSOLUTE
from tests.cli.test_commands import STUDY, run
from tests.proof.bounds import bound_by_chance
from tests.report.examples import visible

compiled = pytest.mark.skipif(library() is None, reason="proofs need the compiled core")


MADE: list[Plan] = []


def _made(plan: Callable[..., Plan]) -> Callable[..., Plan]:
    """What plans, and keeps it: the same plan will do for all tests."""

    def planned(*args: Any, **options: Any) -> Plan:
        MADE.append(plan(*args, **options))
        return MADE[-1]

    return planned


@pytest.fixture(scope="module")
def proved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a study, its plan and its proof."""
    folder = tmp_path_factory.mktemp("proved")
    (folder / "study.yaml").write_text(STUDY, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(planning, "plan", _made(planning.plan))
        result = run("plan", folder / "study.yaml", "-o", folder / "plan.json", "--prove")
    assert result.exit_code == 0, result.stderr
    (folder / "stdout").write_text(result.stdout, encoding="utf-8")
    (folder / "stderr").write_text(result.stderr, encoding="utf-8")
    return folder


@pytest.fixture
def folder(proved: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A copy of it; Ctrl-C works, also where tests run in the background."""
    for file in proved.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    monkeypatch.setattr(planning, "plan", lambda *_, **__: MADE[0])
    monkeypatch.chdir(tmp_path)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield tmp_path
    signal.signal(signal.SIGINT, before)


def section(folder: Path, name: str = "plan.json") -> dict[str, Any]:
    document = json.loads((folder / name).read_text(encoding="utf-8"))
    found: dict[str, Any] = document["certificate"]
    return found


@compiled
def test_a_proof_is_made_and_kept(folder: Path) -> None:
    found, data = section(folder), (folder / "plan.proof").read_bytes()
    assert found["kind"] == "rigorous"
    assert found["proved"]["record"] == "plan.proof"
    assert found["proved"]["sha256"] == hashlib.sha256(data).hexdigest()
    assert found["proved"]["ended"] == "reached"
    assert found["proved"]["left_out"] == []
    bound, numerical = found["proved"]["lower_bound_mm"], found["rho0_lower_bound_mm"]
    assert (1.0 - 1.1e-4) * numerical < bound <= numerical
    said = " ".join((folder / "stdout").read_text(encoding="utf-8").split())
    assert "Rigorous certificate: no plan of 3 experiments has ρ0 below" in said
    assert "By the search, which proves nothing: no plan of 3 experiments" in said
    assert "plan.json, " in said
    assert said.endswith("plan.proof")
    told = (folder / "stderr").read_text(encoding="utf-8").splitlines()
    assert told[0].startswith(("the proof takes", "how long the proof takes"))
    assert told[-1].startswith("proved: no plan of 3 experiments has ρ0 below")
    assert told[-1].endswith(": 0.01 %")
    again = read_plan(folder / "plan.json")
    assert again.certificate.kind == "rigorous"


@compiled
def test_a_proof_is_gone_on_with(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "plan.proof").unlink()
    assert run("plan", "study.yaml", "--prove", "--prove-gap", "10").exit_code == 0
    first = section(folder)["proved"]
    given: list[Any] = []
    usual = engine.prove

    def prove(*args: Any, resumed: Any, **options: Any) -> Any:
        given.append(resumed)
        return usual(*args, resumed=resumed, **options)

    monkeypatch.setattr(engine, "prove", prove)
    assert run("plan", "study.yaml", "--prove").exit_code == 0
    assert given[0] is not None
    second = section(folder)["proved"]
    assert first["gap"] > 0.01
    assert second["gap"] < 1.1e-4
    assert run("plan", "study.yaml", "--prove", "--force").exit_code == 0
    assert given[1] is None
    assert section(folder)["proved"]["lower_bound_mm"] == pytest.approx(second["lower_bound_mm"])


@compiled
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("other.yaml",), "is the proof of another study, 'study'; choose another file"),
        (("study.yaml", "--count", "5"), "is a proof of 3 experiments by test-pose"),
        (("study.yaml", "--criterion", "A"), "is a proof of 3 experiments by test-pose"),
        (("study.yaml", "--proof", "study.yaml"), "study.yaml: would be written over"),
        (("study.yaml", "--proof", "notes.txt"), "notes.txt: not the record of a proof"),
        (("study.yaml", "--proof", "no/plan.proof"), "the folder no does not exist"),
        (("study.yaml", "--criterion", "D"), "the study plans for D"),
    ],
)
def test_what_is_refused_before_any_work(
    folder: Path, options: tuple[str, ...], words: str
) -> None:
    (folder / "other.yaml").write_text(STUDY.replace("0.1", "0.2"), encoding="utf-8")
    (folder / "notes.txt").write_text("mine", encoding="utf-8")
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    result = run("plan", *options, "--prove")
    assert result.exit_code == 2, result.stdout
    assert words in result.stderr
    assert result.stdout == ""
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before


def test_a_record_needs_a_proof(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text(STUDY, encoding="utf-8")
    for command in ("plan", "evaluate"):
        more = ["plan.json"] if command == "evaluate" else []
        result = run(command, tmp_path / "study.yaml", *more, "--proof", "x.proof")
        assert result.exit_code == 2
        assert "--proof belongs to --prove" in result.stderr


def test_without_the_compiled_core_nothing_is_proved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "study.yaml").write_text(STUDY, encoding="utf-8")
    monkeypatch.setattr(proving, "library", lambda: None)
    monkeypatch.chdir(tmp_path)
    result = run("plan", "study.yaml", "--prove")
    assert result.exit_code == 2
    assert "--prove needs the compiled core" in result.stderr
    assert sorted(file.name for file in tmp_path.iterdir()) == ["study.yaml"]


@compiled
def test_no_time_proves_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """But what it came to is kept."""
    (folder / "plan.proof").unlink()
    usual = engine.prove

    def prove(*args: Any, seconds: float, **options: Any) -> Any:
        assert seconds == 0.5
        found = usual(*args, **options)
        nothing = replace(found.statement, largest=None, rho0=None)
        return replace(found, statement=nothing, loss=0.0, ended="time")

    monkeypatch.setattr(engine, "prove", prove)
    result = run("plan", "study.yaml", "--prove", "--prove-seconds", "0.5")
    assert result.exit_code == 0, result.stderr
    assert "note: nothing is proved: the time was over" in result.stderr
    assert section(folder)["kind"] == "numerical"
    assert "proved" not in section(folder)
    assert "Rigorous" not in result.stdout
    assert (folder / "plan.proof").exists()


@compiled
def test_ctrl_c_keeps_what_is_proved(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "plan.proof").unlink()
    usual = engine.prove

    def prove(*args: Any, stop: Any, progress: Any, **options: Any) -> Any:
        stop()
        signal.raise_signal(signal.SIGINT)
        assert stop()
        return replace(usual(*args, progress=progress, **options), ended="stopped")

    monkeypatch.setattr(engine, "prove", prove)
    result = run("plan", "study.yaml", "--prove")
    assert result.exit_code == 0, result.stderr
    assert section(folder)["proved"]["ended"] == "stopped"
    assert "it ended when it was stopped" in " ".join(result.stdout.split())
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@compiled
def test_what_is_saved_on_the_way_can_be_gone_on_with(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "plan.proof").unlink()
    monkeypatch.setattr(engine, "_KEEP", 0.0)
    kept: list[bytes] = []
    usual = proving.write_bytes

    def write(path: Path, data: bytes) -> None:
        usual(path, data)
        kept.append(data)
        if len(kept) == 1:
            raise KeyboardInterrupt

    monkeypatch.setattr(proving, "write_bytes", write)
    stopped = run("plan", "study.yaml", "--prove", "--prove-gap", "0.001")
    assert stopped.exit_code == 130
    assert "plan.json, " in stopped.stderr
    assert kept == [(folder / "plan.proof").read_bytes()]
    assert run("plan", "study.yaml", "--prove", "--prove-gap", "0.001").exit_code == 0
    assert section(folder)["proved"]["gap"] < 1.1e-5


@compiled
def test_evaluate_proves_for_itself(folder: Path) -> None:
    result = run("evaluate", "study.yaml", "plan.json", "--prove", "--random", "0")
    assert result.exit_code == 0, result.stderr
    said = " ".join(result.stdout.split())
    assert "plan.json: Rigorous certificate: no plan of 3 experiments has ρ0 below" in said
    assert "its record plan.proof is of this study" in said
    assert (folder / "plan.evaluated.proof").exists()
    again = run("evaluate", "study.yaml", "plan.csv", "--prove", "--random", "0", "--json")
    assert again.exit_code == 0, again.stderr
    document = json.loads(again.stdout)["plan.csv"]
    assert document["certificate"] == "rigorous"
    assert document["proved"]["lower_bound_mm"] == pytest.approx(
        section(folder)["proved"]["lower_bound_mm"], rel=3e-4
    )


@compiled
def test_several_proofs_are_not_one_file(folder: Path) -> None:
    document = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    twice = {k: document[k] for k in ("elastocal", "kind", "load_cases", "criterion")}
    twice["load_cases"] = [case | {"repeats": 2} for case in document["load_cases"]]
    (folder / "twice.json").write_text(json.dumps(twice), encoding="utf-8")
    plans = ("study.yaml", "plan.json", "twice.json")
    result = run("evaluate", *plans, "--prove", "--proof", "one.proof", "--random", "0")
    assert result.exit_code == 2
    assert "--proof names one file, and these plans need several proofs" in result.stderr


@compiled
def test_evaluate_refuses_a_proof_that_cannot_be(folder: Path) -> None:
    document = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    known = document["certificate"]["proved"]
    for key in ("lower_bound_mm", "reachable_mm"):
        known[key] *= 1.001
    (folder / "plan.json").write_text(json.dumps(document), encoding="utf-8")
    result = run("evaluate", "study.yaml", "plan.json", "--random", "0")
    assert result.exit_code == 2
    assert "it claims as proved that no plan is better than" in result.stderr
    assert "does not count" in " ".join(result.stdout.split())


@compiled
def test_a_bound_that_is_refuted_is_made_again(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One whose gradient is of load cases by chance; the plan is three of these."""
    good = read_plan(folder / "plan.json")
    study, bound = good.study, bound_by_chance(good.study)
    assert bound.design is not None
    cases, repeats = study.space.load_cases(bound.design.x[:3]), np.ones(3, np.int64)
    poor = replace(good, load_cases=cases, repeats=repeats, bound=bound)
    poor = replace(poor, assessment=assess(study, cases, repeats))
    how = proving.Proving(30.0, 1e-3, folder / "other.proof")
    replanned: list[Bound] = []

    def again(better: Bound) -> Plan:
        replanned.append(better)
        return good

    found = proving.proved_plan(poor, folder / "other.json", how, again)
    told = capsys.readouterr().err
    assert "note: the proof found a load case that refutes the numerical bound" in told
    assert len(replanned) == 1
    assert found.load_cases is good.load_cases
    true = lower_bound(study, np.random.default_rng(0)).loss(3)
    assert found.certificate.lower_bound == pytest.approx(true, rel=1e-4)
    assert found.certificate.proved is not None
    assert found.certificate.proved.loss <= true
    assert found.certificate.gap < 1.2e-3
    assert found.certificate.kind == "rigorous"
    assert section(folder, "other.json")["proved"]["record"] == "other.proof"
    kept = proving.proved_plan(poor, folder / "other.json", replace(how, force=True))
    assert kept.load_cases is poor.load_cases
    assert kept.certificate.lower_bound == pytest.approx(true, rel=1e-4)


@compiled
def test_report_and_view_count_a_record_that_is_there(folder: Path) -> None:
    page = folder / "report.html"
    assert run("report", "plan.json", "--quick", "--seed", "3").exit_code == 0
    said = visible(page.read_text(encoding="utf-8"))
    for words in (
        "Rigorous certificate: a bound is proved",
        "Proved bound",
        "its boxes were not bounded again",
        "python -m elastocal.proof.check_proof plan.proof",
    ):
        assert words in said
    study = read_study(folder / "study.yaml")
    shown = _subject(study, folder / "plan.json").certificate
    assert shown.startswith("Rigorous certificate, by its record plan.proof: no better plan than")
    assert "Rigorous certificate" in heading_html(_subject(study, folder / "plan.json"), [])
    (folder / "plan.proof").unlink()
    result = run("report", "plan.json", "--quick")
    assert result.exit_code == 0
    assert "note: plan.json: it claims a proof whose record plan.proof is not beside" in (
        result.stderr
    )
    assert "Rigorous" not in visible(page.read_text(encoding="utf-8"))
    assert _subject(study, folder / "plan.json").certificate.startswith("Numerical certificate")


def test_absolute_readings_are_refused(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text(ABSOLUTE, encoding="utf-8")
    study = read_study(tmp_path / "study.yaml")
    with pytest.raises(InputError, match="of absolute readings there is no proof"):
        refuse(study, study.space)
