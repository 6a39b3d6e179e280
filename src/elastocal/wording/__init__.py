"""Doubts, outcomes and numbers as sentences people read."""

from elastocal.wording.sentences import SENTENCES, together, worded

__all__ = ["SENTENCES", "together", "worded"]
