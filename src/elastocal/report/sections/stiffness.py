"""Section of the stiffness at the test poses, and of the error that the model leaves there.

In: what a model says of the test poses. Out: one section.
"""

from __future__ import annotations

from elastocal.report.contents import Contents
from elastocal.report.section import Chapter, PageSection, Values
from elastocal.report.tables import BarTable, Row
from elastocal.study.at_test_poses import AtTestPose
from elastocal.wording.numbers import length, vector
from elastocal.wording.stiffness import COMPLIANCE, STIFFNESS, left_out, ranged


def stiffness_chapter(contents: Contents) -> Chapter | None:
    """The section, if a model says anything of a test pose."""
    if not contents.at_test_poses:
        return None
    values = {"poses": [_pose(one) for one in contents.at_test_poses]}
    return Chapter("Stiffness", (PageSection("stiffness", "At the test poses", values),))


def _pose(one: AtTestPose) -> Values:
    """One test pose."""
    stiff = one.cartesian
    lines = (*stiff.axes, *stiff.principal)
    softest = max(line.compliance.value for line in lines) or 1.0
    rows = tuple(
        Row(
            (
                line.name if len(line.name) == 1 else f"{line.name} {vector(line.direction, 2)}",
                ranged(line.compliance, COMPLIANCE[0]),
                ranged(line.stiffness, STIFFNESS[0]),
            ),
            max(line.compliance.value, 0.0) / softest,
        )
        for line in lines
    )
    held = [
        f"{axis} {ranged(interval, STIFFNESS[0])}"
        for axis, interval in zip("xyz", stiff.held[:3], strict=bool(stiff.held))
    ]
    return {
        "name": one.name,
        "place": one.place,
        "tool": one.tool,
        "rho0": length(one.rho0),
        "table": BarTable(("force along", COMPLIANCE[1], STIFFNESS[1]), rows),
        "held": held,
        "left_out": left_out(stiff.missing, stiff.rigid),
    }
