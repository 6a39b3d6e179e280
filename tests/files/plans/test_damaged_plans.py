"""Every node of a plan replaced by something else: harmless, or named in one sentence."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import InputError
from elastocal.files.plans.plan_file import plan_document, read_with_study
from elastocal.files.plans.proposal_file import Proposal, read_proposal
from elastocal.files.study.study_file import parse_study
from tests.files.damage import damaged

LIGHT = ec.Effort(batch=8, generations=1, patience=1, islands=1)
STUDY = """\
elastocal: 1
robot: three-link
test_poses:
  - {tool: tip, q_deg: [0, 60, -45], force_N: [0, 290, -960]}
experiments: {tool: tip, max_force_N: 1000, direction: free, count: 3}
instrument: {sigma_mm: 0.1}
"""


@pytest.fixture(scope="module")
def study() -> ec.Study:
    return parse_study(STUDY, Path("study.yaml"))


@pytest.fixture(scope="module")
def document(study: ec.Study) -> Any:
    made = json.loads(json.dumps(plan_document(ec.plan(study, seed=0, effort=LIGHT))))
    del made["blind"]["effects"][1:]  # all are alike
    return made


def same(one: Proposal, other: Proposal) -> bool:
    """Whether the same is measured."""
    return all(
        np.array_equal(a, b)
        for a, b in (
            (one.load_cases.q, other.load_cases.q),
            (one.load_cases.wrench, other.load_cases.wrench),
            (one.repeats, other.repeats),
        )
    )


def test_every_node_is_what_it_was_or_named(study: ec.Study, document: Any, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(document), "utf-8")
    good, said = read_proposal(path, study), set()
    for place, what, changed in damaged(document):
        path.write_text(json.dumps(changed), "utf-8")
        found = what_is_said(path, study, within_study=place[0] == "study")
        told = f"{place} = {what!r}: {found}"
        if isinstance(found, Proposal):
            assert found.edited or same(found, good), told
            continue
        said.add(found)
        assert found.startswith(f"{path}"), told
        assert "\n" not in found, told
    assert len(said) > 300


def what_is_said(path: Path, study: ec.Study, *, within_study: bool) -> Proposal | str:
    """The plan, or the sentence that refuses it."""
    try:
        return read_with_study(path, None if within_study else study)[0]
    except InputError as error:
        return str(error)
