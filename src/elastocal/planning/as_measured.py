"""A campaign that was measured, judged as the plan that it was.

In: measurements. Out: their load cases with repeats, and an evaluation that says what they break:
it is done, so nothing is refused for it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import BoolArray, IntArray
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt
from elastocal.measuring.measurements import FORCE_SCATTER, JOINT_SCATTER, Measurements
from elastocal.planning.certificate import Bound
from elastocal.planning.evaluation import Evaluation, evaluate
from elastocal.robot.chain import Robot
from elastocal.study.study import Study


@dataclass(frozen=True)
class Measured:
    """What was done.

    Attributes:
        cases: S load cases.
        repeats: (S,) how often each was measured.
        names: Names of the experiments of each.
    """

    cases: LoadCases
    repeats: IntArray
    names: tuple[tuple[str, ...], ...]


def as_measured(measurements: Measurements, robot: Robot) -> Measured:
    """Load cases with repeats; experiments that differ by what instruments scatter are one."""
    cases, left = measurements.cases, np.arange(len(measurements.cases))
    turns = np.array([not joint.prismatic for joint in robot.joints])
    groups = []
    while len(left):
        alike = _alike(cases, left, turns)
        groups.append(left[alike])
        left = left[~alike]
    first = np.array([group[0] for group in groups], dtype=np.int64)
    return Measured(
        cases.chosen(first),
        np.array([len(group) for group in groups]),
        tuple(tuple(measurements.names[i] for i in group) for group in groups),
    )


def _alike(cases: LoadCases, places: IntArray, turns: BoolArray) -> BoolArray:
    """Which of the load cases at `places` are the first of them, whole turns of joints aside."""
    q = cases.q[places]
    apart = q - q[0]
    apart -= 2.0 * np.pi * turns * np.round(apart / (2.0 * np.pi))
    alike = (np.abs(apart) <= JOINT_SCATTER).all(axis=1)
    for load in (cases.wrench[places], cases.first[places]):
        for side in (slice(0, 3), slice(3, 6)):
            differ = np.linalg.norm(load[:, side] - load[0, side], axis=1)
            alike &= differ <= FORCE_SCATTER * np.linalg.norm(load[0, side])
    return np.asarray(alike)


def evaluate_measured(study: Study, measured: Measured, bound: Bound) -> Evaluation:
    """What a campaign is worth as a plan, with the noise of the study; its motions are done.

    Args:
        study: The study.
        measured: What was done.
        bound: Bound for this study and as many experiments.
    """
    found = evaluate(study, measured.cases, measured.repeats, {}, bound, None)
    return replace(
        found,
        assessment=replace(found.assessment, violations=()),
        objections=(),
        remarks=tuple(_outside(found.assessment.violations, measured)),
        measured=True,
    )


def _outside(violations: tuple[Doubt, ...], measured: Measured) -> Iterator[Doubt]:
    """One doubt for each constraint that was broken by more than instruments scatter."""
    groups: dict[tuple[str, str], list[tuple[int, float]]] = {}
    for doubt in violations:
        by, scatter = _by(doubt)
        if by > scatter:
            what = doubt.about[0] if doubt.about else doubt.code
            place = int(doubt.numbers["load_case"]) - 1
            groups.setdefault((what, doubt.unit), []).append((place, by))
    for (what, unit), found in groups.items():
        names = tuple(name for place, _ in found for name in measured.names[place])
        yield Doubt("outside-study", names, (what,), {"by": max(by for _, by in found)}, unit)


def _by(doubt: Doubt) -> tuple[float, float]:
    """How far beyond what is allowed, and how far is put down to instruments."""
    numbers = doubt.numbers
    if "by" in numbers:
        return numbers["by"], JOINT_SCATTER
    load = np.array([numbers[axis] for axis in "xyz"])
    if "bound" in numbers:
        return float(np.linalg.norm(load)) - numbers["bound"], FORCE_SCATTER * numbers["bound"]
    wanted = np.array([numbers[f"wanted_{axis}"] for axis in "xyz"])
    return float(np.linalg.norm(load - wanted)), FORCE_SCATTER * float(np.linalg.norm(wanted))
