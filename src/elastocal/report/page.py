"""The page: sections put together from pictures, tables and sentences.

In: values. Out: HTML text. Everything a user named passes through escaping: jinja2's in HTML,
`svg.tag` in pictures, `scene` and `_script_json` in the 3D view.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from elastocal import __version__
from elastocal.arrays import Array
from elastocal.assessment import Assessment
from elastocal.comparison import TradeOff
from elastocal.planning import Plan
from elastocal.report import captions, tables
from elastocal.report.comparison_chart import comparison_chart
from elastocal.report.curve_chart import curve_chart
from elastocal.report.palette import COLOURS
from elastocal.report.picture import group, portrait
from elastocal.report.range_chart import range_chart
from elastocal.report.run_sheet import run_sheet, tool_points
from elastocal.report.scene import scene
from elastocal.report.stage import Figure, Stage, stage
from elastocal.report.units import number, words
from elastocal.report.verdict import bound_of, verdict

_WIDE, _NARROW = 860.0, 350.0


def render(
    plan: Plan,
    *,
    trade_off: TradeOff | None,
    random: Array | None,
    others: Mapping[str, Assessment],
) -> str:
    """HTML of a plan; see `elastocal.report.html`."""
    environment = Environment(
        loader=PackageLoader("elastocal.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["words"] = words
    drawn = stage(plan)
    return environment.get_template("page.html").render(
        plan=plan,
        study=plan.study,
        colours=COLOURS,
        verdict=verdict(plan, random),
        figures=_figures(plan, drawn),
        how_good=_how_good(plan, random, others),
        trade_off=None if trade_off is None else _trade_off(plan, trade_off),
        errors=tables.standard_errors(plan),
        certificate=_certificate(plan, drawn),
        ranges=_two_widths(lambda width: range_chart(plan, width)),
        margins=tables.margins(plan),
        criteria=tables.criteria(plan, others),
        cards=run_sheet(plan, drawn),
        tool_points=tool_points(plan),
        version=__version__,
        scene=_script_json(scene(plan, drawn)),
        plotly=_plotly(),
    )


def _figures(plan: Plan, drawn: Stage) -> dict[str, Any]:
    """Static pictures of everything."""
    return {
        "group": group(drawn.planned, drawn.tests, drawn, 360.0),
        "planned": [(f.label, f.load, portrait(f, drawn)) for f in drawn.planned],
        "tests": [(f.label, f.load, portrait(f, drawn, "test")) for f in drawn.tests],
        "remarks": captions.of_scene(plan),
    }


def _how_good(plan: Plan, random: Array | None, others: Mapping[str, Assessment]) -> dict[str, Any]:
    """ρ0 among other plans, and by test pose."""
    rho0 = plan.assessment.rho0
    compared = {name: other.rho0 for name, other in others.items()}
    chart = None
    if np.isfinite(rho0):
        chart = _two_widths(
            lambda width: comparison_chart(rho0, bound_of(plan), random, compared, width)
        )
    by_pose = tables.test_pose_errors(plan) if len(plan.study.test_poses) > 1 else None
    return {"chart": chart, "caption": captions.of_random(random), "by_pose": by_pose}


def _trade_off(plan: Plan, trade_off: TradeOff) -> list[tuple[str, Markup, str]]:
    """Title, picture and caption of the curves there are."""
    own, few = plan.assessment.rho0, len(plan.load_cases)
    if not np.isfinite(own):
        return []
    curves = []
    if len(trade_off.counts):
        chart = curve_chart(
            trade_off.counts,
            trade_off.rho0,
            trade_off.bound,
            (plan.count, own),
            "number of experiments",
        )
        said = captions.of_experiments(plan, trade_off)
        curves.append(("More or fewer experiments", chart, said))
    if len(trade_off.configurations):
        chart = curve_chart(
            trade_off.configurations,
            trade_off.rho0_configurations,
            None,
            (few, own),
            f"configurations for {plan.count} experiments",
        )
        said = captions.of_configurations(trade_off)
        curves.append(("More or fewer configurations", chart, said))
    return curves


def _certificate(plan: Plan, drawn: Stage) -> dict[str, Any]:
    """Peak of the sensitivity function and support of the continuous design."""
    certificate = plan.certificate
    return {
        "exists": certificate.kind != "none",
        "ratio": number(certificate.peak_ratio, 6),
        "caption": captions.of_peak(certificate),
        "picture": _alone(drawn.peak[0], drawn) if drawn.peak else None,
        "peak": tables.peak(plan),
        "support": tables.support(plan),
    }


def _alone(figure: Figure, drawn: Stage) -> Markup:
    """A figure at a scale of its own."""
    return portrait(figure, replace(drawn, planned=(), tests=(), peak=(figure,)))


def _two_widths(draw: Callable[[float], Markup]) -> Markup:
    """A picture for wide screens and paper, and one for phones."""
    return Markup('<div class="wide">{}</div><div class="narrow">{}</div>').format(
        draw(_WIDE), draw(_NARROW)
    )


def _script_json(value: dict[str, Any]) -> Markup:
    """JSON that cannot end the script element it stands in."""
    text = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)


def _plotly() -> Markup:
    """plotly.js, once."""
    from plotly.offline import get_plotlyjs

    source: str = get_plotlyjs()
    return Markup(source.replace("</script", "<\\/script"))
