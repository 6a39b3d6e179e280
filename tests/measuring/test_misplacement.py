"""What explains misplaced readings, against plainer routes."""

from __future__ import annotations

import numpy as np

from elastocal.measuring.best_fit import best_fits
from elastocal.measuring.misreadings import two_frames
from elastocal.measuring.placement import Unloaded, left_over, place, residuals
from elastocal.robot.posture import forward_kinematics
from elastocal.robot.sources import load


def testtwo_frames_from_sums_are_those_of_two_fits() -> None:
    rng = np.random.default_rng(0)
    when = np.repeat(np.arange(10), 3)
    points, nominal = rng.normal(size=(2, 30, 3)) + np.array([100.0, -50.0, 3.0])
    nominal[:15] *= -1.0  # some fits would be reflections
    splits = np.arange(4, 7)
    found = two_frames(points, nominal, when, splits)
    for i, split in enumerate(splits):
        total = 0.0
        for side in (when < split, when >= split):
            total += best_fits(points[side], nominal[None, side])[2][0] ** 2 * side.sum()
        np.testing.assert_allclose(found[i], np.sqrt(total / 30), rtol=1e-9)


def test_where_markers_should_be() -> None:
    """One by one, from the frames of the flange."""
    robot, rng = load("kuka-kr270"), np.random.default_rng(1)
    q, markers = rng.uniform(-1, 1, (5, 6)), rng.normal(size=(2, 3))
    case, marker = np.repeat(np.arange(5), 2), np.tile([0, 1], 5)
    flange = forward_kinematics(robot, q)
    wanted = np.array(
        [
            flange[i, :3, :3] @ markers[k] + flange[i, :3, 3]
            for i, k in zip(case, marker, strict=True)
        ]
    )
    read = wanted + 1e-3 * rng.normal(size=wanted.shape)
    some = Unloaded(robot, markers, q, case, marker, read, np.zeros(10))
    np.testing.assert_allclose(some.nominal(np.array([q, 2 * q]))[0], wanted, atol=1e-12)
    found = place(some)
    open_ = residuals(some, wanted)
    np.testing.assert_allclose(open_, wanted - found.fits[0].applied(read), atol=1e-12)
    np.testing.assert_allclose(left_over(some, wanted[None])[0], found.rms)
    np.testing.assert_allclose(found.apart, np.sqrt(np.mean(np.sum((read - wanted) ** 2, axis=1))))
