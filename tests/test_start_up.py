"""What commands do not load before they need it: without timing, which is for the benchmarks."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from elastocal.cli import FAMILIES, app
from tests.campaigns import FIRST_STEP
from tests.test_examples import ROOT

STUDY = str(ROOT / "examples" / "kr270" / "study.yaml")
HEAVY = ("pydantic", "scipy", "rich", "jinja2", "plotly", "joblib", "coal", "importlib.metadata")
LOADED = """
import sys
from elastocal.__main__ import main

def loaded(*_, **__):
    print("loaded", *sys.modules)
    sys.exit(0)

{}
sys.argv = ["elastocal", *sys.argv[1:]]
try:
    main()
except SystemExit:
    loaded()
"""


def modules(*arguments: str, until: str = "") -> set[str]:
    """What is loaded when a command ends, or when it calls a function `module:name`."""
    module, _, name = until.partition(":")
    stop = f"import {module}; {module}.{name} = loaded" if until else ""
    code = [sys.executable, "-c", LOADED.format(stop), *arguments]
    said = subprocess.run(code, capture_output=True, text=True, check=True).stdout
    return set(said[said.index("loaded") :].split())


@pytest.mark.parametrize("arguments", [["--version"], ["--help"], ["plan", "--help"]])
def test_help_loads_nothing_heavy(arguments: list[str]) -> None:
    found = modules(*arguments)
    assert not found & {*HEAVY, "numpy", "yaml", "elastocal.arrays"}


@pytest.mark.parametrize(
    ("arguments", "until"),
    [
        (["plan", STUDY, "-o", "other.json"], "elastocal.planning.plan:plan"),
        (["check", STUDY], "elastocal.planning.study_check:check"),
    ],
)
def test_a_study_loads_what_it_names(arguments: list[str], until: str, tmp_path: Path) -> None:
    paths = [str(tmp_path / word) if word.endswith(".json") else word for word in arguments]
    found = modules(*paths, until=until)
    assert "elastocal.study.study" in found
    assert not found & set(HEAVY)
    readers = ("measurements.table", "models.model_file", "plans.proposal_file", "paths.path_file")
    assert not found & {f"elastocal.files.{reader}" for reader in readers}
    assert not found & {"elastocal.robot.sources.urdf", "elastocal.viewer", "elastocal.report"}


def test_identify_loads_no_planning_and_no_scipy(tmp_path: Path) -> None:
    """Both take longer to load than a campaign to fit."""
    study = tmp_path / "study.yaml"
    study.write_text(f"{FIRST_STEP}nuisance: typical\n", encoding="utf-8")
    names = ["J1 [deg]", "J2 [deg]", "J3 [deg]", "Fx [N]", "Fy [N]", "Fz [N]", "dx [mm]"]
    rows = [
        f"{10 * i},{40 - 5 * i},{20 * i - 70},0,0,-1000,{0.1 * i},0,{-1.5 - 0.1 * i}"
        for i in range(9)
    ]
    table = "\n".join([",".join([*names, "dy [mm]", "dz [mm]"]), *rows])
    (tmp_path / "m.csv").write_text(table, encoding="utf-8")
    files = [str(study), str(tmp_path / "m.csv"), "-o", str(tmp_path / "model.json")]
    found = modules("identify", *files)
    assert "elastocal.identification.candidates" in found
    assert not [name for name in found if name.startswith(("scipy", "elastocal.planning"))]


def test_a_command_loads_its_own_family_alone() -> None:
    found = modules("plan", "--help")
    others = {f"elastocal.cli.{family}" for family in FAMILIES} - {"elastocal.cli.plan"}
    assert not found & others
    assert {f"elastocal.cli.{family}" for family in FAMILIES} <= modules("--help")


def test_the_families_are_named_with_their_commands() -> None:
    found: dict[str, list[str]] = {family: [] for family in FAMILIES}
    for command in app.registered_commands:
        assert command.callback is not None
        assert command.name is not None
        found[command.callback.__module__.rpartition(".")[2]].append(command.name)
    assert {family: tuple(names) for family, names in found.items()} == FAMILIES
