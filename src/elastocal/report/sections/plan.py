"""Sections of a plan: what it achieves, the robot, certificate, constraints, run sheet.

In: plan, random plans, curves, other plans. Out: sections.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.picture import group, portrait
from elastocal.drawing.stage import DrawnCase, Stage
from elastocal.planning.assessment import Assessment
from elastocal.planning.plan import Plan
from elastocal.planning.trade_off import TradeOff
from elastocal.report import captions, tables
from elastocal.report.charts.bounds import bounds_chart
from elastocal.report.charts.comparison import comparison_chart
from elastocal.report.charts.curve import curve_chart
from elastocal.report.charts.hours import hours_chart
from elastocal.report.charts.ranges import range_chart
from elastocal.report.contents import Contents
from elastocal.report.layout import two_widths
from elastocal.report.planned_stage import planned_stage
from elastocal.report.run_sheet import run_sheet, tool_points, way_home
from elastocal.report.scene import scene
from elastocal.report.section import Chapter, PageSection, Values
from elastocal.report.sections.blind import blind_sections
from elastocal.report.verdict import bound_of, verdict
from elastocal.wording.lists import counted
from elastocal.wording.numbers import number
from elastocal.wording.plans import freedom
from elastocal.wording.watch import watch


def plan_chapter(contents: Contents, *, alone: bool) -> Chapter | None:
    """The sections of the plan; `alone` if the page has no other stage."""
    plan = contents.plan
    if plan is None:
        return None
    drawn = planned_stage(plan)
    about = {"plan": plan, "study": plan.study}
    said = verdict(plan, contents.random)
    constraints = {
        "ranges": two_widths(lambda width: range_chart(plan, width)),
        "margins": tables.margins(plan),
        "view": tables.view(plan),
        "watch": watch(plan.watch.watched, plan.watch.unwatched),
    }
    sheet = {
        **about,
        "cards": run_sheet(plan, drawn),
        "tool_points": tool_points(plan),
        "way_home": way_home(plan),
        "watch": constraints["watch"],
        "freedom": freedom(plan.free_joints, plan.turns_with_load, plan.load_range),
    }
    top = {**about, "verdict": said, "alone": alone}
    top["picture"] = group(drawn.planned, drawn.tests, drawn, 360.0)
    sections = [
        PageSection("verdict", "" if alone else "Result", top),
        PageSection("robot", "Robot", _robot(plan, drawn), scene(plan, drawn)),
        PageSection("worth", "How good", _worth(plan, contents.random, contents.others)),
        PageSection("errors", "Errors", _errors(plan)),
        *blind_sections(plan),
        PageSection("certificate", "Certificate", _certificate(plan, drawn, said.proof)),
        PageSection("constraints", "Constraints", constraints),
        PageSection("criteria", "Criteria", {"criteria": tables.criteria(plan, contents.others)}),
        PageSection("run-sheet", "Run sheet", sheet),
    ]
    if contents.trade_off is not None:
        curves = _trade_off(plan, contents.trade_off)
        if curves:
            sections.insert(3, PageSection("effort", "How many", {"curves": curves}))
    return Chapter("Plan", tuple(sections))


def _robot(plan: Plan, drawn: Stage) -> Values:
    """Static pictures of everything."""
    return {
        "plan": plan,
        "planned": [(f.label, f.load, portrait(f, drawn)) for f in drawn.planned],
        "tests": [(captions.of_test(f), f.load, portrait(f, drawn, "test")) for f in drawn.tests],
        "remarks": captions.of_scene(plan),
    }


def _worth(plan: Plan, random: Array | None, others: Mapping[str, Assessment]) -> Values:
    """What is left among other plans, and by test pose."""
    rho0 = plan.assessment.promised
    compared = {name: other.promised for name, other in others.items()}
    chart = None
    if np.isfinite(rho0):
        chart = two_widths(
            lambda width: comparison_chart(rho0, bound_of(plan), random, compared, width)
        )
    several = len(plan.study.test_poses) > 1 or plan.study.only_path is not None
    by_pose = tables.test_pose_errors(plan) if several else None
    return {"chart": chart, "caption": captions.of_random(random), "by_pose": by_pose}


def _errors(plan: Plan) -> Values:
    """Standard errors, and sizes of what counts besides."""
    return {"errors": tables.standard_errors(plan), "nuisance": tables.nuisance(plan)}


def _trade_off(plan: Plan, trade_off: TradeOff) -> list[tuple[str, Markup, str]]:
    """Title, picture and caption of the curves there are."""
    own, few = plan.assessment.promised, len(plan.load_cases)
    if not np.isfinite(own):
        return []
    curves = []
    if len(trade_off.counts):
        chart = curve_chart(
            trade_off.counts,
            trade_off.rho0,
            trade_off.bound,
            (plan.count, own),
            "number of further experiments" if plan.study.done else "number of experiments",
        )
        said = captions.of_experiments(plan, trade_off)
        curves.append(("More or fewer experiments", chart, said))
    if len(trade_off.configurations):
        chart = curve_chart(
            trade_off.configurations,
            trade_off.rho0_configurations,
            None,
            (few, own),
            f"configurations for {counted(plan.count, 'experiment')}",
        )
        said = captions.of_configurations(trade_off)
        curves.append(("More or fewer configurations", chart, said))
    if trade_off.by_time:
        chart = hours_chart(trade_off.by_time, (plan.schedule.hours, own))
        curves.append(("Accuracy against time", chart, captions.of_hours(plan)))
    return curves


def _certificate(plan: Plan, drawn: Stage, proof: tuple[str, ...]) -> Values:
    """Peak of the sensitivity function and support of the continuous design."""
    certificate = plan.certificate
    return {
        "exists": certificate.kind != "none",
        "kind": certificate.kind,
        "bounds": _bounds(plan),
        "record": "" if certificate.proved is None else certificate.proved.record,
        "sha256": "" if certificate.proved is None else certificate.proved.sha256,
        "proof": proof,
        "ratio": number(certificate.peak_ratio, 6),
        "caption": captions.of_peak(certificate),
        "picture": _alone(drawn.peak[0], drawn) if drawn.peak else None,
        "peak": tables.peak(plan),
        "support": tables.support(plan),
    }


def _bounds(plan: Plan) -> Markup | None:
    """Plan, bound of the search and proved bound; None where nothing is proved, or no length is."""
    certificate, bound = plan.certificate, plan.certificate.position_bound
    if certificate.proved is None or bound is None:
        return None
    worth, proved = plan.assessment, certificate.proved.loss
    value = worth.promised if certificate.promise else worth.criteria[certificate.criterion]
    return two_widths(lambda width: bounds_chart(value, bound, proved, width))


def _alone(figure: DrawnCase, drawn: Stage) -> Markup:
    """A figure at a scale of its own."""
    return portrait(figure, replace(drawn, planned=(), tests=(), peak=(figure,)))
