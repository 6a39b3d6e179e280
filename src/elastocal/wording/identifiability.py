"""What experiments, planned or done, cannot do or tell apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import counted
from elastocal.wording.numbers import described


def not_identifiable(doubts: Sequence[Doubt]) -> str:
    """Why a campaign cannot work, whatever experiments are chosen, and what would help."""
    return (
        "not identifiable from the allowed experiments: "
        + "; ".join(SENTENCES[doubt.code](doubt) for doubt in doubts)
        + "; leave such joints out of `identify` and find them by a second campaign, see 'Joint 1 "
        "by a second campaign' in docs/how-to-choose.md, or allow other forces or markers"
    )


def left_open(doubts: Sequence[Doubt], source: str) -> str:
    """Why readings cannot be fitted, and what would help."""
    return (
        f"not identifiable from {source or 'these measurements'}: "
        + "; ".join(
            _confounded(doubt, "readings")
            if doubt.code == "confounded"
            else f"{doubt.about[0]}: no reading is moved by this joint"
            for doubt in doubts
        )
        + "; measure other configurations or loads, or leave such joints out of `identify`"
    )


def _confounded(doubt: Doubt, who: str) -> str:
    seen = doubt.numbers["seen"]
    what = "a combination of them" if seen == 1 else f"{seen} combinations of them"
    return f"{' and '.join(doubt.about)}: the {who} see only {what}"


def _too_few(doubt: Doubt, what: str) -> str:
    count, needed = doubt.numbers["count"], doubt.numbers["needed"]
    return (
        f"{counted(int(count), what)} cannot identify the {len(doubt.about)} "
        f"compliances {', '.join(doubt.about)}: at least {needed} are needed"
    )


def _readings(doubt: Doubt) -> str:
    return counted(int(doubt.numbers["readings"]), "reading")


def _no_freedom(doubt: Doubt) -> str:
    said = f"σ cannot be estimated: {_readings(doubt)}"
    if "among_errors" not in doubt.numbers:
        return f"{said} leave no degree of freedom; use a known σ, or measure more"
    return (
        f"{said} show the noise nowhere by itself, and beside errors of load cases and what else "
        "is known by its size it is too small to be told from them; use a known σ, read several "
        "markers, or fit the joints alone"
    )


SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "not-seen": lambda doubt: (
        f"{doubt.about[0]}: no allowed experiment deflects a marker through this joint"
    ),
    "confounded": lambda doubt: _confounded(doubt, "experiments"),
    "too-few-experiments": lambda doubt: _too_few(doubt, "experiment"),
    "too-few-configurations": lambda doubt: _too_few(doubt, "configuration"),
    "no-configuration": lambda doubt: (
        f"no feasible configuration found: the nearest one still breaks {doubt.about[0]!r} "
        f"by {described(doubt.numbers['by'], doubt.unit)}; relax it, or check the units and the "
        "joint limits"
    ),
    "no-freedom": _no_freedom,
    "too-few-readings": lambda doubt: (
        f"{_readings(doubt)} {'gives' if doubt.numbers['readings'] == 1 else 'give'} "
        f"{3 * doubt.numbers['readings']} coordinates, "
        f"too few for the {len(doubt.about)} compliances {', '.join(doubt.about)}"
    ),
}
