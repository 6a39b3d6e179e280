"""Stage: everything of a section that can be drawn, in one frame and at one scale.

In: a plan, or posed figures. Out: figures with their loads, and the box that holds them. The 3D
scene and the static pictures draw the same stage.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import Clearance
from elastocal.drawing.obstacles import corners
from elastocal.drawing.skeleton import Skeleton, skeletons
from elastocal.drawing.units import plain
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.plan import Plan
from elastocal.robot.chain import Robot, Tool

_HALL = 1.1  # farthest that obstacles are drawn, over the size of the robot
_ARROW = 0.22  # longest arrow over the size of the robot


@dataclass(frozen=True)
class Vector:
    """A small vector, magnified, such as the residual of a reading.

    Attributes:
        start: (3,) where it begins [m].
        along: (3,) magnified [m].
        halo: Radius of a ball around its start, magnified [m]: what noise would explain.
    """

    start: Array
    along: Array
    halo: float


@dataclass(frozen=True)
class Figure:
    """One drawn load case.

    Attributes:
        label: What is written next to it.
        skeleton: The robot [m].
        force: (3,) arrow of the force, scaled to a length [m]; zero if there is none.
        moment: (3,) arrow of the moment, likewise.
        load: Size of the wrench in words: "2500 N".
        vectors: Small vectors that begin at its markers.
    """

    label: str
    skeleton: Skeleton
    force: Array
    moment: Array
    load: str
    vectors: tuple[Vector, ...] = ()


@dataclass(frozen=True)
class Stage:
    """Figures and the box around them.

    Attributes:
        planned: The S load cases of the plan.
        tests: Test poses that are load cases.
        peak: Where the sensitivity peaks, if there is a certificate.
        lower: (3,) corner of the box [m].
        upper: (3,) opposite corner [m].
        size: Largest distance from the base that a figure reaches [m].
    """

    planned: tuple[Figure, ...]
    tests: tuple[Figure, ...]
    peak: tuple[Figure, ...]
    lower: Array
    upper: Array
    size: float


def stage(plan: Plan) -> Stage:
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
    planned = _figures(posed, cases, numbers, size)
    peaks = () if peak is None else _figures(at_peak, peak, ["peak"], size)
    tests: list[Figure] = []
    for (pose, _, case), skeleton in zip(drawn, tested, strict=True):
        tests += _figures([skeleton], case, [pose.name], size)
    watched = [c for c in plan.study.constraints if isinstance(c, Clearance)]
    things = np.vstack([np.zeros((1, 3)), *(corners(c) for c in watched)])
    # A hall around the cell must not make the robot small: it is cut off.
    return boxed(planned, tuple(tests), peaks, np.clip(things, -_HALL * size, _HALL * size))


def posed(robot: Robot, tool: Tool, cases: LoadCases, labels: list[str]) -> tuple[Figure, ...]:
    """Figures of N load cases."""
    drawn = skeletons(robot, tool, cases.q)
    size = max(float(np.linalg.norm(s.points, axis=1).max()) for s in drawn)
    return _figures(drawn, cases, labels, size)


def boxed(
    planned: tuple[Figure, ...],
    tests: tuple[Figure, ...] = (),
    peak: tuple[Figure, ...] = (),
    further: Array | None = None,
) -> Stage:
    """The stage that holds figures, and `further` points (., 3) [m]."""
    figures = (*planned, *peak, *tests)
    size = max(float(np.linalg.norm(f.skeleton.points, axis=1).max()) for f in figures)
    points = [extent(f) for f in figures] + [np.zeros((1, 3))]
    box = np.vstack(points + ([] if further is None else [further]))
    margin = size * np.array([0.04, 0.04, 0.08])  # labels hang below the arrows
    low, high = box.min(axis=0) - margin, box.max(axis=0) + margin
    return Stage(planned, tests, peak, low, high, size)


def _figures(
    posed: tuple[Skeleton, ...] | list[Skeleton], cases: LoadCases, labels: list[str], size: float
) -> tuple[Figure, ...]:
    """Figures whose longest arrow has the length of `_ARROW` times `size`."""
    scaled = []
    for part in (cases.wrench[:, :3], cases.wrench[:, 3:]):
        largest = float(np.linalg.norm(part, axis=1).max(initial=0.0))
        scaled.append(part * (_ARROW * size / largest if largest > 0.0 else 0.0))
    return tuple(
        Figure(label, skeleton, scaled[0][i], scaled[1][i], _load(cases.wrench[i]))
        for i, (label, skeleton) in enumerate(zip(labels, posed, strict=True))
    )


def _load(wrench: Array) -> str:
    """Size of a wrench (6,) [N, N·m] in words."""
    sizes = (float(np.linalg.norm(wrench[:3])), "N"), (float(np.linalg.norm(wrench[3:])), "N·m")
    return ", ".join(f"{plain(size)}\u00a0{unit}" for size, unit in sizes if size > 0.0)


def extent(figure: Figure) -> Array:
    """(., 3) points that a figure covers, arrows included [m]."""
    at = figure.skeleton.load_point
    ends = [v.start + v.along for v in figure.vectors]
    return np.vstack([figure.skeleton.points, at + figure.force, at + figure.moment, *ends])
