"""A plan.json and its run sheet plan.csv beside it: whether they are of one plan."""

from __future__ import annotations

import re
from pathlib import Path

from elastocal.errors import InputError
from elastocal.files.texts import file_hash, read_text

_PLAN = re.compile(r"elastocal run sheet, plan ([0-9a-f]{12}) ")


def parted(path: Path) -> Path | None:
    """What stands beside a plan or a run sheet under its name and belongs to another plan.

    A program that was killed between the two leaves such a pair, as does a copy of one of them.
    None if they belong together, or if there is no second file, or none of ours.
    """
    plan, sheet = path.with_suffix(".json"), path.with_suffix(".csv")
    try:
        found = _PLAN.search(read_text(sheet).partition("\n")[0])
        if found is None or file_hash(plan).startswith(found[1]):
            return None
    except InputError:
        return None
    return sheet if path == plan else plan
