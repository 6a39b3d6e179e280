"""The key `known` of a study, and what a plan remembers of it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import InputError, PlanFileError, StudyError
from elastocal.files.plans.plan_file import plan_document, read_with_study
from elastocal.files.plans.proposal_file import study_for
from elastocal.files.study.study_file import parse_study
from elastocal.files.texts import text_hash
from elastocal.planning.certificate import lower_bound
from elastocal.planning.evaluation import evaluate
from elastocal.study.two_steps import with_known
from tests.campaigns import FIRST_STEP

LIGHT = ec.Effort(batch=8, generations=1, patience=1, islands=1)
SECOND = FIRST_STEP.replace("[J2, J3]", "[J1]").replace("0, 0, -1000", "0, 1000, 0")
KNOWN = SECOND + "known: KNOWN\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Plan and model of a first step, plan of the second."""
    path = tmp_path_factory.mktemp("steps")
    (path / "first.yaml").write_text(FIRST_STEP, "utf-8")
    (path / "second.yaml").write_text(KNOWN.replace("KNOWN", "model.json"), "utf-8")
    study = ec.read_study(path / "first.yaml")
    plan = ec.plan(study, effort=LIGHT)
    ec.write_plan(plan, path / "plan.json")
    found = ec.ComplianceModel(study.springs, np.array([3e-6, 5e-6]), plan.assessment.covariance)
    ec.write_model(found, path / "model.json", study.robot)
    ec.write_plan(ec.plan(ec.read_study(path / "second.yaml"), effort=LIGHT), path / "plan_2.json")
    return path


def second(folder: Path, known: str) -> ec.Study:
    return parse_study(KNOWN.replace("KNOWN", known), folder / "study.yaml")


def test_a_model_and_the_plan_it_came_from_promise_the_same(folder: Path) -> None:
    """But for the compliances, of which the plan knows none."""
    by_model, by_plan = second(folder, "model.json"), second(folder, "plan.json")
    assert by_model.known is not None
    assert by_plan.known is not None
    assert (by_model.known.planned, by_plan.known.planned) == (False, True)
    np.testing.assert_array_equal(by_model.known.model.compliance, [3e-6, 5e-6])
    np.testing.assert_allclose(by_plan.prior, by_model.prior, rtol=1e-9)
    assert by_model.fitted.names == ("J1", "J2", "J3")
    assert by_model.test_poses[0].regressor.shape == (3, 3)
    assert by_model.known.source == "model.json"
    assert len(by_model.known.sha256) == 64


def test_a_first_step_that_claims_what_it_does_not_give_is_refused(folder: Path) -> None:
    """As everywhere: its study, its load cases or its claims were changed after planning."""
    document = json.loads((folder / "plan.json").read_text("utf-8"))
    document["standard_error"]["J2"]["value"] /= 10.0
    (folder / "boasts.json").write_text(json.dumps(document), "utf-8")
    with pytest.raises(InputError, match=r"boasts.json: it claims a standard error of \S+ for J2"):
        second(folder, "boasts.json")
    document = json.loads((folder / "plan.json").read_text("utf-8"))
    text = document["study"]["text"].replace("sigma_mm: 0.1", "sigma_mm: 0.01")
    assert text != document["study"]["text"]
    document["study"] |= {"text": text, "sha256": text_hash(text)}
    (folder / "boasts.json").write_text(json.dumps(document), "utf-8")
    with pytest.raises(InputError, match=r"boasts.json: it claims .*changed after planning"):
        second(folder, "boasts.json")


def test_a_model_of_the_first_step_that_contradicts_itself_is_refused(folder: Path) -> None:
    document = json.loads((folder / "model.json").read_text("utf-8"))
    document["identification"] = {"confidence": 0.95, "interval": {"J2": [0.0, 1.0]}}
    (folder / "odd.json").write_text(json.dumps(document), "utf-8")
    with pytest.raises(InputError, match=r"interval.J2: .* is not the interval of"):
        second(folder, "odd.json")


def test_a_plan_knows_what_it_knew(folder: Path, tmp_path: Path) -> None:
    """Embedded: neither study nor model need be beside it."""
    alone = tmp_path / "plan.json"
    alone.write_bytes((folder / "plan_2.json").read_bytes())
    made, again = second(folder, "model.json"), read_with_study(alone)[1]
    assert again.known is not None
    assert made.known is not None
    np.testing.assert_allclose(again.prior, made.prior, rtol=1e-12)
    np.testing.assert_array_equal(again.known.model.compliance, [3e-6, 5e-6])
    assert again.known.sha256 == made.known.sha256
    # A study without the key is judged by what the plan knew; with it, by what it says now.
    bare = parse_study(SECOND, folder / "study.yaml")
    told = study_for(ec.read_proposal(alone, bare), bare)
    np.testing.assert_allclose(told.prior, made.prior, rtol=1e-12)
    given = study_for(ec.read_proposal(alone, made), made)
    assert given.known is made.known


def test_a_plan_of_the_second_step_is_judged_with_the_first(folder: Path) -> None:
    study = second(folder, "model.json")
    proposal = ec.read_proposal(folder / "plan_2.json", study)
    bound = lower_bound(study, np.random.default_rng(1))
    cases, repeats, claims = proposal.load_cases, proposal.repeats, proposal.claims
    assert evaluate(study, cases, repeats, claims, bound).accepted
    # What counts as known exactly would be another promise.
    blind = parse_study(SECOND, folder / "study.yaml")
    bound = lower_bound(blind, np.random.default_rng(1))
    codes = {d.code for d in evaluate(blind, cases, repeats, claims, bound).objections}
    assert "claims-rho0" in codes


def test_the_covariance_of_a_plan_has_names_and_is_held_to(folder: Path) -> None:
    study = second(folder, "model.json")
    document = json.loads((folder / "plan_2.json").read_text("utf-8"))
    section = document["covariance"]
    assert section["order"] == ["J1", "J2", "J3"]
    assert section["unit"] == 3 * ["rad/(N·m)"]
    errors = np.sqrt(np.diagonal(section["matrix"]))
    assert errors[0] == pytest.approx(document["standard_error"]["J1"]["value"], rel=1e-12)
    bound = lower_bound(study, np.random.default_rng(1))

    def objections(matrix: np.ndarray, order: list[str]) -> list[str]:
        document["covariance"] = {"order": order, "matrix": matrix.tolist()}
        (folder / "claims.json").write_text(json.dumps(document), "utf-8")
        proposal = ec.read_proposal(folder / "claims.json", study)
        judged = evaluate(study, proposal.load_cases, proposal.repeats, proposal.claims, bound)
        return [doubt.code for doubt in judged.objections]

    matrix, order = np.array(section["matrix"]), section["order"]
    turned = [2, 0, 1]
    assert not objections(matrix[np.ix_(turned, turned)], [order[i] for i in turned])
    wrong = matrix.copy()
    wrong[0, 1] = wrong[1, 0] = 0.5 * errors[0] * errors[1]
    assert objections(wrong, order) == ["claims-covariance"]
    assert objections(matrix, ["J1", "J2", "J9"]) == ["claims-unknown-error"]
    with pytest.raises(PlanFileError, match="covariance: matrix must be as many rows as columns"):
        objections(matrix[:2], order)
    with pytest.raises(PlanFileError, match="covariance: order must name each of the 3 rows"):
        objections(matrix, order[:2])


@pytest.mark.parametrize(
    ("known", "message"),
    [
        ("nowhere.json", r"study.yaml, line 9: .*nowhere\.json: no such file"),
        ("plan.csv", r"line 9: .*plan\.csv: (no such file|expected a model)"),
        ("first.yaml", r"line 9: .*first\.yaml, line \d+: unknown key"),
        ("only.json", "which the study identifies; what is known of these is a prior"),
        ("other.json", "is a plan for another robot"),
        ("bare.json", "no study is embedded in this plan; name a model instead"),
    ],
)
def test_what_cannot_be_known_is_refused(folder: Path, known: str, message: str) -> None:
    robot = ec.load_robot("three-link")
    one = ec.ComplianceModel(ec.joint_springs(robot, ["J1"]), np.array([1e-6]), np.eye(1) * 1e-16)
    ec.write_model(one, folder / "only.json", robot)
    document = json.loads((folder / "plan.json").read_text("utf-8"))
    text = document["study"]["text"]
    document["study"]["text"] = ""
    (folder / "bare.json").write_text(json.dumps(document), "utf-8")
    rows = "".join(f"{{joint: J{i}, a_mm: 100, alpha_deg: 90}}, " for i in (1, 2, 3))
    table = f"robot: {{convention: modified, dh: [{rows}]}}"
    text = text.replace("robot: three-link", table).replace("tool: tip", "tool: tip")
    tip = "tools: {tip: {tcp_mm: [100, 20, 30]}}\n"
    document["study"] = {"text": text.replace("test_poses:", tip + "test_poses:")}
    (folder / "other.json").write_text(json.dumps(document), "utf-8")
    with pytest.raises(StudyError, match=message):
        second(folder, known)


def test_a_section_that_is_damaged_is_refused(folder: Path) -> None:
    document = json.loads((folder / "plan_2.json").read_text("utf-8"))
    path = folder / "damaged.json"
    for change, message in (
        (
            {"covariance": {"order": ["J2"], "matrix": [[1e-16]]}},
            "known: covariance: order must name every",
        ),
        ({"compliance": {"J2": 3}}, "known: .*expected {value"),
        ([], "known: expected a section of keys"),
    ):
        section = document["known"] | change if isinstance(change, dict) else change
        path.write_text(json.dumps(document | {"known": section}), "utf-8")
        with pytest.raises(InputError, match=message):
            read_with_study(path)


def test_a_first_plan_says_what_it_leaves_rigid(folder: Path) -> None:
    document = json.loads((folder / "plan.json").read_text("utf-8"))
    assert [doubt["about"] for doubt in document["doubts"]] == [["J1"]]
    assert "J1 is taken as rigid, but bent at test pose 'task'" in document["remarks"][0]
    later = json.loads((folder / "plan_2.json").read_text("utf-8"))
    assert later["remarks"] == []


def test_what_was_measured_before_counts_all_that_is_fitted(folder: Path) -> None:
    """The rest of a second step: its information is on known springs too."""
    study = second(folder, "model.json")
    truth = ec.ComplianceModel(ec.joint_springs(study.robot), np.array([2e-6, 3e-6, 5e-6]))
    plan = ec.read_proposal(folder / "plan_2.json", study)
    rng = np.random.default_rng(0)
    data = ec.simulate(study, truth, plan.load_cases, np.minimum(plan.repeats, 1), rng)
    before = ec.done(study, data)
    assert before.information.shape == (3, 3)
    rest = ec.remaining(study, before)
    np.testing.assert_allclose(rest.prior, study.prior + before.information)
    with pytest.raises(InputError, match="its information is on 3 compliances"):
        ec.remaining(with_known(study, None), before)
    assert plan_document(ec.plan(rest, effort=LIGHT))["known"]["file"] == "model.json"
