"""Which kind of study a file is: of deflections, or of absolute readings; and its version."""

from __future__ import annotations

from elastocal.errors import StudyError
from elastocal.files.texts import is_version
from elastocal.files.yaml_lines import Located, LocatedError
from elastocal.robot.geometry import GROUPS

BLOCKS = ("base", "tool", "geometry", *GROUPS, "payload", "compensator")
"""What `identify` of a study of absolute readings may name besides joints and springs."""
LARGEST = 1_000_000
"""Bytes of a study file; it is a page of text."""


def names_blocks(value: dict[str, object]) -> bool:
    """Whether a document's `identify` names more than joints and springs."""
    names = value.get("identify")
    return isinstance(names, list) and any(isinstance(n, str) and n in BLOCKS for n in names)


def check_version(document: Located) -> None:
    """Refuse a study file that does not begin with the version of its format."""
    if "elastocal" not in document.value:
        raise StudyError(
            f"{document.file}: key 'elastocal' is missing; a study file begins with "
            "'elastocal: 1', the version of its format"
        )
    if not is_version(document.value["elastocal"]):
        raise LocatedError(
            ("elastocal",),
            f"format version {document.value['elastocal']!r} is not known; this program reads 1",
        )
