"""Every number of a plan.json, changed: refused, noted, or among what is said to be unchecked."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import PlanFileError
from elastocal.files.plans.plan_file import plan_document
from elastocal.files.plans.proposal_file import read_proposal, study_for
from elastocal.files.study.study_file import parse_study
from elastocal.planning.certificate import Bound, lower_bound
from elastocal.planning.evaluation import Evaluation, evaluate, false_claims

LIGHT = ec.Effort(batch=8, generations=1, patience=1, islands=1)
STUDY = """\
elastocal: 1
robot: three-link
test_poses:
  - {name: one, tool: tip, q_deg: [0, 60, -45], force_N: [0, 290, -960]}
  - {name: two, tool: tip, q_deg: [20, 30, -45], force_N: [300, 0, -960]}
experiments: {tool: tip, max_force_N: 1000, direction: free, count: 3}
instrument: {sigma_mm: 0.1}
"""

NOTHING_FOLLOWS = {
    ("seed",): "which search it was; plan has it for the same plan again",
    ("doubts",): "read by programs; evaluate has its own",
}
"""Numbers that are not looked at, and why that does no harm."""


@pytest.fixture(scope="module")
def study() -> ec.Study:
    return parse_study(STUDY, Path("study.yaml"))


@pytest.fixture(scope="module")
def document(study: ec.Study) -> Any:
    made = json.loads(json.dumps(plan_document(ec.plan(study, seed=0, effort=LIGHT))))
    del made["blind"]["effects"][1:]  # all are alike
    return made


@pytest.fixture(scope="module")
def bound(study: ec.Study) -> Bound:
    return lower_bound(study, np.random.default_rng(7))


def numbers_in(value: Any, above: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where numbers stand, as the keys that lead there."""
    if isinstance(value, dict | list):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from numbers_in(inner, (*above, key))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield above


def changed(document: Any, place: tuple[Any, ...]) -> Any:
    """The document with one number larger, by 1 % and, if it is a whole one, by one at least."""
    other = copy.deepcopy(document)
    inner = other
    for key in place[:-1]:
        inner = inner[key]
    old = inner[place[-1]]
    inner[place[-1]] = old + max(1, old // 100) if isinstance(old, int) else 1.01 * old + 1e-3
    return other


def judged(path: Path, study: ec.Study, bound: Bound) -> tuple[Evaluation, bool]:
    proposal = read_proposal(path, study)
    wanted = study_for(proposal, study)
    found = evaluate(
        wanted, proposal.load_cases, proposal.repeats, proposal.claims, bound, proposal.via
    )
    return found, proposal.edited


def test_every_number_is_held_against_something_or_said_to_be_unchecked(
    study: ec.Study, document: Any, bound: Bound, tmp_path: Path
) -> None:
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(document), "utf-8")
    honest, edited = judged(path, study, bound)
    assert honest.accepted
    assert not edited
    (unchecked,) = (doubt.about for doubt in honest.remarks if doubt.code == "claims-unchecked")
    places = list(numbers_in(document))
    assert len(places) > 100
    for place in places:
        if place[:1] in NOTHING_FOLLOWS:
            continue
        keys = {part for part in place if isinstance(part, str)}
        said = any(name.split(" of ")[0] in keys for name in unchecked)
        path.write_text(json.dumps(changed(document, place)), "utf-8")
        try:
            found, edited = judged(path, study, bound)
        except PlanFileError:
            continue
        assert said or edited or not found.accepted, place
        assert not said or found.accepted, place  # what is said to be unchecked is


def test_claims_of_a_certificate_are_no_proof(
    study: ec.Study, document: Any, bound: Bound, tmp_path: Path
) -> None:
    path = tmp_path / "plan.json"
    other = copy.deepcopy(document)
    other["certificate"] |= {"kind": "rigorous proof", "fresh_starts": 10**9}
    path.write_text(json.dumps(other), "utf-8")
    found, _ = judged(path, study, bound)
    codes = {doubt.code: doubt.about for doubt in found.remarks}
    assert codes["certificate-unknown"] == ("rigorous proof",)
    assert "fresh_starts of the certificate" in codes["claims-unchecked"]
    for key, share in (("rho0_lower_bound_mm", 1.0009), ("efficiency", 1.0018)):
        other = copy.deepcopy(document)
        other["certificate"][key] *= share
        path.write_text(json.dumps(other), "utf-8")
        found, _ = judged(path, study, bound)
        assert [doubt.code for doubt in found.objections] == [
            "claims-bound" if key.startswith("rho0") else "claims-efficiency"
        ]
    other["certificate"] = "proved"
    path.write_text(json.dumps(other), "utf-8")
    with pytest.raises(PlanFileError, match="certificate"):
        judged(path, study, bound)


NUISANCE = "nuisance: {preset: typical, compliance_urad_per_Nm: {J1: 1, J2: 1, J3: 1}}\n"


def test_every_number_of_a_promise_is_held_against_the_study(tmp_path: Path) -> None:
    """Each test pose, each standard error, all nuisance, and what errors are said to count."""
    study = parse_study(STUDY + NUISANCE, Path("study.yaml"))
    made = json.loads(json.dumps(plan_document(ec.plan(study, seed=0, effort=LIGHT))))
    path = tmp_path / "plan.json"

    def refused() -> list[str]:
        proposal = read_proposal(path, study)
        wanted = study_for(proposal, study)
        worth = ec.assess(wanted, proposal.load_cases, proposal.repeats)
        return [doubt.code for doubt in false_claims(wanted, worth, proposal.claims)]

    path.write_text(json.dumps(made), "utf-8")
    assert refused() == []
    places = [("promise", *place) for place in numbers_in(made["promise"])]
    assert len(places) > 30
    for place in places:
        path.write_text(json.dumps(changed(made, place)), "utf-8")
        assert len(refused()) == 1, place
    made["promise"]["errors"]["process_force"] = "exact"
    path.write_text(json.dumps(made), "utf-8")
    assert refused() == ["claims-nuisance"]
