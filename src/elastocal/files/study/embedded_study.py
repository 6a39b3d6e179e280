"""The study that a plan carries: text and what was known in plan.json, its robot file beside it."""

from __future__ import annotations

from pathlib import Path

from elastocal.errors import PlanFileError
from elastocal.files.plans.proposal_file import document_of
from elastocal.files.study.known import embedded_known
from elastocal.files.study.study_file import parse_study
from elastocal.files.texts import read_text
from elastocal.study.study import Study


def embedded_study(plan: Path) -> Study:
    """The study embedded in a plan.json; files it names are looked for beside the plan.

    Raises:
        PlanFileError: no study is embedded, or its robot file is another one than it was.
        StudyError: the study cannot be read, or its robot file is not there.
    """
    document = document_of(read_text(plan), plan)
    origin = document.get("study")
    origin = origin if isinstance(origin, dict) else {}
    text = origin.get("text", "")
    if not isinstance(text, str) or not text:
        raise PlanFileError(f"{plan}: no study is embedded in this plan; name it with --study")
    study = parse_study(text, plan, embedded_known(document, plan))
    made_with = origin.get("robot_sha256", "")
    if made_with and made_with != study.robot.sha256:
        raise PlanFileError(
            f"{plan}: the robot file of {study.robot.name!r} has changed since this plan was made; "
            "name the study with --study if that is meant"
        )
    paths = origin.get("paths_sha256")
    for name, digest in paths.items() if isinstance(paths, dict) else ():
        if study.path_hashes.get(name, digest) != digest:
            raise PlanFileError(
                f"{plan}: path {name!r} has changed since this plan was made; name the study with "
                "--study if that is meant"
            )
    return study
