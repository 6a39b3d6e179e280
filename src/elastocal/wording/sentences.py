"""The one table from the code of a doubt to its sentence."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from elastocal.errors import Code, Doubt
from elastocal.wording import identification

SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {**identification.SENTENCES}


def worded(doubt: Doubt) -> str:
    """The sentence that says a doubt: no capital before it, no full stop behind it."""
    return SENTENCES[doubt.code](doubt)
