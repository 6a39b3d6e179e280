"""Section on where everything comes from.

In: contents. Out: the section.
"""

from __future__ import annotations

from elastocal import __version__
from elastocal.measuring.measurements import Measurements
from elastocal.report.contents import Contents
from elastocal.report.section import PageSection
from elastocal.robot.chain import Robot
from elastocal.study.study import Study


def provenance(contents: Contents) -> PageSection:
    """Study, robot, files with their hashes, version."""
    facts: list[tuple[str, str]] = []
    plan = contents.plan
    if plan is not None:
        facts.append(("Study", plan.study.name))
    robot = robot_of(contents)
    if robot is not None:
        facts.append(("Robot", f"{robot.name}, {len(robot.joints)} joints"))
    if plan is not None:
        facts += [("Criterion", plan.criterion), ("Seed", str(plan.seed))]
        facts += _before(plan.study)
    found, validation = contents.identification, contents.validation
    if found is not None:
        facts += _source("Measurements", found.measurements)

        facts.append(
            ("Fit", f"{found.how.model} model, σ {found.how.sigma}, loss {found.how.loss}")
        )
    if validation is not None and validation.kept_aside:
        facts += _source("Kept aside", validation.measurements)
    if contents.compensation is not None:
        model = contents.compensation.model
        facts.append(("Compensated with", model.source or "a model that does not say its source"))
    facts.append(("elastocal", __version__))
    text = "" if plan is None else plan.study.text
    return PageSection("provenance", "Provenance", {"facts": facts, "text": text})


def robot_of(contents: Contents) -> Robot | None:
    """The robot all of it is about."""
    if contents.plan is not None:
        return contents.plan.study.robot
    if contents.identification is not None:
        return contents.identification.arm.robot
    if contents.compensation is not None:
        return contents.compensation.arm.robot
    return None


def _before(study: Study) -> list[tuple[str, str]]:
    """Files with what the plan counts as known before, and of its paths, with their hashes."""
    parts = {
        "Known": study.known,
        "Prior": study.carried_out or study.earlier,
        "Measured before": study.done,
    }
    named = [(name, part.source, part.sha256) for name, part in parts.items() if part is not None]
    named += [("Path", source, sha256) for source, sha256 in study.path_hashes.items()]
    rows = []
    for name, source, sha256 in named:
        rows.append((name, source or "not from a file"))
        if sha256:
            rows.append((f"{name}, SHA-256", sha256))
    return rows


def _source(name: str, data: Measurements) -> list[tuple[str, str]]:
    """File of measurements, with its hash."""
    rows = [(name, data.source or "not from a file")]
    if data.sha256:
        rows.append((f"{name}, SHA-256", data.sha256))
    return rows
