"""What would make a plan promise more, in a few words each."""

from __future__ import annotations

from typing import Protocol

from elastocal.wording.lists import listed
from elastocal.wording.numbers import more_minutes


class Mending(Protocol):
    """What is said of a way; see `planning.mends.Mend`."""

    @property
    def kind(self) -> str: ...
    @property
    def joints(self) -> tuple[str, ...]: ...
    @property
    def readings(self) -> int: ...
    @property
    def markers(self) -> int: ...
    @property
    def minutes(self) -> float: ...


MENDS = "What would promise more"
"""Title of a table, or of a part of a section."""
ESTIMATES = (
    "Estimates by load cases that were chosen quickly: a plan for it does better. Markers are "
    "0.3 m apart."
)


def mend_name(mend: Mending) -> str:
    """What is done."""
    found = f", {listed(mend.joints)} found along" if mend.joints else ""
    each = "every reading in another configuration"
    aslant = "loads up to 45° aslant"
    markers = f"{mend.markers} markers"
    said = {
        "configurations": each,
        "markers": f"{markers}, the same load cases",
        "second-step": f"{mend.readings} more readings, pulled from the side with 0.4 of the load",
        "aslant": aslant,
        "all": f"{aslant}, {markers}, {each}",
    }
    return f"{said[mend.kind]}{found}"


def minutes_phrase(mend: Mending) -> str:
    """How much longer the campaign takes."""
    return more_minutes(mend.minutes)
