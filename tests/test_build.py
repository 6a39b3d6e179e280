"""What is built of the checkout: wheels with the compiled core and without, and the sources."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import sys
import sysconfig
import tarfile
from pathlib import Path
from zipfile import ZipFile

import pytest

from tests.compiling import BUILDER, COMPILERS, build, needs_compiler, needs_none, plain
from tests.test_examples import ROOT

SAID = "elastocal is built without compiled core, NumPy does its work: "


def package(folder: Path, kind: str, root: Path = ROOT, **more: str) -> tuple[Path, str]:
    """Build a wheel or an sdist; the file and what was said."""
    command = [sys.executable, "-m", "hatchling", "build", "--target", kind, "-d", str(folder)]
    done = subprocess.run(command, cwd=root, env=plain(**more), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (made,) = folder.iterdir()
    return made, done.stderr


def contents(wheel: Path) -> tuple[list[str], str]:
    """The libraries in a wheel, which has no sources, and the page that says for whom it is."""
    with ZipFile(wheel) as opened:
        names = opened.namelist()
        about = next(name for name in names if name.endswith(".dist-info/WHEEL"))
        assert "elastocal/core/library.py" in names
        assert not [name for name in names if name.endswith((".c", ".h"))]
        libraries = [n for n in names if Path(n).name.startswith("libcore.")]
        return libraries, opened.read(about).decode()


def checkout(folder: Path) -> Path:
    """A copy of what packages are built from."""
    for name in ("pyproject.toml", "README.md", "LICENSE", "hatch_build.py"):
        shutil.copy(ROOT / name, folder)
    left = shutil.ignore_patterns("__pycache__", "libcore.*")
    shutil.copytree(ROOT / "src" / "elastocal", folder / "src" / "elastocal", ignore=left)
    return folder


def edited(root: Path, **more: str) -> list[str]:
    """Install the copy as editable; the libraries that are there then."""
    code = "from hatchling.build import build_editable as build; print(build('.'))"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=root, env=plain(**more), capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip().endswith("-py3-none-any.whl")
    return [path.name for path in (root / "src" / "elastocal" / "core").glob("libcore.*")]


@needs_compiler
def test_a_wheel_has_the_library_and_works_elsewhere(tmp_path: Path) -> None:
    made, elsewhere = tmp_path / "made", tmp_path / "elsewhere"
    made.mkdir()
    wheel, said = package(made, "wheel")
    assert SAID not in said
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    if not platform.startswith("macosx"):  # where it says for how old a system
        assert wheel.name.endswith(f"-py3-none-{platform}.whl")
    (library,), about = contents(wheel)
    assert library.startswith("elastocal/core/libcore.")
    assert "Root-Is-Purelib: false" in about
    assert f"Tag: {wheel.stem.split('-', 2)[2]}" in about

    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps"]
    command += ["--disable-pip-version-check", "--target", str(elsewhere), str(wheel)]
    subprocess.run(command, env=plain(), check=True)
    code = "import elastocal.core.library as c; print(c.__file__, c.described(), sep='\\n')"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=plain(PYTHONPATH=str(elsewhere)),
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    where, described = done.stdout.splitlines()
    assert Path(where).is_relative_to(elsewhere)
    assert described.startswith("compiled core (")


@pytest.mark.parametrize(
    ("more", "why"),
    [
        pytest.param({"PATH": ""}, "there is no C compiler", marks=needs_none),
        ({"CC": "no-such-compiler -m64"}, "no-such-compiler cannot be run"),
        ({"CC": f'"{sys.executable}" -c 0/0'}, "the compiler refuses"),
        ({"ELASTOCAL_CORE": "numpy"}, "ELASTOCAL_CORE is numpy"),
    ],
    ids=["no compiler", "wrong name", "broken compiler", "not wanted"],
)
def test_without_compiler_the_wheel_is_for_every_machine(
    more: dict[str, str], why: str, tmp_path: Path
) -> None:
    wheel, said = package(tmp_path, "wheel", **more)
    assert f"{SAID}{why}" in said
    assert wheel.name.endswith("-py3-none-any.whl")
    libraries, about = contents(wheel)
    assert libraries == []
    assert "Root-Is-Purelib: true" in about


@needs_compiler
def test_an_editable_install_has_the_library_beside_its_sources(tmp_path: Path) -> None:
    """And none that its sources do not make any more; only the packages are without it."""
    root = checkout(tmp_path)
    (built,) = edited(root)
    assert edited(root, ELASTOCAL_CORE="numpy") == [built]  # left as it is

    (made := root / "dist").mkdir()
    wheel, _ = package(made, "wheel", root, ELASTOCAL_CORE="numpy")
    assert contents(wheel)[0] == []
    wheel.unlink()
    sources, _ = package(made, "sdist", root)
    with tarfile.open(sources) as opened:
        names = {Path(name).name for name in opened.getnames()}
    assert {"core.c", "export.h", "machine.c", "hatch_build.py"} <= names
    assert built not in names

    with (root / "src" / "elastocal" / "core" / "source" / "core.c").open("a") as core:
        core.write("wrong\n")
    assert edited(root) == []


@needs_compiler
@pytest.mark.parametrize("compiler", [name for name in COMPILERS if name != "cc"] or COMPILERS)
def test_every_compiler_makes_every_level(compiler: str, tmp_path: Path) -> None:
    done = build(tmp_path, CC=compiler, CFLAGS="-O0 -Wall -Wextra -Werror")
    assert done.returncode == 0, done.stderr
    (path,) = tmp_path.iterdir()
    assert done.stdout == f"{path}\n"
    loaded = ctypes.CDLL(str(path))
    assert loaded.core_version_baseline() > 0
    if sysconfig.get_platform().endswith(("x86_64", "amd64")):
        assert loaded.core_version_v3() == loaded.core_version_baseline()
        assert loaded.core_has_v3() in (0, 1)


@needs_compiler
def test_what_the_compiler_says_is_shown(tmp_path: Path) -> None:
    done = build(tmp_path, CFLAGS="-no-such-flag-at-all")
    assert done.returncode == 1
    assert "no-such-flag-at-all" in done.stderr
    assert SAID in done.stderr
    assert list(tmp_path.iterdir()) == []


PRETENDING = """
import sys
if "-E" in sys.argv:
    print(*("#define " + name + " 1" for name in {target}), sep="\\n")
else:
    open(sys.argv[sys.argv.index("-o") + 1], "w").write(" ".join(sys.argv))
"""


@pytest.mark.parametrize(
    ("target", "name", "levels"),
    [
        (("__linux__", "__aarch64__"), "libcore.so", 1),
        (("__APPLE__", "__aarch64__"), "libcore.dylib", 1),
        (("__APPLE__", "__x86_64__"), "libcore.dylib", 2),
        (("_WIN32", "__x86_64__"), "libcore.dll", 2),
    ],
)
def test_the_compiler_says_for_which_machine(
    target: tuple[str, ...], name: str, levels: int, tmp_path: Path
) -> None:
    """A compiler that only pretends, and writes down what it was asked for."""
    (tmp_path / "cc.py").write_text(PRETENDING.format(target=target), "utf-8")
    done = build(tmp_path / "made", CC=f'"{sys.executable}" "{tmp_path / "cc.py"}"')
    assert done.returncode == 0, done.stderr
    (made,) = (tmp_path / "made").iterdir()
    assert made.name == name
    linked = made.read_text("utf-8").split()
    assert [word for word in linked if word.endswith(".o")][1:] == [
        word for word in linked if word.endswith(("baseline.o", "v3.o"))
    ]
    assert (
        sum(word.endswith(("baseline.o", "v3.o")) for word in linked) == 2 * levels
    )  # core.c and boxes.c


@needs_compiler
def test_the_builder_needs_nothing_installed(tmp_path: Path) -> None:
    """`make` compiles before it installs."""
    command = [sys.executable, "-S", str(BUILDER), str(tmp_path)]
    done = subprocess.run(command, env=plain(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
