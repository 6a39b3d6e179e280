"""Which library of the core is used, and what is said about it."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from elastocal.cli import app
from elastocal.core import library as core
from elastocal.errors import InputError
from tests.compiling import BUILDER, build, needs_compiler
from tests.test_examples import ROOT

SOURCE = ROOT / "src" / "elastocal" / "core" / "source"


def forget() -> None:
    """What was found is looked for again."""
    core._found.cache_clear()
    core._chosen.cache_clear()


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a library."""
    folder = tmp_path_factory.mktemp("core")
    done = build(folder)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The library is looked for in an empty folder, and nobody wishes for one."""
    monkeypatch.delenv(core.SWITCH, raising=False)
    monkeypatch.setattr(core, "FOLDER", tmp_path)
    forget()
    yield
    forget()


@needs_compiler
@pytest.mark.skipif(os.environ.get(core.SWITCH) == "numpy", reason="it is switched off")
def test_this_checkout_has_its_library() -> None:
    """Else what is tested is not what is written; `make` sees to it."""
    folder = Path(core.__file__).parent
    built = [path.stat().st_mtime for path in folder.glob("libcore.*")]
    newest = max(path.stat().st_mtime for path in (folder / "source").iterdir())
    assert built, "not compiled: python hatch_build.py"
    assert min(built) >= newest, "older than its sources: python hatch_build.py"


def said() -> str:
    """What `--version` says."""
    result = CliRunner().invoke(app, ["--version"])
    assert result.exit_code == 0, result.stderr
    return result.stdout.strip()


@needs_compiler
def test_the_widest_level_of_this_machine_is_used(
    built: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(core, "FOLDER", built)
    used = core.library()
    assert used is not None
    assert used is core.library()
    assert used.level == list(core.levels())[-1]
    assert list(core.levels()) in (["baseline"], ["baseline", "v3"])
    assert {level: found.lanes for level, found in core.levels().items()}.items() <= (
        {"baseline": 2, "v3": 4}.items()
    )
    assert said().endswith(f", {core.described()}")
    assert core.described().startswith("compiled core (")


@needs_compiler
@pytest.mark.skipif(not Path("/proc/cpuinfo").exists(), reason="only Linux says it in a file")
def test_the_machine_is_asked_what_it_can_do(built: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(core, "FOLDER", built)
    flags = set(Path("/proc/cpuinfo").read_text("utf-8").split())
    assert ("v3" in core.levels()) == ({"avx2", "fma", "bmi2"} <= flags)


@needs_compiler
@pytest.mark.parametrize("level", ["baseline", "v3"])
def test_a_level_can_be_asked_for(level: str, built: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(core, "FOLDER", built)
    monkeypatch.setenv(core.SWITCH, level)
    if level not in core.levels():
        pytest.skip("not on this machine")
    used = core.library()
    assert used is not None
    assert used.level == level
    assert used.function("core_version")() == core.VERSION
    with pytest.raises(AttributeError, match=f"no_such_thing_{level}"):
        used.function("no_such_thing")


@needs_compiler
def test_it_can_be_switched_off(built: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(core, "FOLDER", built)
    monkeypatch.setenv(core.SWITCH, "numpy")
    assert core.library() is None
    assert said().endswith("without compiled core: NumPy (ELASTOCAL_CORE is numpy)")


def test_without_library_numpy_does_the_work() -> None:
    assert core.library() is None
    assert core.levels() == {}
    assert said().endswith("without compiled core: NumPy (none was built)")


@needs_compiler
def test_a_library_of_other_sources_is_not_used(
    built: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(core, "FOLDER", built)
    monkeypatch.setattr(core, "VERSION", core.VERSION + 1)
    assert core.library() is None
    assert said().endswith("without compiled core: NumPy (the one built is out of date)")
    monkeypatch.setenv(core.SWITCH, "baseline")
    with pytest.raises(InputError, match="cannot be used here: the one built is out of date"):
        core.library()


def test_what_cannot_be_loaded_is_not_used(tmp_path: Path) -> None:
    (tmp_path / "libcore.so").write_bytes(b"not a library")
    assert core.library() is None
    assert "NumPy (the one built cannot be loaded: " in said()


@pytest.mark.parametrize(
    ("wish", "complaint"),
    [
        ("fast", "error: ELASTOCAL_CORE is 'fast', expected numpy, baseline or v3\n"),
        ("v3", "error: ELASTOCAL_CORE is 'v3', which cannot be used here: none was built\n"),
    ],
)
def test_a_wish_that_cannot_be_had_is_bad_input(
    wish: str, complaint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(core.SWITCH, wish)
    result = CliRunner().invoke(app, ["--version"])
    assert result.exit_code == 2
    assert result.stderr == complaint
    assert result.stdout == ""


@needs_compiler
def test_a_machine_without_the_instructions_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same library where `machine.c` answers no."""
    source = tmp_path / "src" / "elastocal" / "core" / "source"
    shutil.copytree(SOURCE, source)
    machine = (source / "machine.c").read_text("utf-8")
    assert '__builtin_cpu_supports("avx2")' in machine
    (source / "machine.c").write_text(machine.replace('__builtin_cpu_supports("avx2")', "0"))
    shutil.copy(BUILDER, tmp_path)
    assert build(tmp_path, builder=tmp_path / BUILDER.name).returncode == 0
    used = core.library()
    assert used is not None
    assert used.level == "baseline"
    assert said().endswith("compiled core (baseline)")
    monkeypatch.setenv(core.SWITCH, "v3")
    with pytest.raises(InputError, match="this machine does not have its instructions"):
        core.library()
