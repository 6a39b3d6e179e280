"""What identified compliances leave at a test pose: the distance between target and tool.

In: test pose, truth, many estimates. Out: (C,) errors after compensation, judged on the true arm.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.deflections import deflection_and_gradient, loaded_deflection
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.neighbourhood import Series, deflection_series
from elastocal.study.study import TestPose
from elastocal.study.test_path import TestPath, mean_rows


@dataclass(frozen=True)
class Judge:
    """A test pose with the truth.

    Attributes:
        truth: (c,) true compliances of all springs [rad/(N·m) or m/N].
        free: (p,) which of them are fitted.
        regressor: (r, p) A0; of a path the rows of the loaded deflection, see `mean_rows`.
        arm: The true arm with the tool of the test pose, its TCP the only marker; None: the
            regressor judges.
        case: The load case of the test pose.
        near: Series of its deflection about the truth, where there is one.
    """

    truth: Array
    free: IntArray
    regressor: Array
    arm: ElasticArm | None = None
    case: LoadCases | None = None
    near: Series | None = None


def judge(
    arm: ElasticArm, truth: ComplianceModel, pose: TestPose | TestPath, *, linear: bool
) -> Judge:
    """The judge of a test pose; by its regressor where it has no load case, or if `linear`.

    That of a path has the root mean square over its points. To take all of them, it goes by the
    derivative of the loaded deflection at the truth.
    """
    free = np.array([truth.names.index(name) for name in arm.springs.names])
    if linear or pose.case is None or pose.tool is None:
        return Judge(truth.compliance, free, pose.regressor)
    true = replace(arm, springs=truth.springs, tool=pose.tool.at_tcp)
    if isinstance(pose, TestPose):
        near = deflection_series(true, truth.compliance, pose.case, free)
        return Judge(truth.compliance, free, pose.regressor, true, pose.case, near)
    _, slopes = deflection_and_gradient(true, truth.compliance, pose.cases)
    return Judge(truth.compliance, free, mean_rows(slopes[:, :, free]))


def errors_left(judge: Judge, estimates: Array) -> Array:
    """(C,) errors after compensation with each of the estimates (C, p) [m].

    Compensation moves the target by the modelled deflection; what is left is the deflection of the
    true arm less that of the modelled one. Both are taken at the test pose: the compensated
    configuration lies beside it by the deflection, which changes the error by less than one
    percent of itself.

    Source: paper eqs. (15), (16).
    """
    if judge.arm is None or judge.case is None:
        off = (estimates - judge.truth[judge.free]) @ judge.regressor.T
        return np.linalg.norm(off, axis=1)
    error, exact = np.zeros(len(estimates)), np.zeros(len(estimates), dtype=bool)
    if judge.near is not None:
        bent, exact = judge.near.at(estimates - judge.truth[judge.free])
        error = np.linalg.norm(bent - judge.near.value, axis=1)
    if not exact.all():
        each = np.tile(judge.truth, (int(np.count_nonzero(~exact)) + 1, 1))
        each[1:, judge.free] = estimates[~exact]
        q, wrench = (np.tile(part, (len(each), 1)) for part in (judge.case.q, judge.case.wrench))
        bent = loaded_deflection(judge.arm, each, LoadCases(q, wrench))
        error[~exact] = np.linalg.norm(bent[1:] - bent[0], axis=1)
    return error
