"""Where nuisance springs are and how large, for programs."""

from __future__ import annotations

from typing import Any

from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.places import places_of
from elastocal.robot.chain import Robot


def nuisance_entries(robot: Robot, nuisance: Nuisance | None) -> list[dict[str, Any]]:
    """What `check --json` says of each: base frame, all joints at zero; sizes in SI."""
    if nuisance is None:
        return []
    places = places_of(robot, nuisance.unknowns)
    told = zip(
        places,
        nuisance.unknowns.kinds,
        nuisance.deviation.tolist(),
        nuisance.source,
        strict=True,
    )
    return [
        {
            "name": place.name,
            "moves": "slides" if place.slides else "turns",
            "carried_by": place.behind or "base",
            "axes": place.axes.tolist(),
            "origin_mm": (1e3 * place.origin).tolist(),
            "standard_uncertainty": size,
            "unit": kind.compliance,
            "source": source,
        }
        for place, kind, size, source in told
    ]
