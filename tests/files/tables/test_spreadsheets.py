"""No text that we write into a table is a formula for a spreadsheet, and all come back."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import elastocal as ec
from elastocal.design.exact import Effort
from elastocal.files.measurements.measurement_file import write_measurements
from elastocal.files.tables.numbers import plain
from elastocal.writing import inert, table_row
from tests.cli.test_commands import run

HOSTILE = (
    '=HYPERLINK("http://x")', "+1+1", "-1+1", "@SUM(A1)", "'quoted", "''", "＝1+1", "-", "=",
    "a;b", "a\tb", "# no comment", 'say "x", y', "a|b", "=1,2", "-1.5.5", "+a",
)  # fmt: skip
NUMBERS = ("-1", "+2.5", "-.5e-3", "0", "1e5", "-1.")
STARTS = tuple("=+-@\t\r＝＋－＠")


@pytest.mark.parametrize("text", HOSTILE)
def test_text_is_no_formula_and_comes_back(text: str) -> None:
    line = table_row(["before", text, "after"])
    assert not any(found.startswith(STARTS) for found in next(csv.reader([line])))
    assert [plain(found) for found in next(csv.reader([line]))] == ["before", text, "after"]


@pytest.mark.parametrize("text", NUMBERS)
def test_numbers_stay_numbers(text: str) -> None:
    assert table_row([text, float(text)]).startswith(f"{text},")


@given(st.lists(st.text(st.characters(exclude_categories=["Cc", "Cs", "Zl", "Zp"])), min_size=1))
def test_any_text_comes_back(texts: list[str]) -> None:
    texts = ["begin", *(text.strip() for text in texts)]
    back = next(csv.reader(io.StringIO(table_row(texts))), [""])
    assert [plain(found) for found in back] == texts
    assert not any(found.startswith(STARTS) for found in back if inert(found) != found)


def hostile(text: str) -> str:
    """A study whose joint, marker and study name would be formulas."""
    quoted = "'" + text.replace("'", "''") + "'"
    rows = "".join(
        f"    - {{joint: {quoted if i == 0 else f'J{i}'}, a_mm: 500, limits_deg: [-170, 170]}}\n"
        for i in range(3)
    )
    return f"""\
elastocal: 1
name: {quoted}
robot:
  convention: classic
  dh:
{rows}tools:
  tip: {{tcp_mm: [0, 0, 0], markers_mm: {{{quoted}: [0, 0, 0], M2: [10, 0, 0]}}}}
test_poses:
  - {{tool: tip, q_deg: [10, 20, 30], force_N: [0, 100, 0]}}
experiments: {{tool: tip, force_N: [50, 100, 0], count: 3}}
instrument: {{sigma_mm: 0.1}}
"""


@pytest.mark.parametrize("name", ['=HYPERLINK("x")', "+1+1", "-a", "=1,2"])
def test_every_table_that_we_write(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("study.yaml").write_text(hostile(name), encoding="utf-8")
    study = ec.read_study("study.yaml")
    cases = ec.LoadCases(np.zeros((1, 3)), np.array([[50.0, 100.0, 0, 0, 0, 0]]))
    truth = ec.ComplianceModel(study.springs, np.full(3, 1e-6))
    rng = np.random.default_rng(0)
    measured = ec.simulate(study, truth, cases, np.array([1]), rng)
    measured = replace(measured, names=(name,))
    write_measurements(measured, study.robot, "measured.csv")
    back = ec.read_measurements("measured.csv", study)
    assert back.names == (name,)
    assert back.tool.marker_names == (name, "M2")
    made = ec.plan(study, effort=Effort(batch=8, generations=1, islands=1))
    ec.write_plan(made, "plan.json")
    ec.write_run_sheet(made, "plan.csv")
    assert ec.read_proposal("plan.csv", study).count == 3
    assert run("export", "plan.json", "--to", "csv", "-o", "program.csv").exit_code == 0
    joints = [table_row([f"{joint} [deg]"]).strip() for joint in study.robot.joint_names]
    point = table_row([name]).strip()
    Path("path.csv").write_text(
        f"point,{','.join(joints)},Fx [N],Fy [N],Fz [N]\n{point},1,2,3,0,100,0\n", encoding="utf-8"
    )
    write = ec.write_model
    write(truth, "truth.json", study.robot)
    result = run("compensate", "study.yaml", "truth.json", "path.csv")
    assert result.exit_code == 0, result.stderr
    for file in ("measured.csv", "plan.csv", "program.csv", "corrected.csv"):
        text = Path(file).read_text(encoding="utf-8")
        for row in csv.reader(io.StringIO(text)):
            for found in row:
                number = found.lstrip("+-")[:1] in {*"0123456789."} and "+1" not in found
                assert number or not found.startswith(STARTS), (file, found)
    with Path("corrected.csv").open(encoding="utf-8") as table:
        row = next(csv.DictReader(table))
    assert plain(row["point"]) == name
