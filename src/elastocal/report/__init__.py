"""Report: a campaign as one HTML file that works offline, on a phone and on paper.

In: values the core made. Out: HTML text. Nothing is computed here but geometry to draw.
jinja2 and plotly are imported when a report is made, not when this package is.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from elastocal.arrays import Array
    from elastocal.assessment import Assessment
    from elastocal.comparison import TradeOff
    from elastocal.planning import Plan

__all__ = ["html"]


def html(
    plan: Plan,
    *,
    trade_off: TradeOff | None = None,
    random: Array | None = None,
    others: Mapping[str, Assessment] | None = None,
) -> str:
    """A plan, its certificate and its run sheet as one self-contained HTML page.

    Args:
        plan: What to report.
        trade_off: ρ0 over experiments and configurations; its section is left out if None.
        random: (K,) ρ0 of random feasible plans with as many experiments [m].
        others: Other plans by name, to compare with.

    Returns:
        HTML text that needs no network: styles, pictures and the 3D view are inside.
    """
    from elastocal.report.contents import Contents
    from elastocal.report.page import render

    return render(Contents(plan, trade_off, random, others or {}))
