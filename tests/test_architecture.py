"""The arrows of docs/architecture: outside looks in, never the reverse; and house rules."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import elastocal

SOURCE = Path(elastocal.__file__).parent
MODULES = sorted(SOURCE.rglob("*.py"))
OUTSIDE = {"io", "report", "viewer", "cli", "terminal", "__main__"}
# What the design core may use of the rest: array types. It knows no robot.
DESIGN_MAY_IMPORT = {"elastocal.arrays", "elastocal.errors", "elastocal.design"}
# Fitting neither; a matrix is scaled there as here.
FITTING_MAY_IMPORT = {"elastocal.arrays", "elastocal.errors", "elastocal.fitting"}
FITTING_MAY_IMPORT |= {"elastocal.design.criterion"}
GEOMETRY_MAY_NOT_IMPORT = {"elastocal.design", "elastocal.study", "elastocal.planning"}
LONGEST = 400


def name_of(path: Path) -> str:
    return path.relative_to(SOURCE).as_posix()


def room_of(path: Path) -> str:
    """First part of the path: the folder, or the module itself."""
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def imports(path: Path) -> set[str]:
    """Modules of the package that a file imports, wherever in the file."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"{path}: relative import"
            found.add(node.module)
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {name for name in found if name.split(".")[0] == "elastocal"}


def within(name: str, packages: set[str]) -> bool:
    return any(name == package or name.startswith(package + ".") for package in packages)


@pytest.mark.parametrize("path", [p for p in MODULES if room_of(p) not in OUTSIDE], ids=name_of)
def test_the_core_does_not_look_out(path: Path) -> None:
    outside = {f"elastocal.{room}" for room in OUTSIDE}
    assert not {name for name in imports(path) if within(name, outside)}


@pytest.mark.parametrize("path", sorted((SOURCE / "design").glob("*.py")), ids=name_of)
def test_the_design_core_knows_no_robot(path: Path) -> None:
    assert not {name for name in imports(path) if not within(name, DESIGN_MAY_IMPORT)}


@pytest.mark.parametrize("path", sorted((SOURCE / "fitting").glob("*.py")), ids=name_of)
def test_fitting_knows_no_robot(path: Path) -> None:
    assert not {name for name in imports(path) if not within(name, FITTING_MAY_IMPORT)}


@pytest.mark.parametrize(
    "path",
    [
        p
        for p in MODULES
        if room_of(p)
        in {
            "robot",
            "robots",
            "shapes",
            "coupling",
            "posture",
            "elastostatics",
            "load_case",
            "loads",
            "collision",
            "cell",
            "constraints",
        }
    ],
    ids=name_of,
)
def test_geometry_knows_nothing_of_planning(path: Path) -> None:
    assert not {name for name in imports(path) if within(name, GEOMETRY_MAY_NOT_IMPORT)}


def test_no_module_imports_the_test_tools() -> None:
    """Independent checks stay independent: they are no dependency of the package."""
    for path in MODULES:
        tree = ast.parse(path.read_text())
        roots = {
            alias.name.split(".")[0]
            for node in ast.walk(tree)
            if isinstance(node, ast.Import)
            for alias in node.names
        } | {
            (node.module or "").split(".")[0]
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom)
        }
        assert not roots & {"pinocchio", "cvxpy", "clarabel", "casadi", "hypothesis", "pytest"}


@pytest.mark.parametrize("path", [p for p in MODULES if room_of(p) != "cli"], ids=name_of)
def test_nothing_is_printed_outside_the_command_line(path: Path) -> None:
    calls = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)]
    assert not [
        call.lineno for call in calls if isinstance(call.func, ast.Name) and call.func.id == "print"
    ]


def undocumented(tree: ast.Module) -> list[str]:
    """Public functions, classes and methods without a docstring.

    A method that overrides one of a base class, and a method of a private class, inherits its
    meaning; they are told by having a base or a leading underscore.
    """
    missing = [] if ast.get_docstring(tree) else ["module"]
    for node in tree.body:
        if not isinstance(node, (ast.FunctionDef, ast.ClassDef)) or node.name.startswith("_"):
            continue
        if not ast.get_docstring(node):
            missing.append(node.name)
        if isinstance(node, ast.ClassDef) and not node.bases:
            missing += [
                f"{node.name}.{method.name}"
                for method in node.body
                if isinstance(method, ast.FunctionDef)
                and not method.name.startswith("_")
                and not ast.get_docstring(method)
            ]
    return missing


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_every_public_name_is_documented(path: Path) -> None:
    assert undocumented(ast.parse(path.read_text())) == []


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_files_stay_short(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= LONGEST
