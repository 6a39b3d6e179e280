"""What an earlier campaign found, from its model; or will find, from its plan."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.errors import InputError, PlanFileError
from elastocal.files.models.model_file import read_model, readings_in
from elastocal.files.plans.document import document_of
from elastocal.files.plans.known_section import read_known
from elastocal.files.plans.proposal_file import proposal_in, study_for
from elastocal.files.tables.csv_table import is_table
from elastocal.files.texts import file_hash, read_text
from elastocal.planning.assessment import assess
from elastocal.planning.evaluation import false_claims
from elastocal.robot.chain import Robot
from elastocal.robot.geometry_hash import geometry_hash
from elastocal.study.known import Known
from elastocal.study.study import Study
from elastocal.wording import worded

KnownOf = Callable[[Robot], Known | None]
"""What is known of the springs of a robot."""

StudyOf = Callable[[str, Path, KnownOf], Study]
"""The study in a text, its file, and what it knows."""


def known_at(path: Path, robot: Robot, study_of: StudyOf, source: str = "") -> Known:
    """What a model.json knows, or a plan.json promises, of the springs of `robot`.

    Args:
        path: The file.
        robot: The robot.
        study_of: Reads the study that is embedded in a plan.
        source: What the file is called; its name if not given.

    Raises:
        InputError: neither model nor plan, for another robot, or without uncertainty.
    """
    if is_table(path):
        raise InputError(f"{path}: expected a model.json or a plan.json, which has its study in it")
    text, source = read_text(path), source or path.name
    sha256 = file_hash(path)
    if _is_plan(text):
        return Known(_promised(text, path, robot, study_of), True, source, sha256)
    model = read_model(path, robot)
    return Known(model, False, source, sha256, readings_in(path))


def embedded_known(document: dict[str, object], path: Path) -> KnownOf:
    """What the plan.json of a document knew."""

    def known_of(robot: Robot) -> Known | None:
        if "known" not in document:
            return None
        return read_known(document["known"], robot, f"{path}: known")

    return known_of


def _is_plan(text: str) -> bool:
    """Whether a JSON text is meant to be a plan; its reader finds out what is wrong with it."""
    head = text[:2000].replace(" ", "").replace("\n", "")
    return text.lstrip().startswith("{") and '"kind":"plan"' in head


def _promised(text: str, path: Path, robot: Robot, study_of: StudyOf) -> ComplianceModel:
    """What a plan promises: covariances recomputed from its study; compliances it knows none.

    Errors of its load cases are in them. What all its loads err together is not shared with those
    of the campaign that comes: nobody says that the cell will be the same.
    """
    document = document_of(text, path)
    written = (document.get("study") or {}).get("text")
    if not written:
        raise PlanFileError(f"{path}: no study is embedded in this plan; name a model instead")
    study = study_of(written, path, embedded_known(document, path))
    if geometry_hash(study.robot) != geometry_hash(robot):
        raise PlanFileError(f"{path}: is a plan for another robot, {study.robot.name!r}")
    proposal = proposal_in(document, path, study.robot)
    study = study_for(proposal, study)
    worth = assess(study, proposal.load_cases, proposal.repeats)
    for doubt in false_claims(study, worth, proposal.claims):
        raise PlanFileError(f"{path}: {worded(doubt)}, so it was changed after planning")
    if not worth.identifiable:
        raise PlanFileError(f"{path}: this plan does not identify its compliances")
    springs = study.sought
    own = [study.fitted.names.index(name) for name in springs.names]
    promise = worth.promise
    covariance = worth.covariance[np.ix_(own, own)] if promise is None else promise.covariance
    return ComplianceModel(springs, np.zeros(len(springs)), covariance, source=path.name)
