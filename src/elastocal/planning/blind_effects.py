"""Effects that the model of a plan may lack, at every place of an arm, and what each moves.

In: a study, load cases. Out: columns of the readings and of the task for one of each effect. They
are those of docs/typical.md and those that are sought after measuring.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.case_errors import CaseErrors, common_columns
from elastocal.elastic.effects import FOOT_SLIDING, FOOT_TURNING, TOOL_SLIDING, Size, tilt_of
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.long_links import long_links
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import VirtualJoints, joint_springs
from elastocal.elastic.typical import ERRORS, by_mass, typical_sizes
from elastocal.planning.with_errors import WithErrors
from elastocal.robot.chain import T_body_joint
from elastocal.robot.posture import Posture, flange_axes
from elastocal.study.left_rigid import counted
from elastocal.study.study import Study, TestPose
from elastocal.study.test_path import TestPath

EffectKind = Literal[
    "joint",
    "foot",
    "bearing",
    "link",
    "foot-sliding",
    "tool-sliding",
    "load-gain",
    "load-turn",
    "tool-shift",
    "station-shift",
    "station-turn",
]
"""A joint taken as rigid; what turns in the foot, in a bearing across its axis, or in the long link
behind it; what slides; loads all wrong alike in size or direction; what moved between the readings
without and with load."""

STIFF = 1e-7
"""Foot, bearings and links softer than that [rad/(N·m), m/N] are hard to believe, 10 MN·m/rad and
10 N/µm, unless the usual size is more than half of it."""
SOFT_JOINT = 1e-6
"""The same of a joint [rad/(N·m), m/N]: gears are softer than bearings."""
BRACKET = 1e-6
"""The same of the bracket of a tool [m/N]."""
LARGEST: dict[EffectKind, float] = {
    "load-gain": 0.05,  # a scale that is worse is not calibrated
    "load-turn": float(np.radians(5.0)),  # the eye sees it
    "tool-shift": 1e-3,  # an adapter that was put on anew
    "station-shift": 1e-4,  # a drift that a check of the station shows
    "station-turn": 1e-4,
}
"""The same of what is no spring [1, rad or m]."""
_USUAL: dict[EffectKind, float] = {"load-gain": ERRORS.common_gain, "load-turn": ERRORS.tilt}


@dataclass(frozen=True)
class EffectFamily:
    """Effects of one kind at one place.

    Attributes:
        kind: What they are.
        carrier: Joint that they belong to, empty if none.
        axes: (d, 3) their axes, base frame with all joints at zero, or flange frame of a tool.
        plane: Whether springs about every axis of a plane belong to it: it has three columns then,
            of springs about two axes that span it, and of what couples them. Else one for each
            axis, or one alone.
        unit: SI unit of their sizes.
        usual: Usual size, NaN where nobody knows it.
        largest: Size that is hard to believe.
    """

    kind: EffectKind
    carrier: str
    axes: Array
    plane: bool
    unit: str
    usual: float
    largest: float

    def __post_init__(self) -> None:
        freeze(self, "axes")

    @property
    def columns(self) -> int:
        """How many columns it has."""
        return 3 if self.plane else max(len(self.axes), 1)


class EffectColumns(NamedTuple):
    """What effects move, one of each: c columns of the readings, and of the task at test poses."""

    families: tuple[EffectFamily, ...]
    readings: Array  # (S, m, c)
    task: tuple[Array, ...]  # (N, r, c) each


def effect_columns(study: Study, cases: LoadCases) -> EffectColumns:
    """All effects of an arm, with what they move at load cases, and at the test poses.

    Loads that are wrong alike need the compliances of the joints: they are left out of a study that
    knows no nuisance. Matrices as test poses tell nothing of effects and are left out, too.

    Source: ours.
    """
    groups, tool = list(_springs(study)), study.experiments.tool
    springs, order = _in_chain_order([own for _, own in groups])
    families = [family for family, _ in groups]
    arm = ElasticArm(study.robot, springs, tool)
    others = [*_loads(study, cases), *_shifts(study, cases)]
    read = [_columns(families, regressor(arm, cases)[:, :, order]), *(rows for _, rows in others)]
    task = []
    for pose in judged(study):
        assert pose.cases is not None
        assert pose.tool is not None
        there = regressor(replace(arm, tool=pose.tool.at_tcp), pose.cases)[:, :, order]
        rows = [_columns(families, there)]
        for family, _ in others:
            rows.append(np.zeros((*there.shape[:2], family.columns)))
            if family.kind == "load-gain":
                rows[-1][:, :, 0] = _with_the_force(study, pose)
        task.append(np.concatenate(rows, axis=2))
    families += [family for family, _ in others]
    return EffectColumns(tuple(families), np.concatenate(read, axis=2), tuple(task))


def judged(study: Study) -> tuple[TestPose | TestPath, ...]:
    """The test poses that are planned for and have load cases: matrices tell nothing of effects."""
    return tuple(p for p in study.planned_for if p.cases is not None and p.tool is not None)


def usual_sizes(study: Study) -> tuple[Mapping[str, Size], Array | None]:
    """Usual sizes of effects by name, and (n,) compliances of the joints; none where unknown."""
    nominal = by_mass(study.robot) if study.nuisance is None else study.nuisance.nominal
    if nominal is None or not nominal.any():
        return {}, None
    return typical_sizes(study.robot, nominal), nominal


def _springs(study: Study) -> Iterator[tuple[EffectFamily, VirtualJoints]]:
    """Families of springs, each with its springs."""
    robot = study.robot
    sizes, nominal = usual_sizes(study)

    def usual(name: str) -> float:
        return sizes[name].deviation if name in sizes else float("nan")

    taken = counted(study)
    for j, joint in enumerate(robot.joints):
        if joint.name not in taken:
            size = float("nan") if nominal is None else float(nominal[j]) or float("nan")
            yield _family(study, "joint", joint.name, joint_springs(robot, [joint.name]), size)
    yield _plane(study, "foot", "", 0, np.eye(4), usual(FOOT_TURNING))
    slides = _springs_of(0, np.eye(3), np.zeros(3), slides=True)
    yield _family(study, "foot-sliding", "", slides, usual(FOOT_SLIDING))
    long = long_links(robot)
    for j, joint in enumerate(robot.joints):
        if not joint.prismatic:
            before, size = int(robot.place[j]), usual(tilt_of(joint.name))
            yield _plane(study, "bearing", joint.name, before, robot.links[before], size)
            if long[j]:
                frame = T_body_joint(robot, before + 1)
                about = np.eye(4)  # bodies have their z along the axis of their joint
                about[:3, 3] = frame[:3, 3]
                yield _plane(study, "link", joint.name, before + 1, about, size)
    flange = robot.links[-1]
    slides = _springs_of(robot.last, flange[:3, :3].T, flange[:3, 3], slides=True)
    made = _family(study, "tool-sliding", "", slides, usual(TOOL_SLIDING))
    yield replace(made[0], axes=np.eye(3)), made[1]


def _springs_of(body: int, axes: Array, origin: Array, *, slides: bool = False) -> VirtualJoints:
    count = len(axes)
    return VirtualJoints(
        ("",) * count,
        np.full(count, body),
        axes,
        np.tile(origin, (count, 1)),
        np.full(count, slides),
    )


def _plane(
    study: Study, kind: EffectKind, carrier: str, body: int, frame: Array, usual: float
) -> tuple[EffectFamily, VirtualJoints]:
    """Springs about every axis through the origin of a frame (4, 4) in a body, across its z."""
    x, y = frame[:3, :2].T
    springs = _springs_of(body, np.array([x, y, (x + y) * np.sqrt(0.5)]), frame[:3, 3])
    return _family(study, kind, carrier, springs, usual, plane=True)


def _family(
    study: Study,
    kind: EffectKind,
    carrier: str,
    springs: VirtualJoints,
    usual: float,
    *,
    plane: bool = False,
) -> tuple[EffectFamily, VirtualJoints]:
    posture = Posture(study.robot, np.zeros((1, len(study.robot.joints))))
    there = zip(springs.axis, springs.body.tolist(), strict=True)
    axes = np.array([posture.direction(axis, body)[:, 0] for axis, body in there])
    stiffest = {"joint": SOFT_JOINT, "tool-sliding": BRACKET}.get(kind, STIFF)
    largest = 2.0 * usual
    if np.isnan(usual) or kind != "joint":  # gears are as soft as they are
        largest = float(np.nanmax([stiffest, largest]))
    unit = springs.kinds[0].compliance
    axes = axes[:2] if plane else axes
    return EffectFamily(kind, carrier, axes, plane, unit, usual, largest), springs


def _in_chain_order(groups: list[VirtualJoints]) -> tuple[VirtualJoints, IntArray]:
    """All springs in chain order, and where each of those given is among them."""
    body, joint = (np.concatenate([getattr(own, n) for own in groups]) for n in ("body", "joint"))
    order = np.lexsort((joint >= 0, body))
    parts: dict[str, Any] = {
        n: np.concatenate([getattr(own, n) for own in groups])[order]
        for n in ("body", "axis", "origin", "prismatic", "joint")
    }
    names = tuple(f"effect {i}" for i in range(len(order)))
    return VirtualJoints(names, **parts), np.argsort(order)


def _columns(families: list[EffectFamily], rows: Array) -> Array:
    """Columns of families, of those of their springs: of a plane, what couples two axes is third.

    A spring about c x + s y moves c² of that about x, s² of that about y, and c s of the third.
    """
    rows, first = rows.copy(), 0
    for family in families:
        if family.plane:
            x, y, between = rows[:, :, first : first + 3].transpose(2, 0, 1)
            rows[:, :, first + 2] = 2.0 * between - x - y
        first += family.columns
    return rows


def _loads(study: Study, cases: LoadCases) -> Iterator[tuple[EffectFamily, Array]]:
    """Loads that are all wrong by one factor, or all turned."""
    if study.nuisance is None:
        return
    told = WithErrors(study, study.nuisance)
    if not told.usual.any():
        return
    arm = replace(study.fitted_arm, springs=told.bending)
    wrong = CaseErrors(common_gain=1.0, common_tilt=1.0)
    _, moved = common_columns(wrong, arm, told.usual, cases)
    yield _other("load-gain", np.zeros((0, 3)), "1"), moved[:, :, :1]
    yield _other("load-turn", np.eye(3), "rad"), moved[:, :, 1:]


def _with_the_force(study: Study, pose: TestPose | TestPath) -> Array:
    """(N, r) what a process force moves that is all wrong, as the loads are by the same cell."""
    nuisance = study.nuisance
    if nuisance is None or nuisance.errors.process_force != "same":
        return np.zeros(pose.regressors.shape[:2])
    return WithErrors(study, nuisance).compensated(pose)


def _shifts(study: Study, cases: LoadCases) -> Iterator[tuple[EffectFamily, Array]]:
    """What moved between the readings without and with load: tool, or station."""
    posture, tool = Posture(study.robot, cases.q), study.experiments.tool
    targets, count = len(tool.targets), len(tool.markers)
    still = np.zeros((len(cases), 3 * (targets - count), 3))
    flange = np.tile(flange_axes(posture), (1, count, 1))
    yield _other("tool-shift", np.eye(3), "m"), np.concatenate([flange, still], axis=1)
    station = np.tile(np.eye(3), (len(cases), count, 1))
    yield _other("station-shift", np.eye(3), "m"), np.concatenate([station, still], axis=1)
    points = np.stack([posture.point(marker).T for marker in tool.markers], axis=1)
    turned = np.cross(np.eye(3), points[:, :, None]).transpose(0, 1, 3, 2)
    turned = turned.reshape(len(cases), 3 * count, 3)
    flange = np.tile(np.eye(3), (len(cases), targets - count, 1))
    yield _other("station-turn", np.eye(3), "rad"), np.concatenate([turned, flange], axis=1)


def _other(kind: EffectKind, axes: Array, unit: str) -> EffectFamily:
    usual = _USUAL.get(kind, float("nan"))
    return EffectFamily(kind, "", axes, False, unit, usual, LARGEST[kind])
