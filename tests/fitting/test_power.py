"""How probably a test sees what a model lacks, against an independent library."""

from __future__ import annotations

import math

import pytest
from scipy.special import chdtri, chndtr, fdtri, ncfdtr

from elastocal.fitting.power import critical_chi_square, power, seen_half


@pytest.mark.parametrize(("dof", "size"), [(4, 6.0), (31, 20.0), (1, 0.5), (100, 250.0), (6, 0.0)])
def test_known_noise(dof: int, size: float) -> None:
    critical = chdtri(dof, 0.05)
    assert critical_chi_square(dof) == pytest.approx(critical, rel=1e-10)
    assert power(size, dof) == pytest.approx(1.0 - chndtr(critical, dof, size), abs=1e-9)


@pytest.mark.parametrize(("dof", "other", "size"), [(4, 27, 6.0), (1, 3, 10.0), (9, 9.5, 4.0)])
def test_noise_found_from_repeats(dof: int, other: float, size: float) -> None:
    critical = fdtri(dof, other, 0.95)
    assert power(size, dof, other) == pytest.approx(1.0 - ncfdtr(dof, other, size, critical))


def test_seen_half_of_the_time() -> None:
    assert seen_half(4) == pytest.approx(6.42, abs=5e-3)
    assert seen_half(31) == pytest.approx(14.82, abs=5e-3)
    assert seen_half(4, 27) == pytest.approx(7.62, abs=5e-3)
    assert power(seen_half(12), 12) == pytest.approx(0.5, abs=1e-9)


def test_without_freedom_nothing_is_seen() -> None:
    assert seen_half(0) == math.inf
    assert seen_half(4, 0.0) == math.inf
    assert power(100.0, 0) == pytest.approx(0.05)
    assert power(1e6, 4) == 1.0
