"""What a plan promises when nuisance counts, and what the same plan would promise without.

In: a study that knows nuisance, load cases with repeats. Out: ρ0 with everything in it, ρ0 without
any nuisance, and what no calibration takes away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.case_errors import CaseErrors, shared_covariance
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.springs import joint_springs
from elastocal.matrices import rank_of, scaled_inverse
from elastocal.planning.with_errors import WithErrors
from elastocal.study.study import Study


@dataclass(frozen=True)
class Promise:
    """What a plan is worth when nuisance counts; lengths in metres.

    Attributes:
        rho0: Root mean square position error after compensation of all that is fitted, nuisance
            too, with the errors of load cases in the readings.
        rho0_each: The same at each test pose.
        standard_error: (p,) standard errors of the compliances to identify [rad/(N·m) or m/N].
        without: ρ0 if there were no nuisance: what a plan claims that knows none.
        uncompensated: What the springs of the nuisance move the tool at the test poses, by their
            priors, if nobody compensates it.
        friction: Floor: what friction leaves at the test poses; no calibration takes it away.
        discrepancy: Floor: the same of what no model explains.
        repeatability: Floor: the same of where the robot comes back to.
    """

    rho0: float
    rho0_each: tuple[float, ...]
    standard_error: Array
    without: float
    uncompensated: float
    friction: float
    discrepancy: float
    repeatability: float


def promise(
    study: Study, cases: LoadCases, repeats: IntArray, information: Array
) -> Promise | None:
    """What load cases, each measured `repeats` times, promise; None if the study knows no nuisance.

    What was measured before counts with the noise of its instrument alone.

    Args:
        study: The study.
        cases: S load cases.
        repeats: (S,) repeats.
        information: (f, f) information on all that is fitted by the noise of the instrument alone.

    Source: ours.
    """
    nuisance = study.nuisance
    if nuisance is None:
        return None
    own = [study.fitted.names.index(name) for name in study.sought.names]
    beside = [study.fitted.names.index(name) for name in nuisance.names]
    plain = _inverse(information[np.ix_(own, own)])
    told = WithErrors(study, nuisance)
    covariance = _with_errors(told, cases, repeats, information)
    blocks = [pose.regressors for pose in study.test_poses]
    each = np.array(
        [_square(told.blocks(p), covariance) + told.other_cell(p) for p in study.test_poses]
    )
    prior = np.diag(nuisance.deviation**2)
    errors = nuisance.errors
    floors = [
        _floor(study, nuisance, CaseErrors(friction=errors.friction)),
        _floor(
            study,
            nuisance,
            CaseErrors(
                discrepancy=errors.discrepancy, discrepancy_length=errors.discrepancy_length
            ),
        ),
    ]
    return Promise(
        rho0=_root(study, each),
        rho0_each=tuple(np.sqrt(each).tolist()),
        standard_error=frozen(np.sqrt(np.diagonal(covariance))[study.wanted]),
        without=_root(study, np.array([_square(a[:, :, own], plain) for a in blocks])),
        uncompensated=_root(study, np.array([_square(a[:, :, beside], prior) for a in blocks])),
        friction=floors[0],
        discrepancy=floors[1],
        repeatability=float(np.sqrt(3.0) * errors.repeatability),
    )


def _with_errors(
    told: WithErrors, cases: LoadCases, repeats: IntArray, information: Array
) -> Array:
    """(f + e, f + e) covariance of what is fitted and of e common errors."""
    if not told.nuisance.errors.any:
        return _inverse(information)
    total = told.base + told.informations(cases, repeats).sum(axis=0)
    return _inverse(total, len(told.study.fitted))


def _inverse(information: Array, first: int | None = None) -> Array:
    """Its inverse; infinite where that on the `first` unknowns is singular: the rest has priors."""
    sought = information[:first, :first]
    if rank_of(sought) < len(sought):
        return np.full_like(information, np.inf)
    return np.asarray(scaled_inverse(information[None])[0])


def _square(blocks: Array, covariance: Array) -> float:
    """Mean square of what blocks (N, r, p) make of unknowns with this covariance."""
    if not np.isfinite(covariance).all():
        return float("inf")
    return float(((blocks @ covariance) * blocks).sum(axis=(1, 2)).mean())


def _root(study: Study, squares: Array) -> float:
    """Root of the mean of squares over the test poses, by their weights."""
    shares = study.shares
    return float(np.sqrt(shares[shares > 0.0] @ squares[shares > 0.0]))


def _floor(study: Study, nuisance: Nuisance, errors: CaseErrors) -> float:
    """Root mean square of errors that are new with every load case, at the test poses [m]."""
    squares = []
    for pose in study.test_poses:
        if pose.cases is None or pose.tool is None:
            squares.append(0.0)
            continue
        arm = ElasticArm(study.robot, joint_springs(study.robot), pose.tool.at_tcp, study.gravity)
        found = shared_covariance(errors, arm, nuisance.nominal, pose.cases)
        squares.append(float(np.trace(found, axis1=1, axis2=2).mean()))
    return _root(study, np.array(squares))
