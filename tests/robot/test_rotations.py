"""Rotations in every form, against SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from elastocal.arrays import Array
from elastocal.robot.rotations import (
    frame_about,
    from_quaternions,
    from_rotation_vectors,
    from_zyx_angles,
    quaternions,
    rotation_vectors,
    zyx_angles,
)

PAIRS = {
    "quaternion": (quaternions, from_quaternions),
    "vector": (rotation_vectors, from_rotation_vectors),
    "zyx": (zyx_angles, from_zyx_angles),
}


def awkward() -> Array:
    """Turns by nothing, almost nothing, half a turn, and with the y axis upright."""
    vectors = [[0, 0, 0], [1e-12, 0, 0], [0, 1e-8, 1e-9], [np.pi, 0, 0], [0, np.pi, 0]]
    vectors += [[0, 0, np.pi], [0, np.pi / 2, 0], [0, -np.pi / 2, 0], [2.0, -2.0, 1.0]]
    return Rotation.from_rotvec(vectors).as_matrix()


@pytest.mark.parametrize("form", PAIRS)
def test_there_and_back(form: str) -> None:
    out, back = PAIRS[form]
    random = Rotation.random(200, random_state=3).as_matrix()
    for matrices in (random, awkward()):
        np.testing.assert_allclose(back(out(matrices)), matrices, atol=3e-15)


def test_the_forms_mean_what_scipy_means() -> None:
    turns = Rotation.random(100, random_state=4)
    matrices = turns.as_matrix()
    np.testing.assert_allclose(rotation_vectors(matrices), turns.as_rotvec(), atol=1e-14)
    np.testing.assert_allclose(zyx_angles(matrices), turns.as_euler("ZYX"), atol=1e-12)
    xyzw = turns.as_quat(canonical=True)
    np.testing.assert_allclose(quaternions(matrices), np.roll(xyzw, 1, axis=1), atol=1e-14)


@given(st.lists(st.floats(-1e-3, 1e-3), min_size=3, max_size=3))
def test_small_turns_keep_their_digits(values: list[float]) -> None:
    vector = np.array([values])
    found = rotation_vectors(from_rotation_vectors(vector))
    np.testing.assert_allclose(found, vector, rtol=1e-10, atol=1e-15)


@pytest.mark.parametrize("axis", [*np.eye(3), *-np.eye(3), [0.6, 0.0, 0.8], [-0.48, 0.6, 0.64]])
def test_a_frame_about_an_axis_turns_z_to_it(axis: list[float]) -> None:
    frame = frame_about(np.array(axis))
    np.testing.assert_array_equal(frame[:, 2], axis)
    np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-15)
    assert np.linalg.det(frame) == pytest.approx(1.0, abs=1e-15)
