"""The published plans as files: `evaluate` says of them what docs/validation.md does."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import elastocal as ec
from elastocal.cli import app
from tests.paper.published import TABLE_2, TABLE_5, TABLE_6, TABLE_7, Table2Row

EXAMPLES = Path(__file__).parents[2] / "examples"
THREE_LINK, KR270 = EXAMPLES / "three-link", EXAMPLES / "kr270"


def evaluated(study: Path, *plans: Path) -> dict[str, Any]:
    """What `evaluate --json` says, by the names of the files."""
    words = ["evaluate", str(study), *map(str, plans), "--random", "0", "--json"]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    found: dict[str, Any] = json.loads(result.stdout)
    return found


def file_of(row: Table2Row) -> str:
    times = f"-times-{row.repeats}" if row.repeats > 1 else ""
    return f"{row.name.lower()}{times}.csv"


def test_table_2() -> None:
    """ρ0²/σ² and δk F/σ, for σ = 0.1 mm and F = 1000 N."""
    files = sorted((THREE_LINK / "published").glob("*.csv"))
    assert {file.name for file in files} == {file_of(row) for row in TABLE_2}
    found = evaluated(THREE_LINK / "study.yaml", *files)
    for row in TABLE_2:
        one = found[file_of(row)]
        assert one["accepted"]
        assert (one["rho0_mm"] / 0.1) ** 2 == pytest.approx(row.rho0_squared, abs=0.006)
        errors = np.array(one["standard_error"]) * 1000.0 / 1e-4
        assert errors == pytest.approx(row.errors, abs=0.007)
    test = found["test.csv"]
    assert (test["rho0_mm"] / 0.1) ** 2 == pytest.approx(3.0, abs=1e-4)
    assert test["efficiency"] == pytest.approx(1.475493 / 3.0, abs=1e-4)


def test_table_2_files_are_the_repaired_rows() -> None:
    study = ec.read_study(THREE_LINK / "study.yaml")
    for row in TABLE_2:
        plan = ec.read_proposal(THREE_LINK / "published" / file_of(row), study)
        q2, q3, alpha = np.array(row.configurations).T
        q = np.stack([0.0 * q2, q2, q3], axis=1)
        np.testing.assert_allclose(plan.load_cases.q, np.radians(q), atol=1e-12)
        sides = np.stack([np.sin(np.radians(alpha)), np.cos(np.radians(alpha))], axis=1)
        force = sides if row.from_z else sides[:, ::-1]
        np.testing.assert_allclose(plan.load_cases.wrench[:, 1:3], 1e3 * force, atol=6e-4)
        assert plan.repeats.tolist() == [row.repeats] * len(q2)


def plans_of(m: int) -> dict[int, Path]:
    """The plan of m configurations, once and repeated to twelve experiments."""
    name = f"m{m}"
    files = {m: KR270 / "published" / f"{name}.csv"}
    return files if m == 12 else files | {12: files[m].with_name(f"{name}-times-{12 // m}.csv")}


def test_tables_5_and_6() -> None:
    """The robot as it is: Table 6, and ρ0 by (38) before its digits are rounded."""
    published = KR270 / "published"
    plans = {(count, m): file for m in TABLE_5 for count, file in plans_of(m).items()}
    assert set(plans.values()) == set(published.glob("*.csv"))
    found = evaluated(published / "study.yaml", *plans.values())
    assert all(one["accepted"] for one in found.values())
    for m, rho0 in {2: 8.1717, 3: 6.5883, 4: 5.4528, 6: 4.5288, 12: 3.2002}.items():
        one = found[f"m{m}.csv"]
        assert 1e9 * np.array(one["standard_error"]) == pytest.approx(TABLE_6[m], rel=3e-3)
        assert 1e3 * one["rho0_mm"] == pytest.approx(rho0, rel=1e-4)
    study = ec.read_study(published / "study.yaml")
    for m, rows in TABLE_5.items():
        plan = ec.read_proposal(published / f"m{m}.csv", study)
        np.testing.assert_allclose(plan.load_cases.q[:, 1:], np.radians(rows), atol=1e-12)


def test_table_7() -> None:
    """By the matrix it was computed with: nine of its twelve rows are files."""
    study = ec.read_study(KR270 / "published" / "study_table_7.yaml")
    plans = {(count, m): file for m in TABLE_5 for count, file in plans_of(m).items()}
    for rows, file in plans.items():
        plan = ec.read_proposal(file, study)
        worth = ec.assess(study, plan.load_cases, plan.repeats)
        assert not worth.violations
        assert 1e6 * worth.rho0 == pytest.approx(TABLE_7[rows], rel=3e-4)


def test_the_limit_of_30_degrees_refuses_what_rounding_broke() -> None:
    """Negative control: all but the plan of four configurations, by at most 0.06 degrees."""
    study, off = ec.read_study(KR270 / "study.yaml"), {}
    for m in TABLE_5:
        plan = ec.read_proposal(KR270 / "published" / f"m{m}.csv", study)
        broken = ec.assess(study, plan.load_cases, plan.repeats).violations
        assert {doubt.about for doubt in broken} <= {("elevation of flange z <= 30°",)}
        off[m] = max((np.degrees(doubt.numbers["by"]) for doubt in broken), default=0.0)
    assert list(off) == [2, 3, 4, 6, 12]
    assert [*off.values()] == pytest.approx([0.0131, 0.0333, 0.0, 0.0019, 0.0575], abs=1e-4)
