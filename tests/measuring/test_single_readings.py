"""Noise of single readings, in the frame of the station."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.errors import InputError
from elastocal.measuring.common_errors import CommonErrors
from elastocal.measuring.instrument import PRESETS, Isotropic, PoseProbe
from elastocal.measuring.single_readings import reading_covariance, turn_covariance


def test_a_stated_deviation_is_that_of_a_reading() -> None:
    points = np.ones((2, 3))
    np.testing.assert_allclose(reading_covariance(Isotropic(2e-5), points), [4e-10 * np.eye(3)] * 2)
    both = CommonErrors(Isotropic(2e-5), translation=1e-5)
    np.testing.assert_allclose(reading_covariance(both, points)[0], 5e-10 * np.eye(3))


def test_a_tracker_is_where_its_frame_begins() -> None:
    """Along the beam by the range alone, wherever the study says that it stands."""
    tracker = PRESETS["leica-at500"].at(np.array([9.0, 9.0, 9.0]))
    found = reading_covariance(PoseProbe(tracker, 1e-4), np.array([[0.0, 4.0, 0.0]]))
    along, across = 5e-6 + 0.15e-6 * 4, 7.5e-6 + 3e-6 * 4
    np.testing.assert_allclose(found[0], np.diag([across**2, along**2, across**2]), rtol=1e-12)


def test_orientations_need_their_noise() -> None:
    probe = PoseProbe(Isotropic(2e-5), 1e-4)
    np.testing.assert_allclose(turn_covariance(probe), 1e-8 * np.eye(3))
    with pytest.raises(InputError, match="says nothing of orientations"):
        turn_covariance(Isotropic(2e-5))
