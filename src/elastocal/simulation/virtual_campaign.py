"""Virtual campaigns: what an instrument would read on a robot whose compliances are known.

In: study, true compliances, load cases. Out: `Measurements`, as a file of a real campaign gives.
Deflections are those of the nonlinear equilibrium, a route that does not use the regressor.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.deflections import loaded_deflection, markers_at
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import deflection
from elastocal.elastic.tensors import against_the_load
from elastocal.errors import InputError
from elastocal.measuring.instrument import Instrument
from elastocal.measuring.measurements import Measurements
from elastocal.study.study import Study


@dataclass(frozen=True)
class LoadError:
    """How the load that acts differs from the load that is recorded.

    Attributes:
        size: Standard deviation of its size, relative.
        direction: Standard deviation of its tilt about either of the two axes across it [rad].
    """

    size: float = 0.0
    direction: float = 0.0

    def __post_init__(self) -> None:
        for name in ("size", "direction"):
            value = getattr(self, name)
            if not 0.0 <= value < 1.0:
                raise InputError(f"load error: {name} must be from 0 to below 1, found {value:g}")


@dataclass(frozen=True)
class Outliers:
    """Gross errors of single readings.

    Attributes:
        share: Probability that a reading has one.
        size: Its length [m]; its direction is random. A rotation is wrong by as many standard
            deviations as a position would be.
    """

    share: float = 0.0
    size: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.share <= 1.0:
            raise InputError(f"outliers: share must be from 0 to 1, found {self.share:g}")
        if not (np.isfinite(self.size) and self.size >= 0.0):
            raise InputError(f"outliers: size must be a length from 0, found {self.size:g}")


@dataclass(frozen=True)
class Reality:
    """How a virtual cell differs from what is recorded of it, besides noise.

    Attributes:
        load_error: How true loads differ from recorded ones, anew in each experiment.
        outliers: Gross errors.
        linear: Deflections of the linear model instead of the equilibrium: for statistics of an
            estimator, not for its application.
    """

    load_error: LoadError = field(default_factory=LoadError)
    outliers: Outliers = field(default_factory=Outliers)
    linear: bool = False


@dataclass(frozen=True)
class VirtualReadings:
    """Everything of a virtual campaign that does not depend on chance.

    Attributes:
        arm: The true arm, with the tool of the experiments.
        deflection: (S, T, 3) true deflections of S load cases [m], the last of them rotations
            [rad] if the tool asks for that.
        covariance: (S, T, 3, 3) of their readings [m², rad²].
    """

    arm: ElasticArm
    deflection: Array
    covariance: Array


def simulate(
    study: Study,
    truth: ComplianceModel,
    cases: LoadCases,
    repeats: IntArray,
    rng: np.random.Generator,
    *,
    reality: Reality | None = None,
) -> Measurements:
    """Measure every load case as often as `repeats` says; each time is an experiment of its own.

    Args:
        study: Robot, tool, gravity and instrument of the campaign.
        truth: True compliances; it may have springs that the study does not identify.
        cases: S load cases, as they are recorded.
        repeats: (S,) how often each is measured.
        rng: Source of chance; load errors and outliers leave the noise as it is without them.
        reality: Load errors and outliers; none if None.

    Raises:
        EquilibriumError: the arm gives way under a load case.
        InputError: a compliance is negative.
    """
    case = np.repeat(np.arange(len(cases)), repeats)
    by_noise, by_load, by_outlier = rng.spawn(3)
    reality = reality or Reality()
    ideal = virtual_readings(study.arm, study.instrument, truth, cases, linear=reality.linear)
    true = ideal.deflection[case]
    if reality.load_error.size or reality.load_error.direction:
        wrench = disturbed(cases.wrench[case], reality.load_error, by_load)
        acting = LoadCases(cases.q[case], wrench)
        true = deflections(ideal.arm, truth.compliance, acting, reality.linear)
    covariance = ideal.covariance[case]
    read = true + noise(ideal.covariance, case, by_noise)
    if reality.outliers.share:
        read = read + gross_errors(
            read.shape, reality.outliers, by_outlier, lever(study.instrument)
        )
    count, targets = read.shape[:2]
    kind = "linear" if reality.linear else "nonlinear"
    return Measurements(
        tool=ideal.arm.tool,
        cases=LoadCases(cases.q[case], cases.wrench[case]),
        names=tuple(str(i + 1) for i in range(count)),
        case=np.repeat(np.arange(count), targets),
        marker=np.tile(np.arange(targets), count),
        deflection=read.reshape(-1, 3),
        covariance=covariance.reshape(-1, 3, 3),
        source=f"simulated, {kind} truth: {truth.source or 'given'}",
    )


def virtual_readings(
    arm: ElasticArm,
    instrument: Instrument,
    truth: ComplianceModel,
    cases: LoadCases,
    *,
    linear: bool,
) -> VirtualReadings:
    """True deflections of load cases and the covariance of their readings; see `simulate`."""
    negative = against_the_load(truth.springs, truth.compliance)
    if negative:
        raise InputError(
            f"the compliance of {negative[0]} is negative; a true one cannot be: no arm moves "
            "against the load"
        )
    arm = replace(arm, springs=truth.springs)
    still = np.zeros((len(cases), len(truth.springs)))
    points = markers_at(arm, cases.q, still).reshape(len(cases), -1, 3)
    covariance = instrument.covariances(points)
    true = deflections(arm, truth.compliance, cases, linear)
    return VirtualReadings(arm, true, covariance)


def deflections(arm: ElasticArm, compliance: Array, cases: LoadCases, linear: bool) -> Array:
    """(N, T, 3) deflections of the targets of a true arm [m, rad]; linear ones if `linear`."""
    if linear:
        rows = deflection(arm, compliance, cases)
        rows = rows if arm.tool.rotation else rows[:, :-3]
    else:
        rows = loaded_deflection(arm, compliance, cases)
    return np.asarray(rows).reshape(len(cases), -1, 3)


def noise(covariance: Array, case: IntArray, rng: np.random.Generator) -> Array:
    """(N, T, 3) noise of N experiments, each of a load case, `case` (N,), of S (S, T, 3, 3)."""
    root = np.linalg.cholesky(covariance)[case]
    drawn = rng.standard_normal((*root.shape[:3], 1))[..., 0]
    return np.einsum("ntij,ntj->nti", root, drawn)


def disturbed(wrench: Array, error: LoadError, rng: np.random.Generator) -> Array:
    """(N, 6) true wrenches of recorded ones: force and moment tilt and grow together.

    Source: ours.
    """
    count = len(wrench)
    grown = wrench * (1.0 + error.size * rng.standard_normal((count, 1)))
    force, moment = grown[:, :3], grown[:, 3:]
    main = np.where(np.any(force, axis=1, keepdims=True), force, moment)
    length = np.linalg.norm(main, axis=1, keepdims=True)
    along = main / np.maximum(length, 1e-300)
    turn = rng.standard_normal((count, 3))
    turn = error.direction * (turn - along * np.sum(along * turn, axis=1, keepdims=True))
    return np.concatenate([_turned(force, turn), _turned(moment, turn)], axis=1)


def _turned(vector: Array, turn: Array) -> Array:
    """(N, 3) vectors turned by rotation vectors (N, 3): Rodrigues' formula."""
    angle = np.linalg.norm(turn, axis=1, keepdims=True)
    axis = turn / np.maximum(angle, 1e-300)
    along = axis * np.sum(axis * vector, axis=1, keepdims=True)
    across = np.cross(axis, vector)
    return np.asarray(along + np.cos(angle) * (vector - along) + np.sin(angle) * across)


def lever(instrument: Instrument) -> float | None:
    """Length at which a rotation is as noisy as a position [m]; None if none is measured."""
    rotation = instrument.sigma_rotation
    return None if rotation is None else instrument.sigma / rotation


def gross_errors(
    shape: tuple[int, ...],
    outliers: Outliers,
    rng: np.random.Generator,
    lever: float | None = None,
) -> Array:
    """(..., T, 3) errors of readings, zero but for a share of them [m].

    With a lever [m] the last target is a rotation, and its errors are over that length [rad].
    """
    hit = rng.random(shape[:-1]) < outliers.share
    direction = rng.standard_normal(shape)
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    found = np.asarray(np.where(hit[..., None], outliers.size * direction, 0.0))
    if lever is not None:
        found[..., -1, :] /= lever
    return found
