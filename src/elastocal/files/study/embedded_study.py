"""The study that a plan carries: text and what was known in plan.json, its robot file beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from elastocal.errors import PlanFileError, StudyError
from elastocal.files.study.known import embedded_known
from elastocal.files.study.study_file import parse_study
from elastocal.study.study import Study


def study_in(document: dict[str, Any], plan: Path) -> Study:
    """The study in the document of a plan.json; files it names are looked for beside the plan.

    Raises:
        PlanFileError: no study is embedded, or a file it names is another one than it was.
        StudyError: the study cannot be read, or a file it names is not there.
    """
    origin = document.get("study") or {}
    text = origin.get("text", "")
    if not text:
        raise PlanFileError(f"{plan}: no study is embedded in this plan; name it with --study")
    try:
        study = parse_study(text, plan, embedded_known(document, plan))
    except StudyError as error:
        raise StudyError(
            f"{error}; this is the study in the plan: name the study with --study, or put the "
            "files it needs beside the plan"
        ) from None
    files = [
        (f"the robot file of {study.robot.name!r}", origin.get("robot_sha256"), study.robot.sha256)
    ]
    source, sha256 = study.prior_file
    if source:
        what = "plan" if study.earlier is None else "model"
        files.append((f"the prior {what} {source!r}", origin.get("prior_sha256"), sha256))
    for name, digest in (origin.get("paths_sha256") or {}).items():
        files.append((f"path {name!r}", digest, study.path_hashes.get(name, digest)))
    for what, then, now in files:
        if then and then != now:
            raise PlanFileError(
                f"{plan}: {what} has changed since this plan was made; name the study with "
                "--study if that is meant"
            )
    return study
