"""True robots: what a virtual one has besides its joints, drawn by chance.

In: compliances that are given, nuisance as a study knows it. Out: a robot that gives way where such
robots do, and loads that are all wrong together. The priors of a study are centred on zero, a robot
is not: whatever gives way goes with the load, so compliances are sizes, and tensors have no
negative eigenvalue.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.effects import without
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.springs import merged
from elastocal.elastic.true_loads import TrueLoads
from elastocal.study.study import Study

_TENSOR = float(0.5 * np.sqrt(4.0 + np.sqrt(2.0)))
"""Root mean square, along any axis, of |T| with T a symmetric 2 x 2 matrix of normal numbers whose
deviations are 1 on the diagonal and √½ beside it."""


@dataclass(frozen=True)
class TrueRobot:
    """A robot as it is, which no campaign knows.

    Attributes:
        model: True compliances of all its springs.
        loads: How its loads differ from what is recorded of them; None if nothing says.
        errors: Sizes of what errs anew.
        drawn: Whether any of it was drawn by chance.
    """

    model: ComplianceModel
    loads: TrueLoads | None = None
    errors: CaseErrors = field(default_factory=CaseErrors)
    drawn: bool = False

    @property
    def process_gain(self) -> float:
        """By which share the process force is larger than is said."""
        return 0.0 if self.loads is None else self.loads.process_gain


def true_robot(
    study: Study,
    given: ComplianceModel,
    rng: np.random.Generator,
    loads: TrueLoads | None = None,
) -> TrueRobot:
    """A robot that has what is given, and by chance what else the study knows as nuisance.

    Args:
        study: The study.
        given: Compliances that are true; what of the nuisance they already are is not drawn.
        rng: Source of chance.
        loads: How the loads differ, if that is given.

    Raises:
        InputError: a spring of the nuisance has the name of another one that is given.
    """
    nuisance = study.nuisance
    if nuisance is None:
        return TrueRobot(given, loads)
    by_spring, by_load = rng.spawn(2)
    drawn = loads is None and nuisance.errors.any_common
    loads = loads or _loads(nuisance.errors, by_load)
    left = without(study.robot, nuisance, given.springs)
    if not len(left.unknowns):
        return TrueRobot(given, loads, nuisance.errors, drawn)
    own = left.unknowns.springs
    made = (left.unknowns.make @ sizes(left, by_spring)).tolist()
    value = dict(zip(own.names, made, strict=True)) | dict(
        zip(given.names, given.compliance.tolist(), strict=True)
    )
    springs = merged(given.springs, own)
    model = ComplianceModel(
        springs,
        frozen([value[name] for name in springs.names]),
        source=f"{given.source or 'given'}; what gives way besides by chance",
    )
    return TrueRobot(model, loads, nuisance.errors, drawn=True)


def sizes(nuisance: Nuisance, rng: np.random.Generator) -> Array:
    """(u,) true values of the unknowns of a nuisance [rad/(N·m) or m/N].

    Each is the size of a normal number whose deviation is the root mean square of its prior, so
    that of the size is the same. A tensor T of such numbers is |T|, of the same eigenvectors and
    the sizes of its eigenvalues, over what makes its root mean square along any axis the same.

    Source: ours; independent normal entries, of half the variance beside the diagonal, make a
    distribution that no rotation changes, and so is that of |T|.
    """
    usual = np.hypot(nuisance.mean, nuisance.deviation)
    drawn = usual * rng.standard_normal(len(usual))
    found = np.abs(drawn)
    make = nuisance.unknowns.make != 0.0
    for u in np.flatnonzero(nuisance.signed).tolist():
        springs = make[:, u]
        own = np.flatnonzero(make[springs].any(axis=0))
        rows = nuisance.unknowns.make[np.ix_(springs, own)]
        axes = nuisance.unknowns.springs.axis[springs]
        tensors = np.einsum("su,si,sj->iju", rows, axes, axes)
        value, vectors = np.linalg.eigh(tensors @ drawn[own])
        size = (vectors * np.abs(value)) @ vectors.T / _TENSOR
        found[own] = np.linalg.lstsq(tensors.reshape(9, -1), size.ravel(), rcond=None)[0]
    return np.asarray(found)


def _loads(errors: CaseErrors, rng: np.random.Generator) -> TrueLoads:
    """How all loads are wrong together; the process force as the cell that measures it."""
    own, other = errors.common_gain * rng.standard_normal(2)
    turn = errors.common_tilt * rng.standard_normal(3)
    gain = {"same": own, "exact": 0.0, "other": other}[errors.process_force]
    return TrueLoads(float(own), turn, float(gain))
