"""What a study means, before anything is planned: the facts a person should recognise.

In: a `Study`. Out: a `Checkup`: reach, room left by the constraints, identifiability, and doubts
about numbers that look like another unit. Nothing is guessed or corrected.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import BeamRange, Clearance, LineOfSight, margins_at
from elastocal.constraints.cell import ITSELF
from elastocal.constraints.watch import Watch, watch_of
from elastocal.errors import Doubt, ElastocalError
from elastocal.measuring.instrument import tracker_of
from elastocal.motion.via_points import refuse_home
from elastocal.motion.within_reach import out_of_reach
from elastocal.planning.never_seen import NeverSeen, never_seen
from elastocal.planning.visibility import visibility
from elastocal.robot.pose_check import PoseCheck, check_known_poses, refuse_misfit
from elastocal.robot.posture import Posture
from elastocal.study.criteria import renamed
from elastocal.study.identifiability import check_count, check_identifiable
from elastocal.study.left_rigid import left_rigid
from elastocal.study.study import Study, TestPose
from elastocal.study.test_path import TestPath

HEAD = "tracker-head"
"""Why a beam is not watched: what it would touch is at the head of the tracker."""

# Below, or above, these a number looks like one in another unit.
_TINY = 0.01  # lengths in a cell [m]
_THIN = 0.002  # radii of links [m]
_SMALL_TOOL = 0.005  # [m]
_SMALL_ANGLE = float(np.radians(6.3))  # of a turn in radians taken for degrees
_SMALL_FORCE = 1.0  # [N]
_COARSE = 1e-3  # σ [m]
_COARSE_ROTATION = 3e-3  # σ of a rotation [rad]
_LOOKED_AT = 400  # refused configurations of which it is asked what refuses them


@dataclass(frozen=True)
class Checkup:
    """Facts about a study.

    Attributes:
        reach: Largest distance of the load point from the base origin found [m].
        feasible_share: Share of random configurations that satisfy the constraints.
        bottleneck: Constraint that refuses most of them, empty if there is none.
        within: What of that constraint refuses most often, as two parts of the robot that come
            near each other; empty if it is the constraint itself.
        within_share: In which share of what the bottleneck refuses that is the worst.
        never_seen: Effects that no plan can show.
        problem: Why the campaign cannot work, None if it can.
        doubts: What looks odd, besides what the robot's own remarks say.
        poses: How well the model fits poses read off at the robot, None if there are none.
        watch: What is watched for collisions.
        unwatched: What may touch what, because it is not watched.
        seen: Share of random configurations in which the tracker sees each marker; empty if the
            instrument is no tracker.
    """

    reach: float
    feasible_share: float
    bottleneck: str
    problem: ElastocalError | None
    doubts: tuple[Doubt, ...]
    watch: Watch
    poses: PoseCheck | None = None
    unwatched: tuple[Doubt, ...] = ()
    seen: Mapping[str, float] = field(default_factory=dict)
    within: str = ""
    within_share: float = 0.0
    never_seen: NeverSeen = field(default_factory=NeverSeen)


def check(study: Study, *, seed: int = 0) -> Checkup:
    """Look at a study without planning it."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(study.limits[0], study.limits[1], (4000, len(study.robot.joints)))
    posture = Posture(study.robot, q)
    reach = float(np.linalg.norm(posture.point(study.experiments.tool.load_point), axis=0).max())
    refused = margins_at(study.constraints, posture) < 0.0
    share = float((~refused.any(axis=0)).mean())
    worst = int(refused.sum(axis=1).argmax()) if len(refused) else 0
    bottleneck = study.constraints[worst].name if refused.any() else ""
    poses = None
    if study.known_poses:
        poses = check_known_poses(study.robot, study.coupling, study.known_poses)
    problem = _problem(study, poses, rng)
    return Checkup(
        reach,
        share,
        bottleneck,
        problem,
        tuple(_doubts(study, reach)),
        watch_of(study.constraints),
        poses,
        _unwatched(study),
        _seen(study, q),
        *_within(study, q[refused[worst]] if bottleneck else q[:0], worst),
        NeverSeen() if problem else never_seen(study, rng),
    )


def _within(study: Study, refused: Array, worst: int) -> tuple[str, float]:
    """What of constraint `worst` is broken most in most of configurations `refused`; its share."""
    if not len(refused):
        return "", 0.0
    constraint, looked_at = study.constraints[worst], refused[:_LOOKED_AT]
    names = Counter(constraint.names_at(Posture(study.robot, looked_at)))
    name, times = names.most_common(1)[0]
    return ("", 0.0) if name == constraint.name else (name, times / len(looked_at))


def _problem(
    study: Study, poses: PoseCheck | None, rng: np.random.Generator
) -> ElastocalError | None:
    """Why the campaign cannot work: first of all, because the model is not that of the robot."""
    experiments = study.experiments
    distinct = experiments.distinct
    try:
        if poses is not None:
            refuse_misfit(poses)
        check_identifiable(study.space, study.prior, rng)
        check_count(study.space, study.prior, experiments.count, distinct, rng)
        refuse_home(study.motion_space)
    except ElastocalError as error:
        return error
    return None


def _seen(study: Study, q: Array) -> dict[str, float]:
    """Share of the configurations `q` in which each marker is seen."""
    view = visibility(study.space, q)
    if view is None:
        return {}
    return {name: float(seen.mean()) for name, seen in zip(view.markers, view.seen, strict=True)}


def _unwatched(study: Study) -> tuple[Doubt, ...]:
    """Contacts that no clearance watches, those of one reason together."""
    contacts: dict[str, list[str]] = {}
    for constraint in study.constraints:
        if isinstance(constraint, Clearance):
            for left in constraint.unwatched:
                contacts.setdefault(left.why, []).append(f"{left.first}–{left.second}")
        if isinstance(constraint, LineOfSight):
            for name in constraint.around_head:
                contacts.setdefault(HEAD, []).append(f"beam to {constraint.marker}–{name}")
    return tuple(Doubt("not-watched", tuple(names), (why,)) for why, names in contacts.items())


def _doubts(study: Study, reach: float) -> Iterator[Doubt]:
    """Numbers that look like another unit, and joints that are left aside."""
    yield from _tools(study, reach)
    yield from _robot_below_floor(study)
    for pose in study.test_poses:
        if pose.cases is None:
            continue
        yield from _below_floor(study, pose)
        turning = np.abs(pose.cases.q[:, ~study.robot.prismatic])
        if turning.any() and turning.max() < _SMALL_ANGLE:
            yield Doubt("small-angles", (pose.name,), numbers={"below": _SMALL_ANGLE})
        force = float(np.linalg.norm(pose.cases.wrench[:, :3], axis=1).max())
        if 0.0 < force < _SMALL_FORCE:
            yield Doubt("small-pose-force", (pose.name,), numbers={"force": force})
    if study.sigma > _COARSE:
        yield Doubt("coarse-sigma", numbers={"sigma": study.sigma})
    rotation = study.instrument.sigma_rotation
    if rotation is not None and rotation > _COARSE_ROTATION:
        yield Doubt("coarse-sigma", numbers={"sigma": rotation}, unit="rad")
    if 0.0 < study.experiments.force.size < _SMALL_FORCE:
        yield Doubt("small-force", numbers={"force": study.experiments.force.size})
    yield from _small_cell(study)
    yield from watch_of(study.constraints).doubts
    yield from out_of_reach(study.motion_space)
    rows = np.concatenate([p.regressor for p in study.planned_for])[:, study.wanted]
    involved = np.abs(rows).sum(axis=0) > 0.0
    names = zip(study.springs.names, involved, strict=True)
    if idle := tuple(name for name, used in names if not used):
        yield Doubt("no-task", idle)
    yield from left_rigid(study)
    yield from renamed(study)


def _robot_below_floor(study: Study) -> Iterator[Doubt]:
    """A floor above what the robot stands on: its base, and links that move with no tilt."""
    clearances = [c for c in study.constraints if isinstance(c, Clearance)]
    own = [s for c in clearances if c.what == ITSELF for s in c.pairs.solids if not s.body]
    for floor in clearances:
        if floor.height is not None:
            below = [solid.name for solid in own if solid.top < floor.height]
            below += [left.first for left in floor.unwatched if left.why == "below-it"]
            if below:
                names = tuple(dict.fromkeys(below))
                height = {"height": floor.height}
                yield Doubt("robot-below-floor", names, numbers=height, unit="m")


def _below_floor(study: Study, pose: TestPose | TestPath) -> Iterator[Doubt]:
    """A task below the floor that the campaign keeps clear of."""
    heights = [c.height for c in study.constraints if isinstance(c, Clearance)]
    floors = [height for height in heights if height is not None]
    if floors and pose.cases is not None and pose.tool is not None:
        tcp = Posture(study.robot, pose.cases.q).point(pose.tool.tcp)
        depth = max(floors) - float(tcp[2].min())
        if depth > 0.0:
            yield Doubt("pose-below-floor", (pose.name,), numbers={"by": round(depth, 6)}, unit="m")


def _tools(study: Study, reach: float) -> Iterator[Doubt]:
    """Tools of another size than tools of this robot have."""
    tools = [study.experiments.tool] + [p.tool for p in study.test_poses if p.tool is not None]
    for tool in {tool.name: tool for tool in tools}.values():
        size = float(np.abs(np.vstack([tool.markers, tool.load_point, tool.tcp])).max())
        if 0.0 < size < _SMALL_TOOL:
            yield Doubt("small-tool", (tool.name,), numbers={"size": size})
        if size > max(reach, 1.0):
            yield Doubt("large-tool", (tool.name,), numbers={"size": size})


def _small_cell(study: Study) -> Iterator[Doubt]:
    """Lengths around the robot that look like metres under a key in millimetres."""
    tracker = tracker_of(study.instrument)
    distance = 0.0 if tracker is None else float(np.linalg.norm(tracker.position))
    if 0.0 < distance < _TINY:
        yield Doubt("near-tracker", numbers={"distance": distance})
    radii = [1.0]
    for constraint in study.constraints:
        if isinstance(constraint, BeamRange) and constraint.sign < 0.0 and constraint.bound < _TINY:
            yield Doubt("short-range", (constraint.name,), numbers={"bound": constraint.bound})
        if not isinstance(constraint, Clearance):
            continue
        shape = constraint.obstacle
        if shape is not None and shape.kind != "mesh" and shape.size.max() < _TINY:
            size = {"size": float(shape.size.max())}
            yield Doubt("small-obstacle", (shape.name,), numbers=size)
        if not study.robot.collisions:
            radii += [s.radius for s in constraint.pairs.solids if s.joint]
    if min(radii) < _THIN:
        yield Doubt("thin-links", numbers={"radius": min(radii)})
