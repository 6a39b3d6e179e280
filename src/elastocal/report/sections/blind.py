"""Section of what the readings of a plan cannot show."""

from __future__ import annotations

from elastocal.planning.blind import BlindEffect
from elastocal.planning.plan import Plan
from elastocal.report.charts.blind import BlindLane, blind_chart
from elastocal.report.layout import two_widths
from elastocal.report.section import PageSection, Values
from elastocal.report.tables import BarTable, Row
from elastocal.wording.blind import BLIND, effect_name, proof_sentence, size_of
from elastocal.wording.mends import ESTIMATES, MENDS, mend_name, minutes_phrase
from elastocal.wording.numbers import length
from elastocal.wording.robust import robust_sentences

_INVISIBLE, _VISIBLE = 6, 8  # lanes


def blind_sections(plan: Plan) -> tuple[PageSection, ...]:
    """The section; none if nothing is known."""
    found = plan.blind
    if found is None or not found.effects:
        return ()
    worth = plan.assessment
    claim = worth.rho0 if worth.promise is None else worth.promise.rho0
    shown = (*found.invisible[:_INVISIBLE], *found.visible[:_VISIBLE])
    lanes = [_lane(effect) for effect in shown]
    chart = two_widths(lambda width: blind_chart(lanes, claim, width))
    left = len(found.effects) - len(lanes)
    values: Values = {
        "title": BLIND,
        "chart": chart,
        "said": proof_sentence(found),
        "robust": robust_sentences(plan),
        "left": left,
        "mends": _mends(plan),
        "help": f"{ESTIMATES} This plan promises {length(claim)}.",
    }
    return (PageSection("blind", "Not seen", values),)


def _lane(effect: BlindEffect) -> BlindLane:
    seen = "dot" if effect.half <= effect.largest else "ring"
    seen = "far" if effect.invisible else seen
    return BlindLane(effect_name(effect), size_of(effect.size, effect.unit), seen, effect.error)


def _mends(plan: Plan) -> BarTable | None:
    """What would promise more; None if nothing is known to."""
    rows = tuple(
        Row((mend_name(mend), length(mend.promised), minutes_phrase(mend))) for mend in plan.mends
    )
    return BarTable((MENDS, "Promised", "At the cell"), rows) if rows else None
