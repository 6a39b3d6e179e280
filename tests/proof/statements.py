"""Statements by chance: chains, springs, loads and constraints of every kind."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.proof.statement import (
    AnyDirection,
    CarriedSprings,
    ChainJoints,
    DirectionOverPlane,
    InCone,
    PointByDistance,
    PointOverPlane,
    ProofLoad,
    Statement,
    SteadyLoad,
)

LOADS = ("steady", "moment", "free", "plane", "cone")


def unit(rng: np.random.Generator, *shape: int) -> Array:
    vectors = rng.normal(size=(*shape, 3))
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def load_of(kind: str, rng: np.random.Generator) -> ProofLoad:
    point, basis = rng.normal(size=3), np.linalg.qr(rng.normal(size=(3, 3)))[0]
    if kind == "free":
        return AnyDirection(point, 1.3, np.eye(3))
    if kind == "plane":
        return AnyDirection(point, 1.3, basis[:, :2])
    if kind == "cone":
        return InCone(point, 1.3, basis[:, 0], 0.7)
    return SteadyLoad(point, rng.normal(size=3), rng.normal(size=3) * (kind == "moment"))


def chance(
    rng: np.random.Generator,
    kinds: str = "ttst",
    load: str = "steady",
    *,
    markers: int = 2,
    columns: int = 2,
    rotation: bool = True,
) -> Statement:
    """A statement by chance; `kinds` has a t for each joint that turns, an s for one that slides.

    There is a spring in every joint, a linear one on the foot and one across the last body.
    """
    n = len(kinds)
    slides = np.array([kind == "s" for kind in kinds])
    axis, point = unit(rng, n), rng.normal(size=(n, 3))
    lower = rng.uniform(-2.0, -0.5, n)
    c = n + 2
    return Statement(
        name="by chance",
        criterion="test-pose",
        study_sha256="0" * 64,
        version="0",
        joints=ChainJoints(
            tuple(f"J{i}" for i in range(n)), slides, axis, point, lower, lower + 2.0
        ),
        springs=CarriedSprings(
            ("foot", *(f"J{i}" for i in range(n)), "tip"),
            np.array([True, *slides, False]),
            np.array([0, *range(n), n]),
            np.concatenate([unit(rng, 1), axis, unit(rng, 1)]),
            np.concatenate([rng.normal(size=(1, 3)), point, rng.normal(size=(1, 3))]),
        ),
        make=rng.normal(size=(c, c - 1)),
        unknowns=tuple(f"k{i}" for i in range(c - 1)),
        markers=rng.normal(size=(markers, 3)),
        sigma=0.5,
        sigma_turn=0.3 if rotation else None,
        load=load_of(load, rng),
        constraints=(
            PointOverPlane("height", rng.normal(size=3), unit(rng), -0.2),
            DirectionOverPlane("tilt", unit(rng), unit(rng), -0.4),
            PointByDistance("radius", rng.normal(size=3), np.zeros(3), np.array([1, 1, 0]), 1, 0.3),
            PointByDistance("range", rng.normal(size=3), rng.normal(size=3), np.ones(3), -1, 9.0),
        ),
        V=rng.normal(size=(c - 1, columns)),
        K=rng.normal(size=(c - 1, columns)),
        B=np.eye(c - 1),
        count=12,
    )


def within_root(statement: Statement, rng: np.random.Generator, count: int) -> Array:
    """(count, n) points of the root by chance."""
    low, high = statement.root
    return np.asarray(low + (high - low) * rng.uniform(size=(count, len(low))))
