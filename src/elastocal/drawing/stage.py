"""Stage: everything of a section that can be drawn, in one frame and at one scale.

In: posed load cases. Out: figures with their loads, and the box that holds them. The 3D
scene and the static pictures draw the same stage.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array
from elastocal.drawing.skeleton import Skeleton, skeletons
from elastocal.elastic.load_cases import LoadCases
from elastocal.robot.chain import Robot, Tool
from elastocal.wording.numbers import plain

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
class DrawnCase:
    """One drawn load case.

    Attributes:
        label: What is written next to it.
        skeleton: The robot [m].
        force: (3,) arrow of the force, scaled to a length [m]; zero if there is none.
        moment: (3,) arrow of the moment, likewise.
        load: Size of the wrench in words: "2500 N".
        vectors: Small vectors that begin at its markers.
        trace: (K, 3) line that the tool follows [m]; none for a single pose.
    """

    label: str
    skeleton: Skeleton
    force: Array
    moment: Array
    load: str
    vectors: tuple[Vector, ...] = ()
    trace: Array = field(default_factory=lambda: np.zeros((0, 3)))


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

    planned: tuple[DrawnCase, ...]
    tests: tuple[DrawnCase, ...]
    peak: tuple[DrawnCase, ...]
    lower: Array
    upper: Array
    size: float


def posed(robot: Robot, tool: Tool, cases: LoadCases, labels: list[str]) -> tuple[DrawnCase, ...]:
    """Figures of N load cases."""
    drawn = skeletons(robot, tool, cases.q)
    size = max(float(np.linalg.norm(s.points, axis=1).max()) for s in drawn)
    return figures(drawn, cases, labels, size)


def boxed(
    planned: tuple[DrawnCase, ...],
    tests: tuple[DrawnCase, ...] = (),
    peak: tuple[DrawnCase, ...] = (),
    further: Array | None = None,
) -> Stage:
    """The stage that holds figures, and `further` points (., 3) [m]."""
    drawn = (*planned, *peak, *tests)
    size = max(float(np.linalg.norm(f.skeleton.points, axis=1).max()) for f in drawn)
    points = [extent(f) for f in drawn] + [np.zeros((1, 3))]
    box = np.vstack(points + ([] if further is None else [further]))
    margin = size * np.array([0.04, 0.04, 0.08])  # labels hang below the arrows
    low, high = box.min(axis=0) - margin, box.max(axis=0) + margin
    return Stage(planned, tests, peak, low, high, size)


def figures(
    posed: tuple[Skeleton, ...] | list[Skeleton], cases: LoadCases, labels: list[str], size: float
) -> tuple[DrawnCase, ...]:
    """Figures whose longest arrow has the length of `_ARROW` times `size`."""
    scaled = []
    for part in (cases.wrench[:, :3], cases.wrench[:, 3:]):
        largest = float(np.linalg.norm(part, axis=1).max(initial=0.0))
        scaled.append(part * (_ARROW * size / largest if largest > 0.0 else 0.0))
    return tuple(
        DrawnCase(label, skeleton, scaled[0][i], scaled[1][i], _load(cases.wrench[i]))
        for i, (label, skeleton) in enumerate(zip(labels, posed, strict=True))
    )


def _load(wrench: Array) -> str:
    """Size of a wrench (6,) [N, N·m] in words."""
    sizes = (float(np.linalg.norm(wrench[:3])), "N"), (float(np.linalg.norm(wrench[3:])), "N·m")
    return ", ".join(f"{plain(size)}\u00a0{unit}" for size, unit in sizes if size > 0.0)


def extent(figure: DrawnCase) -> Array:
    """(., 3) points that a figure covers, arrows included [m]."""
    at = figure.skeleton.load_point
    ends = [v.start + v.along for v in figure.vectors]
    points = [figure.skeleton.points, at + figure.force, at + figure.moment, *ends, figure.trace]
    return np.vstack(points)
