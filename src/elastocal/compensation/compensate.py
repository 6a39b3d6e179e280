"""Compensation: joint values at which the loaded arm has its tool where the task wants it.

In: elastic arm, compliance model, load cases of the task. Out: corrected configurations, and what
the model expects to remain with what uncertainty. The target of a load case is where the tool is
at its configuration q0 without the process load; the weight of the links, if known, is there with
and without.

    linear:      q = q0 - J0⁺ A(q0, w) k                                     (paper eq. 15)
    nonlinear:   tool(bent) = target,  bent = q + θ,  θ = k ∘ y(bent)        (paper eq. 14, exact)

The nonlinear rule looks for the *bent* arm: where the springs are all in actuated joints it is
the arm at q0, and q = q0 - k ∘ y(q0, w) needs neither Jacobian nor iteration. Springs in links
and base move the tool besides; then the bent joints are searched by Newton steps.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, frozen
from elastocal.compensation.doubts import doubts, notes
from elastocal.compensation.loaded_inverse_kinematics import (
    Bent,
    loaded_arm_at,
    stable,
    task_rows,
    tcp_poses,
)
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.cartesian import limit_left
from elastocal.elastic.case_errors import CaseErrors, shared_covariance
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.equilibrium import equilibrium
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import deflection, regressor
from elastocal.elastic.springs import subset
from elastocal.errors import Doubt, InputError
from elastocal.robot.damped_steps import damped_steps
from elastocal.robot.posture import jacobian

SAME_PLACE = 1e-9
"""How far the re-simulated tool may be from where the search left it [m]."""


@dataclass(frozen=True)
class Compensation:
    """N corrected configurations of a task.

    Attributes:
        arm: Elastic arm with the tool of the task.
        model: Compliances that were compensated.
        cases: The N load cases of the task, as wanted.
        rule: "nonlinear" or "linear".
        q: (N, n) corrected configurations [rad or m]; NaN where there is none.
        target: (N, 4, 4) pose of the TCP without process load: what the task wants [m].
        command: (N, 4, 4) pose of the TCP that a controller must be given, if it takes poses: the
            rigid arm at the corrected configuration [m].
        before: (N, 3) deflection of the TCP without compensation, by the model [m].
        after: (N, 3) what remains with it, by the nonlinear equilibrium of the model [m].
        covariance: (N, 3, 3) of the remaining error, caused by the covariance of the model [m²].
        limit: What the root mean square of that error over all points stays below with 95 % [m].
        floor: (N,) root mean square error that no calibration takes away: friction, what no model
            explains, where the robot comes back to [m]; zero where nothing is said of them.
        converged: (N,) whether a stable equilibrium was found at the corrected configuration and
            the search for it came to rest, at the target or, where damped, as near as it gets.
        iterations: (N,) steps of the search.
        damped: (N,) whether the arm is nearly singular there, so that some error may remain.
        doubts: What is odd at each of the N points.
        notes: What is odd with all of them.
        calibrated: Whether a calibrated robot was corrected, its geometry too.
    """

    arm: ElasticArm
    model: ComplianceModel
    cases: LoadCases
    rule: str
    q: Array
    target: Array
    command: Array
    before: Array
    after: Array
    covariance: Array
    limit: float
    floor: Array
    converged: BoolArray
    iterations: IntArray
    damped: BoolArray
    doubts: tuple[tuple[Doubt, ...], ...]
    notes: tuple[Doubt, ...]
    calibrated: bool = False

    def __len__(self) -> int:
        return len(self.cases)

    @property
    def rho0(self) -> Array:
        """(N,) root mean square of the remaining error caused by the uncertain model [m].

        Source: paper eq. (17), (20) with every load case as its own test pose.
        """
        return np.sqrt(np.maximum(np.trace(self.covariance, axis1=1, axis2=2), 0.0))

    @property
    def expected(self) -> Array:
        """(N,) root mean square error expected [m].

        Of the uncertain and imperfect model, the imperfect rule, and the floor below them.
        """
        square = self.rho0**2 + np.sum(self.after**2, axis=1)
        return np.asarray(np.sqrt(square + self.model.model_error**2 + self.floor**2))

    @property
    def beyond_limits(self) -> BoolArray:
        """(N, n) corrected joint values that the robot's limits do not allow."""
        robot = self.arm.robot
        return np.asarray((self.q < robot.lower) | (self.q > robot.upper))


def compensate(
    arm: ElasticArm, model: ComplianceModel, cases: LoadCases, errors: CaseErrors | None = None
) -> Compensation:
    """Corrected configurations by the nonlinear equilibrium: exact for any size of deflection.

    Robots with six joints or more restore position and orientation of the tool, robots with fewer
    its position. Of many solutions the one is taken whose loaded joints are nearest to q0.

    Args:
        arm: Elastic arm with the springs of the model and the tool of the task: the wrench acts at
            its load point, its TCP is judged.
        model: p compliances with their covariance.
        cases: N load cases of the task.
        errors: What errs from load case to load case besides; none if not given.

    Raises:
        InputError: arm and model have different springs, or none of them bends.

    Source: paper eq. (14); the split into joint springs and others is ours.
    """
    _refuse_rigid(model)
    idle = _idle(arm, model, cases.q)
    target = tcp_poses(arm, cases.q, idle)
    start = cases.q.copy()
    own = arm.springs.joint >= 0
    start[:, arm.springs.joint[own]] += np.nan_to_num(idle[:, own])
    q, found = loaded_arm_at(arm, model.compliance, cases, target, start)
    return _judged(arm, model, cases, "nonlinear", q, target, found, errors)


def compensate_linearly(
    arm: ElasticArm, model: ComplianceModel, cases: LoadCases, errors: CaseErrors | None = None
) -> Compensation:
    """Corrected configurations by the linear rule q = q0 - J0⁻¹ K_C⁻¹ W.

    Arguments, robots with few or many joints, and what is raised: as for `compensate`. What
    remains is judged by the nonlinear equilibrium.

    Source: paper eq. (15), with K_C⁻¹ W = A(q0, w) k and the pseudo-inverse of J0.
    """
    _refuse_rigid(model)
    target = tcp_poses(arm, cases.q, _idle(arm, model, cases.q))
    shift = deflection(replace(arm, tool=arm.tool.at_tcp), model.compliance, cases)
    rows = task_rows(arm)
    columns = jacobian(arm.robot, cases.q, arm.tool.tcp)[:, :rows]
    steps = damped_steps(columns, -shift[:, :rows], arm.robot.prismatic)
    count = len(cases)
    found = Bent(
        cases.q,
        np.zeros((count, 0)),
        np.ones(count, dtype=bool),
        np.ones(count, dtype=np.int64),
        steps.damped,
        steps.lost,
    )
    return _judged(arm, model, cases, "linear", cases.q + steps.step, target, found, errors)


def _refuse_rigid(model: ComplianceModel) -> None:
    if not model.compliance.any():
        raise InputError(
            f"{model.source or 'the model'}: all compliances are zero, as where a fit held them "
            "all, so nothing bends and nothing is known of the error; look at that fit first"
        )


RULES = {"nonlinear": compensate, "linear": compensate_linearly}
"""The rules by their names."""


def mirrored(compensation: Compensation) -> Compensation:
    """The same correction to the wrong side: a negative control, which must leave more."""
    return replace(compensation, q=2.0 * compensation.cases.q - compensation.q)


def residual(
    arm: ElasticArm, truth: ComplianceModel, compensation: Compensation, *, gain: float = 0.0
) -> Array:
    """(N, 3) error of the TCP that remains if the arm is in truth as `truth` says [m].

    Judged by the nonlinear equilibrium of the true arm at the corrected configurations, against
    where its tool is without process load in the wanted ones. NaN where there is no correction
    or no equilibrium.

    Args:
        arm: The true arm, which may have other springs than the model.
        truth: Its compliances.
        compensation: What was corrected, by whatever model.
        gain: By which share the loads of the task are larger than is said.

    Raises:
        InputError: arm and truth have different springs.
    """
    wanted = tcp_poses(arm, compensation.cases.q, _idle(arm, truth, compensation.cases.q))
    reached = np.full((len(compensation), 3), np.nan)
    there = np.isfinite(compensation.q).all(axis=1)
    wrench = (1.0 + gain) * compensation.cases.wrench[there]
    cases = LoadCases(compensation.q[there], wrench)
    rest = equilibrium(arm, truth.compliance, cases)
    reached[there] = tcp_poses(arm, cases.q, stable(rest))[:, :3, 3]
    return np.asarray(reached - wanted[:, :3, 3])


def _judged(
    arm: ElasticArm,
    model: ComplianceModel,
    cases: LoadCases,
    rule: str,
    q: Array,
    target: Array,
    found: Bent,
    errors: CaseErrors | None,
) -> Compensation:
    """The corrected configurations with everything that is said of them."""
    finite = np.where(np.isfinite(q), q, cases.q)
    rest = equilibrium(arm, model.compliance, LoadCases(finite, cases.wrench))
    reached = tcp_poses(arm, finite, stable(rest))
    after = reached[:, :3, 3] - target[:, :3, 3]
    good = np.asarray((np.isfinite(after) & np.isfinite(q).all(axis=1, keepdims=True)).all(axis=1))
    converged = good & found.at_rest
    if rule == "nonlinear":
        # Another equilibrium than the one looked for is no solution.
        there = np.linalg.norm(np.nan_to_num(after), axis=1) < SAME_PLACE
        converged &= there | found.damped
    q, after = q.copy(), after.copy()
    q[~converged], after[~converged] = np.nan, np.nan
    loaded = tcp_poses(arm, cases.q, stable(equilibrium(arm, model.compliance, cases)))
    rows = regressor(replace(arm, tool=arm.tool.at_tcp), cases)
    command = np.full_like(target, np.nan)
    rigid = replace(arm, springs=subset(arm.springs, ()))
    command[converged] = tcp_poses(rigid, q[converged], np.zeros((int(converged.sum()), 0)))
    return Compensation(
        arm=arm,
        model=model,
        cases=cases,
        rule=rule,
        q=frozen(q),
        target=frozen(target),
        command=frozen(command),
        before=frozen(loaded[:, :3, 3] - target[:, :3, 3]),
        after=frozen(after),
        covariance=frozen(rows @ model.at_task @ rows.transpose(0, 2, 1)),
        limit=limit_left(arm, model, cases),
        floor=frozen(_floor(arm, model, cases, errors)),
        converged=frozen(converged, np.bool_),
        iterations=frozen(found.iterations, np.int64),
        damped=frozen(found.damped, np.bool_),
        doubts=doubts(arm.robot, q, after, good, found.at_rest, found.damped, found.lost),
        notes=notes(arm, model.compliance, cases, task_rows(arm)),
    )


def _floor(
    arm: ElasticArm, model: ComplianceModel, cases: LoadCases, errors: CaseErrors | None
) -> Array:
    """(N,) what friction, discrepancy and repeatability leave of any correction [m]."""
    if errors is None:
        return np.zeros(len(cases))
    bent = replace(arm, tool=replace(arm.tool.at_tcp, rotation=False))
    shared = shared_covariance(errors, bent, model.compliance, cases)
    return np.sqrt(np.trace(shared, axis1=1, axis2=2) + 3.0 * errors.repeatability**2)


def _idle(arm: ElasticArm, model: ComplianceModel, q: Array) -> Array:
    """(N, p) displacements under the weight of the links alone."""
    if arm.springs.names != model.names:
        raise InputError(
            f"the arm has springs {', '.join(arm.springs.names) or 'nowhere'}, the model has "
            f"compliances of {', '.join(model.names) or 'nothing'}"
        )
    if not arm.sags:
        return np.zeros((len(q), len(arm.springs)))
    return stable(equilibrium(arm, model.compliance, LoadCases(q, np.zeros((len(q), 6)))))
