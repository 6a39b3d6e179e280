"""The box on top: how far the campaign is, in plain words, and what is weak in it.

In: contents. Out: the section.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from elastocal.compensation.compensate import Compensation
from elastocal.compensation.remaining import alarms, rms
from elastocal.identification.result import Identification
from elastocal.identification.validation import Validation
from elastocal.planning.plan import Plan
from elastocal.report.contents import Contents
from elastocal.report.section import PageSection
from elastocal.report.sections.compensation import compensation_remarks
from elastocal.report.sections.identification import readings_remarks
from elastocal.report.sections.identification import remarks as identification_remarks
from elastocal.report.sections.provenance import robot_of
from elastocal.report.sections.validation import origin, removed, validation_remarks
from elastocal.report.verdict import only
from elastocal.simulation.campaigns import MonteCarlo
from elastocal.simulation.prediction import doubts_of_campaigns
from elastocal.wording import worded
from elastocal.wording.lists import counted
from elastocal.wording.numbers import length, number, percent, small, sure

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
    stages = (contents.identification, contents.validation, contents.compensation)
    later = any(stage is not None for stage in (*stages, contents.monte_carlo))
    return f"{contents.plan.study.name}: calibration {'campaign' if later else 'plan'}"


def state_section(contents: Contents) -> PageSection:
    """State of the campaign."""
    robot = robot_of(contents)
    name = contents.plan.study.name if contents.plan is not None else ""
    steps = list(_steps(contents))
    done = {step.name for step in steps}
    missing = [Step(step, "", "–", said) for step, said in _NEXT.items() if step not in done]
    order = [*_NEXT, "Simulated"]
    steps = sorted([*steps, *missing], key=lambda step: order.index(step.name))
    return PageSection(
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
    """The stages there are."""
    if contents.plan is not None:
        yield _planned(contents.plan)
    if contents.identification is not None:
        yield _identified(contents.identification)
    if contents.validation is not None:
        yield _validated(contents.validation)
    if contents.compensation is not None:
        yield _compensated(contents, contents.compensation)
    if contents.monte_carlo is not None:
        yield _simulated(contents.monte_carlo)


def _planned(plan: Plan) -> Step:
    """What the plan promises: ρ0, or more where errors of load cases count."""
    efficiency, promised = plan.certificate.efficiency, plan.assessment.promised
    what = "expected position error ρ₀"
    if promised != plan.assessment.rho0:
        what = "promised position error"
    said = f"{what} after compensation{only(plan)}, from {counted(plan.count, 'experiment')}"
    if np.isfinite(efficiency):
        said += f"; efficiency {percent(efficiency)}, {plan.certificate.kind} certificate"
    return Step("Planned", "verdict", length(promised), said + ".")


def _identified(found: Identification) -> Step:
    """The least certain compliance."""
    if set(found.identified) <= set(found.held):
        return Step("Identified", "identification", "none", "all are held at zero by the bound.")
    relative = found.relative_error
    worst = int(np.argmax(relative))
    said = (
        f"largest standard error, of {found.identified[worst]}; "
        f"{counted(len(found.identified), 'compliance')} from "
        f"{counted(len(found.measurements.cases), 'experiment')}."
    )
    if np.isfinite(found.scale):
        data = found.measurements
        for noise in found.noise_of_kinds:
            kind = noise.kind
            sigma, of = data.noise_of(kind), "" if kind.unit == "m" else "of rotations "
            said += (
                f" Noise {of}found: σ = {small(noise.scale * sigma, kind.unit)}, promised "
                f"{small(sigma, kind.unit)}."
            )
    largest = float(relative[worst])
    value = f"± {number(100.0 * largest, 2)} %" if largest < 1.0 else "± over 100 %"
    return Step("Identified", "identification", value, said)


def _validated(found: Validation) -> Step:
    """What the model removes."""
    first, *others = (removed(found, kind) for kind in found.measurements.quantities)
    turned = "".join(f"; {o.share} of the {o.what}, {o.before} → {o.after}" for o in others)
    said = (
        f"of the {first.what} removed, {first.before} → {first.after}{turned}, in "
        f"{origin(found)}. {percent(found.inside)} inside intervals that promise "
        f"{sure(found.confidence)}."
    )
    return Step("Validated", "validation", first.share, said)


def _compensated(contents: Contents, done: Compensation) -> Step:
    """The error along the path before and after."""
    before, left = rms(done.before), rms(done.expected)
    value = f"{length(before)} → {length(left)}"
    said = f"position error expected along {counted(len(done), 'point')} of the path (RMS)."
    if contents.judged is not None:
        value = f"{length(before)} → {length(rms(contents.judged))}"
        said = (
            f"position error of the true robot along {counted(len(done), 'point')} of the path "
            f"(RMS); {length(left)} expected."
        )
    return Step("Compensated", "remaining", value, said)


def _simulated(found: MonteCarlo) -> Step:
    """The plan that differs most from its prediction."""
    ratios = [plan.rms / plan.rho0 for plan in found.plans]
    worst = max(ratios, key=lambda ratio: abs(np.log(ratio)))
    said = f"root mean square error found in {found.number} virtual campaigns"
    if len(found.plans) > 1:
        said += f" of each of {len(found.plans)} plans, where it differs most from the prediction"
    said += "."
    unit = "× promised" if found.nuisance else "ρ₀"
    return Step("Simulated", "monte-carlo", f"{number(worst)} {unit}", said)


def _alarms(contents: Contents) -> list[tuple[str, tuple[str, ...]]]:
    """What forbids to go on, with what must not be done."""
    found = []
    if contents.plan is not None and contents.plan.broken:
        said = "This plan breaks its constraints. Do not run it."
        found.append((said, tuple(map(worded, contents.plan.broken))))
    if contents.compensation is not None and (told := alarms(contents.compensation)):
        found.append(("Do not run the corrected path.", tuple(map(worded, told))))
    return found


def _remarks(contents: Contents) -> tuple[str, ...]:
    """What is weak, of every stage."""
    remarks: list[str] = []
    if contents.plan is not None:
        remarks += map(worded, contents.plan.doubts)
    if contents.identification is not None:
        found = contents.identification
        remarks += identification_remarks(found, contents.searched)
    if contents.validation is not None:
        if contents.validation.kept_aside:
            kept = readings_remarks(contents.validation.measurements)
            remarks += [f"readings kept aside: {remark}" for remark in kept]
        remarks += validation_remarks(contents.validation)
    remarks += compensation_remarks(contents)
    if contents.monte_carlo is not None:
        remarks += map(worded, doubts_of_campaigns(contents.monte_carlo))
    return tuple(dict.fromkeys(remarks))
