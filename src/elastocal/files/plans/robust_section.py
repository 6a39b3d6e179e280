"""What a plan withstands, and what that cost, as a section of plan.json."""

from __future__ import annotations

from typing import Any

import numpy as np

from elastocal.files.plans.load_case_entries import finite_at
from elastocal.planning.plan import Plan
from elastocal.planning.standing import Standing

_KEYS = {"promised": "promised_mm", "lost": "after_a_loss_mm", "blind": "blind_mm"}


def robust_section(plan: Plan) -> dict[str, Any]:
    """The section `robust` by its key; empty if nothing is asked for."""
    wish, now, before = plan.study.experiments.robust, plan.standing, plan.as_good
    if wish is None or now is None:
        return {}
    asked = {
        "loss": wish.loss,
        "blind_um": None if wish.blind is None else 1e6 * wish.blind,
        "within": wish.within,
    }
    section: dict[str, Any] = {
        "asked": {key: value for key, value in asked.items() if value is not None},
        "has": _entry(now),
    }
    return {"robust": section if before is None else section | {"as_good_had": _entry(before)}}


def _entry(found: Standing) -> dict[str, float | None]:
    """Lengths in millimetres, null where infinite."""
    sizes = {key: getattr(found, name) for name, key in _KEYS.items()}
    lengths = {
        key: 1e3 * size if np.isfinite(size) else None
        for key, size in sizes.items()
        if size is not None
    }
    return {**lengths, "minutes": found.minutes}


def claimed_standing(section: Any, where: str) -> Standing | None:
    """Where the plan stood that was as good as can be, as a file has it; None if it has not."""
    entry = section.get("as_good_had") if isinstance(section, dict) else None
    if not isinstance(entry, dict):
        return None
    sizes = {
        name: finite_at(entry[key], f"{where}: {key}") / 1e3
        for name, key in _KEYS.items()
        if entry.get(key) is not None
    }
    return Standing(
        promised=sizes.get("promised", float("inf")),
        lost=sizes.get("lost", float("inf")),
        blind=sizes.get("blind"),
        minutes=finite_at(entry.get("minutes"), f"{where}: minutes"),
    )
