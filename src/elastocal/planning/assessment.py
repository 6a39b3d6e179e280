"""What a set of load cases with repeats is worth, whoever proposed it.

In: study, load cases, repeats. Out: ρ0, standard errors, criteria, margins to every constraint.
The planner and `evaluate` both call it: a plan's claims are always recomputed from the study.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.constraints import describe, room_at
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, Load
from elastocal.elastic.load_cases import LoadCases
from elastocal.matrices import rank_of, scaled_inverse
from elastocal.robot.posture import Posture
from elastocal.study.criteria import RHO0, losses
from elastocal.study.study import Study


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
class Assessment:
    """What a plan is worth.

    Attributes:
        rho0: Root mean square position error after compensation at the test poses [m].
        rho0_each: Error at each test pose [m].
        standard_error: (p,) standard errors of the compliances [rad/(N·m)].
        criteria: Every criterion's value; see `study.criteria`.
        information: (p, p) information, prior included [(N·m/rad)²].
        nearest: Nearest constraint of every load case.
        violations: One sentence for every broken constraint.
    """

    rho0: float
    rho0_each: tuple[float, ...]
    standard_error: Array
    criteria: dict[str, float]
    information: Array
    nearest: tuple[Nearest, ...]
    violations: tuple[str, ...]

    @property
    def identifiable(self) -> bool:
        """Whether the load cases tell all compliances apart."""
        return bool(np.isfinite(self.standard_error).all())


TOLERANCE = 1e-5
"""Violation that is put down to rounding in a file [rad, m; relative for N and N·m]."""


def assess(study: Study, cases: LoadCases, repeats: IntArray) -> Assessment:
    """Worth of `cases`, each measured `repeats` times, under `study`.

    Source: paper eqs. (13), (20); prior information and several test poses are ours.
    """
    informations = study.space.information(cases)
    total = study.prior + np.einsum("i,ijk->jk", repeats.astype(float), informations)
    regular = rank_of(total) == len(total)
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
        standard_error=frozen(np.sqrt(np.diagonal(covariance))),
        criteria=criteria,
        information=frozen(total),
        nearest=nearest,
        violations=violations,
    )


def _margins(study: Study, cases: LoadCases) -> tuple[tuple[Nearest, ...], tuple[str, ...]]:
    """Nearest constraint of every load case, and what is violated."""
    constraints = (*study.joint_limits, *study.constraints)
    posture = Posture(study.robot, cases.q)
    room = room_at(constraints, posture)
    names = [constraint.names_at(posture) for constraint in constraints]
    nearest = []
    violations = []
    for i in range(len(cases)):
        least = int(np.argmin(room[:, i]))
        nearest.append(Nearest(names[least][i], float(room[least, i]), constraints[least].unit))
        for c, constraint in enumerate(constraints):
            if room[c, i] < -TOLERANCE:
                broken = describe(-float(room[c, i]), constraint.unit)
                violations.append(f"load case {i + 1} breaks {names[c][i]} by {broken}")
    e = study.experiments
    violations += _load_violations("force", "N", e.force, cases.wrench[:, :3])
    violations += _load_violations("torque", "N·m", e.moment, cases.wrench[:, 3:])
    return tuple(nearest), tuple(violations)


def _load_violations(what: str, unit: str, load: Load, vectors: Array) -> list[str]:
    """Sentences for loads that the study does not allow."""
    found = []
    room = load.margin(vectors) / max(load.size, 1.0)
    for i in np.flatnonzero(room < -TOLERANCE).tolist():
        shown = "[" + ", ".join(f"{value:.6g}" for value in vectors[i]) + f"] {unit}"
        if isinstance(load, FixedVector):
            wanted = "[" + ", ".join(f"{value:.6g}" for value in load.value) + f"] {unit}"
            found.append(f"load case {i + 1} has {what} {shown} where the study has {wanted}")
        else:
            found.append(
                f"load case {i + 1} has {what} {shown}, above the bound of {load.size:.6g} {unit}"
            )
    if isinstance(load, FreeDirection) and load.is_cone:
        for i in range(len(vectors)):
            if not np.linalg.norm(vectors[i]) > 0.0:
                continue
            margin = float(load.cone(vectors[i][:, None])[0][0])
            if margin < -TOLERANCE:
                found.append(
                    f"load case {i + 1} has a {what} outside the cone by {describe(-margin, 'rad')}"
                )
    return found
