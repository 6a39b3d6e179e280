"""Virtual campaigns: what an instrument would read on a robot whose compliances are known.

In: study, true compliances, load cases. Out: `Measurements`, as a file of a real campaign gives.
Deflections are those of the nonlinear equilibrium, a route that does not use the regressor.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.arrays import Array, IntArray, unset
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.deflections import loaded_deflection, markers_at
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.elastic.tensors import against_the_load
from elastocal.elastic.true_loads import TrueLoads
from elastocal.errors import InputError
from elastocal.measuring.instrument import Instrument
from elastocal.measuring.measurements import Measurements
from elastocal.simulation.new_each_time import come_back, rubbed, unexplained
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
        loads: How all loads together differ from recorded ones. None: not at all; where each
            campaign is on a robot of its own, as the study lets them.
        errors: What is new with every load case, load or approach; what is common to all loads
            does not count. None: nothing; where each campaign is on a robot of its own, what the
            study says.
    """

    load_error: LoadError = field(default_factory=LoadError)
    outliers: Outliers = field(default_factory=Outliers)
    linear: bool = False
    loads: TrueLoads | None = None
    errors: CaseErrors | None = None

    @property
    def each_load(self) -> LoadError:
        """How loads differ anew in each experiment, whoever says so."""
        given, errors = self.load_error, self.errors or CaseErrors()
        return LoadError(
            float(np.hypot(given.size, errors.gain)), float(np.hypot(given.direction, errors.tilt))
        )


@dataclass(frozen=True)
class VirtualReadings:
    """Everything of a virtual campaign that does not depend on chance.

    Attributes:
        arm: The true arm, with the tool of the experiments.
        deflection: (S, T, 3) true deflections of S load cases [m], the last of them rotations
            [rad] if the tool asks for that.
        covariance: (S, T, 3, 3) of their readings [m², rad²].
        common: (S, T, 3, e) what readings of one experiment share, in that already [m, rad].
    """

    arm: ElasticArm
    deflection: Array
    covariance: Array
    common: Array


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
    by_noise, by_load, by_outlier, by_case = rng.spawn(4)
    reality = reality or Reality()
    ideal = virtual_readings(study.arm, study.instrument, truth, cases, linear=reality.linear)
    true = moved(ideal, truth.compliance, cases, case, reality, by_load, by_case)
    covariance = ideal.covariance[case]
    read = true + noise(ideal.covariance, case, by_noise, ideal.common)
    if reality.outliers.share:
        read = read + gross_errors(
            read.shape, reality.outliers, by_outlier, lever(study.instrument)
        )
    count, targets = read.shape[:2]
    kind = "linear" if reality.linear else "nonlinear"
    return Measurements(
        tool=ideal.arm.tool,
        cases=cases.chosen(case),
        names=tuple(str(i + 1) for i in range(count)),
        case=np.repeat(np.arange(count), targets),
        marker=np.tile(np.arange(targets), count),
        deflection=read.reshape(-1, 3),
        covariance=covariance.reshape(-1, 3, 3),
        common=np.concatenate(ideal.common[case]) if ideal.common.size else unset(),
        source=f"simulated, {kind} truth: {truth.source or 'given'}",
    )


def moved(
    ideal: VirtualReadings,
    compliance: Array,
    cases: LoadCases,
    case: IntArray,
    reality: Reality,
    by_load: np.random.Generator,
    by_case: np.random.Generator,
) -> Array:
    """(N, T, 3) how the targets move in N experiments, before anybody reads it [m, rad].

    Args:
        ideal: How they would if nothing but the compliances were in it.
        compliance: (c,) true compliances.
        cases: S load cases, as they are recorded.
        case: (N,) which of them each experiment is of.
        reality: What is in it besides.
        by_load: Source of chance for what each load has of its own.
        by_case: The same for what each load case has, and each approach.
    """
    errors, loads = reality.errors or CaseErrors(), reality.loads or TrueLoads()
    each = reality.each_load
    by_joint, by_misfit, by_approach = by_case.spawn(3)
    wrench, true = cases.wrench[case], ideal.deflection[case]
    if loads.gain or loads.turn.any():
        turn = np.tile(loads.turn, (len(wrench), 1))
        grown = (1.0 + loads.gain) * wrench
        wrench = np.hstack([_turned(grown[:, :3], turn), _turned(grown[:, 3:], turn)])
    if each.size or each.direction:
        wrench = disturbed(wrench, each, by_load)
    same = cases.distinct
    number = int(same.max(initial=-1)) + 1
    if errors.friction:
        own = rubbed(errors.friction, compliance, ideal.arm.springs.joint >= 0, number, by_joint)
        compliance = own[same[case]]
    if errors.friction or not np.array_equal(wrench, cases.wrench[case]):
        acting = LoadCases(cases.q[case], wrench)
        true = deflections(ideal.arm, compliance, acting, reality.linear)
    tool = ideal.arm.tool
    if errors.discrepancy or errors.discrepancy_length:
        _, first = np.unique(same, return_index=True)
        off = unexplained(errors, ideal.deflection[first], len(tool.markers), by_misfit)
        true = true + off[same[case]]
    if errors.repeatability:
        true = true + come_back(
            errors.repeatability, len(case), len(tool.targets), len(tool.markers), by_approach
        )
    return true


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
    return VirtualReadings(arm, true, covariance, instrument.common(points))


def deflections(arm: ElasticArm, compliance: Array, cases: LoadCases, linear: bool) -> Array:
    """(N, T, 3) deflections of the targets of a true arm [m, rad]; linear ones if `linear`.

    `compliance` is (c,), or (N, c) where each load case has its own.
    """
    if linear:
        blocks = regressor(arm, cases)
        each = np.broadcast_to(compliance, (len(cases), blocks.shape[2]))
        rows = np.einsum("nrc,nc->nr", blocks, each)
    else:
        rows = loaded_deflection(arm, compliance, cases)
    return np.asarray(rows).reshape(len(cases), -1, 3)


def noise(
    covariance: Array, case: IntArray, rng: np.random.Generator, common: Array | None = None
) -> Array:
    """(N, T, 3) noise of N experiments, each of a load case, `case` (N,), of S.

    Args:
        covariance: (S, T, 3, 3) of the readings.
        case: Load case of each experiment.
        rng: Source of chance.
        common: (S, T, 3, e) what readings of one experiment share, in `covariance` already.
    """
    shared = np.zeros((*covariance.shape[:3], 0)) if common is None else common
    root = np.linalg.cholesky(covariance - shared @ shared.transpose(0, 1, 3, 2))[case]
    drawn = rng.standard_normal((*root.shape[:3], 1))[..., 0]
    together = rng.standard_normal((len(case), shared.shape[3]))
    each = np.einsum("ntij,ntj->nti", root, drawn)
    return np.asarray(each + np.einsum("ntij,nj->nti", shared[case], together))


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
