"""Marks of readings: how a model file knows the readings it was made from, wherever they stand.

A copy of a file with one more comment is another file with the same readings, and so is a part of
it. What counts is what was read: configuration, load, marker, values.
"""

from __future__ import annotations

from dataclasses import replace
from hashlib import blake2b
from pathlib import Path

import numpy as np

from elastocal.errors import InputError
from elastocal.files.models.model_file import model_sections
from elastocal.measuring.measurements import Measurements, chosen

_MOST = 10_000  # readings that are marked one by one
_DIGITS = 9  # of joint values [rad, m], loads [N, N·m]
_READ = 12  # of values [m, rad]
_LENGTH = 6  # bytes


def reading_marks(data: Measurements) -> list[str]:
    """A mark for each reading; none where there are too many to list."""
    if len(data) > _MOST:
        return []
    cases = data.cases
    load = np.round(np.hstack([cases.q, cases.wrench]), _DIGITS)[data.case]
    rows = np.hstack([load, np.round(data.deflection, _READ)]) + 0.0  # no zero below zero
    names = [data.tool.targets[m].encode() for m in data.marker]
    return [
        blake2b(row.tobytes() + name, digest_size=_LENGTH).hexdigest()
        for row, name in zip(rows, names, strict=True)
    ]


def without_used(data: Measurements, model: Path) -> Measurements:
    """The experiments of which the model in a file has counted no reading, with a remark.

    Raises:
        InputError: the model was made from all of them.
    """
    used = set(model_sections(model)["provenance"].get("marks") or ())
    if not used:
        return data
    known = np.array([mark in used for mark in reading_marks(data)], dtype=bool)
    if not known.any():
        return data
    count = np.bincount(data.case[known], minlength=len(data.cases))
    keep = np.asarray(count == 0)
    if not keep.any():
        raise InputError(
            f"{data.source}: {model} was made from all these readings; name the files it was made "
            "from, then every experiment is left out in turn"
        )
    told = (
        f"{int((~keep).sum())} of {len(keep)} experiments are left out: {model.name} was made from "
        "their readings"
    )
    rest = chosen(data, keep)
    return replace(rest, remarks=(*data.remarks, told))
