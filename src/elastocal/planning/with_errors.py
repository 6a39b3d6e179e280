"""Information with errors of load cases: what repeats share, and what all experiments share.

In: a study that knows nuisance. Out: information matrices on what is fitted and, behind it, on the
common errors of the loads, and what these move the tool at the test poses. What was read before has
the same errors: those common to all loads it shares, others where its load cases are near.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.elastic.absorbed import KnownErrors
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.case_errors import (
    LOAD_GAIN,
    common_columns,
    own_covariance,
    shared_covariance,
)
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.nuisance import Nuisance, usual_compliances
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.elastic.unknowns import Unknowns, joined, left_alone
from elastocal.planning.near import chained, near_load_cases, near_others
from elastocal.robot.posture import Posture
from elastocal.study.before import EarlierReadings
from elastocal.study.experiment_space import LoadCaseSpace
from elastocal.study.left_rigid import counted
from elastocal.study.study import Study, TestPose
from elastocal.study.test_path import TestPath

_UNIT = 1e-7  # size of compliances, so that information on common errors is as large as theirs
_AT_ONCE = 1_000_000  # pairs of load cases, of plans and of before


@dataclass(frozen=True)
class WithErrors:
    """Information on f unknowns that are fitted and e common errors, each of size `_UNIT`.

    Attributes:
        study: The study.
        nuisance: What it knows of nuisance.
    """

    study: Study
    nuisance: Nuisance

    @cached_property
    def common(self) -> int:
        """Number e of common errors."""
        errors = self.nuisance.errors
        return int(errors.common_gain > 0.0) + 3 * int(errors.common_tilt > 0.0)

    @cached_property
    def before(self) -> EarlierReadings | None:
        """What was read before; None for nothing."""
        carried_out, done = self.study.carried_out, self.study.done
        parts = [] if done is None or done.readings is None else [done.readings]
        if carried_out is not None:
            precision = precision_of(self.study, carried_out.cases)
            parts.insert(0, EarlierReadings(carried_out.cases, carried_out.repeats, precision))
        if not parts:
            return None
        return parts[0] if len(parts) == 1 else parts[0].followed_by(parts[1])

    @cached_property
    def beside(self) -> Array:
        """(f + e, f + e) what is known before, but for what was read."""
        study, f = self.study, len(self.study.fitted)
        known = np.eye(f + self.common) / _UNIT**2
        known[:f, :f] = study.prior
        if study.carried_out is not None:
            known[:f, :f] -= study.carried_out.information(study.space)
        if study.done is not None and study.done.readings is not None:
            known[:f, :f] -= study.done.information
        return known

    @cached_property
    def base(self) -> Array:
        """(f + e, f + e) what is known before, as long as nothing is measured near to it."""
        if self.before is None:
            return self.beside
        return np.asarray(self.beside + self._of(self.before, self._sharing_before).sum(axis=0))

    def total(self, cases: LoadCases, repeats: IntArray) -> Array:
        """(f + e, f + e) of S load cases, each measured `repeats` times, (S,), and all before.

        Source: ours; a plan in two parts is worth what it is in one.
        """
        told = self.informations(cases, repeats).sum(axis=0)
        return np.asarray(self.told_before(cases, repeats) + told)

    def told_before(self, cases: LoadCases, repeats: IntArray) -> Array:
        """(f + e, f + e) what is known before, beside S load cases, each measured (S,) `repeats`.

        What was read before tells less where it shares errors with these.
        """
        near = self.near_before(cases)[0]
        if self.before is None or not near.any():
            return self.base
        now = np.where(near, self.sharing(cases, repeats[None])[0][:, None], 0.0).max(axis=0)
        sharing = np.where(
            near.any(axis=0)[self._group_before], now[self._group_before], self._sharing_before
        )
        return np.asarray(self.beside + self._of(self.before, sharing).sum(axis=0))

    @cached_property
    def bending(self) -> VirtualJoints:
        """The springs that errors are shares of: joints and nuisance."""
        return merged(joint_springs(self.study.robot), self.nuisance.unknowns.springs)

    @cached_property
    def usual(self) -> Array:
        """(c,) their compliances, as expected before [rad/(N·m) or m/N]."""
        usual = usual_compliances(self.study.robot, self.nuisance)
        return np.array([usual[name] for name in self.bending.names])

    @cached_property
    def space(self) -> LoadCaseSpace:
        """The load cases to choose from, with rows in units of all that errs."""
        study, errors = self.study, self.nuisance.errors
        joints, fitted = joint_springs(study.robot), study.fitted
        more = [name for name in joints.names if name not in fitted.springs.names]
        makers = joined(fitted, left_alone(joint_springs(study.robot, more))) if more else fitted
        springs = makers.springs
        usual = dict(zip(self.bending.names, self.usual.tolist(), strict=True))
        compliance = np.array([usual.get(name, 0.0) for name in springs.names])
        if errors.common_gain > 0.0:
            gain = errors.common_gain / _UNIT * compliance[:, None]
            makers = Unknowns((*makers.names, LOAD_GAIN), springs, np.hstack([makers.make, gain]))
        known = KnownErrors(errors, compliance, springs.joint >= 0, _UNIT)
        arm = replace(study.fitted_arm, springs=springs)
        return replace(study.space, arm=arm, makers=makers, errors=known)

    def groups(self, cases: LoadCases, plans: int = 1) -> IntArray:
        """(plans, S) the first load case of the group that shares errors, of load cases of plans.

        `cases` are those of all the plans, one after the other. What was read before links none.
        """
        return near_load_cases(self.study.robot, *self._tables(cases, plans))

    def _tables(self, cases: LoadCases, plans: int) -> tuple[Array, Array, Array]:
        """Configurations, loads and information, of (plans, S)."""
        tables = cases.q, cases.wrench, self.space.information(cases)
        q, wrench, each = (table.reshape(plans, -1, *table.shape[1:]) for table in tables)
        return q, wrench, each

    @cached_property
    def _told_before(self) -> tuple[Array, Array, Array]:
        """Configurations, loads and information of what was read before."""
        assert self.before is not None
        q, wrench, each = self._tables(self.before.cases, 1)
        return q[0], wrench[0], each[0]

    @cached_property
    def _group_before(self) -> IntArray:
        """(E,) number of the group that shares errors, of load cases that were read before."""
        first = near_load_cases(self.study.robot, *self._told_before)
        return np.asarray(np.unique(first, return_inverse=True)[1])

    @cached_property
    def _sharing_before(self) -> Array:
        """(E,) readings that share the errors of each load case that was read before."""
        assert self.before is not None
        group = self._group_before
        return np.asarray(np.bincount(group, self.before.repeats)[group])

    def near_before(self, cases: LoadCases, plans: int = 1) -> BoolArray:
        """(plans, S, G) to which groups of what was read before load cases of plans are near.

        `cases` are those of all the plans, one after the other; G is 0 where nothing was read.
        """
        if self.before is None:
            return np.zeros((plans, len(cases) // plans, 0), dtype=bool)
        own = np.eye(int(self._group_before.max()) + 1)[self._group_before]
        q, wrench, each = self._tables(cases, plans)
        step = max(1, _AT_ONCE // (q.shape[1] * len(own)))
        parts = [slice(i, i + step) for i in range(0, plans, step)]
        robot, told = self.study.robot, self._told_before
        near = [near_others(robot, q[part], wrench[part], each[part], told) for part in parts]
        return np.asarray(np.concatenate(near) @ own > 0.0)

    def sharing(self, cases: LoadCases, repeats: IntArray) -> Array:
        """(plans, S) readings that share the errors of each load case, measured (plans, S) times.

        `cases` are those of all the plans, one after the other. What was read before is among them.
        """
        group, times = self.groups(cases, len(repeats)), repeats[:, :, None].astype(float)
        same = group[:, :, None] == group[:, None, :]
        if self.before is None:
            return np.asarray((same @ times)[..., 0])
        near = self.near_before(cases, len(repeats)).astype(float)
        group = chained(same | (near @ near.transpose(0, 2, 1) > 0.0))
        same = group[:, :, None] == group[:, None, :]
        known = np.bincount(self._group_before, self.before.repeats)
        return np.asarray((same @ times)[..., 0] + (same @ near > 0.0) @ known)

    def informations(self, cases: LoadCases, repeats: IntArray) -> Array:
        """(S, f + e, f + e) of S load cases, each measured `repeats` times, (S,).

        Of near load cases each reading counts as one of all theirs that share an error, those of
        before among them.
        """
        now = EarlierReadings(cases, repeats, precision_of(self.study, cases))
        return self._of(now, self.sharing(cases, repeats[None])[0])

    def _of(self, read: EarlierReadings, sharing: Array) -> Array:
        """(E, f + e, f + e) what readings tell, (E,) `sharing` of which have errors together.

        Source: ours; n Aᵀ (V + N S_shared + S_own)⁻¹ A with N readings that share, common errors as
        further unknowns; in the coordinates W that were read, Wᵀ W = V⁻¹.
        """
        study, errors, cases = self.study, self.nuisance.errors, read.cases
        bending, usual = replace(study.fitted_arm, springs=self.bending), self.usual
        rows = study.fitted.columns(regressor(study.fitted_arm, cases))
        _, common = common_columns(errors, bending, usual, cases)
        rows = np.concatenate([rows, common / _UNIT], axis=2)
        besides = own_covariance(errors, bending, usual, cases)
        besides += sharing[:, None, None] * shared_covariance(errors, bending, usual, cases)
        size, axes = np.linalg.eigh(read.precision)
        white = (np.sqrt(np.maximum(size, 0.0))[:, None] * axes).transpose(0, 2, 1)
        noise = np.eye(rows.shape[1]) + white @ besides @ white.transpose(0, 2, 1)
        over = np.linalg.solve(np.linalg.cholesky(noise), white @ rows)
        told = over.transpose(0, 2, 1) @ over
        return np.asarray(read.repeats.astype(float)[:, None, None] * told)

    def blocks(self, pose: TestPose | TestPath) -> Array:
        """(N, r, f + e) how all of it moves the tool of a test pose.

        With the cell of the campaign the process force is as wrong as the loads were: by as much as
        the compliances are too small. Nothing of the direction of the loads is in the task.
        """
        moved = np.zeros((*pose.regressors.shape[:2], self.common))
        errors = self.nuisance.errors
        if errors.common_gain > 0.0 and errors.process_force == "same":
            moved[:, :, 0] = errors.common_gain / _UNIT * self.compensated(pose)
        return np.concatenate([pose.regressors, moved], axis=2)

    @cached_property
    def form(self) -> Array:
        """(f + e, f + e) F so that xᵀ F x is the mean square over the test poses, by their weights.

        Of a path it is the mean of its points.
        """
        size = len(self.base)
        squares = np.zeros((size, size))
        for share, pose in zip(self.study.shares, self.study.test_poses, strict=True):
            blocks = self.blocks(pose)
            squares += share / len(blocks) * np.einsum("nri,nrj->ij", blocks, blocks)
        return squares

    def other_cell(self, pose: TestPose | TestPath) -> float:
        """Mean square that another cell for the process force adds [m²]; as good as the first."""
        errors = self.nuisance.errors
        if errors.process_force != "other":
            return 0.0
        moved = errors.common_gain * self.compensated(pose)
        return float((moved**2).sum(axis=1).mean())

    def compensated(self, pose: TestPose | TestPath) -> Array:
        """(N, r) deflection at a test pose by all that the study takes into account."""
        if pose.cases is None or pose.tool is None:
            return np.zeros(pose.regressors.shape[:2])
        study = self.study
        seen = (*counted(study), *self.nuisance.unknowns.springs.names)
        there = [float(name in seen) for name in self.bending.names]
        arm = ElasticArm(study.robot, self.bending, pose.tool.at_tcp, study.gravity)
        return np.asarray(regressor(arm, pose.cases) @ (self.usual * there))


def precision_of(study: Study, cases: LoadCases) -> Array:
    """(N, m, m) inverse of `noise_of`."""
    return np.asarray(np.linalg.inv(noise_of(study, cases)), dtype=float)


def noise_of(study: Study, cases: LoadCases) -> Array:
    """(N, m, m) covariance of what the instrument reads of each load case."""
    posture, tool = Posture(study.robot, cases.q), study.experiments.tool
    points = np.stack([posture.point(marker).T for marker in tool.markers], axis=1)
    return study.instrument.pose_covariance(points)
