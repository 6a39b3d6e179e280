"""How a calibration file is told from other models, without its reader."""

from __future__ import annotations

import json
from pathlib import Path

from elastocal.errors import InputError
from elastocal.files.texts import read_text

KIND = "calibration"


def is_calibration(path: Path) -> bool:
    """Whether a file says that it is a calibration; False if it cannot be read as JSON."""
    if path.suffix.lower() != ".json":
        return False
    try:
        document = json.loads(read_text(path))
    except (InputError, ValueError, RecursionError):
        return False
    return isinstance(document, dict) and document.get("kind") == KIND
