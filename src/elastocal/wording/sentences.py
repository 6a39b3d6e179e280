"""The one table from the code of a doubt to its sentence."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from elastocal.errors import Code, Doubt
from elastocal.wording import (
    calibration,
    campaigns,
    compensation,
    identifiability,
    identification,
    measurements,
    motion,
    placements,
    plans,
    poses,
    proofs,
    searches,
    studies,
)

SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    **identification.SENTENCES,
    **compensation.SENTENCES,
    **campaigns.SENTENCES,
    **calibration.SENTENCES,
    **identifiability.SENTENCES,
    **measurements.SENTENCES,
    **placements.SENTENCES,
    **studies.SENTENCES,
    **poses.SENTENCES,
    **searches.SENTENCES,
    **plans.SENTENCES,
    **proofs.SENTENCES,
    **motion.SENTENCES,
}


def worded(doubt: Doubt) -> str:
    """The sentence that says a doubt: no capital before it, no full stop behind it."""
    sentence = SENTENCES[doubt.code](doubt)
    return f"with the joints alone, {sentence}" if "alone" in doubt.numbers else sentence


def ended(sentence: str) -> str:
    """A sentence with its mark: a full stop, unless it asks or has one."""
    return sentence if sentence.endswith((".", "?")) else f"{sentence}."


def together(doubts: Iterable[Doubt]) -> str:
    """Several doubts in one sentence; empty if there are none."""
    return "; ".join(map(worded, doubts))
