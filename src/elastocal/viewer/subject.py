"""Subject: everything that a view can show, as one value, and the poses to step through.

In: study, plan, model. Out: stops: configurations with their load and their tool.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, IntArray, freeze, unset
from elastocal.elastic.allowed_loads import FixedVector, InPlane, Load, ThereOrNot
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.sensitivity import Sensitivity
from elastocal.robot.chain import Tool
from elastocal.study.study import Study
from elastocal.study.test_path import TestPath

KINDS = ("plan", "peak", "test", "middle")
"""What a stop is: of the plan, where measuring is worth most, a test pose, or neither."""


@dataclass(frozen=True)
class Stop:
    """A configuration that one can step to.

    Attributes:
        label: What it is called, alone of this name.
        kind: One of `KINDS`.
        tool: What the robot carries there.
        q: (n,) joint values [rad or m].
        wrench: (6,) load [N, N·m].
        via: (K, n) configurations that are passed on the way from the stop before [rad or m].
    """

    label: str
    kind: str
    tool: Tool
    q: Array
    wrench: Array
    via: Array = field(default_factory=unset)

    def __post_init__(self) -> None:
        freeze(self, "q", "wrench", via=np.reshape(self.via, (-1, len(self.q))))


@dataclass(frozen=True)
class Subject:
    """What a view shows.

    Attributes:
        study: The study.
        stops: Poses to step through, at least one.
        model: Compliances, None if no deflection is to be shown.
        sensitivity: Sensitivity at the certified design, None if there is none.
        width: Half width of intervals of the model, in standard errors.
        certificate: What kind of certificate the plan has, as a sentence; empty without a plan.
    """

    study: Study
    stops: tuple[Stop, ...]
    model: ComplianceModel | None = None
    sensitivity: Sensitivity | None = None
    width: float = 1.959964
    certificate: str = ""

    @property
    def tools(self) -> tuple[Tool, ...]:
        """The tools of all stops, each once."""
        return tuple({id(stop.tool): stop.tool for stop in self.stops}.values())

    @property
    def slider_limits(self) -> Array:
        """(2, n) joint values that can be set by hand: the limits, and where stops are."""
        q = np.array([stop.q for stop in self.stops])
        limits = self.study.limits
        return np.array(
            [np.minimum(limits[0], q.min(axis=0)), np.maximum(limits[1], q.max(axis=0))]
        )


def stops_of(
    study: Study,
    cases: LoadCases | None = None,
    repeats: IntArray | None = None,
    peak: LoadCases | None = None,
    via: Sequence[Array] = (),
) -> tuple[Stop, ...]:
    """Poses of a plan in their order, then where measuring is worth most, then test poses.

    Without a plan the middle of the joint ranges comes first, under a load that is allowed there.

    Args:
        study: The study.
        cases: S load cases of a plan.
        repeats: (S,) how often each is measured.
        peak: The load case where the sensitivity is largest.
        via: Arrays (K, n): what is passed on the way to each load case; empty for nothing.
    """
    tool, found = study.experiments.tool, []
    if cases is None:
        middle, wrench = study.limits.mean(axis=0), _typical_load(study)
        found.append(Stop("middle of the joint ranges", "middle", tool, middle, wrench))
    else:
        for i in range(len(cases)):
            times = "" if repeats is None or repeats[i] == 1 else f", measured {repeats[i]}×"
            label = f"pose {i + 1} of {len(cases)}{times}"
            passed = via[i] if len(via) and i else unset()
            found.append(Stop(label, "plan", tool, cases.q[i], cases.wrench[i], passed))
    if peak is not None:
        label = "where one more measurement is worth most"
        found.append(Stop(label, "peak", tool, peak.q[0], peak.wrench[0]))
    for i, pose in enumerate(study.test_poses):
        if pose.case is not None and pose.tool is not None:
            alike = [p.name for p in study.test_poses].count(pose.name) > 1
            kind = "path" if isinstance(pose, TestPath) else "pose"
            label = f"test {kind} {pose.name}" + (f" ({i + 1})" if alike else "")
            if isinstance(pose, TestPath):
                label += f", first of {len(pose.cases)} points"
            found.append(Stop(label, "test", pose.tool, pose.case.q[0], pose.case.wrench[0]))
    return tuple(found)


def way(stops: Sequence[Stop], begin: int, end: int) -> Array:
    """(K, n) what is passed between two stops [rad or m]: that of a plan from one to the next."""
    if end == begin + 1:
        return stops[end].via
    if end == begin - 1:
        return stops[begin].via[::-1]
    return stops[end].via[:0]


def _typical_load(study: Study) -> Array:
    """(6,) the load of the experiments, or the middle one of those that are allowed."""
    e = study.experiments
    return np.concatenate([_middle(e.force), _middle(e.moment)])


def _middle(load: Load) -> Array:
    """(3,) a fixed load itself; the axis of its cone for a free one, straight down without.

    In a plane the direction that is nearest to straight down.
    """
    if isinstance(load, FixedVector | ThereOrNot):
        return load.value
    if isinstance(load, InPlane):
        return load.decode(load.design(np.array([[0.0, 0.0, -1.0]])).T)[:, 0]
    axis = load.axis if load.is_cone else np.array([0.0, 0.0, -1.0])
    return np.asarray(load.largest * axis)
