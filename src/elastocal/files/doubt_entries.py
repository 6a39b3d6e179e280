"""Doubts for programs: what the sentences beside them say, in codes and numbers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from elastocal.errors import Doubt


def doubt_entries(doubts: Iterable[Doubt]) -> list[dict[str, Any]]:
    """Entries of a JSON document."""
    return [
        {
            "code": doubt.code,
            "about": list(doubt.about),
            "because": list(doubt.because),
            "numbers": dict(doubt.numbers),
            "unit": doubt.unit,
        }
        for doubt in doubts
    ]
