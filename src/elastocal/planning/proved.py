"""What is proved of a bound: a theorem about the model of a study, and where its record is.

In: nothing. Out: the value that certificates, plan files and pages have of it.
"""

from __future__ import annotations

from dataclasses import dataclass

from elastocal.errors import Doubt

ENDS = ("reached", "time", "stopped", "open")
"""Why proofs end: as near as was asked for, or before: out of time, stopped, or no more is true."""


@dataclass(frozen=True)
class Proved:
    """What is proved of a bound: a theorem about the model, its loads and its constraints.

    Attributes:
        loss: No plan of as many experiments has a smaller loss: ρ0 or promise [m] for these.
        reachable: What no proof by the same inequality is above, by the load cases that are known.
        largest: No load case has a larger sensitivity, in the units of the record.
        boxes: Boxes that were looked at.
        seconds: How long it took.
        ended: Why it ended, one of `ENDS`.
        left_out: What it does not use, so that the bound is weaker than it could be.
        record: Name of the file with its record; empty if none was written.
        sha256: Hash of that file.
        efficiency: φ of the plan over what is left to any plan: 0.9 means that at best 10 % of the
            experiments could be saved, where nothing was known before; nan: not known.
    """

    loss: float
    reachable: float
    largest: float
    boxes: int
    seconds: float
    ended: str
    left_out: tuple[Doubt, ...] = ()
    record: str = ""
    sha256: str = ""
    efficiency: float = float("nan")

    @property
    def finished(self) -> bool:
        """Whether it came as near to what is reachable as was asked for."""
        return self.ended == "reached"
