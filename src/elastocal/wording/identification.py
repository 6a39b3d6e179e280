"""What is weak in an identification."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import listed
from elastocal.wording.numbers import number, percent, probability, short, small

SURE = 1e-3
"""Probability below which chance is ruled out: as in `fitting.goodness`, which knows no words."""


def chance(p: float) -> str:
    """A probability for people: how rare it is, as long as it may be chance."""
    if p < SURE:
        return f"too far for chance ({probability(p)})"
    return f"as in one of {1.0 / p:.0f} right models ({probability(p)})"


def _noisier(doubt: Doubt) -> str:
    n = doubt.numbers
    text = (
        f"the residuals scatter {short(n['scale'])} times as much as σ promises (χ² = "
        f"{n['chi_square']:.4g} with {n['dof']:.0f} degrees of freedom)"
    )
    if n.get("p_value", 0.0) >= SURE:
        return f"{text}, {chance(n['p_value'])}"
    if "estimated" in n:
        return (
            f"{text}: the noise is larger, which the intervals count, or the model lacks "
            "something, which they do not"
        )
    return (
        f"{text}: the noise is larger or the model lacks something; the intervals are too narrow, "
        "estimate σ"
    )


def _softer(doubt: Doubt) -> str:
    *sizes, most = (1e6 * abs(doubt.numbers[name]) for name in (*doubt.about, "most"))
    return (
        f"{listed(doubt.about)}: softer than any joint of an arm, {number(max(sizes), 2)} "
        f"µ{doubt.unit} where {number(most, 2)} would be much; look at units and loads, and "
        "whether these experiments tell the joints apart"
    )


def _held(doubt: Doubt) -> str:
    values = [
        f"{name} {number(1e6 * doubt.numbers[name], 2)}"
        for name in doubt.about
        if name in doubt.numbers
    ]
    text = f"{listed(doubt.about)}: held at zero by the bound"
    if values:
        text += f"; without it the fit says {listed(values)} µ{doubt.unit}".rstrip(" µ")
    return f"{text}, which no spring can be; look at signs and joint values"


def _explains_little(doubt: Doubt) -> str:
    n, what = doubt.numbers, "rotations" if doubt.unit == "rad" else "deflections"
    whole, left, noise = (small(n[name], doubt.unit) for name in ("whole", "left", "noise"))
    text = (
        f"the model explains {percent(1.0 - n['left'] / n['whole'])} of the {what}: of {whole} "
        f"(RMS) {left} are left"
    )
    if n["left"] < _AS_PROMISED * n["noise"]:
        return f"{text}, which is the noise that σ promises; larger loads would tell more"
    return (
        f"{text}, where σ promises {noise}; look at signs, joint values and loads, and at what "
        "else gives way"
    )


_AS_PROMISED = 1.2  # residuals over the promised noise that are put down to it


def _grows(doubt: Doubt) -> str:
    n = doubt.numbers
    text = f"the residuals grow with the load (rank correlation {n['correlation']:.2f})"
    if n["p_value"] >= SURE:
        return f"{text}, {chance(n['p_value'])}"
    return (
        f"{text}, {chance(n['p_value'])}: the loads are not what is recorded, or a spring is "
        "missing; the intervals do not count that"
    )


def _hardly_known(doubt: Doubt) -> str:
    errors = [f"{name} ± {100.0 * doubt.numbers[name]:.0f} %" for name in doubt.about]
    return f"standard errors are a large share of the compliances: {listed(errors)}"


def _model_error(doubt: Doubt) -> str:
    n = doubt.numbers
    return (
        f"repeats agree with one another ({short(n['pure_scale'])} of the promised noise) far "
        f"better than with the model ({short(n['fit_scale'])}): this is model error, not "
        "noise; no number of repeats will cure it"
    )


def _zero_in_interval(doubt: Doubt) -> str:
    bends = "this spring bends" if len(doubt.about) == 1 else "these springs bend"
    return (
        f"{listed(doubt.about)}: the interval contains zero, so the data do not show that "
        f"{bends} at all"
    )


def _carried(doubt: Doubt) -> str:
    ratio, named = doubt.numbers["error_ratio"], listed(doubt.because)
    grows = (
        "without it nothing is known of these joints"
        if np.isinf(ratio)
        else f"without it the standard errors are up to {short(ratio)} times as large"
    )
    return (
        f"{listed(doubt.about)}: carried by experiment {named} alone; {grows}, and no other "
        "reading checks it"
    )


def _by_chance(doubt: Doubt) -> str:
    return (
        f"repeats differ from the model {chance(doubt.numbers['p_value'])}; one more "
        "configuration would tell"
    )


def _counts_less(doubt: Doubt) -> str:
    unused = doubt.numbers["unused"]
    return (
        f"{len(doubt.about)} of {doubt.numbers['readings']} readings count less than half"
        + (f", {unused} of them not at all" if unused else "")
        + f": {listed(doubt.about)}"
    )


def _combination(doubt: Doubt) -> str:
    """'A2 + 0.35 A4 − 0.04 A6', the largest first."""
    n = doubt.numbers
    names = sorted(doubt.about, key=lambda name: -abs(n[name]))
    first, *rest = names
    terms = [f"{'+' if n[k] >= 0.0 else '−'} {number(abs(n[k]), 2)} {k}" for k in rest]
    return " ".join([first, *terms])


def _parallel(doubt: Doubt) -> str:
    n, several = doubt.numbers, len(doubt.about) > 1
    if not several:
        return (
            f"{listed(doubt.about)}: moves the readings by no more than joint values that are off "
            "by 0.005° do, so nothing is known of it; measure other configurations or loads"
        )
    seen = int(n["seen"])
    known = (
        f"the combination {_combination(doubt)} is known"
        if seen == 1
        else f"{seen} combinations of them are known"
    )
    return (
        f"{listed(doubt.about)}: told apart by no more than joint values that are off by 0.005° "
        f"make, so only {known}; measure configurations that are further apart"
    )


def _nearly_parallel(doubt: Doubt) -> str:
    return (
        f"{listed(doubt.about)}: joint values that are off by 0.005° bias what tells them apart by "
        f"up to {100.0 / (1.0 + doubt.numbers['ratio']):.0f} %"
    )


SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "all-held-at-zero": lambda _: (
        "all compliances are held at zero by the bound: loaded and unloaded are probably swapped, "
        "or the force has the wrong sign"
    ),
    "all-negative": lambda _: (
        "all compliances are negative: loaded and unloaded are probably swapped, or the force "
        "has the wrong sign"
    ),
    "negative": lambda doubt: (
        f"{listed(doubt.about)}: negative, which no spring can be; look at signs and joint values"
    ),
    "held-at-zero": _held,
    "softer-than-any": _softer,
    "noisier-than-promised": _noisier,
    "quieter-than-promised": lambda doubt: (
        f"the residuals scatter only {short(doubt.numbers['scale'])} times as much as σ promises: "
        "σ is too pessimistic, or the readings were smoothed or repeated"
    ),
    "few-degrees-of-freedom": lambda doubt: (
        f"σ is estimated from {doubt.numbers['dof']} degrees of freedom only: the intervals are "
        "wide"
    ),
    "noise-beside-errors": lambda doubt: (
        "no reading shows the noise by itself: σ is what they scatter beyond the errors of load "
        f"cases of the sizes stated, {short(doubt.numbers['dof'])} degrees of freedom; if these "
        "are smaller, it is larger"
    ),
    "unlike-noise": lambda doubt: (
        f"positions scatter {short(doubt.numbers['positions'])} times as much as promised, "
        f"rotations {short(doubt.numbers['rotations'])} times: their weights do not fit to each "
        "other; look at the noise of both, and at the model"
    ),
    "model-error": _model_error,
    "explains-little": _explains_little,
    "grows-with-load": _grows,
    "hardly-known-compliance": _hardly_known,
    "zero-in-interval": _zero_in_interval,
    "carried": _carried,
    "by-chance": _by_chance,
    "more-than-stated": lambda doubt: (
        f"what is left is {short(doubt.numbers['scale'])} times as large as noise, priors and the "
        f"stated errors of load cases make it, {chance(doubt.numbers['p_value'])}: one of them is "
        "larger, or something else gives way"
    ),
    "shared-with-nuisance": lambda doubt: (
        "known together, and better than each alone: "
        + ", ".join(f"{a} with {b}" for a, b in zip(doubt.about, doubt.because, strict=True))
    ),
    "correlated": lambda doubt: (
        f"{doubt.about[0]} and {doubt.about[1]}: correlated by "
        f"{doubt.numbers['correlation']:.3f}; their combination is known better than either"
    ),
    "parallel": _parallel,
    "nearly-parallel": _nearly_parallel,
    "counts-less": _counts_less,
    "outlying": lambda doubt: (
        f"{listed(doubt.about)}: more than {short(doubt.numbers['deviations'])} σ from "
        "what the other experiments say; look at it, or use a robust loss"
    ),
    "linear-model": lambda doubt: (
        f"linear model with deflections up to {1e3 * doubt.numbers['deflection']:.2g} mm: its "
        "estimates are biased at second order; the model of the equilibrium is not"
    ),
}
