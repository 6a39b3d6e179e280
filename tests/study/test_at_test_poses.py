"""What a model says of the test poses, and how it is written and worded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.files.models.stiffness_section import pose_entries
from elastocal.study.at_test_poses import at_test_poses
from elastocal.study.study import TestPose
from elastocal.study.test_path import test_path
from elastocal.wording.stiffness import left_out, plus_minus, ranged
from tests.kr270 import kr270_study, kr270_truth


def model() -> ec.ComplianceModel:
    truth = kr270_truth(kr270_study())
    return replace(truth, covariance=np.diag((1e-2 * truth.compliance) ** 2))


def test_poses_and_paths_have_their_error_and_stiffness() -> None:
    study = kr270_study()
    (pose,) = study.test_poses
    assert pose.case is not None
    assert pose.tool is not None
    arm = replace(study.arm, tool=pose.tool)
    other = ec.LoadCases(
        np.vstack([pose.case.q, pose.case.q + 0.1]), np.tile(pose.case.wrench, (2, 1))
    )
    path = test_path(arm, other, 1.0, "path")
    given = TestPose("given", np.ones((3, 5)))
    both = replace(study, test_poses=(pose, given, path))
    one, along = at_test_poses(both, model(), 2.0)
    assert (one.name, one.tool, one.place) == ("milling", "milling", "")
    assert (along.name, along.place) == ("path", "point 1")
    np.testing.assert_array_equal(along.cartesian.matrix, one.cartesian.matrix)
    single = test_path(arm, ec.LoadCases(other.q[1:], other.wrench[1:]), 1.0, "end")
    (end,) = at_test_poses(replace(study, test_poses=(single,)), model(), 2.0)
    assert along.rho0**2 == pytest.approx(0.5 * (one.rho0**2 + end.rho0**2), rel=1e-12)


def test_a_document_has_units_in_its_keys() -> None:
    (entry,) = pose_entries(at_test_poses(kr270_study(), model(), 2.0))
    matrix = np.array(entry["compliance_matrix_SI"])
    assert entry["compliance_um_per_N"]["x"]["value"] == pytest.approx(1e6 * matrix[0, 0])
    assert entry["stiffness_N_per_um"]["x"]["value"] == pytest.approx(1e-6 / matrix[0, 0])
    held = np.array(entry["stiffness_matrix_SI"])
    np.testing.assert_allclose(held @ matrix, np.eye(6), atol=1e-8)
    assert entry["held_N_per_um"]["z"]["value"] == pytest.approx(1e-6 * held[2, 2])
    assert entry["held_Nm_per_rad"]["x"]["value"] == pytest.approx(held[3, 3])
    assert entry["directions"]["y"] == [0.0, 1.0, 0.0]
    assert entry["rho0_mm"] > 0.0


@pytest.mark.parametrize(
    ("interval", "text"),
    [
        ((2.0e-6, 1.9e-6, 2.1e-6), "2.000 (1.900 … 2.100)"),
        ((3.4167e-6, 3.4059e-6, 3.4275e-6), "3.4167 (3.4059 … 3.4275)"),
        ((0.0, 0.0, 0.0), "0"),
        ((np.inf, np.inf, np.inf), "∞"),
        ((1.0e-6, -1.0e-6, 3.0e-6), "1.000 (−1.000 … 3.000)"),
    ],
)
def test_values_are_worded_with_their_intervals(
    interval: tuple[float, float, float], text: str
) -> None:
    assert ranged(interval, 1e6) == text


def test_where_room_is_short_half_the_width_is_said() -> None:
    assert plus_minus((2.0e-6, 1.9e-6, 2.1e-6), 1e6) == "2.000 ± 0.10"
    assert plus_minus((np.inf, np.inf, np.inf), 1.0) == "∞"
    assert plus_minus((0.5, 0.4, np.inf), 1.0) == "0.5000 ± ∞"


def test_what_a_stiffness_lacks_is_said() -> None:
    assert left_out(0, ()) == []
    one, two = left_out(1, ("A1",))
    assert one == "A1 is taken as rigid by this model: the robot is softer than that"
    assert two.startswith("K_C is infinite: the springs of the model leave one of the six ways")
    assert "J1, J2 are taken as rigid" in left_out(0, ("J1", "J2"))[0]
