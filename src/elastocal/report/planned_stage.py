"""The stage of a plan: everything of it that can be drawn, in one frame and at one scale."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.constraints import Clearance
from elastocal.drawing.obstacles import corners
from elastocal.drawing.skeleton import skeletons
from elastocal.drawing.stage import DrawnCase, Stage, boxed, figures
from elastocal.drawing.traces import trace
from elastocal.planning.plan import Plan

_HALL = 1.1  # farthest that obstacles are drawn, over the size of the robot


def planned_stage(plan: Plan) -> Stage:
    """What of `plan` can be drawn."""
    robot, tool = plan.study.robot, plan.study.experiments.tool
    cases, peak = plan.load_cases, plan.certificate.peak
    posed = skeletons(robot, tool, cases.q)
    at_peak = () if peak is None else skeletons(robot, tool, peak.q)
    drawn = [(p, p.tool, p.case) for p in plan.study.test_poses if p.tool and p.case]
    tested = [skeletons(robot, own, case.q)[0] for _, own, case in drawn]
    everything = [*posed, *at_peak, *tested]
    size = max(float(np.linalg.norm(s.points, axis=1).max()) for s in everything)
    numbers = [str(i + 1) for i in range(len(cases))]
    planned = figures(posed, cases, numbers, size)
    peaks = () if peak is None else figures(at_peak, peak, ["peak"], size)
    tests: list[DrawnCase] = []
    for (pose, _, case), skeleton in zip(drawn, tested, strict=True):
        posed_test = figures([skeleton], case, [pose.name], size)
        tests += [replace(figure, trace=trace(robot, pose)) for figure in posed_test]
    watched = [c for c in plan.study.constraints if isinstance(c, Clearance)]
    things = np.vstack([np.zeros((1, 3)), *(corners(c) for c in watched)])
    # A hall around the cell must not make the robot small: it is cut off.
    return boxed(planned, tuple(tests), peaks, np.clip(things, -_HALL * size, _HALL * size))
