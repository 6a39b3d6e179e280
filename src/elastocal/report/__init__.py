"""A campaign as one HTML page that works offline, on a phone and on paper.

In: values the core made. Out: HTML text. Nothing is computed here but where things are drawn.
jinja2 and plotly are imported when a report is made, not when this package is.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from elastocal.arrays import Array
    from elastocal.compensation.compensate import Compensation
    from elastocal.elastic.compliance_model import ComplianceModel
    from elastocal.identification.result import Identification
    from elastocal.identification.validation import Validation
    from elastocal.planning.assessment import Assessment
    from elastocal.planning.plan import Plan
    from elastocal.planning.trade_off import TradeOff
    from elastocal.simulation.monte_carlo import MonteCarlo

__all__ = ["html"]


def html(
    plan: Plan | None = None,
    *,
    trade_off: TradeOff | None = None,
    random: Array | None = None,
    others: Mapping[str, Assessment] | None = None,
    identification: Identification | None = None,
    references: Mapping[str, ComplianceModel] | None = None,
    validation: Validation | None = None,
    compensation: Compensation | None = None,
    judged: Array | None = None,
    control: Array | None = None,
    monte_carlo: MonteCarlo | None = None,
) -> str:
    """A campaign, as far as it has come, as one self-contained HTML page.

    Args:
        plan: The plan with its study; certificate and run sheet come with it.
        trade_off: ρ0 over experiments and configurations; its section is left out if None.
        random: (K,) ρ0 of random feasible plans with as many experiments [m].
        others: Other plans by name, to compare with.
        identification: The compliances found.
        references: Compliances from elsewhere, by name, three at most: known before, or true.
        validation: The model against readings.
        compensation: A corrected path.
        judged: (N, 3) what remains of its error if the robot is as a true model says [m]; see
            `compensation.residual`.
        control: (N, 3) the same for a correction to the wrong side, which must be worse [m].
        monte_carlo: Virtual campaigns of plans side by side.

    Returns:
        HTML text that needs no network: styles, pictures and the 3D views are inside.

    Raises:
        InputError: there is nothing to show.
    """
    from elastocal.report.contents import Contents
    from elastocal.report.page import render

    return render(
        Contents(
            plan=plan,
            trade_off=trade_off,
            random=random,
            others=others or {},
            identification=identification,
            references=references or {},
            validation=validation,
            compensation=compensation,
            judged=judged,
            control=control,
            monte_carlo=monte_carlo,
        )
    )
