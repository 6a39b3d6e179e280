"""Robust losses: thresholds recomputed, weights with their derivatives."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import chi

from elastocal.fitting.robust import LOSSES, Bisquare, Huber, inflation, robust_scale
from elastocal.identification.choices import LossName

DENSITY = chi(3).pdf


@pytest.mark.parametrize("loss", [Huber(), Bisquare()])
def test_the_threshold_keeps_95_percent_of_the_efficiency(loss: Huber | Bisquare) -> None:
    """Efficiency of an M-estimate for normal noise in three dimensions, by quadrature."""

    def mean(function) -> float:  # type: ignore[no-untyped-def]
        cut = loss.threshold
        return sum(
            quad(lambda r: function(np.array([r]))[0] * DENSITY(r), a, b, limit=200)[0]
            for a, b in ((0.0, cut), (cut, 30.0))
        )

    bend = mean(lambda r: loss.weight(r) + loss.slope(r) * r / 3.0)
    spread = mean(lambda r: (loss.weight(r) * r) ** 2) / 3.0
    assert bend**2 / spread == pytest.approx(0.95, abs=1e-4)


def test_every_choice_of_a_fit_has_its_loss() -> None:
    assert tuple(LOSSES) == get_args(LossName)


@pytest.mark.parametrize("name", LOSSES)
def test_slopes_are_derivatives(name: str) -> None:
    loss = LOSSES[name]
    size = np.linspace(0.05, 7.0, 200)
    size = size[np.abs(size - getattr(loss, "threshold", 0.0)) > 0.05]
    h = 1e-6
    difference = (loss.weight(size + h) - loss.weight(size - h)) / (2.0 * h)
    np.testing.assert_allclose(loss.slope(size), difference, atol=1e-8)
    assert (loss.weight(size) <= 1.0).all()
    assert loss.weight(np.zeros(1))[0] == 1.0


def test_scale_and_inflation_of_sound_readings() -> None:
    size = 2.5 * np.sqrt(np.random.default_rng(0).chisquare(3, 200_000))
    assert robust_scale(size, 3 * len(size)) == pytest.approx(2.5, rel=0.01)
    plain = inflation(LOSSES["squares"], size, 2.5, 3 * len(size))
    assert plain == pytest.approx(2.5**2, rel=0.01)
    huber = inflation(LOSSES["huber"], size, 2.5, 3 * len(size))
    assert huber == pytest.approx(2.5**2 / 0.95, rel=0.01)
