"""Nuisance: what moves readings and tools besides, of known form and unknown size.

Nobody asks for these numbers. Each has a prior: the mean and the standard uncertainty that arms
of this kind are known to have. Fits find them together with what is asked for, plans see them.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, BoolArray, freeze
from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.unknowns import Unknowns
from elastocal.errors import InputError
from elastocal.robot.chain import Robot


@dataclass(frozen=True)
class Nuisance:
    """u unknowns with priors, and the errors of load cases.

    Attributes:
        unknowns: The u unknowns, and the springs they make.
        mean: (u,) prior means [rad/(N·m) or m/N].
        deviation: (u,) prior standard uncertainties, independent of each other.
        signed: (u,) which of them may be below zero; the others cannot.
        source: u sentences: where the size of each is from.
        nominal: (n,) compliances of all joints of the robot, as far as they are known before the
            campaign: what errors that are shares of a deflection are shares of.
        errors: What is new with every load case or load.
    """

    unknowns: Unknowns
    mean: Array
    deviation: Array
    signed: BoolArray
    source: tuple[str, ...]
    nominal: Array
    errors: CaseErrors = field(default_factory=CaseErrors)

    def __post_init__(self) -> None:
        freeze(self, "mean", "deviation", "nominal")
        freeze(self, "signed", dtype=np.bool_)
        u = len(self.unknowns)
        sizes = {len(self.mean), len(self.deviation), len(self.signed), len(self.source)}
        if sizes != {u}:
            raise InputError(f"{u} nuisance parameters need as many priors, found {sorted(sizes)}")
        if not (self.deviation > 0.0).all():
            raise InputError("the standard uncertainty of a nuisance parameter must be positive")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the u unknowns."""
        return self.unknowns.names

    @property
    def information(self) -> Array:
        """(u, u) inverse of the prior covariance [(N·m/rad)² or (N/m)²]."""
        return np.diag(self.deviation**-2.0)

    @property
    def expected(self) -> Array:
        """(u,) means of the unknowns in truth: what cannot be below zero is a size [rad/(N·m) …].

        A prior about zero has that size as its root mean square.
        """
        size = np.hypot(self.mean, self.deviation)
        return np.asarray(np.where(self.signed, self.mean, np.sqrt(2.0 / np.pi) * size))


def usual_compliances(robot: Robot, nuisance: Nuisance) -> dict[str, float]:
    """Compliances of all that bends, joints and nuisance, as expected before, by spring.

    Errors are shares of what the arm bends. With the joints alone, load cases in which these hardly
    move anything would promise next to no errors.
    """
    unknowns = nuisance.unknowns
    made = (unknowns.make @ nuisance.expected).tolist()
    joints = zip(robot.joint_names, nuisance.nominal.tolist(), strict=True)
    return dict(zip(unknowns.springs.names, made, strict=True)) | dict(joints)
