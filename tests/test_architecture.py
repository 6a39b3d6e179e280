"""The house: which room may import which, and house rules that hold in all of them.

`MAY_IMPORT` is the one table; `docs/architecture.md` shows the same, with a door sign for every
room, which is the first line of its `__init__`.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

import elastocal
from elastocal.cli import FAMILIES
from tests.test_examples import ROOT

SOURCE = Path(elastocal.__file__).parent
MODULES = sorted(SOURCE.rglob("*.py"))
LONGEST = 400

GROUND = (
    "arrays",
    "cores",
    "errors",
    "matrices",
    "names",
    "reading",
    "squares",
    "stopping",
    "writing",
)
# Rooms in import order, with the rooms above that each may import besides the ground floor.
MAY_IMPORT = {
    "core": "none",
    "wording": "none",
    "robot": "wording",
    "elastic": "robot",
    "constraints": "wording robot",
    "measuring": "robot elastic",
    "design": "none",
    "fitting": "none",
    "identification": "wording robot elastic measuring fitting",
    "calibration": "wording robot elastic measuring fitting",
    "compensation": "robot elastic calibration",
    "motion": "wording robot elastic constraints",
    "study": "core wording robot elastic constraints measuring calibration design motion",
    "planning": "all but compensation",
    "proof": "core wording robot elastic constraints measuring design study planning",
    "simulation": "robot elastic measuring fitting identification study planning",
    "programs": "wording robot elastic constraints study motion planning",
    "drawing": "wording robot elastic constraints study planning",
    "files": "all but programs drawing",
    "report": "all but design fitting programs files",
    "viewer": "wording robot elastic constraints measuring study planning drawing",
    "terminal": "all but design fitting report viewer",
    "cli": "all",
}


def may_import(room: str) -> set[str]:
    """The rooms that `room` may import."""
    words, order = MAY_IMPORT[room].split(), list(MAY_IMPORT)
    above = set(order[: order.index(room)])
    if words[0] == "all":
        assert set(words[2:]) <= above, f"{room}: what is excluded is not above it"
        return above - set(words[2:])
    assert words == ["none"] or set(words) <= above, f"{room}: imports what is not above it"
    return set(words) & above


def name_of(path: Path) -> str:
    return path.relative_to(SOURCE).as_posix()


def room_of(path: Path) -> str:
    """First part of the path: the folder, or the module itself."""
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def module_of(path: Path) -> str:
    return ".".join(("elastocal", *path.relative_to(SOURCE).with_suffix("").parts)).removesuffix(
        ".__init__"
    )


BY_NAME = {module_of(path): path for path in MODULES}
TREES = {path: ast.parse(path.read_text("utf-8")) for path in MODULES}


def imports(path: Path) -> set[str]:
    """Modules of the package that a file imports, wherever in the file."""
    found = set()
    for node in ast.walk(TREES[path]):
        if isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"{path}: relative import"
            longer = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name if name in BY_NAME else node.module for name in longer}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {name for name in found if name in BY_NAME} - {"elastocal"}


def test_only_rooms_and_the_ground_floor_stand_in_the_root() -> None:
    files = {path.stem for path in SOURCE.glob("*.py")} - {"__init__", "__main__"}
    assert files <= set(GROUND)
    rooms = {path.parent.name for path in SOURCE.glob("*/__init__.py")}
    assert rooms == set(MAY_IMPORT)
    assert all((path.parent / "__init__.py").exists() for path in MODULES)


def test_a_file_imports_what_its_room_may() -> None:
    wrong = {}
    for path in MODULES:
        room = room_of(path)
        if room in ("__init__", "__main__"):
            continue
        allowed = set(GROUND) | (set() if room in GROUND else {room} | may_import(room))
        if beyond := {name for name in imports(path) if name.split(".")[1] not in allowed}:
            wrong[name_of(path)] = beyond
    assert wrong == {}


def test_no_files_import_each_other_in_a_circle() -> None:
    """Also not for types alone: what is under TYPE_CHECKING counts."""
    left = {name: imports(path) - {name} for name, path in BY_NAME.items()}
    while ready := [name for name, needed in left.items() if not needed & left.keys()]:
        for name in ready:
            del left[name]
    assert not left, f"among {', '.join(sorted(left))}"


def test_commands_do_not_import_each_other() -> None:
    commands = {f"elastocal.cli.{family}" for family in FAMILIES}
    for name in commands:
        assert not imports(BY_NAME[name]) & commands - {name}


def test_the_documented_rooms_are_these() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    rows = re.findall(r"^\| `(\w+)/` \| (.*?) \| (.*?) \|$", page, flags=re.MULTILINE)
    assert {name: rooms for name, _, rooms in rows} == MAY_IMPORT
    assert [name for name, _, _ in rows] == list(MAY_IMPORT)
    for name, sign, _ in rows:
        docstring = ast.get_docstring(TREES[SOURCE / name / "__init__.py"])
        assert docstring is not None
        assert docstring.splitlines()[0] == sign, name


def roots_of(tree: ast.Module) -> set[str]:
    """Packages that a file imports."""
    nodes = list(ast.walk(tree))
    names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    names += [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
    return {name.split(".")[0] for name in names}


def test_no_module_imports_the_test_tools() -> None:
    """Independent checks stay independent: they are no dependency of the package."""
    tools = {"pinocchio", "cvxpy", "clarabel", "casadi", "hypothesis", "pytest"}
    assert [name_of(path) for path, tree in TREES.items() if roots_of(tree) & tools] == []


def prints(tree: ast.Module) -> bool:
    calls = [node.func for node in ast.walk(tree) if isinstance(node, ast.Call)]
    return any(isinstance(called, ast.Name) and called.id == "print" for called in calls)


def test_nothing_is_printed_outside_the_command_line() -> None:
    loud = {room_of(path) for path, tree in TREES.items() if prints(tree)}
    assert loud <= {"cli"}


SHOWING = ("wording", "drawing", "report", "viewer", "terminal")


def computed(tree: ast.Module) -> set[str]:
    """Random numbers, distributions, linear algebra: all but lengths and outlines."""
    used = {ast.unparse(node) for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    numeric = {name for name in used if re.fullmatch(r"np\.(random|linalg)\.\w+", name)}
    modules = {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    scipy = {name for name in modules if name.startswith("scipy")}
    return (numeric | scipy) - {"np.linalg.norm", "scipy.spatial"}


def test_what_shows_values_computes_none() -> None:
    found = {name_of(p): computed(tree) for p, tree in TREES.items() if room_of(p) in SHOWING}
    assert {name: what for name, what in found.items() if what} == {}


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


def test_every_public_name_is_documented() -> None:
    missing = {name_of(path): undocumented(tree) for path, tree in TREES.items()}
    assert {name: names for name, names in missing.items() if names} == {}


def test_files_stay_short() -> None:
    lengths = {name_of(path): len(path.read_text("utf-8").splitlines()) for path in MODULES}
    assert {name: lines for name, lines in lengths.items() if lines > LONGEST} == {}


def test_every_class_has_a_name_of_its_own() -> None:
    places: dict[str, list[str]] = {}
    for path, tree in TREES.items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name, []).append(name_of(path))
    assert {name: files for name, files in places.items() if len(files) > 1} == {}


def test_values_are_frozen() -> None:
    """Every dataclass, but for those that are filled while something is read or runs."""
    filled = {"Node", "Urdf", "Batch"}
    loose = {
        node.name
        for tree in TREES.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        for mark in map(ast.unparse, node.decorator_list)
        if mark.startswith("dataclass") and "frozen=True" not in mark
    }
    assert loose == filled
