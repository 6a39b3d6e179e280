"""Turns of a probe and of an arm, in frames that nobody knows."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from elastocal.measuring.turn_misfit import turn_misfit


def test_unknown_frames_do_not_matter_and_other_turns_do() -> None:
    flange, base, probe = (Rotation.random(n, random_state=n).as_matrix() for n in (30, 1, 2))
    turned = base[0] @ flange @ probe[0]
    assert turn_misfit(flange, turned) < 1e-12
    noise = Rotation.from_rotvec(1e-3 * np.random.default_rng(0).normal(size=(30, 3)))
    found = turn_misfit(flange, turned @ noise.as_matrix())
    assert 1e-3 < found < 4e-3  # of three components of two readings, about 2.4 mrad
    assert turn_misfit(flange, turned.transpose(0, 2, 1)) > 0.5
    assert np.isnan(turn_misfit(flange[:3], turned[:3]))
