"""The record of a proof beside a plan.json: whether it is of this study, and shows what is claimed.

Its boxes are not bounded again here: that is what `proof/check_proof.py` does.
"""

from __future__ import annotations

import hashlib
import json
import zipfile
from io import BytesIO
from pathlib import Path

from elastocal.errors import Doubt, InputError
from elastocal.files.plans.proposal_file import Proposal, study_for
from elastocal.files.texts import text_hash
from elastocal.planning.aim import aim_of
from elastocal.planning.proved import Proved
from elastocal.proof.plain_data import from_data
from elastocal.proof.statement import Statement
from elastocal.reading import bytes_of
from elastocal.study.study import Study

SUFFIX = ".proof"
"""How the names of records end."""
LARGEST = 1024 * 1024 * 1024
_STATEMENT = 16 * 1024 * 1024  # of a statement, unpacked
_ROUNDING = 1e-9


def statement_of(data: bytes, path: Path) -> Statement:
    """The statement in the record of a proof.

    Args:
        data: The bytes of the file.
        path: Its name, for messages.

    Raises:
        InputError: that is no record of a proof.
    """
    try:
        with zipfile.ZipFile(BytesIO(data)) as archive:
            with archive.open("statement.json") as file:
                text = file.read(_STATEMENT + 1)
            archive.getinfo("tree")
        if len(text) > _STATEMENT:
            raise ValueError
        return from_data(json.loads(text))
    except InputError as error:
        raise InputError(f"{path}: not the record of a proof: {error}") from None
    except Exception:  # whatever readers of archives and of JSON raise
        raise InputError(f"{path}: not the record of a proof") from None


def proof_beside(
    proposal: Proposal, study: Study, folder: Path
) -> tuple[Proved | None, Doubt | None]:
    """What a plan claims to be proved, if its record is beside it.

    Args:
        proposal: The plan.
        study: The study as it is written.
        folder: Where the plan is.

    Returns:
        What counts as proved; what is to be said of it. None and None if nothing is claimed.
    """
    claimed: Proved | None = proposal.claims.get("proved")
    if claimed is None:
        return None, None
    name = Path(claimed.record).name or "(without a name)"
    about = (name,)
    try:
        data = bytes_of(folder / name, LARGEST)
    except InputError:
        return None, Doubt("proof-record-missing", about)
    if hashlib.sha256(data).hexdigest() != claimed.sha256:
        return None, Doubt("proof-record-other", about)
    try:
        why = _unlike(statement_of(data, folder / name), claimed, study_for(proposal, study))
    except InputError:
        why = "it is none"
    if why:
        return None, Doubt("proof-record-unlike", about, (why,))
    return claimed, Doubt("proof-not-checked", about)


def _unlike(statement: Statement, claimed: Proved, study: Study) -> str:
    """In what a record differs from what is claimed; empty if it does not."""
    aim = aim_of(study)
    if statement.study_sha256 != text_hash(study.text):
        return "it is of another study"
    if statement.criterion != study.criterion:
        return f"it is of the criterion {statement.criterion}"
    if statement.count != aim.count:
        return f"it is of plans of {statement.count} experiments"
    shown = 0.0 if statement.rho0 is None else statement.rho0
    if claimed.loss**2 - aim.beyond > shown**2 * (1.0 + _ROUNDING):
        return "it shows a smaller bound"
    return ""
