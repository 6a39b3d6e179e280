"""What a proof leaves out, so that it proves less than it could."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import listed
from elastocal.wording.numbers import length

SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "proof-leaves-out": lambda doubt: (
        f"the proof does not use: {listed(doubt.about)}; it holds for more configurations than "
        "the study allows, so that the bound is true and may be weaker"
    ),
    "proof-best-noise": lambda doubt: (
        f"the proof takes the noise of the tracker as {length(doubt.numbers['sigma'])} wherever "
        "markers are, the least it has; the bound is true and weaker"
    ),
    "proof-without-errors": lambda doubt: (
        "the proof leaves out errors of load cases that depend on these; they only take "
        "information away, so that the bound is true and weaker"
    ),
    "proof-without-shared-noise": lambda doubt: (
        "the proof leaves out the noise that readings of one pose share; it only takes "
        "information away, so that the bound is true and weaker"
    ),
}
