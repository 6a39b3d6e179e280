"""Names of what is no ordinary file are refused at once, wherever a file can be named."""

from __future__ import annotations

import os
import signal
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

import pytest

from elastocal.errors import InputError
from elastocal.reading import bytes_of
from tests.cli.test_commands import STUDY, run
from tests.cli.test_overwriting import PATH, TRUTH

pytestmark = pytest.mark.skipif(os.name != "posix", reason="makes what POSIX has")


def _socket(path: Path) -> None:
    """Bound by a short name: addresses of sockets may not be long."""
    here = Path.cwd()
    os.chdir(path.parent)
    try:
        with socket.socket(socket.AF_UNIX) as end:
            end.bind(path.name)
    finally:
        os.chdir(here)


THINGS: dict[str, tuple[Callable[[Path], object], str]] = {  # made, and what is said of it
    "device": (lambda path: path.symlink_to("/dev/zero"), "is not an ordinary file"),
    "pipe": (os.mkfifo, "is not an ordinary file"),
    "socket": (_socket, "is not an ordinary file"),
    "folder": (Path.mkdir, "it is a folder"),
    "nothing": (lambda path: path.symlink_to("nowhere"), "no such file"),
    "circle": (lambda path: path.symlink_to(path.name), "Too many levels of symbolic links"),
}
URDF_STUDY = STUDY.replace("robot: three-link", "robot: {urdf: bad.urdf, packages: {p: bad}}")
ON_THE_COMMAND_LINE = {
    "study": ["check", "bad"],
    "plan": ["evaluate", "study.yaml", "bad.json"],
    "sheet": ["evaluate", "study.yaml", "bad.csv"],
    "exported": ["export", "bad.json", "--to", "krl"],
    "reported": ["report", "bad.json"],
    "viewed": ["view", "study.yaml", "--plan", "bad.json", "--no-browser", "--port", "18091"],
    "truth": ["simulate", "study.yaml", "sheet.csv", "--truth", "bad.json"],
    "measurements": ["identify", "study.yaml", "bad.csv"],
    "looked at": ["check", "study.yaml", "--measurements", "bad.csv"],
    "mapping": ["check", "study.yaml", "--measurements", "path.csv", "--mapping", "bad.yaml"],
    "known": ["plan", "study.yaml", "--known", "bad.json"],
    "after": ["plan", "study.yaml", "--after", "bad.csv"],
    "model": ["compensate", "study.yaml", "bad.json", "path.csv"],
    "path": ["compensate", "study.yaml", "truth.json", "bad.csv"],
    "judged path": ["evaluate", "study.yaml", "sheet.csv", "--path", "bad.csv"],
}
SHEET = (
    "configuration,J1 [deg],J2 [deg],J3 [deg],Fx [N],Fy [N],Fz [N],repeats\n1,0,60,-45,0,0,-9,3\n"
)
IN_A_STUDY = {  # what a study says, and the line of it
    "robot": (STUDY.replace("three-link", "{urdf: bad.urdf}"), 2),
    "xacro": (STUDY.replace("three-link", "{urdf: bad.xacro}"), 2),
    "included": (STUDY.replace("three-link", "{urdf: whole.xacro}"), 2),
    "prior": (f"{STUDY}prior: {{plan: bad.json}}\n", 8),
    "known": (f"{STUDY}known: bad.json\nidentify: [J1]\n", 8),
    "path": (STUDY.replace("q_deg: [0, 60, -45], force_N: [0, 290, -960]", "path: bad.csv"), 4),
    "mesh": (
        STUDY.replace("{coll", "{obstacles: [{name: box, mesh: bad.stl, mesh_unit: mm}], coll"),
        7,
    ),
}
XACRO = """\
<robot name="r" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:include filename="bad"/></robot>
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    files = {"study.yaml": STUDY, "truth.json": TRUTH, "path.csv": PATH, "sheet.csv": SHEET}
    for name, text in (files | {"whole.xacro": XACRO}).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(autouse=True)
def _at_once() -> Iterator[None]:
    """No test waits for what never comes."""

    def late(signum: int, frame: FrameType | None) -> None:
        raise AssertionError("waits")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(20)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def refused(folder: Path, *arguments: str) -> str:
    """What a command says that is refused, and leaves nothing behind."""
    before = {path.name for path in folder.iterdir()}
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    assert {path.name for path in folder.iterdir()} == before
    assert result.stderr.startswith("error: ")
    assert result.stderr.count("\n") == 1
    return str(result.stderr)


@pytest.mark.parametrize("thing", THINGS)
@pytest.mark.parametrize("what", ON_THE_COMMAND_LINE)
def test_no_ordinary_file_on_the_command_line(what: str, thing: str, folder: Path) -> None:
    arguments = ON_THE_COMMAND_LINE[what]
    bad = next(word for word in arguments if word.startswith("bad"))
    make, said = THINGS[thing]
    make(folder / bad)
    sentence = refused(folder, *arguments)
    assert bad in sentence
    assert said in sentence


@pytest.mark.parametrize("thing", THINGS)
@pytest.mark.parametrize("what", IN_A_STUDY)
def test_no_ordinary_file_in_a_study(what: str, thing: str, folder: Path) -> None:
    text, line = IN_A_STUDY[what]
    (folder / "study.yaml").write_text(text, encoding="utf-8")
    bad = next(b for b in ("bad.urdf", "bad.xacro", "bad.json", "bad.csv", "bad.stl", "bad")
               if b in text or b == "bad")  # fmt: skip
    make, said = THINGS[thing]
    make(folder / bad)
    sentence = refused(folder, "check", "study.yaml")
    assert f"study.yaml, line {line}: " in sentence
    if what == "included":
        pytest.importorskip("xacro")
        said = {"folder": "is not an ordinary file"}.get(thing, said)
    elif what in ("robot", "xacro") and thing in ("nothing", "circle"):
        said = "is not there"
    elif what == "mesh":
        said = {
            "device": "is outside the folder of the study", "circle": "is not the name of a file"
        }.get(thing, said)  # fmt: skip
    # What a circle of links is depends on the Python: to resolve it, or to open it, fails.
    assert any(words in sentence for words in (said, "No such file", "Too many levels"))


@pytest.mark.parametrize("name", ["a\\0.json", "x" * 300, "x" * 4097, "a/" * 2100])
@pytest.mark.parametrize("what", sorted(set(IN_A_STUDY) - {"included"}))
def test_names_that_no_file_can_have(what: str, name: str, folder: Path) -> None:
    text, line = IN_A_STUDY[what]
    for suffix in ("urdf", "xacro", "json", "csv", "stl"):
        text = text.replace(f"bad.{suffix}", f'"{name}.{suffix}"')
    (folder / "study.yaml").write_text(text, encoding="utf-8")
    assert f"study.yaml, line {line}: " in refused(folder, "check", "study.yaml")


@pytest.mark.parametrize("what", ON_THE_COMMAND_LINE)
def test_names_too_long_on_the_command_line(what: str, folder: Path) -> None:
    long = [w.replace("bad", "bad" * 100) for w in ON_THE_COMMAND_LINE[what]]
    assert "badbad" in refused(folder, *long)


def test_folders_of_packages(folder: Path) -> None:
    for name in ("nowhere", "x" * 300, "study.yaml"):
        text = STUDY.replace("three-link", f"{{urdf: a.urdf, packages: {{p: {name}}}}}")
        (folder / "a.urdf").write_text("<robot name='r'/>", encoding="utf-8")
        (folder / "study.yaml").write_text(text, encoding="utf-8")
        sentence = refused(folder, "check", "study.yaml")
        assert "study.yaml, line 2: " in sentence
        assert "does not exist" in sentence


def test_no_more_is_read_than_is_allowed(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"12345")
    assert bytes_of(file, 5) == b"12345"
    with pytest.raises(InputError, match=r"file: 5 bytes, more than the 4 that are read"):
        bytes_of(file, 4)


def test_a_file_system_that_says_nothing_of_sizes() -> None:
    """Files of /proc have the size 0."""
    endless = Path("/proc/self/maps")
    if not endless.exists():
        pytest.skip("no /proc")
    with pytest.raises(InputError, match="more than the 100 that are read"):
        bytes_of(endless, 100)


@pytest.mark.parametrize("name", ["a\0b", "\ud800"])
def test_names_that_only_python_can_have(name: str) -> None:
    with pytest.raises(InputError, match=r"not a file name|no such file"):
        bytes_of(Path(name), 10)
