"""Many campaigns at once: the estimates of `identify` for a batch of readings of one plan.

In: elastic arm, load cases, readings of C campaigns. Out: C estimates with their standard errors.
It is the same weighted least squares by the same Gauss-Newton iteration, without diagnostics:
what differs between campaigns is the right-hand side, so that one regressor serves all of them, and
the linearised equilibria of all campaigns are one batch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.equilibrium import linearise, markers_at
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.errors import InputError

_MOST_STEPS = 60
_AT_REST = 1e-7  # step over the standard errors, as in `identify`


@dataclass(frozen=True)
class Design:
    """What C campaigns have in common.

    Attributes:
        arm: Robot with the c springs that bend, and the tool with K markers.
        free: (p,) positions of the identified springs.
        start: (c,) compliances; those of the free springs do not count.
        cases: S load cases, as recorded.
        case: (N,) load case of each experiment.
        covariance: (S, K, 3, 3) of the readings [m²].
        equilibrium: Whether the model is the nonlinear equilibrium, or else the regressor.
    """

    arm: ElasticArm
    free: IntArray
    start: Array
    cases: LoadCases
    case: IntArray
    covariance: Array
    equilibrium: bool

    @property
    def dof(self) -> int:
        """Degrees of freedom of the residuals."""
        return 3 * len(self.case) * len(self.arm.tool.markers) - len(self.free)


@dataclass(frozen=True)
class Estimates:
    """C fits.

    Attributes:
        compliance: (C, p) estimates [rad/(N·m) or m/N].
        covariance: (C, p, p) for the noise that the covariances of the readings promise.
        chi_square: (C,) sums of the squared residuals over their variances.
    """

    compliance: Array
    covariance: Array
    chi_square: Array


def fit_all(design: Design, readings: Array) -> Estimates:
    """Fit every campaign by itself.

    Repeats of a load case have the same row and the same weight, so their mean tells all that
    the estimate needs; their scatter goes to chi-square.

    Args:
        design: What the campaigns have in common.
        readings: (C, N, K, 3) deflections read [m].

    Raises:
        InputError: an iteration does not come to rest.

    Source: paper eqs. (6), (9), (13); the batch is ours.
    """
    count, markers = len(readings), readings.shape[2]
    whitener = np.linalg.inv(np.linalg.cholesky(design.covariance))  # (S, K, 3, 3)
    repeats = np.bincount(design.case, minlength=len(design.cases))
    white = np.einsum("nkij,cnkj->cnki", whitener[design.case], readings)
    share = np.zeros((len(repeats), len(design.case)))
    share[design.case, np.arange(len(design.case))] = 1.0 / repeats[design.case]
    mean = (share @ white.reshape(count, len(design.case), -1)).reshape(count, -1, markers, 3)
    scatter = np.sum((white - mean[:, design.case]) ** 2, axis=(1, 2, 3))
    weight = np.sqrt(repeats)[:, None, None, None] * whitener
    values = (np.sqrt(repeats)[:, None, None] * mean).reshape(count, -1)
    if design.equilibrium:
        compliance, covariance, rest = _iterated(design, weight, values)
    else:
        compliance, covariance, rest = _direct(design, weight, values)
    return Estimates(compliance, covariance, scatter + np.sum(rest**2, axis=1))


def _direct(design: Design, weight: Array, values: Array) -> tuple[Array, Array, Array]:
    """Estimates, covariances, residuals of the linear model."""
    arm, free = design.arm, design.free
    rows = _weighted(regressor(arm, design.cases)[None], weight)[0]
    known = np.array(design.start)
    known[free] = 0.0
    right = values - rows @ known
    own = rows[:, free]
    scale = 1.0 / np.linalg.norm(own, axis=0)
    q, r = np.linalg.qr(own * scale)
    root = np.linalg.inv(r)
    compliance = scale * (right @ q @ root.T)
    rest = right - compliance @ own.T
    compliance += scale * (rest @ q @ root.T)  # one step of refinement
    covariance = scale[:, None] * (root @ root.T) * scale
    return (
        compliance,
        np.broadcast_to(covariance, (len(values), *covariance.shape)),
        right - compliance @ own.T,
    )


def _iterated(design: Design, weight: Array, values: Array) -> tuple[Array, Array, Array]:
    """The same of the equilibrium: Gauss-Newton from the linear estimate."""
    arm, cases, free = design.arm, design.cases, design.free
    count, size, springs = len(values), len(cases), len(arm.springs)
    compliance = np.tile(design.start, (count, 1))
    compliance[:, free] = _direct(design, weight, values)[0]
    q = np.tile(cases.q, (count, 1))
    loads = [np.tile(cases.wrench, (count, 1))]
    if arm.sags:
        loads.append(np.zeros_like(loads[0]))
    states = [np.zeros((count * size, springs)) for _ in loads]
    still = markers_at(arm, cases.q, np.zeros((size, springs)))
    for _ in range(_MOST_STEPS):
        each = np.repeat(compliance, size, axis=0)
        found = [
            linearise(arm, each, q, load, state) for load, state in zip(loads, states, strict=True)
        ]
        modelled = [f.markers + np.einsum("nmp,np->nm", f.velocity, f.step) for f in found]
        gradients = [f.velocity @ f.slope for f in found]
        unloaded = modelled[1] if arm.sags else np.tile(still, (count, 1))
        gradient = gradients[0] - gradients[1] if arm.sags else gradients[0]
        deflection = (modelled[0] - unloaded).reshape(count, size, -1)
        rows = _weighted(gradient.reshape(count, size, -1, springs), weight)[:, :, free]
        rest = values - _weighted(deflection[..., None], weight)[..., 0]
        step, covariance, in_errors = _steps(rows, rest)
        full = np.zeros((count, springs))
        full[:, free] = step
        states = [
            state + f.step + np.einsum("npq,nq->np", f.slope, np.repeat(full, size, axis=0))
            for state, f in zip(states, found, strict=True)
        ]
        compliance += full
        if not np.isfinite(compliance).all():
            break
        small = np.abs(step).max(axis=1) <= 1e-14 * np.abs(compliance[:, free]).max(axis=1)
        if (small | (in_errors <= _AT_REST * np.sqrt(len(free)))).all():
            rest = rest - np.einsum("crp,cp->cr", rows, step)
            return compliance[:, free], covariance, rest
    raise InputError(
        "a virtual campaign cannot be fitted: the loads are too large for these compliances"
    )


def _weighted(rows: Array, weight: Array) -> Array:
    """(C, 3SK, x) rows over the noise of rows (C, S, 3K, x), times the root of the repeats."""
    count, size, _, width = rows.shape
    apart = rows.reshape(count, size, -1, 3, width)
    return np.asarray(weight @ apart).reshape(count, -1, width)


def _steps(rows: Array, rest: Array) -> tuple[Array, Array, Array]:
    """Least-squares solutions (C, p) of C systems, covariances, sizes in standard errors (C,)."""
    scale = 1.0 / np.linalg.norm(rows, axis=1)
    q, r = np.linalg.qr(rows * scale[:, None])
    right = np.einsum("crp,cr->cp", q, rest)
    root = np.linalg.inv(r) * scale[..., None]
    step = np.einsum("cpq,cq->cp", root, right)
    return step, root @ root.transpose(0, 2, 1), np.linalg.norm(right, axis=1)
