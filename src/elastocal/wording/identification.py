"""What is weak in an identification."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import listed
from elastocal.wording.numbers import short


def _noisier(doubt: Doubt) -> str:
    n = doubt.numbers
    return (
        f"the residuals scatter {short(n['scale'])} times as much as σ promises (χ² = "
        f"{n['chi_square']:.4g} with {n['dof']} degrees of freedom): the noise is larger "
        "or the model lacks something; the intervals are too narrow, estimate σ"
    )


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
    several, ratio = len(doubt.because) > 1, doubt.numbers["error_ratio"]
    what, it = ("the repeated experiments", "them") if several else ("experiment", "it")
    named = listed(doubt.because)
    if several and "configuration" in doubt.numbers:
        what, named = f"configuration {doubt.numbers['configuration']}", f"({_span(doubt.because)})"
    grows = (
        f"without {it} nothing is known of these joints"
        if np.isinf(ratio)
        else f"without {it} the standard errors are up to {short(ratio)} times as large"
    )
    return (
        f"{listed(doubt.about)}: carried by {what} {named}; {grows}, and no other "
        f"load case checks {it}"
    )


def _span(names: Sequence[str]) -> str:
    """'experiments 10 to 12' where they are numbered in a row, else their names."""
    numbers = [int(name) for name in names if name.isascii() and name.isdigit()]
    if len(names) > 2 and numbers == list(range(numbers[0], numbers[0] + len(names))):
        return f"experiments {names[0]} to {names[-1]}"
    return f"experiments {listed(names)}"


def _by_chance(doubt: Doubt) -> str:
    p = doubt.numbers["p_value"]
    return (
        f"repeats differ from the model as they do by chance in 1 of {1.0 / p:.0f} campaigns "
        f"(p = {p:.2g}); one more configuration would tell"
    )


def _counts_less(doubt: Doubt) -> str:
    unused = doubt.numbers["unused"]
    return (
        f"{len(doubt.about)} of {doubt.numbers['readings']} readings count less than half"
        + (f", {unused} of them not at all" if unused else "")
        + f": {listed(doubt.about)}"
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
        f"{listed(doubt.about)}: negative, which no spring can be; look at signs and joint "
        "values, or rule it out with a bound at zero"
    ),
    "held-at-zero": lambda doubt: (
        f"{listed(doubt.about)}: held at zero by the bound; the covariance of the "
        "others takes that as exact"
    ),
    "noisier-than-promised": _noisier,
    "quieter-than-promised": lambda doubt: (
        f"the residuals scatter only {short(doubt.numbers['scale'])} times as much as σ promises: "
        "σ is too pessimistic, or the readings were smoothed or repeated"
    ),
    "few-degrees-of-freedom": lambda doubt: (
        f"σ is estimated from {doubt.numbers['dof']} degrees of freedom only: the intervals are "
        "wide"
    ),
    "unlike-noise": lambda doubt: (
        f"positions scatter {short(doubt.numbers['positions'])} times as much as promised, "
        f"rotations {short(doubt.numbers['rotations'])} times: their weights do not fit to each "
        "other; look at the noise of both, and at the model"
    ),
    "model-error": _model_error,
    "zero-in-interval": _zero_in_interval,
    "carried": _carried,
    "by-chance": _by_chance,
    "correlated": lambda doubt: (
        f"{doubt.about[0]} and {doubt.about[1]}: correlated by "
        f"{doubt.numbers['correlation']:.3f}; their combination is known better than either"
    ),
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
