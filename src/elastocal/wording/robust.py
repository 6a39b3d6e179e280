"""What it cost that a plan withstands something, and what it gained."""

from __future__ import annotations

import math
from typing import Protocol

from elastocal.wording.blind import Seen, effect_name
from elastocal.wording.numbers import length, more_minutes, number


class Stands(Protocol):
    """What is said of a plan; see `planning.standing.Standing`."""

    @property
    def promised(self) -> float: ...
    @property
    def lost(self) -> float: ...
    @property
    def blind(self) -> float | None: ...
    @property
    def minutes(self) -> float: ...


class Robustly(Protocol):
    """What is said of a plan; see `planning.plan.Plan`."""

    @property
    def standing(self) -> Stands | None: ...
    @property
    def as_good(self) -> Stands | None: ...
    @property
    def blind(self) -> Seen | None: ...
    @property
    def for_promise(self) -> bool: ...


def robust_sentences(plan: Robustly) -> list[str]:
    """What a plan gave for what it got, by the plan that is as good as can be; else none."""
    now, before = plan.standing, plan.as_good
    if now is None or before is None:
        return []
    what = "the promise" if plan.for_promise else "ρ0"
    more = 100.0 * (now.promised / before.promised - 1.0)
    cost = f"{what} is {length(now.promised)} in place of {length(before.promised)}"
    if abs(more) >= _SAID:
        cost += f", {number(abs(more), 2)} % {'more' if more > 0.0 else 'less'}"
    longer = more_minutes(now.minutes - before.minutes)
    said = f"What it costs to be robust: {cost}, {longer} at the cell."
    got = f"What it gains: {_lost(now.lost)} without any one configuration, {_lost(before.lost)}"
    got += " before"
    if now.blind is None or before.blind is None:
        return [said, f"{got}."]
    got += f"; a largest blind error of {length(now.blind)}, {length(before.blind)} before."
    if unseen := () if plan.blind is None else plan.blind.invisible:
        worst = max(unseen, key=lambda effect: effect.error)
        others = f" and {len(unseen) - 1} more" if len(unseen) > 1 else ""
        got += (
            f" What no reading under these loads shows is not in it and not mended by it: "
            f"{effect_name(worst)}, up to {length(worst.error)}{others}; only other loads or "
            "markers show that."
        )
    return [said, got]


_SAID = 0.05  # %


def _lost(size: float) -> str:
    return length(size) if math.isfinite(size) else "nothing known"
