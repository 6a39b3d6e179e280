"""Doubts in documents: what programs read beside the sentences."""

from __future__ import annotations

import json

import numpy as np

from elastocal.errors import Doubt
from elastocal.files.doubt_entries import doubt_entries
from elastocal.files.texts import finite


def test_an_entry_says_code_names_and_numbers() -> None:
    doubts = (
        Doubt("carried", ("A1",), ("E1", "E2"), {"error_ratio": np.inf}),
        Doubt("beyond-limit", ("A2",), (), {"value": 0.5, "limit": 0.0}, "rad"),
    )
    first, second = json.loads(json.dumps(finite(doubt_entries(doubts))))
    assert (first["code"], first["about"], first["because"]) == ("carried", ["A1"], ["E1", "E2"])
    assert first["numbers"] == {"error_ratio": None}
    assert second["numbers"] == {"value": 0.5, "limit": 0.0}
    assert second["unit"] == "rad"
