"""What is proved of a bound, how far a proof is, and what it leaves out."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import counted
from elastocal.wording.numbers import length, number


class ProvedBound(Protocol):
    """What is said of a proof; see `planning.proved.Proved`."""

    @property
    def loss(self) -> float: ...
    @property
    def reachable(self) -> float: ...
    @property
    def boxes(self) -> int: ...
    @property
    def seconds(self) -> float: ...
    @property
    def ended(self) -> str: ...
    @property
    def left_out(self) -> tuple[Doubt, ...]: ...
    @property
    def record(self) -> str: ...
    @property
    def efficiency(self) -> float: ...


NOT_AGAIN = (
    "For this page the record of the proof was compared with the study and with what the plan "
    "claims; its boxes were not bounded again."
)
"""What a report does with a proof."""
MODEL = "joints, springs, noise, loads and constraints"
"""What a proof is a theorem about."""


class Certified(Protocol):
    """What is said of a certificate; see `planning.certificate.Certificate`."""

    @property
    def symbol(self) -> str: ...
    @property
    def lower_bound(self) -> float: ...
    @property
    def position_bound(self) -> float | None: ...
    @property
    def proved(self) -> ProvedBound | None: ...


def proof_sentences(certificate: Certified, experiments: int) -> list[str]:
    """What is proved, by what, and how near it is to the bound of the search; empty if nothing is.

    Args:
        certificate: The certificate of a plan.
        experiments: How many the plan has.
    """
    proved, symbol = certificate.proved, certificate.symbol
    if proved is None:
        return []
    every = counted(experiments, "experiment")
    gain = at_most(1.0 - math.sqrt(min(max(proved.efficiency, 0.0), 1.0)))
    said = f"no plan of {every} has {symbol} below {proved_length(proved.loss)}, so "
    if certificate.position_bound is None:
        said = f"against every plan of {every}, by {symbol}, "
    sentences = [
        f"Rigorous certificate: {said}at most {gain} can be gained in the error. This is proved, "
        f"as a theorem about the model: its {MODEL}, as the study has them.",
        f"{boxes(proved.boxes)}, which cover all load cases, were bounded; the last run took "
        f"{duration(proved.seconds)}.",
    ]
    for doubt in proved.left_out:
        sentence = SENTENCES[doubt.code](doubt)
        sentences.append(f"{sentence[0].upper()}{sentence[1:]}.")
    sentences.append(_how_near(proved, certificate.lower_bound))
    if proved.record:
        sentences.append(
            f"The record is {proved.record}; 'elastocal check-proof {proved.record}' verifies it "
            "without what made it."
        )
    return sentences


def claimed_kind(kind: str, bound: float | None, proved: ProvedBound | None) -> str:
    """What kind of certificate a plan file says that its plan has.

    Args:
        kind: What it says.
        bound: The bound of the search [m]; None if it is no length, or none.
        proved: What is proved by a record that is beside it; None if nothing is.
    """
    by = "" if bound is None else f": no better plan than {length(bound, 4)}"
    if proved is not None:
        shown = "" if bound is None else f": no better plan than {proved_length(proved.loss)}"
        found = "" if bound is None else f"; {length(bound, 4)} by a search"
        return f"Rigorous certificate, by its record {proved.record}{shown}{found}"
    if kind in ("numerical", "rigorous"):
        return f"Numerical certificate, by a search and not proved{by}"
    return "No certificate: no bound on the best plan is stated"


def _how_near(proved: ProvedBound, bound: float) -> str:
    """How far below the bound of the search it is, and why."""
    gap = at_most(max(1.0 - proved.loss / bound, 0.0))
    below = f"It is {gap} below the bound of the search"
    short = 1.0 - proved.reachable / bound
    if short > _FAR:
        below += f", and what it leaves out costs {at_most(short)}"
    if proved.ended == "reached":
        return f"{below}, as near as was asked for."
    if proved.ended == "open":
        return f"{below}; with what it uses no more can be proved, so more time does not help."
    why = "when its time was over" if proved.ended == "time" else "when it was stopped"
    return f"{below}: it ended {why}, and goes on from its record if it is asked for again."


def so_far(symbol: str, experiments: int, loss: float, bound: float, *, is_length: bool) -> str:
    """What is proved up to now, as one line.

    Args:
        symbol: What is bounded, as "ρ0".
        experiments: How many a plan has.
        loss: What is proved; 0: nothing.
        bound: The bound of the search.
        is_length: Whether these are lengths [m].
    """
    if loss <= 0.0:
        return "nothing is proved yet"
    gap = at_most(max(1.0 - loss / bound, 0.0))
    every = counted(experiments, "experiment")
    if not is_length:
        return f"proved: no plan of {every} is better by {symbol} than the bound less {gap}"
    return (
        f"proved: no plan of {every} has {symbol} below {proved_length(loss)} "
        f"(numerical bound {length(bound, 4)}): {gap}"
    )


def going_on(gap: float, left: float, count: int, proved: str) -> str:
    """What a proof is at.

    Args:
        gap: What is being proved.
        left: Seconds that it takes still, about; infinite: not known.
        count: Boxes looked at.
        proved: What is proved already, in short; empty if nothing is.
    """
    more = f", about {duration(left)} more" if 1.0 <= left < math.inf else ""
    known = f"; {proved} is proved" if proved else ""
    return f"to {at_most(gap)}{more}, {boxes(count)}{known}"


def foretold(expected: Sequence[tuple[float, float]]) -> str:
    """How long a proof takes, about.

    Args:
        expected: Gaps, from the largest down, and the seconds that each takes; infinite: unknown.
    """
    known = [(gap, seconds) for gap, seconds in expected if math.isfinite(seconds)]
    shown = [pair for pair in known if pair in (known[0], known[-1]) or pair[0] in _TOLD]
    if not shown:
        return "how long the proof takes cannot be foretold"
    parts = [f"about {duration(seconds)} to {at_most(gap)}" for gap, seconds in shown]
    if known[-1][1] < 1.0:
        parts = [f"less than 1 s to {at_most(known[-1][0])}"]
    rest = [gap for gap, _ in expected[len(known) :]]
    more = f"; how long {at_most(rest[0])} takes cannot be foretold" if rest else ""
    return f"the proof takes {', '.join(parts)}{more}"


def nothing_proved(ended: str) -> str:
    """Why a proof came to nothing."""
    why = {
        "time": "the time was over before all load cases were bounded once; give it more",
        "stopped": "it was stopped before all load cases were bounded once",
    }.get(ended, "with what it uses nothing can be")
    return f"nothing is proved: {why}"


def corrected_sentence(before: str, after: str) -> str:
    """That a proof found a load case which refutes the bound of the search."""
    return (
        f"the proof found a load case that refutes the numerical bound: {before} was wrong, it is "
        f"{after} now, and that is proved in its place"
    )


def proved_length(value: float, digits: int = 4) -> str:
    """A length that is proved [m], never rounded up: no more is said than is proved."""
    if not 0.0 < value < math.inf:
        return length(value, digits)
    step = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    return length(math.floor(value / step * (1.0 + 1e-12)) * step, digits)


def boxes(count: int) -> str:
    """A number of boxes, with blanks between thousands."""
    return f"{count:,}".replace(",", "\u202f") + (" box" if count == 1 else " boxes")


def at_most(share: float) -> str:
    """A share as per cent with two digits, never rounded down."""
    percent = 100.0 * share
    if percent < _SMALLEST:
        return f"{_SMALLEST:g} %"
    step = 10.0 ** (math.floor(math.log10(percent)) - 1)
    return f"{float(f'{math.ceil(percent / step - 1e-6) * step:.6g}'):g} %"


def duration(seconds: float) -> str:
    """A time in the unit that suits it."""
    if seconds < 90.0:
        return f"{number(max(seconds, 0.01), 1 if seconds < 10.0 else 2)} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{number(seconds / 3600.0, 2)} h"


_FAR = 1e-3  # share by which a proof cannot reach the bound of the search, that is said
_SMALLEST = 0.001  # per cent
_TOLD = (0.01,)  # gaps that are foretold besides the first and the last

SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "proof-leaves-out": lambda doubt: (
        f"the proof does not use: {', '.join(doubt.about)}; it holds for more configurations than "
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
    "proof-record-missing": lambda doubt: (
        f"it claims a proof whose record {doubt.about[0]} is not beside it, so that the proof does "
        "not count"
    ),
    "proof-record-other": lambda doubt: (
        f"it claims a proof whose record {doubt.about[0]} is another file than when the plan was "
        "written, so that the proof does not count"
    ),
    "proof-record-unlike": lambda doubt: (
        f"it claims a proof that is not what its record {doubt.about[0]} shows: "
        f"{doubt.because[0]}; so the proof does not count"
    ),
    "proof-not-checked": lambda doubt: (
        f"its record {doubt.about[0]} is of this study and says what the plan claims; the boxes in "
        f"it were not bounded again here: 'elastocal check-proof {doubt.about[0]}' does that"
    ),
    "claims-proved": lambda doubt: (
        f"it claims as proved that no plan is better than {_size(doubt, 'claimed')}, but "
        f"{_size(doubt, 'found')} is in reach, so that there is no such proof"
    ),
}


def _size(doubt: Doubt, name: str) -> str:
    value = doubt.numbers[name]
    return length(value, 6) if doubt.unit == "m" else number(value, 6)
