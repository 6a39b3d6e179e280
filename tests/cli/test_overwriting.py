"""Nothing is written over an input, nor over a file that elastocal did not write."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from elastocal.writing import kind_of, sealed, signature
from tests.cli.test_commands import STUDY, run

TRUTH = """\
{"elastocal": 1, "kind": "model", "compliance": {
"J1": {"value": 1e-6, "unit": "rad/(N.m)"}, "J2": {"value": 1e-6, "unit": "rad/(N.m)"},
"J3": {"value": 1e-6, "unit": "rad/(N.m)"}}}
"""
PATH = (
    "point,J1 [deg],J2 [deg],J3 [deg],Fx [N],Fy [N],Fz [N]\n1,0,60,-45,0,0,-9\n2,1,60,-45,0,0,-9\n"
)
WRITERS: dict[str, tuple[list[str], tuple[str, ...]]] = {  # arguments and what is written
    "init": (["init", "new.yaml"], ("new.yaml",)),
    "picture": (["check", "study.yaml", "--picture", "robot.svg"], ("robot.svg",)),
    "page": (["check", "study.yaml", "--picture", "robot.html"], ("robot.html",)),
    "plan": (["plan", "study.yaml", "-o", "p.json"], ("p.json", "p.csv")),
    "simulate": (
        ["simulate", "study.yaml", "plan.json", "--truth", "truth.json", "-o", "m.csv"],
        ("m.csv",),
    ),
    "campaigns": (
        [
            "simulate",
            "study.yaml",
            "plan.json",
            "--truth",
            "truth.json",
            "--campaigns",
            "5",
            "-o",
            "c.json",
            "--picture",
            "c.svg",
        ],
        ("c.json", "c.svg"),
    ),
    "identify": (["identify", "study.yaml", "measured.csv", "-o", "model.json"], ("model.json",)),
    "compensate": (
        ["compensate", "study.yaml", "truth.json", "path.csv", "-o", "out.csv"],
        ("out.csv",),
    ),
    "krl": (["export", "plan.json", "--to", "krl", "-o", "job.src"], ("job.src", "job.dat")),
    "rapid": (["export", "plan.json", "--to", "rapid", "-o", "job.mod"], ("job.mod",)),
    "fanuc": (["export", "plan.json", "--to", "fanuc", "-o", "JOB.ls"], ("JOB.ls",)),
    "ros": (["export", "plan.json", "--to", "ros", "-o", "job.yaml"], ("job.yaml",)),
    "csv": (["export", "plan.json", "--to", "csv", "-o", "job.csv"], ("job.csv",)),
    "report": (["report", "plan.json", "--quick", "-o", "r.html"], ("r.html",)),
}
EVERY = [(name, file) for name, (_, files) in WRITERS.items() for file in files]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign to write beside."""
    folder = tmp_path_factory.mktemp("made")
    for name, text in (("study.yaml", STUDY), ("truth.json", TRUTH), ("path.csv", PATH)):
        (folder / name).write_text(text, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert run("plan", "study.yaml").exit_code == 0
        done = run(*WRITERS["simulate"][0][:-1], "measured.csv")
        assert done.exit_code == 0, done.stderr
    return folder


@pytest.fixture
def campaign(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for file in made.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", WRITERS)
def test_what_a_command_wrote_it_writes_again(name: str, campaign: Path) -> None:
    arguments, files = WRITERS[name]
    for _ in range(2):
        result = run(*arguments)
        assert result.exit_code == 0, result.stderr
    assert all((campaign / file).is_file() for file in files)


@pytest.mark.parametrize(("name", "file"), EVERY)
def test_what_others_wrote_stays_unless_forced(name: str, file: str, campaign: Path) -> None:
    before = {path.name for path in campaign.iterdir()}
    out = campaign / file
    out.write_text("of mine\n", encoding="utf-8")
    result = run(*WRITERS[name][0])
    assert result.exit_code == 2
    assert f"{file}: exists already" in result.stderr
    assert "--force" in result.stderr
    assert {path.name for path in campaign.iterdir()} == before | {file}, "nothing is half written"
    assert out.read_text(encoding="utf-8") == "of mine\n"
    result = run(*WRITERS[name][0], "--force")
    assert result.exit_code == 0, result.stderr
    assert out.read_text(encoding="utf-8") != "of mine\n"


@pytest.mark.parametrize(
    ("name", "file"), [(n, f) for n, f in EVERY if n != "init" and not f.endswith(".json")]
)
def test_what_was_changed_by_hand_stays(name: str, file: str, campaign: Path) -> None:
    assert run(*WRITERS[name][0]).exit_code == 0
    out = campaign / file
    text = out.read_bytes()
    assert kind_of(text.decode("utf-8"))
    mine = text.replace(b"0", b"1", 1) if b"0" in text else text + b" "
    out.write_bytes(mine)
    result = run(*WRITERS[name][0])
    assert result.exit_code == 2
    assert out.read_bytes() == mine


def test_one_kind_of_ours_does_not_replace_another(campaign: Path) -> None:
    sheet = (campaign / "plan.csv").read_bytes()
    for arguments in (
        ["simulate", "study.yaml", "plan.json", "--truth", "truth.json", "-o", "plan.csv"],
        ["export", "plan.json", "--to", "csv", "-o", "plan.csv"],
        ["identify", "study.yaml", "measured.csv", "-o", "plan.json"],
    ):
        result = run(*arguments)
        assert result.exit_code == 2, arguments
        assert "exists already" in result.stderr
    assert (campaign / "plan.csv").read_bytes() == sheet


@pytest.mark.parametrize(
    "arguments",
    [
        ["export", "plan.json", "--to", "ros", "-o", "study.yaml"],
        ["export", "plan.json", "--to", "ros"],
        ["compensate", "study.yaml", "truth.json", "path.csv", "--to", "ros", "-o", "study.csv"],
    ],
)
def test_a_study_named_like_its_file_survives_the_export(
    arguments: list[str], campaign: Path
) -> None:
    text = f"name: study\n{STUDY}"
    (campaign / "study.yaml").write_text(text, encoding="utf-8")
    assert run("plan", "study.yaml").exit_code == 0
    result = run(*arguments)
    assert ("-o" in arguments and arguments[-1] == "study.yaml") == (result.exit_code == 2)
    assert (campaign / "study.yaml").read_text(encoding="utf-8") == text


@pytest.mark.parametrize("link", [os.link, os.symlink], ids=["hard link", "symbolic link"])
@pytest.mark.parametrize(
    ("read", "arguments"),
    [
        ("path.csv", ["compensate", "study.yaml", "truth.json", "path.csv", "-o", "in.csv"]),
        ("measured.csv", ["plan", "study.yaml", "--after", "measured.csv", "-o", "in.json"]),
        ("plan.json", ["identify", "study.yaml", "measured.csv", "--known", "plan.json",
                       "-o", "in.json"]),
        ("study.yaml", ["export", "plan.json", "--to", "ros", "--study", "study.yaml",
                        "-o", "in.yaml"]),
        ("plan.json", ["report", "plan.json", "-o", "in.html"]),
    ],
)  # fmt: skip
def test_inputs_are_never_written_over(
    read: str, arguments: list[str], link: Callable[..., None], campaign: Path
) -> None:
    text = (campaign / read).read_bytes()
    name = Path(arguments[-1]).with_suffix(".csv" if read == "measured.csv" else "").name
    link(campaign / read, campaign / (name if name != "in" else arguments[-1]))
    result = run(*arguments, "--force")
    assert result.exit_code == 2
    assert "would be written over the file it is made from" in result.stderr
    assert (campaign / read).read_bytes() == text


def test_the_demo_leaves_files_of_others_alone(tmp_path: Path) -> None:
    (tmp_path / "model.json").write_text(TRUTH, encoding="utf-8")
    result = run("demo", tmp_path)
    assert (result.exit_code, "model.json: exists already" in result.stderr) == (2, True)
    assert [path.name for path in tmp_path.iterdir()] == ["model.json"]


def test_a_signature_holds_for_the_text_it_was_made_for() -> None:
    text = sealed(f"a,b\n1,2,{signature('run sheet')}\n")
    assert kind_of(text) == "run sheet"
    assert sealed(text) == text
    for changed in (text.replace("1", "2", 1), text + " ", text.replace("\n", "\r\n"), "a,b\n"):
        assert kind_of(changed) == ""


def test_words_like_a_signature_do_no_harm() -> None:
    forged = signature("program")
    text = sealed(f"# study {forged}\n# {signature('run sheet')}\n")
    assert kind_of(text) == ""
    assert kind_of(sealed("# nothing of ours\n")) == ""


@pytest.mark.parametrize(
    "text",
    ["{", "{}", '{"made_by": 1, "kind": "plan"}', '{"kind": "plan"}', "{" * 100_000, "[1]", TRUTH],
)
def test_documents_that_we_did_not_write(text: str) -> None:
    assert kind_of(text) == ""
