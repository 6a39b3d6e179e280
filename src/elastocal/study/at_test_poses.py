"""What a model is worth at the test poses of a study: the error it leaves, and the stiffness there.

In: study, compliance model. Out: one value for each test pose that is a load case, or a path.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.cartesian import (
    CartesianCompliance,
    cartesian_compliance,
    error_left,
    limit_left,
)
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.study.study import Study
from elastocal.study.test_path import TestPath


@dataclass(frozen=True)
class AtTestPose:
    """A test pose, by a model.

    Attributes:
        name: Name of the test pose.
        tool: Name of its tool.
        rho0: Root mean square error that the uncertainty of the model leaves there after
            compensation [m]; over the points of a path.
        limit: What that error stays below with 95 % [m].
        cartesian: Compliance and stiffness at its TCP; of a path at its first point.
        place: That point, empty if it is the test pose itself.
    """

    name: str
    tool: str
    rho0: float
    limit: float
    cartesian: CartesianCompliance
    place: str = ""


def at_test_poses(study: Study, model: ComplianceModel, width: float) -> tuple[AtTestPose, ...]:
    """What a model says of the test poses; `width` of its intervals is in standard errors.

    Test poses that are given as a matrix are left out.
    """
    found = []
    for pose in study.test_poses:
        if pose.cases is None or pose.case is None or pose.tool is None:
            continue
        arm = ElasticArm(study.robot, model.springs, pose.tool, study.gravity)
        left = error_left(arm, model, pose.cases)
        limit = limit_left(arm, model, pose.cases)
        (stiff,) = cartesian_compliance(arm, model, pose.case.q, width)
        place = f"point {pose.points[0]}" if isinstance(pose, TestPath) else ""
        rms = float(np.sqrt(np.mean(left**2)))
        found.append(AtTestPose(pose.name, pose.tool.name, rms, limit, stiff, place))
    return tuple(found)
