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
from elastocal.matrices import rank_of, scaled_inverse
from elastocal.planning.with_errors import WithErrors
from elastocal.squares import largest_likely, weights_of
from elastocal.study.study import Study


@dataclass(frozen=True)
class Promise:
    """What a plan is worth when nuisance counts; lengths in metres.

    Attributes:
        rho0: Root mean square position error after compensation of all that is fitted, nuisance
            too, with the errors of load cases in the readings.
        rho0_each: The same at each test pose.
        squares: The squared error is expected to be Σ w z² with these weights w [m²] and standard
            normal numbers z, weighed over the test poses, mean of the points of a path.
        covariance: (c, c) of the springs that are sought [(rad/(N·m))² or (m/N)²].
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
    squares: Array
    covariance: Array
    standard_error: Array
    without: float
    uncompensated: float
    friction: float
    discrepancy: float
    repeatability: float

    @property
    def limit(self) -> float:
        """What the root mean square error stays below in 95 % of campaigns [m]."""
        return largest_likely(self.squares)


def promise(
    study: Study, cases: LoadCases, repeats: IntArray, information: Array | None = None
) -> Promise | None:
    """What load cases, each measured `repeats` times, promise; None if the study knows no nuisance.

    What was measured before has errors of load cases, too, and shares those that are common.

    Args:
        study: The study.
        cases: S load cases.
        repeats: (S,) repeats.
        information: (f, f) information on all that is fitted by the noise of the instrument alone;
            computed if not given.

    Source: ours.
    """
    nuisance = study.nuisance
    if nuisance is None:
        return None
    if information is None:
        each_case = study.space.information(cases)
        information = study.prior + np.einsum("i,ijk->jk", repeats.astype(float), each_case)
    own = [study.fitted.names.index(name) for name in study.sought.names]
    beside = [study.fitted.names.index(name) for name in nuisance.names]
    absolute = study.experiments.weighs  # what readings cannot tell rests on its prior then
    plain = _inverse(information[np.ix_(own, own)], regular=absolute)
    told = WithErrors(study, nuisance)
    covariance = _with_errors(told, cases, repeats, information)
    blocks = [pose.regressors for pose in study.test_poses]
    moved = [told.blocks(pose) for pose in study.test_poses]
    other = np.array([told.other_cell(pose) for pose in study.test_poses])
    each = np.array([_square(a, covariance) for a in moved]) + other
    prior = np.diag(nuisance.deviation**2)
    errors = nuisance.errors
    floors = [
        _floor(told, CaseErrors(friction=errors.friction)),
        _floor(
            told,
            CaseErrors(
                discrepancy=errors.discrepancy, discrepancy_length=errors.discrepancy_length
            ),
        ),
    ]
    return Promise(
        rho0=_root(study, each),
        rho0_each=tuple(np.sqrt(each).tolist()),
        squares=frozen(np.append(_weights(told, covariance), study.shares @ other)),
        covariance=frozen(covariance[np.ix_(own, own)]),
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
        return _inverse(information, regular=told.study.experiments.weighs)
    total = told.total(cases, repeats)
    return _inverse(total, len(told.study.fitted))


def _inverse(information: Array, first: int | None = None, *, regular: bool = False) -> Array:
    """Its inverse; infinite where that on the `first` unknowns is singular: the rest has priors.

    If all have, it is `regular` anyway.
    """
    sought = information[:first, :first]
    if not regular and rank_of(sought) < len(sought):
        return np.full_like(information, np.inf)
    return np.asarray(scaled_inverse(information[None])[0])


def _square(blocks: Array, covariance: Array) -> float:
    """Mean square of what blocks (N, r, p) make of unknowns with this covariance."""
    if not np.isfinite(covariance).all():
        return float("inf")
    return float(((blocks @ covariance) * blocks).sum(axis=(1, 2)).mean())


def _weights(told: WithErrors, covariance: Array) -> Array:
    """Weights w so that Σ w z² is the mean square over the test poses, by their weights [m²]."""
    if not np.isfinite(covariance).all():
        return np.array([np.inf])
    return weights_of(told.form, covariance)[0]


def _root(study: Study, squares: Array) -> float:
    """Root of the mean of squares over the test poses, by their weights."""
    shares = study.shares
    return float(np.sqrt(shares[shares > 0.0] @ squares[shares > 0.0]))


def _floor(told: WithErrors, errors: CaseErrors) -> float:
    """Root mean square of errors that are new with every load case, at the test poses [m]."""
    study, squares = told.study, []
    for pose in study.test_poses:
        if pose.cases is None or pose.tool is None:
            squares.append(0.0)
            continue
        arm = ElasticArm(study.robot, told.bending, pose.tool.at_tcp, study.gravity)
        found = shared_covariance(errors, arm, told.usual, pose.cases)
        squares.append(float(np.trace(found, axis1=1, axis2=2).mean()))
    return _root(study, np.array(squares))
