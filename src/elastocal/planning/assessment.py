"""What a set of load cases with repeats is worth, whoever proposed it.

In: study, load cases, repeats. Out: ρ0, standard errors, criteria, margins to every constraint.
The planner and `evaluate` both call it: a plan's claims are always recomputed from the study.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.constraints import HeldJoint, room_at
from elastocal.elastic.allowed_loads import FixedVector, InPlane, Load
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import VirtualJoints
from elastocal.errors import Code, Doubt
from elastocal.matrices import rank_of, scaled_inverse
from elastocal.motion.margins import Vias, motion_violations
from elastocal.planning.loss import AfterLoss, loss_of
from elastocal.planning.promise import Promise, promise
from elastocal.robot.joint_kinds import PRISMATIC, REVOLUTE
from elastocal.robot.posture import Posture
from elastocal.study.criteria import RHO0, losses
from elastocal.study.study import Study, TestPose
from elastocal.study.test_path import TestPath, errors_along


@dataclass(frozen=True)
class Nearest:
    """The constraint with the least room at one load case.

    Attributes:
        name: Name of the constraint.
        margin: Room left [unit], negative if violated.
        unit: "m", "rad", "N" or "N·m".
    """

    name: str
    margin: float
    unit: str


@dataclass(frozen=True)
class WorstPoint:
    """The point of a test path with the largest error.

    Attributes:
        index: Its place among the points, from 0.
        name: Its name.
        rho0: Error there [m].
    """

    index: int
    name: str
    rho0: float


@dataclass(frozen=True)
class Assessment:
    """What a plan is worth.

    Attributes:
        rho0: Root mean square position error after compensation at the test poses [m].
        rho0_each: Error at each test pose [m]; of a path its root mean square.
        worst_points: The worst point of each test pose that is a path, None for the others.
        standard_error: (p,) standard errors of the compliances to identify [rad/(N·m)].
        criteria: Every criterion's value; see `study.criteria`.
        information: (f, f) information on all that is fitted, prior included [(N·m/rad)²].
        covariance: (f, f) covariance of all that is fitted [(rad/(N·m))²]; infinite if singular.
        nearest: Nearest constraint of every load case.
        violations: Every broken constraint and every load that is not allowed.
        promise: What is promised when all nuisance counts; None if the study knows none. Of it ρ0
            and what else is above count the unknowns, and not the errors of load cases.
        loss: What is left without the configuration that is missed most; None if not asked for.
    """

    rho0: float
    rho0_each: tuple[float, ...]
    worst_points: tuple[WorstPoint | None, ...]
    standard_error: Array
    criteria: dict[str, float]
    information: Array
    covariance: Array
    nearest: tuple[Nearest, ...]
    violations: tuple[Doubt, ...]
    promise: Promise | None = None
    loss: AfterLoss | None = None

    @property
    def promised(self) -> float:
        """What is left by all that counts [m]: the promise, ρ0 if the study knows no nuisance."""
        return self.rho0 if self.promise is None else self.promise.rho0

    @property
    def identifiable(self) -> bool:
        """Whether the load cases tell all compliances apart."""
        return bool(np.isfinite(self.standard_error).all())


TOLERANCE = 1e-5
"""Violation that is put down to rounding in a file [rad, m; relative for N and N·m]."""

_WANTED = ("wanted_x", "wanted_y", "wanted_z")


def assess(study: Study, cases: LoadCases, repeats: IntArray) -> Assessment:
    """Worth of `cases`, each measured `repeats` times, under `study`.

    Source: paper eqs. (13), (20); prior information and several test poses are ours.
    """
    informations = study.space.information(cases)
    total = study.prior + np.einsum("i,ijk->jk", repeats.astype(float), informations)
    weighs = study.experiments.weighs  # what readings cannot tell rests on its prior then
    regular = weighs or rank_of(total) == len(total)
    covariance = scaled_inverse(total[None])[0] if regular else np.full_like(total, np.inf)
    each = tuple(
        float(np.sqrt(np.einsum("ij,jk,ik->", pose.regressor, covariance, pose.regressor)))
        if regular
        else float("inf")
        for pose in study.test_poses
    )
    nearest, violations = _margins(study, cases)
    criteria = losses(study, total)
    return Assessment(
        rho0=criteria[RHO0.name] if regular else float("inf"),
        rho0_each=each,
        worst_points=tuple(_worst(pose, covariance, regular) for pose in study.test_poses),
        standard_error=frozen(np.sqrt(np.diagonal(covariance))[study.wanted]),
        criteria=criteria,
        information=frozen(total),
        covariance=frozen(covariance),
        nearest=nearest,
        violations=violations,
        promise=promise(study, cases, repeats, total),
        loss=loss_of(study, cases, repeats) if regular and not weighs else None,
    )


def hardly_known(springs: VirtualJoints, standard_error: Array) -> Iterator[Doubt]:
    """Compliances with standard errors (p,) beyond those that springs of arms have, by kind."""
    for kind in dict.fromkeys(springs.kinds):
        errors = {
            name: float(error)
            for name, unit, error in zip(springs.names, springs.units, standard_error, strict=True)
            if unit == kind.compliance and _SOFT[kind] < error < np.inf
        }
        if errors:
            yield Doubt("hardly-known", tuple(errors), numbers=errors, unit=kind.compliance)


def search_stopped(generations: int | None) -> Iterator[Doubt]:
    """That a search was stopped after so many generations; nothing if it was not, None."""
    if generations is not None:
        yield Doubt("search-stopped", numbers={"generations": generations})


_SOFT = {REVOLUTE: 1e-4, PRISMATIC: 1e-5}  # compliances of soft arms: 10 000 N·m/rad, 100 N/mm


def _worst(pose: TestPose | TestPath, covariance: Array, regular: bool) -> WorstPoint | None:
    if not isinstance(pose, TestPath):
        return None
    if not regular:
        return WorstPoint(0, pose.points[0], float("inf"))
    errors = errors_along(pose, covariance)
    i = int(errors.argmax())
    return WorstPoint(i, pose.points[i], float(errors[i]))


def _margins(study: Study, cases: LoadCases) -> tuple[tuple[Nearest, ...], tuple[Doubt, ...]]:
    """Nearest constraint of every load case, and what is violated."""
    constraints = (*study.joint_limits, *study.constraints)
    posture = Posture(study.robot, cases.q)
    room = room_at(constraints, posture)
    names = [constraint.names_at(posture) for constraint in constraints]
    # What is held always has room 0: that is no news, unless nothing else is there.
    held = np.array([isinstance(constraint, HeldJoint) for constraint in constraints], dtype=bool)
    shown = np.where(held[:, None] & (room >= -TOLERANCE), np.inf, room)
    shown = np.where(np.isinf(shown).all(axis=0), room, shown)
    nearest = [Nearest("no constraint", np.inf, "rad")] * (0 if constraints else len(cases))
    violations = []
    for i in range(len(cases) if constraints else 0):
        least = int(np.argmin(shown[:, i]))
        nearest.append(Nearest(names[least][i], float(room[least, i]), constraints[least].unit))
        for c, constraint in enumerate(constraints):
            if room[c, i] < -TOLERANCE:
                numbers = {"load_case": i + 1, "by": -float(room[c, i])}
                broken = Doubt("constraint-broken", (names[c][i],), (), numbers, constraint.unit)
                violations.append(broken)
    e = study.experiments
    violations += _load_violations("N", e.force, cases.wrench[:, :3])
    violations += _load_violations("N·m", e.moment, cases.wrench[:, 3:])
    return tuple(nearest), tuple(violations)


def broken_on_the_way(study: Study, via: Vias) -> tuple[list[Doubt], list[Doubt]]:
    """What via points break: what must hold wherever the robot is, and what is about measuring.

    Of clearances they keep what is to be kept while moving, as the motions to them do. Home is
    judged by itself, also where a plan passes it.
    """
    must: list[Doubt] = []
    rest: list[Doubt] = []
    constraints = [c.on_the_way for c in (*study.joint_limits, *study.constraints)]
    for leg, points in enumerate(via):
        if not len(points):
            continue
        posture = Posture(study.robot, points)
        room = room_at(constraints, posture)
        room[:, (points == study.pace.home).all(axis=1)] = np.inf
        for c, i in np.argwhere(~(room >= -TOLERANCE)).tolist():
            name = constraints[c].names_at(posture)[i]
            numbers = {"via": i + 1, "leg": leg, "legs": len(via), "by": -float(room[c, i])}
            doubt = Doubt("via-breaks", because=(name,), numbers=numbers, unit=constraints[c].unit)
            (rest if constraints[c].measuring else must).append(doubt)
    return must, rest


def broken(study: Study, worth: Assessment, q: Array, via: Vias = ()) -> tuple[Doubt, ...]:
    """What forbids to carry out load cases: limits and constraints, via points, blocked motions.

    Args:
        study: The study.
        worth: What the load cases are worth.
        q: (S, n) their configurations in order of execution [rad or m].
        via: Configurations passed on the way, see `motion.Vias`.
    """
    must, _ = broken_on_the_way(study, via)
    return (*worth.violations, *must, *motion_violations(study.motion_space, q, via))


def _load_violations(unit: str, load: Load, vectors: Array) -> list[Doubt]:
    """Loads (N, 3) that the study does not allow."""
    found = []
    room = load.margin(vectors) / max(load.size, 1.0)
    for i in np.flatnonzero(room < -TOLERANCE).tolist():
        numbers = {"load_case": i + 1} | dict(zip("xyz", vectors[i].tolist(), strict=True))
        if isinstance(load, FixedVector):
            wanted = dict(zip(_WANTED, load.value.tolist(), strict=True))
            found.append(Doubt("load-differs", numbers=numbers | wanted, unit=unit))
        else:
            found.append(Doubt("load-too-large", numbers=numbers | {"bound": load.size}, unit=unit))
    outside = load.direction_room(vectors)
    for i in np.flatnonzero(outside < -TOLERANCE).tolist():
        numbers = {"load_case": i + 1, "by": -float(outside[i])}
        code: Code = "load-outside-plane" if isinstance(load, InPlane) else "load-outside-cone"
        found.append(Doubt(code, numbers=numbers, unit=unit))
    return found
