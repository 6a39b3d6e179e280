"""A criterion added as docs/architecture.md says is known everywhere, with its unit and direction.

Two are added: a standard error as A with another mean, and a position error; neither by a line
outside `CRITERIA`.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.design.criterion import Criterion
from elastocal.design.exact import Effort
from elastocal.design.matrix_means import MatrixMean
from elastocal.files.plans.plan_file import plan_document, write_plan
from elastocal.files.plans.proposal_file import read_proposal
from elastocal.planning.certificate import Bound, lower_bound
from elastocal.planning.evaluation import Evaluation, evaluate
from elastocal.planning.plan import Plan, plan
from elastocal.report import tables
from elastocal.study.criteria import CRITERIA, PlanCriterion, compliances, metres
from elastocal.study.study import Study
from elastocal.terminal.certificates import certificate_sentences
from elastocal.terminal.console import micrometres
from elastocal.terminal.plans import show_evaluations
from tests.design.examples import study_with_two_test_poses
from tests.report.examples import gantry_plan, three_link_plan

LIGHT = Effort(batch=8, generations=1, patience=1, islands=1)


def squared(study: Study, information: Array, function: Criterion) -> float:
    """A loss of its own: the mean square standard error."""
    return 1.0 / float(function.value(information[None])[0])


ADDED = (
    PlanCriterion("A2", lambda _: MatrixMean(-2.0), "quartic mean of the axes", compliances),
    PlanCriterion(
        "V", lambda _: MatrixMean(-1.0), "precision", lambda _: "rad²/(N·m)²", squared, True
    ),
    PlanCriterion("P", CRITERIA["test-pose"].function, "test poses again", metres, symbol="P0"),
)


@pytest.fixture(autouse=True)
def _added(monkeypatch: pytest.MonkeyPatch) -> None:
    for criterion in ADDED:
        monkeypatch.setitem(CRITERIA, criterion.name, criterion)


def rows_of(table: tables.Table) -> dict[str, tuple[str, ...]]:
    """Value, unit and direction of every criterion."""
    return {row.cells[0]: row.cells[1:4] for row in table.rows}


def test_the_report_shows_its_unit_and_direction() -> None:
    made = three_link_plan.__wrapped__()  # the cached one is for tests without these criteria
    rows = rows_of(tables.criteria(made, {}))
    assert rows["A2"][1:] == rows["A"][1:] == ("nrad/(N·m)", "smaller")
    assert rows["V"][1:] == ("rad²/(N·m)²", "larger")
    assert rows["P"] == rows["test-pose"]
    shown = float(rows["A2"][0])
    assert shown == pytest.approx(1e9 * made.assessment.criteria["A2"], rel=5e-3)


def test_with_sliding_joints_it_follows_the_springs() -> None:
    rows = rows_of(tables.criteria(gantry_plan.__wrapped__(), {}))
    assert rows["A2"][1] == rows["A"][1] == "10⁻⁹ SI, mixed"
    assert [rows[name][1] for name in ("O1", "O2", "O5")] == ["SI", "", "SI"]


@pytest.mark.parametrize("name", [criterion.name for criterion in ADDED])
def test_it_is_planned_written_read_and_judged(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = replace(study_with_two_test_poses(), criterion=name)
    bound = lower_bound(study, np.random.default_rng(0))
    made = plan(study, effort=LIGHT, bound=bound)
    document = plan_document(made)
    criteria, certificate = document["criteria"], document["certificate"]
    (sentence,) = certificate_sentences(made.certificate, 4)
    information = made.assessment.information
    value = float(CRITERIA[name].function(study).value(information[None])[0])
    if name == "P":
        assert criteria["P_mm"] == pytest.approx(1e3 / np.sqrt(value))
        assert certificate["P_lower_bound_mm"] == 1e3 * made.certificate.lower_bound
        assert "P0 below" in sentence
        assert made.certificate.position_bound == made.certificate.lower_bound
    else:
        assert criteria[name] == pytest.approx(1.0 / (value if name == "V" else np.sqrt(value)))
        assert not [key for key in certificate if key.endswith("_mm")]
        assert f"by {name}:" in sentence
        assert made.certificate.position_bound is None
    judged = judged_anew(study, tmp_path / "plan.json", made, bound)
    assert judged.accepted
    show_evaluations(study, {"made": judged}, {})
    shown = "–" if name != "P" else micrometres(judged.certificate.lower_bound)
    row = next(line for line in capsys.readouterr().out.splitlines() if "made" in line)
    assert shown in row
    assert judged.assessment.criteria[name] == pytest.approx(made.assessment.criteria[name])
    assert judged.certificate.efficiency == pytest.approx(made.certificate.efficiency)


def judged_anew(study: Study, path: Path, made: Plan, bound: Bound) -> Evaluation:
    write_plan(made, path)
    assert json.loads(path.read_text())["criterion"] == study.criterion
    proposal = read_proposal(path, study)
    return evaluate(study, proposal.load_cases, proposal.repeats, proposal.claims, bound)


def test_a_bound_that_is_too_good_is_refused_under_every_position_error(tmp_path: Path) -> None:
    study = replace(study_with_two_test_poses(), criterion="P")
    bound = lower_bound(study, np.random.default_rng(0))
    made = plan(study, effort=LIGHT, bound=bound)
    boasting = replace(made.certificate, lower_bound=1.02 * made.certificate.lower_bound)
    made = replace(made, certificate=boasting)
    assert len(judged_anew(study, tmp_path / "plan.json", made, bound).objections) == 1


def test_a_bound_on_another_criterion_is_none_on_rho0() -> None:
    certificate = three_link_plan.__wrapped__().certificate
    assert certificate.rho0_bound == certificate.lower_bound
    assert replace(certificate, criterion="P").rho0_bound is None
    assert replace(certificate, kind="none").rho0_bound is None
