"""What else explains readings: another convention of the joint values, or what a model lacks."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from elastocal.errors import Code, Doubt
from elastocal.wording.identification import SURE, chance
from elastocal.wording.numbers import length, number, probability
from elastocal.wording.poses import explained


def _convention(doubt: Doubt) -> str:
    n = doubt.numbers
    mistakes = [Doubt("counts-other-way", (j,), numbers={"sign": n[j]}) for j in doubt.about]
    for pair in zip(doubt.because[::2], doubt.because[1::2], strict=True):
        mistakes.append(Doubt("coupled", pair, numbers={"factor": n["/".join(pair)]}))
    owners = [name for name in ("controller", "model") if name in n]
    why = (
        explained(tuple(mistakes))
        if mistakes
        else f"the joint values are those of the {owners[0]} (joints: {owners[0]})"
        if len(owners) == 1
        else "the joint values are taken the other way (joints: controller for model, or model "
        "for controller)"
    )
    return (
        f"of {n['tried']:.0f} conventions of the joint values another one fits best: the same "
        f"springs leave {length(n['after'])} in place of {length(n['before'])} (RMS) if {why}"
    )


def candidate(kind: str, carrier: str = "", axis: str = "") -> str:
    """What may be missing, in words."""
    where = "the base" if carrier == "base" else carrier
    return {
        "in-joint": f"a spring in {where}",
        "turning": f"a spring about {axis} of {where}",
        "sliding": f"a spring that slides along {axis} of {where}",
        "tool-shift": "a tool shifted between the readings without and with load",
        "station-shift": "a base or instrument shifted between the readings without and with load",
        "station-turn": (
            "a base or instrument shifted and turned between the readings without and with load"
        ),
        "load-gain": "one factor on all loads",
    }[kind]


def _size(doubt: Doubt) -> str:
    """How large it would be, where that is one number or three lengths."""
    kind, size = doubt.because[0], doubt.numbers.get("size")
    if size is None or kind in ("station-turn", "load-gain"):
        return ""
    if kind == "sliding":
        return f" ({number(1e6 * size, 2)} µm/N)"
    if kind in ("in-joint", "turning"):
        return f" ({number(1e6 * size, 2)} µrad/(N·m))"
    shift = " ".join(number(1e3 * doubt.numbers[name], 2) for name in ("size", "y", "z"))
    return f" by [{shift}] mm{' in its frame' if kind == 'tool-shift' else ''}"


def _lacks(doubt: Doubt) -> str:
    n = doubt.numbers
    besides = " besides" if "besides" in n else ""
    return (
        f"{candidate(*doubt.because)}{_size(doubt)} would{besides} remove "
        f"{100.0 * n['share']:.0f} % of the residual variance ({length(n['before'])} → "
        f"{length(n['after'])} when configurations are left out) and change {doubt.about[0]} by "
        f"{number(100.0 * n['change'], 2)} %"
    )


def _may_lack(doubt: Doubt) -> str:
    n = doubt.numbers
    p = n["p_value"]
    told = f"{probability(p)}, but what is left out is hardly predicted better"
    if p >= SURE:
        told = chance(p)
    return (
        f"{candidate(*doubt.because)}{_size(doubt)} would remove {100.0 * n['share']:.0f} % of the "
        f"residual variance, {told}; further configurations would tell"
    )


SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "other-convention": _convention,
    "model-lacks": _lacks,
    "model-may-lack": _may_lack,
}
