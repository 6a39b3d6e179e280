"""Doubts, outcomes and numbers as sentences people read."""

from elastocal.wording.sentences import SENTENCES, worded

__all__ = ["SENTENCES", "worded"]
