"""The box on top: how far the campaign is, in plain words, and what is weak in it.

In: contents. Out: the section.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from elastocal.identification import Identification
from elastocal.planning import Plan
from elastocal.report.contents import Contents
from elastocal.report.section import Section
from elastocal.report.sections.identification import promised
from elastocal.report.sections.provenance import robot_of
from elastocal.report.sections.validation import origin, removed, validation_remarks
from elastocal.report.units import length, number, percent, sure
from elastocal.report.verdict import counted
from elastocal.validation import Validation, summary

_NEXT = {
    "Planned": "no plan in this report",
    "Identified": "no measurements yet",
    "Validated": "not validated yet",
    "Compensated": "no path compensated yet",
}


@dataclass(frozen=True)
class Step:
    """One stage of the campaign.

    Attributes:
        name: What was done.
        anchor: Section that tells more; empty if the stage is missing.
        value: The number that matters.
        meaning: One sentence.
    """

    name: str
    anchor: str
    value: str
    meaning: str


def title(contents: Contents) -> str:
    """Title of the page."""
    if contents.plan is None:
        robot = robot_of(contents)
        return f"{robot.name}: calibration" if robot is not None else "Calibration"
    later = contents.identification or contents.validation
    return f"{contents.plan.study.name}: calibration {'campaign' if later else 'plan'}"


def state_section(contents: Contents) -> Section:
    """State of the campaign."""
    robot = robot_of(contents)
    name = contents.plan.study.name if contents.plan is not None else ""
    steps = list(_steps(contents))
    done = {step.name for step in steps}
    missing = [Step(step, "", "–", said) for step, said in _NEXT.items() if step not in done]
    order = [*_NEXT, "Simulated"]
    steps = sorted([*steps, *missing], key=lambda step: order.index(step.name))
    return Section(
        "state",
        "",
        {
            "robot": robot.name if robot is not None else "",
            "name": name or (robot.name if robot is not None else "Calibration"),
            "steps": steps,
            "alarms": _alarms(contents),
            "remarks": _remarks(contents),
        },
    )


def _steps(contents: Contents) -> Iterator[Step]:
    if contents.plan is not None:
        yield _planned(contents.plan)
    if contents.identification is not None:
        yield _identified(contents.identification)
    if contents.validation is not None:
        yield _validated(contents.validation)


def _planned(plan: Plan) -> Step:
    efficiency = plan.certificate.efficiency
    said = (
        f"expected position error ρ₀ after compensation, from {counted(plan.count, 'experiment')}"
    )
    if np.isfinite(efficiency):
        said += f"; efficiency {percent(efficiency)}"
    return Step("Planned", "verdict", length(plan.assessment.rho0), said + ".")


def _identified(found: Identification) -> Step:
    with np.errstate(divide="ignore"):
        relative = found.standard_error / np.abs(found.compliance)
    worst = int(np.argmax(relative))
    said = (
        f"largest standard error, of {found.identified[worst]}; "
        f"{counted(len(found.identified), 'compliance')} from "
        f"{counted(len(found.measurements.cases), 'experiment')}."
    )
    if np.isfinite(found.scale):
        sigma = promised(found)
        said += f" Noise found: σ = {length(found.scale * sigma)}, promised {length(sigma)}."
    value = f"± {number(100.0 * float(relative[worst]), 2)} %"
    return Step("Identified", "identification", value, said)


def _validated(found: Validation) -> Step:
    before, after = summary(found.before), summary(found.after)
    said = (
        f"of the deflection removed, {length(before.rms)} → {length(after.rms)}, in "
        f"{origin(found)}. {percent(found.inside)} inside intervals that promise "
        f"{sure(found.confidence)}."
    )
    return Step("Validated", "validation", percent(removed(found)), said)


def _alarms(contents: Contents) -> tuple[str, ...]:
    """What forbids to go on."""
    return contents.plan.assessment.violations if contents.plan is not None else ()


def _remarks(contents: Contents) -> tuple[str, ...]:
    """What is weak, of every stage."""
    remarks: list[str] = []
    if contents.identification is not None:
        found = contents.identification
        remarks += [*found.measurements.remarks, *found.remarks]
    if contents.validation is not None:
        if contents.validation.kept_aside:
            remarks += contents.validation.measurements.remarks
        remarks += validation_remarks(contents.validation)
    return tuple(dict.fromkeys(remarks))
