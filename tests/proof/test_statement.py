"""Statements: to plain data and back, and what they speak of by other means."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.proof.cones import largest_in_cone
from elastocal.proof.plain_data import as_data, from_data
from elastocal.proof.reference import ArmAt, best_force, margins, rows, sensitivity
from elastocal.proof.statement import (
    HalvedVariable,
    HeldVariable,
    InCone,
    PointByDistance,
    Statement,
    SteadyLoad,
)
from tests.proof.statements import LOADS, chance, unit, within_root


def full(rng: np.random.Generator, load: str) -> Statement:
    """With everything that a statement may have."""
    made = chance(rng, load=load)
    mix = np.eye(4)
    mix[1, 0] = -1.0
    half = HalvedVariable(3, np.array([1.0, 1.0, 1.0, -1.0]), np.array([np.pi, 0.0, 0.0, 0.0]))
    return replace(
        made,
        mix=mix,
        limited=np.array([False, True, False, False]),
        held=(HeldVariable(0, "flat"), HeldVariable(2, "base")),
        halved=(half,),
        points=np.array([1, 10, 1, 10]),
        largest=1.25,
        rho0=1e-5,
        left_out=("line of sight",),
        witnesses=rng.normal(size=(3, 7)),
        sigma_turn=None if load == "free" else 0.1,
    )


def same(a: Any, b: Any) -> bool:
    """Whether two frozen values are the same, all the way down."""
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and bool((a == b).all())
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if hasattr(a, "__dataclass_fields__"):
        each = (same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
        return type(a) is type(b) and all(each)
    return bool(a == b)


@pytest.mark.parametrize("load", LOADS)
def test_to_json_and_back(load: str) -> None:
    made = full(np.random.default_rng(0), load)
    text = json.dumps(as_data(made), allow_nan=False)
    assert same(from_data(json.loads(text)), made)
    unproved = replace(made, largest=None, rho0=None, witnesses=np.zeros(0), points=np.zeros(0))
    assert same(from_data(json.loads(json.dumps(as_data(unproved)))), unproved)


def spoiled(path: str, value: Any) -> dict[str, Any]:
    """Data with another value at a path; None leaves the key out."""
    data = json.loads(json.dumps(as_data(full(np.random.default_rng(0), "cone"))))
    *way, last = [int(step) if step.isdigit() else step for step in path.split(".")]
    at: Any = data
    for step in way:
        at = at[step]
    if value is None:
        del at[last]
    else:
        at[last] = value
    return dict(data)


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("format", "elastocal-proof 9", "format: expected 'elastocal-proof 1'"),
        ("joints", None, "joints is missing"),
        ("joints", {}, "joints: expected a list, found {}"),
        ("joints.1.axis", None, "joints[1].axis is missing"),
        ("joints.1.axis", [0, 1], "joints[1].axis: expected 3 numbers in lists, found [0, 1]"),
        ("joints.2.kind", "bends", "joints[2].kind: expected turns or slides, found 'bends'"),
        ("joints.0.lower", "1", "joints[0].lower: expected a finite number"),
        ("springs.3.body", 9, "springs[3].body: expected an integer from 0 to 4, found 9"),
        ("springs.3.body", True, "springs[3].body: expected an integer"),
        ("make.0", [1.0], "make: expected 6 x 5 numbers"),
        ("V", [[1.0]], "V: expected 5 x any numbers"),
        ("K", [[1.0]] * 5, "K: expected 5 x 2 numbers"),
        ("B.1.1", float("nan"), "B: expected 5 x 5 numbers"),
        ("B.1.1", "x", "B: expected 5 x 5 numbers"),
        ("load.half_angle", None, "load.half_angle is missing"),
        ("load", 3, "load: expected keys with values, found 3"),
        ("constraints.2.sign", 0.5, "constraints[2].sign: expected an integer from -1 to 1"),
        ("root.upper", [0.0], "root.upper: expected 4 numbers"),
        ("limited", [1, 0, 0, 0], "limited: expected a list of 4 times true or false"),
        ("held.0.because", "no", "held[0].because: expected flat or base"),
        ("unknowns", "abc", "unknowns: expected a list of texts"),
        ("witnesses", [[0.0]], "witnesses: expected any x 7 numbers"),
        ("tables", None, "tables is missing"),
        ("sigma_turn", "", "sigma_turn: expected a finite number"),
    ],
)
def test_what_is_wrong_is_named_by_its_key(path: str, value: Any, said: str) -> None:
    with pytest.raises(InputError) as refused:
        from_data(spoiled(path, value))
    assert str(refused.value).startswith(said)


def test_bodies_by_matrix_exponentials() -> None:
    rng = np.random.default_rng(1)
    made = full(rng, "steady")
    x = within_root(made, rng, 5)
    arm, q = ArmAt(made, x), x @ made.mix.T
    for k in range(5):
        moved = np.eye(4)
        for i in range(4):
            a, o = made.joints.axis[i], made.joints.point[i]
            twist = np.zeros((4, 4))
            if made.joints.slides[i]:
                twist[:3, 3] = a
            else:
                twist[:3, :3], twist[:3, 3] = np.cross(a, np.eye(3)).T, -np.cross(a, o)
            moved = moved @ expm(q[k, i] * twist)
            np.testing.assert_allclose(arm.turns[i + 1][k], moved[:3, :3], atol=1e-14)
            np.testing.assert_allclose(arm.shifts[i + 1][k], moved[:3, 3], atol=1e-14)


@pytest.mark.parametrize("load", LOADS)
def test_sensitivity_is_a_square_of_rows(load: str) -> None:
    rng = np.random.default_rng(2)
    made = chance(rng, load=load)
    x = within_root(made, rng, 40)
    found, d = rows(made, x), sensitivity(made, x)
    force = best_force(made, x)
    assert force.shape == (40, 3)
    if isinstance(made.load, SteadyLoad):
        np.testing.assert_allclose(d, (found**2).sum(axis=(1, 2)))
        return
    k = found.shape[-1]
    u = rng.normal(size=(4000, k))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    if isinstance(made.load, InCone):
        u = u[u @ made.load.axis >= np.cos(made.load.half_angle)]
    all_of_them = (np.einsum("nmrk,uk->unmr", found, u) ** 2).sum(axis=(2, 3))
    assert (all_of_them.max(axis=0) <= d * (1.0 + 1e-12)).all()
    assert (all_of_them.max(axis=0) >= 0.97 * d).all()
    directions = made.directions
    assert directions is not None
    each = sensitivity(made, x, force=(directions @ u[:40].T).T)
    np.testing.assert_allclose(each, np.diagonal(all_of_them[:40]))
    np.testing.assert_allclose(sensitivity(made, x, force=force), d, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), 1.3)


def test_largest_in_a_cone() -> None:
    rng = np.random.default_rng(3)
    root = rng.normal(size=(300, 3, 3)) * [1.0, 0.6, 0.2]
    form = root @ root.transpose(0, 2, 1)
    axis, half = unit(rng), 0.4
    edge = np.linspace(0.0, 2.0 * np.pi, 20000)
    across = np.linalg.svd(axis[None])[2][1:]
    around = np.cos(edge)[:, None] * across[0] + np.sin(edge)[:, None] * across[1]
    u = np.cos(half) * axis + np.sin(half) * around
    brute = np.einsum("uk,nkl,ul->nu", u, form, u).max(axis=1)
    values, vectors = np.linalg.eigh(form)
    inside = np.abs(vectors[:, :, 2] @ axis) > np.cos(half)
    brute = np.where(inside, values[:, 2], brute)
    assert 0.05 < inside.mean() < 0.95
    found, direction = largest_in_cone(form, axis, half)
    np.testing.assert_allclose(found, brute, rtol=2e-7)
    assert (found >= brute * (1.0 - 1e-12)).all()
    np.testing.assert_allclose(np.einsum("nk,nkl,nl->n", direction, form, direction), found)
    assert (direction @ axis >= np.cos(half) - 1e-12).all()


def test_constraints_by_their_points() -> None:
    rng = np.random.default_rng(4)
    made = chance(rng)
    x = within_root(made, rng, 30)
    arm, found = ArmAt(made, x), margins(made, x)
    height, tilt, radius, far = made.constraints
    assert isinstance(radius, PointByDistance)
    assert isinstance(far, PointByDistance)
    point: Array = arm.point(radius.point)
    np.testing.assert_allclose(found[:, 2], np.hypot(point[:, 0], point[:, 1]) ** 2 - 0.09)
    away = np.linalg.norm(arm.point(far.point) - far.center, axis=1)
    np.testing.assert_allclose(found[:, 3], 81.0 - away**2)
    assert found.shape == (30, 4)
    assert [height.name, tilt.name] == ["height", "tilt"]
