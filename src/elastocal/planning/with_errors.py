"""Information with errors of load cases: what repeats share, and what all experiments share.

In: a study that knows nuisance. Out: information matrices on what is fitted and, behind it, on the
common errors of the loads, and what these move the tool at the test poses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, IntArray
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
from elastocal.planning.near import near_load_cases
from elastocal.robot.posture import Posture
from elastocal.study.experiment_space import LoadCaseSpace
from elastocal.study.left_rigid import counted
from elastocal.study.study import Study, TestPose
from elastocal.study.test_path import TestPath

_UNIT = 1e-7  # size of compliances, so that information on common errors is as large as theirs


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
    def base(self) -> Array:
        """(f + e, f + e) what is known before."""
        f = len(self.study.fitted)
        known = np.eye(f + self.common) / _UNIT**2
        known[:f, :f] = self.study.prior
        return known

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

        `cases` are those of all the plans, one after the other.
        """
        informations = self.space.information(cases)
        q, wrench, each = (
            table.reshape(plans, -1, *table.shape[1:])
            for table in (cases.q, cases.wrench, informations)
        )
        return near_load_cases(self.study.robot, q, wrench, each)

    def sharing(self, cases: LoadCases, repeats: IntArray) -> Array:
        """(plans, S) readings that share the errors of each load case, measured (plans, S) times.

        `cases` are those of all the plans, one after the other.
        """
        group = self.groups(cases, len(repeats))
        same = group[:, :, None] == group[:, None, :]
        return np.asarray((same * repeats[:, None, :].astype(float)).sum(axis=2))

    def informations(self, cases: LoadCases, repeats: IntArray) -> Array:
        """(S, f + e, f + e) of S load cases, each measured `repeats` times, (S,).

        Of near load cases each reading counts as one of all theirs that share an error.

        Source: ours; n Aᵀ (V + N S_shared + S_own)⁻¹ A with N readings that share, common errors as
        further unknowns.
        """
        study, errors = self.study, self.nuisance.errors
        arm, count = study.fitted_arm, repeats.astype(float)[:, None, None]
        bending, usual = replace(arm, springs=self.bending), self.usual
        rows = study.fitted.columns(regressor(arm, cases))
        sharing = self.sharing(cases, repeats[None])[0][:, None, None]
        noise = noise_of(study, cases) + own_covariance(errors, bending, usual, cases)
        noise = (noise + sharing * shared_covariance(errors, bending, usual, cases)) / count
        _, common = common_columns(errors, bending, usual, cases)
        rows = np.concatenate([rows, common / _UNIT], axis=2)
        white = np.linalg.solve(np.linalg.cholesky(noise), rows)
        return np.asarray(white.transpose(0, 2, 1) @ white)

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


def noise_of(study: Study, cases: LoadCases) -> Array:
    """(N, m, m) covariance of what the instrument reads of each load case."""
    posture, tool = Posture(study.robot, cases.q), study.experiments.tool
    points = np.stack([posture.point(marker).T for marker in tool.markers], axis=1)
    return study.instrument.pose_covariance(points)
