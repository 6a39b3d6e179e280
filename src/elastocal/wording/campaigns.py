"""What a validation and virtual campaigns do not bear out."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import listed
from elastocal.wording.numbers import number, percent, probability, sure


def _unexplained(doubt: Doubt) -> str:
    n = doubt.numbers
    return (
        f"the errors are larger than noise and covariance explain (χ² = "
        f"{number(n['chi_square'], 4)} with {n['dof']} degrees of freedom, "
        f"{probability(n['p_value'])}); {percent(n['inside'])} lie in the intervals that "
        f"promise {sure(n['confidence'])}"
    )


def _share(doubt: Doubt) -> str:
    n = doubt.numbers
    if n["repeated"] == n["experiments"]:
        return f"all {n['experiments']} experiments repeat"
    return f"{n['repeated']} of {n['experiments']} experiments repeat"


SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "worse-with-model": lambda doubt: (
        f"with the model the error is larger than without it in {listed(doubt.about)}"
    ),
    "errors-unexplained": _unexplained,
    "same-load-cases": lambda doubt: (
        f"{_share(doubt)} load cases of the identification: that tests the noise, not the model; "
        "measure other configurations"
    ),
    "unlike-predicted": lambda doubt: (
        f"virtual campaigns of {doubt.about[0]}: the error found is "
        f"{number(doubt.numbers['ratio'])} times the predicted ρ₀"
    ),
    "not-covered": lambda doubt: (
        f"virtual campaigns of {doubt.because[0]}: 95 % intervals of {', '.join(doubt.about)} do "
        "not cover the truth as often as promised"
    ),
}
