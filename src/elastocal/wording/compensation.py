"""What is odd with corrected configurations: limits, singular arms, rigid joints."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import counted
from elastocal.wording.numbers import length, shown

_NOTHING = 1e-9  # remaining error not worth a number [m]


def _beyond_limit(doubt: Doubt) -> str:
    factor, unit = shown(doubt.unit)
    value, limit = doubt.numbers["value"], doubt.numbers["limit"]
    return (
        f"{doubt.about[0]} would need {factor * value:.4f}{unit}, beyond its limit "
        f"{factor * limit:.6g}{unit}"
    )


def _singular(doubt: Doubt, does: str) -> str:
    axis = " ".join(f"{np.round(doubt.numbers[name], 3) + 0.0:.3g}" for name in "xyz")
    said = f"nearly singular: the joints hardly {does} [{axis}]"
    rest = doubt.numbers.get("remaining")
    if rest is None:
        return said
    return f"{said}; {1e3 * rest:.3g} mm remain" if rest > _NOTHING else f"{said}; no error remains"


SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "no-better": lambda doubt: (
        f"the correction is of {length(doubt.numbers['before'])} and its uncertainty "
        f"{length(doubt.numbers['after'])} (RMS): it may be worse than none; measure near these "
        "poses, or the point that is to be there"
    ),
    "gives-way": lambda _: "no stable equilibrium: the arm gives way under the load",
    "not-at-rest": lambda _: "the search for the corrected configuration did not come to rest",
    "rests-elsewhere": lambda _: "the arm comes to rest elsewhere: the load is too large for it",
    "beyond-limit": _beyond_limit,
    "hardly-moves": lambda doubt: _singular(doubt, "move the tool along"),
    "hardly-turns": lambda doubt: _singular(doubt, "turn the tool about"),
    "points-lost": lambda doubt: (
        f"{counted(int(doubt.numbers['points']), 'point')} of {doubt.numbers['all']} cannot be "
        "corrected"
    ),
    "points-beyond-limits": lambda doubt: (
        f"{counted(int(doubt.numbers['points']), 'corrected point')} of {doubt.numbers['all']} "
        "would leave the joint limits"
    ),
    "points-nearly-singular": lambda doubt: (
        f"the arm is nearly singular at {counted(int(doubt.numbers['points']), 'point')}, where "
        "some error may remain"
    ),
    "more-than-expected": lambda doubt: (
        f"with the true model {length(doubt.numbers['remaining'])} remain, more than twice "
        f"what was expected, {length(doubt.numbers['expected'])}"
    ),
    "rigid-but-loaded": lambda doubt: (
        f"{doubt.about[0]} has no compliance in the model and is taken as rigid; the load turns it "
        f"with up to {doubt.numbers['load']:.3g} {doubt.unit}, so that every 0.1 "
        f"{'µm/N' if doubt.unit == 'N' else 'µrad/(N·m)'} of it leaves up to "
        f"{length(1e-7 * doubt.numbers['moves'])}"
    ),
    "wrong-side": lambda doubt: (
        f"{', '.join(doubt.about)}: negative compliance, so its correction goes to the wrong "
        "side; identify again before a robot drives this"
    ),
    "position-only": lambda doubt: (
        f"the robot has {doubt.numbers['joints']} joints: the position of the tool is corrected, "
        "not its orientation"
    ),
    "taken-as-zero": lambda doubt: (
        f"{', '.join(doubt.about)}: of no compliance in the model, as held at zero by a fit; what "
        "they bend in truth is in none of these numbers"
    ),
    "tool-elsewhere": lambda doubt: (
        f"{doubt.about[0]} was found {length(doubt.numbers['off'])} from where it is drawn: the "
        "path is taken to be for the tool as it was found"
    ),
    "tcp-not-read": lambda _: (
        "the TCP is none of the reflectors that were read, nor carried by three of them: it is "
        "where the drawing has it, on a flange that only the priors hold, and ρ0 counts that; read "
        "three reflectors beside it, or name one with --point"
    ),
    "nothing-to-compensate": lambda _: "no load acts on the tool: there is nothing to compensate",
}
