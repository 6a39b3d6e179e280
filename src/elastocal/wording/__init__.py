"""Doubts, outcomes and numbers as sentences people read."""

from elastocal.wording.sentences import SENTENCES, ended, together, worded

__all__ = ["SENTENCES", "ended", "together", "worded"]
