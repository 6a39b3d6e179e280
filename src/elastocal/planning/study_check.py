"""What a study means, before anything is planned: the facts a person should recognise.

In: a `Study`. Out: a `Checkup`: reach, room left by the constraints, identifiability, and remarks
on numbers that look like another unit. Nothing is guessed or corrected.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import BeamRange, Clearance, LineOfSight, margins_at
from elastocal.errors import ElastocalError, InputError
from elastocal.motion.via_points import refuse_home
from elastocal.planning.visibility import visibility
from elastocal.robot.pose_check import PoseCheck, check_known_poses
from elastocal.robot.posture import Posture
from elastocal.study.identifiability import check_count, check_identifiable
from elastocal.study.study import Study

_TINY = 0.01  # lengths in a cell below this are suspicious [m]
_THIN = 0.002  # radii of links


@dataclass(frozen=True)
class Checkup:
    """Facts about a study.

    Attributes:
        reach: Largest distance of the load point from the base origin found [m].
        feasible_share: Share of random configurations that satisfy the constraints.
        bottleneck: Constraint that refuses most of them, empty if there is none.
        problem: Why the campaign cannot work, None if it can.
        remarks: Sentences on what looks odd.
        poses: How well the model fits poses read off at the robot, None if there are none.
        unwatched: Sentences on what may touch what, because it is not watched.
        seen: Share of random configurations in which the tracker sees each marker; empty if the
            instrument is no tracker.
    """

    reach: float
    feasible_share: float
    bottleneck: str
    problem: ElastocalError | None
    remarks: tuple[str, ...]
    poses: PoseCheck | None = None
    unwatched: tuple[str, ...] = ()
    seen: Mapping[str, float] = field(default_factory=dict)


def check(study: Study, *, seed: int = 0) -> Checkup:
    """Look at a study without planning it."""
    rng = np.random.default_rng(seed)
    space, experiments = study.space, study.experiments
    q = rng.uniform(study.limits[0], study.limits[1], (4000, len(study.robot.joints)))
    posture = Posture(study.robot, q)
    reach = float(np.linalg.norm(posture.point(experiments.tool.load_point), axis=0).max())
    refused = margins_at(study.constraints, posture) < 0.0
    share = float((~refused.any(axis=0)).mean())
    worst = int(refused.sum(axis=1).argmax()) if len(refused) else 0
    bottleneck = study.constraints[worst].name if refused.any() else ""
    problem: ElastocalError | None = None
    distinct = min(experiments.count, experiments.max_configurations or experiments.count)
    try:
        check_identifiable(space, study.prior, rng)
        check_count(space, study.prior, experiments.count, distinct, rng)
        refuse_home(study.motion_space)
    except ElastocalError as error:
        problem = error
    poses = None
    if study.known_poses:
        poses = check_known_poses(study.robot, study.coupling, study.known_poses)
        problem = problem if poses.fits else _misfit(poses)
    remarks = (*study.robot.remarks, *_remarks(study, reach))
    return Checkup(
        reach, share, bottleneck, problem, remarks, poses, _unwatched(study), _seen(study, q)
    )


def _seen(study: Study, q: Array) -> dict[str, float]:
    """Share of the configurations `q` in which each marker is seen."""
    view = visibility(study.space, q)
    if view is None:
        return {}
    return {name: float(seen.mean()) for name, seen in zip(view.markers, view.seen, strict=True)}


def _misfit(poses: PoseCheck) -> InputError:
    """Why the model is not that of the controller."""
    found = f"the check poses are up to {1e3 * poses.largest:.1f} mm from where the model has them"
    if not poses.explanations:
        return InputError(
            f"{found}, and no single mistake of sign, zero, coupling or unit explains it; compare "
            "lengths, base and flange of the model with the robot"
        )
    return InputError(
        f"{found}; it would fit to {1e3 * poses.left_over:.1f} mm if "
        f"{', or if '.join(poses.explanations)}"
    )


def _unwatched(study: Study) -> tuple[str, ...]:
    """Contacts that no clearance watches, those of one reason together."""
    reasons: dict[str, list[str]] = {}
    for constraint in study.constraints:
        if isinstance(constraint, Clearance):
            for left in constraint.left_out:
                reasons.setdefault(left.why, []).append(f"{left.first}–{left.second}")
        if isinstance(constraint, LineOfSight):
            for name in constraint.around_head:
                reasons.setdefault("the head of the tracker stands in it", []).append(
                    f"beam to {constraint.marker}–{name}"
                )
    return tuple(f"{why}: {', '.join(pairs)}" for why, pairs in reasons.items())


def _remarks(study: Study, reach: float) -> tuple[str, ...]:
    found = []
    tools = [study.experiments.tool] + [p.tool for p in study.test_poses if p.tool is not None]
    for tool in {tool.name: tool for tool in tools}.values():
        size = float(np.abs(np.vstack([tool.markers, tool.load_point, tool.tcp])).max())
        if 0.0 < size < 0.005:
            found.append(
                f"tool {tool.name!r} is no larger than {1e3 * size:g} mm: were metres meant?"
            )
        if size > max(reach, 1.0):
            found.append(
                f"tool {tool.name!r} reaches {size:.4g} m from the flange, which is "
                "larger than the arm"
            )
    for pose in study.test_poses:
        if pose.case is None:
            continue
        turning = pose.case.q[0][~study.robot.prismatic]
        if turning.any() and np.abs(np.degrees(turning)).max() < 6.3:
            found.append(
                f"all angles of test pose {pose.name!r} are below 6.3°: were radians meant?"
            )
        force = float(np.linalg.norm(pose.case.wrench[0, :3]))
        if 0.0 < force < 1.0:
            found.append(
                f"the force at test pose {pose.name!r} is only {force:g} N: were kilonewtons meant?"
            )
    if study.sigma > 1e-3:
        found.append(
            f"sigma is {1e3 * study.sigma:g} mm per coordinate: "
            "were micrometres meant? A laser tracker has about 0.03 mm"
        )
    if 0.0 < study.experiments.force.size < 1.0:
        found.append(
            f"the calibration force is only {study.experiments.force.size:g} N: were "
            "kilonewtons meant?"
        )
    found += _small_cell(study)
    names = study.robot.joint_names
    involved = np.abs(np.concatenate([p.regressor for p in study.test_poses])).sum(axis=0) > 0.0
    idle = [n for n, used in zip(study.springs.names, involved, strict=True) if not used]
    if idle:
        found.append(
            f"{', '.join(idle)}: no test pose is deflected through "
            f"{'this joint' if len(idle) == 1 else 'these joints'}, so the plan spends "
            "no effort there that it can avoid"
        )
    left_out = [name for name in names if name not in study.springs.names]
    if left_out:
        found.append(f"{', '.join(left_out)}: taken as rigid, not identified by this study")
    return tuple(found)


def _small_cell(study: Study) -> list[str]:
    """Lengths around the robot that look like metres under a key in millimetres."""
    found, place = [], getattr(study.instrument, "position", None)
    if place is not None and 0.0 < np.linalg.norm(place) < _TINY:
        found.append(
            f"the tracker stands {1e3 * np.linalg.norm(place):.3g} mm from the origin of the base: "
            "were metres meant?"
        )
    radii = [1.0]
    for constraint in study.constraints:
        if isinstance(constraint, BeamRange) and constraint.sign < 0.0 and constraint.bound < _TINY:
            found.append(f"{constraint.name}: were metres meant?")
        if not isinstance(constraint, Clearance):
            continue
        shape = constraint.obstacle
        if shape is not None and shape.kind != "mesh" and shape.size.max() < _TINY:
            found.append(
                f"obstacle {shape.name!r} is no larger than {1e3 * shape.size.max():g} mm: were "
                "metres meant?"
            )
        if not study.robot.collisions:
            radii += [s.radius for s in constraint.pairs.solids if s.joint]
    if min(radii) < _THIN:
        found.append(f"links are as thin as {1e3 * min(radii):g} mm in radius: were metres meant?")
    return found
