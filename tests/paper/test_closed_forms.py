"""Section 5 on paper: eqs. (23) to (37), repaired, against the program; as printed they fail.

The reduced equations (33) to (37) are those of examples/09_closed_form.py; the others stand here.
"""

from __future__ import annotations

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import elastocal as ec
from elastocal.arrays import Array
from elastocal.robot.posture import forward_kinematics, jacobian
from elastocal.robot.sources.three_link import LENGTHS
from tests.paper.problems import three_link_study
from tests.paper.published import FORCE_IN_TABLE_2, FORCE_IN_TEXT, TABLE_2, TEST_CONFIGURATION

L1, L2, L3 = LENGTHS
ROUNDING = 1e-12


def example() -> ModuleType:
    path = Path(__file__).parents[2] / "examples" / "09_closed_form.py"
    spec = spec_from_file_location("closed_form", path)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


PAPER = example()


def cases(count: int) -> tuple[Array, Array]:
    """Configurations and forces."""
    rng = np.random.default_rng(0)
    return rng.uniform(-np.pi, np.pi, (count, 3)), rng.normal(size=(count, 3))


def planar(count: int, seed: int = 0) -> tuple[Array, ec.LoadCases]:
    """x = (q2, q3, α), and the load cases with q1 = 0 and the force of eq. (30)."""
    x = np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, 3))
    return x, load_cases(x)


def load_cases(x: Array) -> ec.LoadCases:
    q2, q3, alpha = x.T
    zero = np.zeros(len(x))
    wrench = np.stack([zero, np.cos(alpha), np.sin(alpha), zero, zero, zero], axis=1)
    return ec.LoadCases(np.stack([zero, q2, q3], axis=1), wrench)


def reach_and_rise(q: Array) -> tuple[Array, Array]:
    """l_C and l_S of eq. (25)."""
    q23 = q[:, 1] + q[:, 2]
    return L2 * np.cos(q[:, 1]) + L3 * np.cos(q23), L2 * np.sin(q[:, 1]) + L3 * np.sin(q23)


def rows(entries: list[list[Array]]) -> Array:
    """(N, 3, 3) matrices of entries (N,)."""
    return np.stack([np.stack(row, axis=-1) for row in entries], axis=-2)


def test_eq_23_kinematics() -> None:
    q, _ = cases(100)
    reach, rise = reach_and_rise(q)
    position = np.stack([reach * np.cos(q[:, 0]), reach * np.sin(q[:, 0]), L1 + rise], axis=1)
    found = forward_kinematics(ec.load_robot("three-link"), q)[:, :3, 3]
    np.testing.assert_allclose(found, position, atol=ROUNDING)


def jacobian_24(q: Array, *, printed: bool = False) -> Array:
    reach, rise = reach_and_rise(q)
    q23 = q[:, 1] + q[:, 2]
    s1, c1, s23, c23 = np.sin(q[:, 0]), np.cos(q[:, 0]), np.sin(q23), np.cos(q23)
    one, two = (-rise * s1, -reach * s1) if printed else (-reach * s1, -rise * s1)
    return rows(
        [
            [one, -rise * c1, -L3 * s23 * c1],
            [reach * c1, two, -L3 * s23 * s1],
            [0.0 * s1, reach, L3 * c23],
        ]
    )


def test_eq_24_jacobian() -> None:
    q, _ = cases(100)
    found = jacobian(ec.load_robot("three-link"), q, np.zeros(3))[:, :3]
    np.testing.assert_allclose(found, jacobian_24(q), atol=ROUNDING)
    off = np.abs(found - jacobian_24(q, printed=True)).max(axis=(1, 2))
    assert np.median(off) > 0.1  # as printed


def test_eq_27_28_columns_of_a_test_pose() -> None:
    q, force = cases(100)
    reach, rise = reach_and_rise(q)
    q23 = q[:, 1] + q[:, 2]
    s1, c1, s23, c23 = np.sin(q[:, 0]), np.cos(q[:, 0]), np.sin(q23), np.cos(q23)
    x, y, z = force.T
    zero = 0.0 * s1
    first = reach**2 * (x * s1 - y * c1) * np.stack([s1, -c1, zero])
    second = (x * rise * c1 + y * rise * s1 - z * reach) * np.stack([rise * c1, rise * s1, -reach])
    third = L3 * (x * L3 * s23 * c1 + y * L3 * s23 * s1 - z * L3 * c23)
    third = third * np.stack([s23 * c1, s23 * s1, -c23])
    expected = np.stack([first, second, third], axis=1).transpose(2, 0, 1)
    study = three_link_study(1)
    found = ec.regressor(study.arm, ec.LoadCases(q, np.hstack([force, 0.0 * force])))
    np.testing.assert_allclose(found, expected, atol=ROUNDING)


def test_eq_29_to_31_regressor_with_q1_and_fx_zero() -> None:
    x, at = planar(100)
    reach, rise = reach_and_rise(at.q)
    q23 = x[:, 0] + x[:, 1]
    sine, cosine, zero = np.sin(x[:, 2]), np.cos(x[:, 2]), np.zeros(100)
    expected = rows(
        [
            [zero, -rise * reach * sine, -(L3**2) * np.cos(q23) * np.sin(q23) * sine],
            [reach**2 * cosine, zero, zero],
            [zero, reach**2 * sine, L3**2 * np.cos(q23) ** 2 * sine],
        ]
    )
    found = ec.regressor(three_link_study(1).arm, at)
    np.testing.assert_allclose(found, expected, atol=ROUNDING)
    np.testing.assert_allclose(jacobian_24(at.q)[:, 0, 1], -rise, atol=ROUNDING)  # (29)


@pytest.mark.parametrize("count", [1, 2, 3, 12])
def test_eq_32_33_information(count: int) -> None:
    x, at = planar(count)
    a11, a22, a33, a23 = PAPER.sums(x)
    expected = np.array([[a11, 0, 0], [0, a22, a23], [0, a23, a33]])
    worth = ec.assess(three_link_study(count), at, np.ones(count, dtype=int))
    np.testing.assert_allclose(worth.information, expected, atol=ROUNDING * a22)


def test_eq_33_as_printed() -> None:
    """a23 as it can be read: cosec q23 (l3 + l2 - q3)² α; neither that nor a cosine gives it."""
    x, _ = planar(6)
    q2, q3, alpha = x.T
    reach, right = L2 * np.cos(q2) + L3 * np.cos(q2 + q3), PAPER.sums(x)[3]
    for trigonometric in (1.0 / np.sin(q2 + q3), np.cos(q2 + q3)):
        printed = L3**2 * reach * trigonometric * (L3 + L2 - q3) ** 2 * alpha
        assert abs(printed.sum() / right - 1.0) > 0.5


@pytest.mark.parametrize("count", [2, 3, 12])
def test_eq_34_covariance(count: int) -> None:
    x, at = planar(count)
    worth = ec.assess(three_link_study(count), at, np.ones(count, dtype=int))
    cov = PAPER.covariance(x)
    np.testing.assert_allclose(cov @ worth.information, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(np.sqrt(np.diagonal(cov)), worth.standard_error, rtol=1e-9)
    printed = cov * np.where(np.eye(3), 1.0, -1.0)
    assert np.abs(printed @ worth.information - np.eye(3)).max() > 0.1  # no inverse at all


def published(name: str) -> Array:
    """(m, 3) q2, q3 and α from the y axis, of a plan of Table 2."""
    row = next(row for row in TABLE_2 if row.name == name)
    x = np.array(row.configurations)
    if row.from_z:
        x[:, 2] = 90.0 - x[:, 2]
    return np.radians(x)


@pytest.mark.parametrize("count", [2, 3, 12])
def test_eq_35_objective(count: int) -> None:
    x, at = planar(count)
    d = PAPER.coefficients(np.radians(TEST_CONFIGURATION), FORCE_IN_TEXT)
    worth = ec.assess(three_link_study(count), at, np.ones(count, dtype=int))
    assert PAPER.objective(x, d) == pytest.approx(worth.rho0**2, rel=1e-9)
    weight = np.array([[d[0], 0, 0], [0, d[2], d[3]], [0, d[3], d[1]]])  # A0ᵀA0
    assert PAPER.objective(x, d) == pytest.approx(np.trace(weight @ PAPER.covariance(x)), rel=1e-9)


@pytest.mark.parametrize(
    ("name", "right", "printed"),
    [("Opt1", 1.92, 13.6), ("Opt2", 0.80, 3.99), ("Opt4", 0.39, 2.33)],
)
def test_eq_35_on_table_2(name: str, right: float, printed: float) -> None:
    """With - 2 d4 a23 Table 2; with + 2 d4 a23, as printed, values 5 to 7 times as large."""
    x, d = published(name), PAPER.coefficients(np.radians(TEST_CONFIGURATION), FORCE_IN_TABLE_2)
    assert PAPER.objective(x, d) == pytest.approx(right, abs=0.005)
    assert PAPER.objective(x, d * [1.0, 1.0, 1.0, -1.0]) == pytest.approx(printed, rel=5e-3)


def test_eq_36_37_coefficients() -> None:
    q, force = cases(50)
    A0 = ec.regressor(three_link_study(1).arm, ec.LoadCases(q, np.hstack([force, 0.0 * force])))
    gram = np.einsum("nij,nik->njk", A0, A0)
    expected = np.stack([gram[:, 0, 0], gram[:, 2, 2], gram[:, 1, 1], gram[:, 1, 2]], axis=1)
    found = np.array([PAPER.coefficients(*case) for case in zip(q, force, strict=True)])
    np.testing.assert_allclose(found, expected, atol=ROUNDING * np.abs(expected).max())
