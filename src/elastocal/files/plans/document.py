"""The document of a plan.json: JSON of our version, unedited, every key of its kind."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from elastocal.errors import PlanFileError
from elastocal.files.plans.plan_schema import check_kinds
from elastocal.files.texts import is_version, json_document, text_hash
from elastocal.names import LONGEST, flaw, shown

_LONGEST_TEXT = 10_000  # of a remark


def document_of(text: str, path: Path) -> Any:
    """The content of a plan.json, with the study it was written with.

    Raises:
        PlanFileError: not JSON, not a plan, of another version, with a key of another kind, or with
            a text of the study that is not the one whose hash stands beside it.
    """
    document = json_document(text, path, PlanFileError)
    if not isinstance(document, dict) or document.get("kind") != "plan":
        raise PlanFileError(f'{path}: not a plan file; expected JSON with "kind": "plan"')
    if not is_version(document.get("elastocal")):
        raise PlanFileError(
            f"{path}: format version {document.get('elastocal')!r} is not known; "
            "this program reads 1"
        )
    _check_texts(document, path)
    check_kinds(document, path)
    _refuse_edited(document.get("study") or {}, path)
    return document


def _refuse_edited(origin: dict[str, Any], path: Path) -> None:
    """Refuse a text of the study that was changed inside the plan."""
    text, digest = origin.get("text"), origin.get("sha256")
    if text and digest and text_hash(text) != digest:
        raise PlanFileError(
            f"{path}: the text of the study in it is not the one its sha256 stands for, so it was "
            "changed after planning; plan again from the study that is meant, or export the run "
            "sheet (CSV) with --study"
        )


def _check_texts(document: Any, path: Path) -> None:
    """Refuse keys that cannot be names, and texts but that of the study with signs unseen."""
    left: list[tuple[str, Any]] = [("", document)]
    while left:
        place, value = left.pop()
        texts, inner, longest = [], [], LONGEST
        if isinstance(value, dict):
            texts = list(value)
            inner = [(f"{place}.{key}", v) for key, v in value.items()]
        elif isinstance(value, list):
            inner = [(place, v) for v in value if isinstance(v, dict | list | str)]
        elif isinstance(value, str) and place != ".study.text":
            texts, longest = [value], _LONGEST_TEXT
        if wrong := next(filter(None, (flaw(text, longest) for text in texts)), ""):
            where = f"{path}, {shown(place[1:])}" if place else str(path)
            raise PlanFileError(f"{where}: {wrong}")
        left += inner[::-1]
