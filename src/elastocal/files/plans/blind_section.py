"""What a plan cannot see, and what would promise more, as sections of plan.json and `evaluate`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from elastocal.planning.blind import BlindEffect, BlindErrors
from elastocal.planning.mends import Mend
from elastocal.wording.blind import effect_name
from elastocal.wording.mends import mend_name


def blind_section(found: BlindErrors | None) -> dict[str, Any]:
    """The section `blind` by its key, lengths in millimetres; empty if nothing is known."""
    if found is None:
        return {}
    return {
        "blind": {
            "degrees_of_freedom": found.dof,
            "seen_half": _finite(found.seen_half),
            "larger_if_estimated": _finite(found.if_estimated),
            "together_mm": _finite(1e3 * found.together),
            "effects": [blind_entry(effect) for effect in found.effects],
        }
    }


def blind_entry(effect: BlindEffect) -> dict[str, Any]:
    """One effect: sizes in SI, lengths in millimetres."""
    return {
        "name": effect_name(effect),
        "kind": effect.kind,
        "joints": list(effect.carriers),
        "axis": effect.axis.tolist(),
        "unit": effect.unit,
        "invisible": effect.invisible,
        "left_mm": 1e3 * effect.error,
        "left_mm_per_unit": 1e3 * effect.leak,
        "visibility_per_unit2": effect.visibility,
        "seen_half_from": _finite(effect.half),
        "hard_to_believe_from": effect.largest,
        "usual": _finite(effect.usual),
        "usual_seen": _finite(effect.usual_seen),
    }


def mends_section(found: Sequence[Mend]) -> dict[str, Any]:
    """The section `mends` by its key; empty if there are none."""
    entries = [
        {
            "name": mend_name(mend),
            "kind": mend.kind,
            "joints": list(mend.joints),
            "promised_mm": 1e3 * mend.promised,
            "more_min": mend.minutes,
        }
        for mend in found
    ]
    return {"mends": entries} if entries else {}


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
