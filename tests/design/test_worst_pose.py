"""The worst of very many poses: as the minimum over all, and by the few that decide."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.design.continuous import continuous_design
from elastocal.design.criterion import InformationFunction
from elastocal.design.exact import Effort, exact_design
from elastocal.design.power_mean import PowerMean, floored
from elastocal.design.refinement import Goal
from elastocal.design.test_pose import TestPosePrecision
from elastocal.design.worst_pose import SoftWorstPose, WorstPose
from tests.design.examples import information_matrix
from tests.design.polynomial import polynomial
from tests.design.worst import Worst


def curve(count: int) -> np.ndarray:
    """(K, 1, 3) rows along a curve, as of a path."""
    t = np.linspace(0.0, 2.0 * np.pi, count)
    return np.stack([np.cos(t), np.sin(2.0 * t), 1.0 + 0.5 * np.cos(3.0 * t)], axis=1)[:, None]


def matrices(count: int, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.array([information_matrix(rng) for _ in range(count)])


def test_it_is_the_minimum_over_single_poses() -> None:
    """Values and gradients, kinked and smooth, against the general minimum, pose by pose."""
    blocks = np.random.default_rng(1).normal(size=(9, 2, 3))
    members = [TestPosePrecision(block.T @ block) for block in blocks]
    batch = matrices(7)
    for found, expected in (
        (WorstPose(blocks), Worst(members)),
        (WorstPose(blocks).smooth, PowerMean(members)),
    ):
        assert found.value(batch) == pytest.approx(expected.value(batch), rel=1e-12)
        slopes = expected.gradient(batch)
        assert np.allclose(found.gradient(batch), slopes, rtol=1e-9, atol=1e-9 * slopes.max())
        values, gradients = found.both(batch)
        assert values == pytest.approx(found.value(batch), rel=1e-14)
        assert np.array_equal(gradients, found.gradient(batch))


def test_few_poses_are_all_kept() -> None:
    few = WorstPose(curve(12))
    assert few.near(matrices(3)) is few


def test_near_is_nowhere_smaller_and_equal_where_asked() -> None:
    whole, asked, elsewhere = WorstPose(curve(500)), matrices(4), matrices(50, 1)
    some = whole.near(asked)
    assert some.chosen is not None
    assert 1 <= len(some.chosen) <= 4
    assert some.value(asked) == pytest.approx(whole.value(asked), rel=1e-7)
    assert (some.value(elsewhere) >= whole.value(elsewhere) * (1.0 - 1e-12)).all()
    assert (some.value(elsewhere) > whole.value(elsewhere) * 1.001).any()  # some are left out
    assert some.near(asked) is some
    more = some.near(elsewhere)
    assert more.chosen is not None
    assert set(some.chosen) < set(more.chosen)
    assert more.value(elsewhere) == pytest.approx(whole.value(elsewhere), rel=1e-7)


def test_near_of_parts_is_near_of_the_whole() -> None:
    whole, asked = WorstPose(curve(300)), matrices(5)
    scale = np.eye(3)
    for criterion in (whole.smooth, floored(whole, scale, 0.1)):
        some = criterion.near(asked)
        assert some is not criterion
        assert some.near(asked) is some
        kept = some if isinstance(some, SoftWorstPose) else some.members[0]  # type: ignore[attr-defined]
        assert isinstance(kept, SoftWorstPose)
        assert np.array_equal(kept.chosen, whole.near(asked).chosen)  # type: ignore[arg-type]


def test_no_poses_are_refused() -> None:
    with pytest.raises(ValueError, match="worst of no criteria"):
        WorstPose(np.zeros((0, 3, 2)))


def along_an_interval(count: int) -> WorstPose:
    """Variance of a fitted parabola at many places between -1 and 1."""
    t = np.linspace(-1.0, 1.0, count)
    return WorstPose(np.stack([np.ones(count), t, t**2], axis=1)[:, None])


def test_the_worst_along_an_interval_is_the_optimum_of_d() -> None:
    """Kiefer & Wolfowitz: for G over the design interval the D-optimum is best, with φ = 1/3 and
    a third of the weight at each of -1, 0 and 1. A thousand places, of which few are taken up."""
    criterion = along_an_interval(1001)
    found = continuous_design(polynomial(2), criterion, np.random.default_rng(0))
    assert float(criterion.value(found.total[None])[0]) == pytest.approx(1.0 / 3.0, rel=2e-3)
    assert found.certificate.upper >= 1.0 / 3.0 * (1.0 - 1e-9)
    assert found.certificate.upper == pytest.approx(1.0 / 3.0, rel=5e-3)
    some = criterion.near(found.total[None])
    assert some.chosen is not None
    assert len(some.chosen) < 50


def test_an_exact_design_is_valued_by_all_of_them() -> None:
    """Three experiments for a parabola: one at each of -1, 0 and 1."""
    criterion: InformationFunction = along_an_interval(1001)
    space, rng = polynomial(2), np.random.default_rng(0)
    continuous = continuous_design(space, criterion, rng)
    found = exact_design(
        Goal(space, criterion, np.zeros((3, 3))),
        3,
        3,
        rng,
        continuous=continuous,
        effort=Effort(batch=12, generations=3, patience=1, islands=1),
    )
    assert np.sort(found.x[:, 0]) == pytest.approx([-1.0, 0.0, 1.0], abs=2e-3)
    assert found.value == pytest.approx(1.0, rel=2e-3)
    totals, _ = Goal(space, criterion, np.zeros((3, 3))).totals(found.x[None], found.counts[None])
    assert found.value == pytest.approx(float(criterion.value(totals)[0]), rel=1e-12)


def test_taking_up_few_proves_as_much_as_taking_all() -> None:
    """200 rows along a curve: the bound is not above that of all at once, which is smoothed more,
    and no design refutes it. Negative control: the first few taken up alone bound nothing tight."""
    space, blocks = polynomial(2), curve(200)
    few, rng = WorstPose(blocks), np.random.default_rng(3)
    every = Worst([TestPosePrecision(block.T @ block) for block in blocks])
    reduced = continuous_design(space, few, np.random.default_rng(0))
    whole = continuous_design(space, every, np.random.default_rng(0))
    assert reduced.certificate.upper <= whole.certificate.upper * (1.0 + 1e-6)
    assert float(few.value(reduced.total[None])[0]) <= reduced.certificate.upper
    assert reduced.gap < 3e-3
    x = rng.uniform(-1.0, 1.0, (20_000, 4, 1)) ** 3
    rows = np.concatenate([np.ones_like(x), x, x**2], axis=2)
    designs = np.einsum("bs,bsi,bsj->bij", rng.dirichlet(np.ones(4), 20_000), rows, rows)
    best = max(float(few.value(part).max()) for part in np.array_split(designs, 10))
    assert 0.75 * reduced.certificate.upper < best <= reduced.certificate.upper
    alone = continuous_design(space, WorstPose(blocks[:3]), np.random.default_rng(0))
    assert alone.certificate.upper > 1.05 * reduced.certificate.upper


def test_an_exact_design_is_refined_by_what_decides() -> None:
    """Whatever the seed: the mean of order -300 over all that was taken up stops short of it."""
    criterion, space = WorstPose(curve(400)), polynomial(2)
    found = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        continuous = continuous_design(space, criterion, rng)
        goal = Goal(space, criterion, np.zeros((3, 3)))
        effort = Effort(batch=12, generations=3, patience=1, islands=1)
        found.append(exact_design(goal, 5, 4, rng, continuous=continuous, effort=effort).value)
    assert max(found) / min(found) - 1.0 < 2e-4
