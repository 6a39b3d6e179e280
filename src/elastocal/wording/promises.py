"""What a plan promises with nuisance, and that one promises without, as sentences."""

from __future__ import annotations

from typing import Protocol

from elastocal.wording.lists import listed
from elastocal.wording.numbers import length

WITHOUT = (
    "No nuisance counts: only what is identified or known is taken to give way, and loads and "
    "joints to have no errors. `nuisance: typical` in the study says what foot, bearings, links "
    "and errors of usual size leave."
)


class Promised(Protocol):
    """What is said of a promise; see `planning.promise.Promise`."""

    @property
    def rho0(self) -> float: ...
    @property
    def limit(self) -> float: ...
    @property
    def without(self) -> float: ...
    @property
    def uncompensated(self) -> float: ...
    @property
    def friction(self) -> float: ...
    @property
    def discrepancy(self) -> float: ...
    @property
    def repeatability(self) -> float: ...


def promise_sentences(rho0: float, promise: Promised | None, *, made_for_it: bool) -> list[str]:
    """What the numbers of a promise are; that there is none, if nuisance does not count.

    Args:
        rho0: ρ0 of the plan [m].
        promise: What is promised.
        made_for_it: Whether plans of the study are made for their promise.
    """
    if promise is None:
        return [WITHOUT]
    said = []
    counts = "counts the springs of the nuisance" if promise.uncompensated > 0.0 else "is"
    if abs(promise.rho0 - rho0) > 1e-9 * rho0:
        said.append(
            f"Promised: {length(promise.rho0)}, with 95 % below {length(promise.limit)}, with the "
            f"errors of load cases in the readings, which repeats share; ρ0 {counts} without these "
            "errors. "
            + (
                "Plans are made for the promise, and bound and efficiency speak of it."
                if made_for_it
                else "Plans are not made for it, and bound and efficiency do not speak of it."
            )
        )
    alone = ""
    if promise.uncompensated > 0.0:
        alone = (
            "; if nobody compensated them, the springs of the nuisance would move the tool by "
            f"{length(promise.uncompensated)}"
        )
    said.append(f"Without nuisance the same plan would claim {length(promise.without)}{alone}.")
    floors = {
        "friction": promise.friction,
        "discrepancy": promise.discrepancy,
        "repeatability": promise.repeatability,
    }
    left = [f"{name} {length(size)}" for name, size in floors.items() if size > 0.0]
    if left:
        said.append(f"On top comes what no calibration takes from the task: {listed(left)}.")
    return said
