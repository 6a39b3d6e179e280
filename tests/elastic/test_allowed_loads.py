"""Wrenches the experiments may use: cone, directions, gradients."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, InPlane, Load
from elastocal.errors import InputError
from tests.arms import central_difference

CONE = FreeDirection(2500.0, np.array([0.2, -0.1, -1.0]), np.radians(30.0))
FREE = FreeDirection(2.0, np.array([0.0, 0.0, 1.0]))
GRADIENT = 1e-8


def directions(count: int) -> np.ndarray:
    """(3, count) design variables, of any norm that occurs."""
    rng = np.random.default_rng(0)
    return rng.normal(size=(3, count)) * rng.uniform(0.3, 2.0, count)


def angles(unit: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """(N,) angles of (3, N) directions to an axis, by the cross product."""
    return np.arctan2(np.linalg.norm(np.cross(unit.T, axis), axis=1), unit.T @ axis)


def test_a_free_force_always_has_the_largest_size() -> None:
    vectors = CONE.decode(directions(10))
    assert np.linalg.norm(vectors, axis=0) == pytest.approx(np.full(10, 2500.0))
    assert np.cross(vectors.T, directions(10).T) == pytest.approx(np.zeros((10, 3)), abs=1e-9)


def test_gradient_of_a_free_force_in_its_design_variables() -> None:
    x, cotangent = directions(10), np.random.default_rng(1).normal(size=(3, 10))
    expected = central_difference(lambda y: (CONE.decode(y.T) * cotangent).sum(axis=0), x.T)
    scale = np.abs(expected).max()
    pulled = CONE.pull(x, cotangent).T
    assert pulled == pytest.approx(expected, abs=GRADIENT * scale)


def test_cone_margin_is_the_angle_left() -> None:
    x = directions(50)
    expected = np.radians(30.0) - angles(x / np.linalg.norm(x, axis=0), CONE.axis)
    assert CONE.cone(x)[0] == pytest.approx(expected, abs=1e-12)


def test_gradient_of_the_cone_margin() -> None:
    """Away from the axis, where the angle has a kink that central differences cannot cross."""
    x = directions(50)
    angle = angles(x / np.linalg.norm(x, axis=0), CONE.axis)
    x = x[:, (angle > 0.3) & (angle < np.pi - 0.3)]
    assert x.shape[1] > 40
    expected = central_difference(lambda y: CONE.cone(y.T)[0], x.T)
    gradient = CONE.cone(x)[1].T
    assert gradient == pytest.approx(expected, abs=GRADIENT * np.abs(expected).max())


def test_cone_gradient_is_finite_on_the_axis() -> None:
    margin, gradient = CONE.cone(np.stack([CONE.axis, -CONE.axis], axis=1))
    assert margin == pytest.approx([np.radians(30.0), np.radians(30.0) - np.pi], abs=1e-7)
    assert np.isfinite(gradient).all()


def test_samples_fill_the_cone_uniformly() -> None:
    """cos(angle) is uniform between cos 30° and 1: mean within 5 standard errors, all inside."""
    count = 20000
    sample = CONE.sample(count, np.random.default_rng(2))
    cosine = CONE.axis @ sample
    lowest = np.cos(np.radians(30.0))
    assert np.linalg.norm(sample, axis=0) == pytest.approx(np.ones(count))
    assert cosine.min() >= lowest - 1e-12
    standard_error = (1.0 - lowest) / np.sqrt(12.0 * count)
    assert abs(cosine.mean() - (1.0 + lowest) / 2.0) < 5.0 * standard_error
    assert (CONE.cone(sample)[0] >= -1e-7).all()


def test_samples_of_an_unrestricted_direction_cover_the_sphere() -> None:
    sample = FREE.sample(20000, np.random.default_rng(3))
    assert np.abs(sample.mean(axis=1)).max() < 5.0 / np.sqrt(3.0 * 20000)
    assert np.abs(sample @ sample.T / 20000 - np.eye(3) / 3.0).max() < 0.02
    assert not FREE.is_cone


def test_a_fixed_force_has_nothing_to_choose() -> None:
    fixed = FixedVector(np.array([0.0, 0.0, -2500.0]))
    assert fixed.variables == 0
    assert fixed.size == 2500.0
    assert fixed.decode(np.zeros((0, 4))) == pytest.approx(np.tile([[0], [0], [-2500.0]], 4))
    off = fixed.margin(np.array([[0.0, 0.0, -2500.0], [3.0, 4.0, -2500.0]]))
    assert off == pytest.approx([0.0, -5.0])


PLANE = InPlane(300.0, np.array([1.0, -2.0, 0.5]))


def in_plane(count: int) -> np.ndarray:
    rng = np.random.default_rng(5)
    return rng.normal(size=(2, count)) * rng.uniform(0.3, 2.0, count)


def test_a_force_in_a_plane_has_the_largest_size_and_no_part_across() -> None:
    vectors = PLANE.decode(in_plane(10)).T
    assert np.linalg.norm(vectors, axis=1) == pytest.approx(np.full(10, 300.0))
    assert vectors @ [1.0, -2.0, 0.5] == pytest.approx(np.zeros(10), abs=1e-10)
    assert PLANE.direction_room(vectors) == pytest.approx(np.zeros(10), abs=1e-14)
    assert PLANE.margin(vectors) == pytest.approx(np.zeros(10), abs=1e-10)


def test_gradient_of_a_force_in_a_plane() -> None:
    x, cotangent = in_plane(10), np.random.default_rng(1).normal(size=(3, 10))
    expected = central_difference(lambda y: (PLANE.decode(y.T) * cotangent).sum(axis=0), x.T)
    assert (
        pytest.approx(expected, abs=GRADIENT * np.abs(expected).max()) == PLANE.pull(x, cotangent).T
    )


@pytest.mark.parametrize("load", [PLANE, CONE, FREE, FixedVector(np.ones(3))])
def test_design_variables_of_vectors_lead_back_to_them(load: Load) -> None:
    vectors = load.decode(load.sample(20, np.random.default_rng(6)))
    assert load.design(vectors.T).shape == (20, load.variables)
    assert load.decode(load.design(vectors.T).T) == pytest.approx(vectors, abs=1e-9)


def test_samples_in_a_plane_go_round_uniformly() -> None:
    """All directions alike: mean zero, second moments of half in the plane, none across."""
    vectors = PLANE.decode(PLANE.sample(20000, np.random.default_rng(7))) / 300.0
    assert np.abs(vectors.mean(axis=1)).max() < 5.0 / np.sqrt(2.0 * 20000)
    normal = np.array([1.0, -2.0, 0.5]) / np.sqrt(5.25)
    across = np.eye(3) - np.outer(normal, normal)
    assert vectors @ vectors.T / 20000 == pytest.approx(across / 2.0, abs=0.02)


def test_how_far_a_force_is_out_of_the_plane() -> None:
    """By the angle, on either side; a zero vector has no direction."""
    level = InPlane(2.0, np.array([0.0, 0.0, 7.0]))
    tilted = np.array([[2.0, 0.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, -np.sqrt(3.0)], [0.0] * 3])
    room = level.direction_room(tilted)
    assert np.degrees(room) == pytest.approx([0.0, -45.0, -60.0, 180.0])
    assert level.margin(tilted) == pytest.approx([0.0, 2.0 - np.sqrt(2.0), 0.0, 2.0])


def test_how_far_a_force_is_out_of_the_cone() -> None:
    x = directions(50)
    assert CONE.direction_room(x.T) == pytest.approx(CONE.cone(x)[0], abs=1e-7)
    assert (FREE.direction_room(x.T) == np.pi).all()
    assert CONE.direction_room(np.zeros((1, 3))) == np.pi


def test_a_plane_needs_a_normal_and_a_size() -> None:
    with pytest.raises(InputError, match="normal of the plane of directions must not be zero"):
        InPlane(1.0, np.zeros(3))
    with pytest.raises(InputError, match="largest force or torque must be positive, found -1"):
        InPlane(-1.0, np.ones(3))


def test_slack_in_the_bound_on_a_free_force() -> None:
    assert FREE.margin(np.array([[0.0, 1.5, 0.0], [0.0, 0.0, 3.0]])) == pytest.approx([0.5, -1.0])


@pytest.mark.parametrize("largest", [0.0, -1.0, np.nan, np.inf])
def test_the_largest_force_must_be_a_positive_number(largest: float) -> None:
    with pytest.raises(InputError, match="largest force or torque must be positive, found"):
        FreeDirection(largest, np.array([0.0, 0.0, 1.0]))


@pytest.mark.parametrize("axis", [[0.0, 0.0, 0.0], [np.nan, 0.0, 1.0]])
def test_the_axis_of_a_cone_must_be_a_direction(axis: list[float]) -> None:
    with pytest.raises(InputError, match="axis of the cone of directions must not be zero"):
        FreeDirection(1.0, np.array(axis))
