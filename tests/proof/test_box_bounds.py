"""Bounds over boxes: never too small, and each term of them as large as it must be.

Where a term stands alone the largest ratio of the truth to the bound shows that it is needed.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import combinations_with_replacement, product
from threading import Thread

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.core.layout import LEAF, OPEN, PENDING
from elastocal.core.library import levels
from elastocal.errors import InputError
from elastocal.proof import branching, prove
from elastocal.proof.boxes import SMALLEST
from elastocal.proof.branching import Branching
from elastocal.proof.prove import ProofError
from elastocal.proof.reference import margins, quadratic_form, rows, sensitivity, within
from elastocal.proof.series import FiniteSeries, constraint_series, rows_series
from elastocal.proof.statement import (
    AnyDirection,
    InCone,
    PointByDistance,
    ProofConstraint,
    Statement,
    SteadyLoad,
)
from elastocal.proof.tree import Region, divided, is_complete, leaf_at, proved, symbols_of
from elastocal.proof.trigonometric import Thirds, third_derivatives
from tests.proof.crafted import (
    Derivatives,
    EveryLevel,
    box_about,
    columns_of,
    least_aim,
    many_springs,
    no_tables,
    with_largest,
    with_rows,
)
from tests.proof.statements import LOADS, chance, unit

pytestmark = pytest.mark.skipif(not levels(), reason="there is no compiled core")

SIZES = (1e-3, 0.05, 0.3, 1.0)


def free_of_constraints(s: Statement) -> Statement:
    return replace(s, constraints=())


def with_sums(s: Statement) -> Statement:
    """Coordinates are sums, differences and neither, in turn."""
    mix = np.eye(len(s.joints))
    for i in range(1, len(mix)):
        if not s.joints.slides[[i - 1, i]].any():
            mix[i, i - 1] = (-1.0, 1.0, 0.0)[i % 3 - 1]
    return replace(s, mix=mix)


def steps(rng: np.random.Generator, r: Array, count: int = 200) -> Array:
    """(N, n) where in a box of half-widths r (n,) the largest may be: corners, faces, inside."""
    corners = np.array(list(product((-1.0, 1.0), repeat=len(r))))
    inside = rng.uniform(-1.0, 1.0, (count, len(r)))
    faces = np.where(rng.random(inside.shape) < 0.5, np.sign(inside), inside)
    return np.concatenate([corners, inside, faces]) * r


def derivatives(series: FiniteSeries, x: Array) -> tuple[Array, Array, Array]:
    """Value (C,), first (n, C) and second (n, n, C) derivatives at x (n,); zero where held."""
    n, place = len(x), {int(v): i for i, v in enumerate(series.variables)}

    def by(*variables: int) -> Array:
        orders = [0] * len(place)
        for v in variables:
            if v not in place:
                return np.zeros(series.coefficients.shape[-1])
            orders[place[v]] += 1
        return np.asarray(series.at(x[None], orders)[0])

    second = [[by(i, j) for j in range(n)] for i in range(n)]
    return by(), np.array([by(i) for i in range(n)]), np.array(second)


def largest_quadratic(G: Array, H: Array, r: Array) -> float:
    """A bound of G·h + hᵀHh/2, |h| ≤ r: mixed terms to both squares, each variable by itself."""
    size, bend = np.abs(G), np.diag(H) + (np.abs(H) @ r - np.abs(np.diag(H)) * r) / r
    inner = (bend < 0.0) & (size < -bend * r)
    ends = size * r + 0.5 * bend * r**2
    return float(np.where(inner, size**2 / np.where(inner, -2.0 * bend, 1.0), ends).sum())


def rest_of(third: Array, r: Array) -> float:
    return float(np.einsum("ijk,i,j,k->", third, r, r, r) / 6.0)


# The function: it is the one that the statement speaks of.


def fuzzed(seed: int) -> Statement:
    """Chains of 1 to 8 joints with up to five markers, of any rank and load."""
    rng = np.random.default_rng(seed)
    kinds = "".join(rng.choice(list("tts"), rng.integers(1, 9)))
    s = chance(
        rng,
        kinds,
        LOADS[seed % len(LOADS)],
        markers=int(rng.integers(0, 6)),
        columns=int(rng.integers(1, 7)),
        rotation=bool(rng.random() < 0.5),
    )
    markers, root = s.markers.copy(), s.root.copy()
    if len(markers) and rng.random() < 0.6:
        markers[rng.integers(len(markers))] = s.load.point
    held = rng.random(len(kinds)) < 0.2
    root[1, held] = root[0, held]
    kept = [c for c in s.constraints if rng.random() < 0.5]
    s = replace(s, markers=markers, root=root, constraints=tuple(kept))
    return with_sums(s) if rng.random() < 0.5 else s


@pytest.mark.parametrize("seed", range(60))
def test_values_at_centres(seed: int) -> None:
    s = fuzzed(seed)
    boxes = EveryLevel(s, no_tables(s))
    a = len(boxes.variables)
    u = np.random.default_rng(seed).uniform(size=(9, a))
    x = boxes.statement_points(u)
    feasible = (margins(s, x) >= 0.0).all(axis=1)
    rtol = 1e-5 if isinstance(s.load, InCone) else 1e-10
    _, values, kinds = boxes.bounds(np.hstack([u, np.full((9, a), 1e-9)]), np.inf)
    np.testing.assert_array_equal(kinds != OPEN, feasible)
    np.testing.assert_allclose(values[feasible], sensitivity(s, x)[feasible], rtol=rtol, atol=1e-12)


def test_cones_by_a_grid_of_directions() -> None:
    """Largest values over cones, those of nearly a right angle and narrow ones too."""
    rng = np.random.default_rng(11)
    s = free_of_constraints(chance(rng, "ts", "cone"))
    polar, around = np.meshgrid(np.linspace(0, 1, 50), np.linspace(0, 2 * np.pi, 100))
    u = rng.uniform(size=(8, 2))
    looser = []
    for half in (0.02, 0.3, 0.7, 1.2, 1.5, 1.57):
        axis = unit(rng)
        s = replace(s, load=InCone(s.load.point, 1.3, axis, half))
        boxes = EveryLevel(s, no_tables(s))
        across = np.linalg.svd(axis[None])[2][1:]
        side = np.cos(around)[..., None] * across[0] + np.sin(around)[..., None] * across[1]
        tilt = (polar * half)[..., None]
        F = 1.3 * (np.cos(tilt) * axis + np.sin(tilt) * side).reshape(-1, 3)
        B = rows(s, boxes.statement_points(u)).reshape(len(u), -1, 3) / 1.3
        found = (np.einsum("nck,fk->nfc", B, F) ** 2).sum(axis=2).max(axis=1)
        value = boxes.bounds(np.hstack([u, np.full((8, 2), 1e-10)]), np.inf)[1]
        assert (found <= value * (1.0 + 1e-12)).all()
        assert (found >= value * 0.99).all()
        box = np.concatenate([u[0], np.full(2, 1e-10)])
        assert least_aim(boxes, box, 2.0 * value[0]) == pytest.approx(value[0], rel=1e-6)
        free = sensitivity(
            replace(s, load=AnyDirection(s.load.point, 1.3, np.eye(3))), boxes.statement_points(u)
        )
        looser.append((value / free).min())
    assert min(looser) < 0.5


def test_cones_of_a_right_angle_are_no_cones() -> None:
    s = free_of_constraints(chance(np.random.default_rng(12), "tt", "cone"))
    u = np.full((1, 4), 0.4) * [1, 1, 0, 0]
    free = sensitivity(
        replace(s, load=AnyDirection(s.load.point, 1.3, np.eye(3))),
        EveryLevel(s, no_tables(s)).statement_points(u[:, :2]),
    )
    for half in (np.pi / 2.0, 2.0):
        wide = replace(s, load=InCone(s.load.point, 1.3, s.load.axis, half))
        assert EveryLevel(wide, no_tables(s)).bounds(u, np.inf)[1] == pytest.approx(free)


# Steady loads.


@cache
def sample(kinds: str, load: str, sums: bool) -> tuple[Statement, Thirds]:
    rng = np.random.default_rng(len(kinds))
    s = free_of_constraints(chance(rng, kinds, load))
    s = replace(s, markers=np.array([s.markers[0], s.load.point]))
    s = with_sums(s) if sums else s
    turns = 20 if sums else 9
    return s, third_derivatives(s, 1e-3, [turns if kind == "t" else 4 for kind in kinds])


@pytest.mark.parametrize("load", ["steady", "moment"])
@pytest.mark.parametrize(
    ("kinds", "sums"), [("t", False), ("st", False), ("tst", False), ("tt", True), ("ttt", True)]
)
def test_bounds_are_what_the_formula_says(kinds: str, sums: bool, load: str) -> None:
    """By derivatives of the series: so those of the core are right, in boxes of any size."""
    s, third = sample(kinds, load, sums)
    boxes, series = EveryLevel(s, third), rows_series(s)
    rng = np.random.default_rng(3)
    seen = []
    for size in SIZES:
        for _ in range(3):
            x = boxes.statement_points(rng.uniform(0.2, 0.8, (1, len(kinds))))[0]
            r = size * rng.uniform(0.1, 1.0, len(kinds))
            B, B1, B2 = derivatives(series, x)
            b1, b2 = r @ np.linalg.norm(B1, axis=1), 0.5 * r @ np.linalg.norm(B2, axis=2) @ r
            quadratic = largest_quadratic(2.0 * B1 @ B, 2.0 * (B1 @ B1.T + B2 @ B), r)
            R = rest_of(third.rows, r)
            expected = (np.sqrt(B @ B + quadratic + 2.0 * b1 * b2 + b2**2) + R) ** 2
            bound, value, _ = boxes.bounds(box_about(boxes, s, x, r)[None], 0.0)
            assert bound[0] - value[0] == pytest.approx(expected - value[0], rel=1e-6)
            h = steps(rng, r)
            here = rows(s, x + h).reshape(len(h), -1)
            P = B + h @ B1 + 0.5 * np.einsum("ni,nj,ijc->nc", h, h, B2)
            assert np.linalg.norm(here - P, axis=1).max() <= R * (1.0 + 1e-9)
            seen.append(np.linalg.norm(here - P, axis=1).max() / R if R > 0.0 else 0.0)
            assert (here**2).sum(axis=1).max() <= bound[0] * (1.0 + 1e-12)
    assert max(seen) > 0.2 or kinds == "t"


def zeros(s: Statement, of: int) -> list[tuple[tuple[int, ...], Array]]:
    """All derivatives up to an order are to be zero."""
    orders = [
        c for m in range(of + 1) for c in combinations_with_replacement(range(len(s.joints)), m)
    ]
    return [(order, np.zeros(1)) for order in orders]


def turned_slide(load: str) -> Statement:
    """The slide is across the axis of the turn, so B_zz along it may be sin 2x."""
    s = many_springs(np.random.default_rng(1), "ts", load, each=24)
    axis = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    return replace(s, joints=replace(s.joints, axis=axis))


@cache
def third_order_alone(load: str) -> tuple[Statement, Thirds]:
    """B = B' = B'' = 0, and a third derivative that is nowhere larger."""
    if load == "plane":
        s = many_springs(np.random.default_rng(1), "t", load, each=24)
        of = Derivatives(s, np.zeros(1))
        silent = [of.by(*(0,) * order) for order in (0, 1, 2, 4)]
        found = with_largest(s, np.vstack(silent), of.by(0, 0, 0))
        return found, third_derivatives(found, 1e-3, [64])
    s, up, no = turned_slide(load), np.array([0.0, 0.0, 1.0]), np.zeros(1)
    given = [*zeros(s, 2), ((0, 1, 1), up), ((0, 0, 1, 1), no), ((0, 0, 0, 1, 1), -4.0 * up)]
    found = with_rows(s, np.zeros(2), [*given, ((0,) * 4 + (1, 1), no)])
    return found, third_derivatives(found, 1e-3, [64, 4])


@pytest.mark.parametrize(("load", "tight"), [("steady", 0.97), ("moment", 0.97), ("plane", 0.3)])
def test_third_order(load: str, tight: float) -> None:
    s, third = third_order_alone(load)
    boxes, n = EveryLevel(s, third), len(s.joints)
    r = np.array([1e-3, 1.0][:n])
    box = box_about(boxes, s, np.zeros(n), r)
    d = sensitivity(s, steps(np.random.default_rng(0), r)).max()
    bound = least_aim(boxes, box, 2.0 * d / tight)
    assert tight < d / bound <= 1.0
    assert boxes.bounds(box[None], d * 0.999)[2][0] != LEAF


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("case", ["second", "mixed", "both"])
def test_second_order_alone(load: str, case: str) -> None:
    """B = B' = 0, and B = 0 with B' along B'': all of |P|² is what is added to the quadratic."""
    s = many_springs(np.random.default_rng(2), "ss" if case == "mixed" else "s", load, each=40)
    n = len(s.joints)
    if isinstance(s.load, InCone):
        s = replace(s, load=AnyDirection(s.load.point, 1.0, np.eye(3)))
    of = Derivatives(s, np.zeros(n))
    if case == "second":
        s = with_largest(s, np.vstack([of.by(), of.by(0)]), of.by(0, 0))
    elif case == "both":
        s = with_largest(s, np.vstack([of.by(), of.by(0) - of.by(0, 0)]), of.by(0, 0))
    else:
        silent = [of.by(*order) for order in ((), (0,), (1,), (0, 0), (1, 1))]
        s = with_largest(s, np.vstack(silent), of.by(0, 1))
    x = np.full((1, n), 0.5)
    if load == "cone":  # about what it is largest for
        top = np.linalg.eigh(quadratic_form(s, x)[0])[1][:, -1]
        s = replace(s, load=InCone(s.load.point, 1.0, top, 0.7))
    boxes, tight = EveryLevel(s, no_tables(s)), 0.99 if s.directions is None else 0.8
    for size in (0.9, 0.02):
        r = size * np.array([1.0, 0.7][:n])
        d = sensitivity(s, steps(np.random.default_rng(0), r)).max()
        bound = least_aim(boxes, box_about(boxes, s, np.zeros(n), r), 3.0 * d)
        assert tight < d / bound <= 1.0 + 1e-9


# Free loads.


@pytest.mark.parametrize("kinds", ["t", "s"])
def test_free_loads_to_second_order(kinds: str) -> None:
    """Of one variable and two forms only the third order is lost where boxes shrink."""
    for seed in range(6):
        rng = np.random.default_rng(seed)
        s = free_of_constraints(chance(rng, kinds, "plane"))
        third = third_derivatives(s, 1e-3, [12])
        boxes = EveryLevel(s, third)
        x = s.root.mean(axis=0) + rng.uniform(-0.5, 0.5, 1)
        excess = []
        for r in (1e-3, 5e-4):
            d = sensitivity(s, x + np.array([[-r], [r]])).max()
            bound = least_aim(boxes, box_about(boxes, s, x, np.array([r])), 3.0 * d)
            assert bound >= d * (1.0 - 1e-9)
            excess.append(bound - d)
        assert excess[1] < 0.2 * excess[0] + 1e-9 * d


@cache
def free_sample(kinds: str, load: str) -> tuple[Statement, Thirds]:
    rng = np.random.default_rng(7)
    s = free_of_constraints(chance(rng, kinds, load))
    return s, third_derivatives(s, 1e-3, [9 if kind == "t" else 4 for kind in kinds])


@pytest.mark.parametrize("load", ["free", "plane", "cone"])
@pytest.mark.parametrize("kinds", ["tt", "sts"])
def test_free_loads_are_bounded(load: str, kinds: str) -> None:
    s, third = free_sample(kinds, load)
    boxes, rng, seen = EveryLevel(s, third), np.random.default_rng(4), []
    for size in SIZES:
        for _ in range(4):
            x = boxes.statement_points(rng.uniform(0.2, 0.8, (1, len(kinds))))[0]
            r = size * rng.uniform(0.1, 1.0, len(kinds))
            d = sensitivity(s, x + steps(rng, r)).max()
            start = sensitivity(s, x[None])[0]
            bound = least_aim(boxes, box_about(boxes, s, x, r), 1e7 * d, 1e-8)
            assert bound >= d * (1.0 - 1e-9)
            seen.append((d - start) / (bound - start))
    assert max(seen) > 0.9


XY = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
ZX = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
XX = np.diag([1.0, 0.0, 0.0])
SCHUR = {
    # b(h) is h² alone, or h and h², of a form whose eigenvalues are near to each other
    "aside": (2, [1.01, 1.0, 0.0], 0.0 * XY, 0.1 * XY),
    "both": (2, [1.01, 1.0, 0.0], 0.025 * XY, 0.05 * XY),
    "leaning": (3, [1.0, 0.5, 1.01], 0.1 * ZX, 0.0 * XY),
    # the rest of the form alone rises
    "across": (3, [1.0, 0.99, 1.01], 0.1 * XY, 0.0 * XY),
    "beside": (3, [1.0, 0.99, 1.01], 0.1 * XX, 0.0 * XY),
}


def sliding_form(k: int) -> Statement:
    s = many_springs(np.random.default_rng(5), "s", "free", each=40)
    basis = np.eye(3)[:, :k]
    return replace(
        s,
        joints=replace(s.joints, axis=np.array([[0.0, 0.0, 1.0]])),
        load=AnyDirection(s.load.point, 1.0, basis),
    )


def check_schur(s: Statement) -> None:
    boxes = EveryLevel(s, no_tables(s))
    d = sensitivity(s, np.array([[-1.0], [1.0], [0.0]])).max()
    bound = least_aim(boxes, box_about(boxes, s, np.zeros(1), np.ones(1)), 9.0)
    assert d > 1.01**2 + 0.02
    assert 1.0 - 1e-9 < bound / d < 1.04


@pytest.mark.parametrize("case", SCHUR)
def test_terms_of_the_inequality_of_schur(case: str) -> None:
    """B is given to second order in what slides: that is all of it."""
    k, roots, slope, bend = SCHUR[case]
    given = [((), np.diag(roots)[:, :k]), ((0,), slope[:, :k]), ((0, 0), bend[:, :k])]
    check_schur(with_rows(sliding_form(k), np.zeros(1), given))


def test_the_rest_of_the_form_bends() -> None:
    """Its two directions mix by h² alone, in the one way that there is."""
    s = sliding_form(3)
    of = Derivatives(s, np.zeros(1))
    one = with_largest(s, np.vstack([of.by(), of.by(0)]), of.by(0, 0)).V[:, 0]
    u, _, w = np.linalg.svd((of.by(0, 0) @ one).reshape(3, 3))
    seen, made = w.T[:, [1, 2, 0]], u[:, [1, 0, 2]]  # the last column is made of the second
    B = made @ np.diag([1.01, 1.0, 0.99]) @ seen.T
    bend = 0.4 * np.outer(u[:, 0], w[0])
    check_schur(with_rows(s, np.zeros(1), [((), B), ((0,), np.zeros(1)), ((0, 0), bend)]))


# Constraints: what no point of a box keeps to, and what they take off.


def shifted(one: ProofConstraint, by: float) -> ProofConstraint | None:
    """The constraint whose value is less by so much; None where there is none."""
    if not isinstance(one, PointByDistance):
        return replace(one, offset=one.offset + by)
    square = one.bound**2 + one.sign * by
    return replace(one, bound=float(np.sqrt(square))) if square >= 0.0 else None


def one_constraint(s: Statement, c: int) -> Statement:
    return replace(s, constraints=s.constraints[c : c + 1])


@pytest.mark.parametrize("sums", [False, True])
@pytest.mark.parametrize("c", range(4))
def test_empty_is_what_the_formula_says(c: int, sums: bool) -> None:
    """A box is empty if the largest of g and its rest is below zero, and not if it is above.

    So no box is that a constraint grazes at a corner, inside, or where its third order takes it.
    """
    s = one_constraint(chance(np.random.default_rng(20 + c), "tts"), c)
    s = with_sums(s) if sums else s
    third = third_derivatives(s, 1e-3, [17, 17, 4])
    (series,), (one,) = constraint_series(s), s.constraints
    rng, seen, needed = np.random.default_rng(5), [], 0
    for size in SIZES:
        for k in range(8):
            x = s.root.mean(axis=0) + rng.uniform(-0.6, 0.6, 3)
            r = size * rng.uniform(0.1, 1.0, 3)
            r[np.arange(3) != k] *= 1.0 if k > 2 else 1e-3
            g, G, H = derivatives(series, x)
            R = rest_of(third.constraints[0], r)
            most = g[0] + largest_quadratic(G[:, 0], H[:, :, 0], r)
            h = steps(rng, r)
            here = margins(s, x + h)[:, 0]
            P = g[0] + h @ G[:, 0] + 0.5 * np.einsum("ni,nj,ij->n", h, h, H[:, :, 0])
            assert np.abs(here - P).max() <= R * (1.0 + 1e-9) + 1e-12
            seen.append(np.abs(here - P).max() / (R + 1e-9))
            needed += here.max() > most
            assert here.max() <= most + R + 1e-12
            for by, empty in (
                (most + R + 1e-6, True),
                (most + R - 1e-6, False),
                (here.max() - 1e-9, False),
            ):
                tried = shifted(one, by)
                if tried is None:
                    continue
                boxes = EveryLevel(replace(s, constraints=(tried,)), third)
                kinds = boxes.bounds(box_about(boxes, s, x, r)[None], 0.0)[2]
                assert (kinds[0] == OPEN) == empty
    assert max(seen) > 0.2
    assert needed or c != 2


def test_a_rest_keeps_boxes_from_being_empty() -> None:
    """Tilted circles seen from above: the third order alone takes the radius to its bound."""
    s = one_constraint(chance(np.random.default_rng(1), "t"), 2)
    rng, found = np.random.default_rng(2), 0
    for _ in range(70):
        one = PointByDistance(
            "radius", rng.normal(size=3), rng.normal(size=3), np.array([1, 1, 0]), 1, 1.0
        )
        s = replace(s, constraints=(one,))
        (series,) = constraint_series(s)
        x, r = rng.uniform(-1.0, 1.0, 1) + s.root.mean(axis=0), np.array([rng.uniform(0.3, 1.0)])
        g, G, H = derivatives(series, x)
        most = g[0] + largest_quadratic(G[:, 0], H[:, :, 0], r)
        largest = margins(s, x + steps(rng, r)).max()
        tried = shifted(one, largest - 1e-9)
        if largest < most + 1e-3 or tried is None:
            continue
        s, found = replace(s, constraints=(tried,)), found + 1
        boxes = EveryLevel(s, third_derivatives(s, 1e-3, [17]))
        assert boxes.bounds(box_about(boxes, s, x, r)[None], 0.0)[2][0] != OPEN
    assert found > 2


def test_limits_of_sums_count() -> None:
    """q of a sum coordinate at its ends, from both sides: a box is empty, or not, to 1e-8."""
    s = with_sums(free_of_constraints(chance(np.random.default_rng(8), "ttt")))
    joints, x = s.joints, np.array([0.3, 0.4, 0.5])
    r = np.array([0.02, 0.03, 0.04])
    q, reach = s.mix @ x, np.abs(s.mix) @ r
    for i in range(3):
        for side in (-1.0, 1.0):
            for gap in (-1e-8, 1e-8):
                lower, upper = q - 9.0, q + 9.0
                if side > 0.0:
                    lower[i] = q[i] + reach[i] + gap
                else:
                    upper[i] = q[i] - reach[i] - gap
                limited = replace(
                    s,
                    joints=replace(joints, lower=lower, upper=upper),
                    root=np.array([x - 1.0, x + 1.0]),
                    limited=np.ones(3, dtype=bool),
                )
                boxes = EveryLevel(limited, no_tables(s))
                kinds = boxes.bounds(box_about(boxes, limited, x, r)[None], 0.0)[2]
                assert (kinds[0] == OPEN) == (gap > 0.0)


def test_multipliers_of_limits() -> None:
    """What sums leave of a box is below its bound, which is mostly lower than without limits."""
    rng, helped = np.random.default_rng(26), 0
    for seed in range(12):
        s = with_sums(free_of_constraints(chance(np.random.default_rng(seed), "tt")))
        x, r = s.root.mean(axis=0), np.array([0.1, 0.1])
        q, third = s.mix @ x, third_derivatives(s, 1e-3, [12, 12])
        for lower, upper in ((q - 2.5, q), (q, q + 2.5)):
            joints = replace(s.joints, lower=lower, upper=upper)
            t = replace(s, joints=joints, root=np.array([x - 1.0, x + 1.0]))
            limited = replace(t, limited=np.array([False, True]))
            here = x + steps(rng, r)
            allowed = (within(limited, here)[:, [1, 3]] >= 0.0).all(axis=1)
            box = box_about(EveryLevel(t, third), t, x, r)[None]
            bound = EveryLevel(limited, third).bounds(box, 0.0)[0][0]
            assert sensitivity(t, here)[allowed].max() <= bound
            helped += bound < 0.999 * EveryLevel(t, third).bounds(box, 0.0)[0][0]
    assert helped > 5


@pytest.mark.parametrize("load", ["steady", "cone", "plane"])
@pytest.mark.parametrize("c", range(4))
def test_multipliers_of_constraints(c: int, load: str) -> None:
    """What is feasible is below the bound, on either side of the constraint; mostly they help."""
    s = one_constraint(chance(np.random.default_rng(30 + c), "st", load), c)
    third = third_derivatives(s, 1e-3, [4, 17])
    rng, helped, seen = np.random.default_rng(6), 0, []
    for k in range(8):
        x = s.root.mean(axis=0) + rng.uniform(-0.5, 0.5, 2)
        r = (0.03, 0.2)[k % 2] * rng.uniform(0.5, 1.0, 2)
        here = x + steps(rng, r)
        one = shifted(s.constraints[0], margins(s, here)[rng.integers(4, len(here)), 0])
        if one is None:
            continue
        for sign in (1.0, -1.0):
            if isinstance(one, PointByDistance):
                flipped = replace(one, sign=int(one.sign * sign))
            else:
                flipped = replace(one, normal=sign * one.normal, offset=sign * one.offset)
            t = replace(s, constraints=(flipped,))
            allowed = margins(t, here)[:, 0] >= 0.0
            if not allowed.any():
                continue
            d, none = sensitivity(t, here), replace(third, constraints=third.constraints[:0])
            every = EveryLevel(free_of_constraints(s), none)
            boxes = EveryLevel(t, third)
            box = box_about(boxes, s, x, r)
            alone, bound = (least_aim(one, box, 1e5 * d.max(), 1e-8) for one in (every, boxes))
            assert d[allowed].max() * (1.0 - 1e-9) <= bound <= alone * (1.0 + 1e-7)
            helped += bound < 0.999 * alone
            seen.append(d[allowed].max() / bound)
            if load != "steady":
                continue
            others = x + rng.uniform(-0.3, 0.3, (4, 2))  # side by side with what is cut otherwise
            stack = np.array([box, *(box_about(boxes, s, other, r) for other in others)])
            bounds, _, kinds = boxes.bounds(stack, 0.0)
            for other, most, kind in zip(others, bounds[1:], kinds[1:], strict=True):
                there = other + steps(rng, r, 50)
                there = there[margins(t, there)[:, 0] >= 0.0]
                assert not len(there) or kind != OPEN
                assert not len(there) or sensitivity(t, there).max() <= most
    assert helped > 1
    assert max(seen) > 0.95


def test_multipliers_take_the_rest_along() -> None:
    """d depends on a slide alone; how far that may go a circle says, in a corner by third order."""
    s = many_springs(np.random.default_rng(3), "st", "steady", each=3)
    along, (z, x), origin = np.array([1.0, 0.0, 0.0]), (0.1, 0.6), np.zeros(3)
    on_base = np.arange(9) < 3
    s = replace(
        s,
        joints=replace(s.joints, axis=np.array([along, along]), point=np.zeros((2, 3))),
        springs=replace(s.springs, slides=np.zeros(9, dtype=bool)),
        markers=origin[None],
        load=SteadyLoad(origin, along, origin),
        V=(np.random.default_rng(1).normal(size=9) * on_base)[:, None],
    )
    one = PointByDistance(
        "radius", np.array([0.0, 1.0, 0.0]), np.array([4.0, 2.0, 0.0]), np.array([1, 1, 0]), 1, 0.0
    )
    r, center = np.array([0.1, 0.5]), np.array([z, x])
    d = sensitivity(s, np.array([center + r, center - r]))
    if d[0] < d[1]:  # it is to rise with the slide
        s = replace(s, load=replace(s.load, force=along), V=s.V[:, [0]])
    t = replace(s, constraints=(one,))
    tried = shifted(one, margins(t, (center + r)[None])[0, 0] - 1e-9)
    assert tried is not None
    t = replace(s, constraints=(tried,))
    h = steps(np.random.default_rng(0), r)
    d = sensitivity(t, center + h)[margins(t, center + h)[:, 0] >= 0.0].max()
    box = box_about(EveryLevel(t, no_tables(t)), t, center, r)[None]
    assert d <= EveryLevel(t, third_derivatives(t, 1e-3, [4, 33])).bounds(box, 0.0)[0][0]
    assert d > EveryLevel(t, no_tables(t)).bounds(box, 0.0)[0][0] * 1.001


def test_a_constraint_never_pulls_the_wrong_way() -> None:
    """Where d rises into what is feasible a constraint takes nothing off."""
    for seed in range(20):
        s = one_constraint(chance(np.random.default_rng(seed), "s"), 0)
        third = third_derivatives(s, 1e-3, [4])
        x, r = s.root.mean(axis=0), np.array([0.3])
        ends = np.array([x - r, x + r])
        d, g = sensitivity(s, ends), margins(s, ends)[:, 0]
        if (d[1] > d[0]) != (g[1] > g[0]) or d.max() < 1.1 * d.min():
            continue
        t = replace(s, constraints=(shifted(s.constraints[0], g.mean()),))
        bound = EveryLevel(t, third).bounds(box_about(EveryLevel(t, third), t, x, r)[None], 0.0)
        assert bound[0][0] >= d.max()


def test_the_largest_of_a_quadratic() -> None:
    """Squares of distances of what slides, convex and not: against corners, faces and a grid."""
    rng = np.random.default_rng(9)
    s = one_constraint(chance(rng, "sss"), 2)
    tight, inside = [], 0
    for k in range(24):
        sign = 1 if k % 2 else -1
        weights = rng.uniform(0.0, 1.0, 3)
        one = PointByDistance("range", rng.normal(size=3), rng.normal(size=3), weights, sign, 50.0)
        s = replace(s, constraints=(one,))
        x, r = s.root.mean(axis=0), 10.0 ** rng.uniform(-2.0, 0.0, 3)
        r[rng.integers(3)] *= 1e-6 if k % 3 else 1.0
        g, G, H = derivatives(constraint_series(s)[0], x)
        most = g[0] + largest_quadratic(G[:, 0], H[:, :, 0], r)
        here = margins(s, x + steps(rng, r, 1500))[:, 0]
        inside += not (here[:8].max() >= here.max())
        assert here.max() <= most + 1e-9
        tight.append((here.max() - g[0]) / (most - g[0]))
        for by, empty in ((most + 2e-6, True), (most - 2e-6, False)):
            tried = shifted(one, by)
            if tried is None:
                continue
            boxes = EveryLevel(replace(s, constraints=(tried,)), no_tables(s))
            kinds = boxes.bounds(box_about(boxes, s, x, r)[None], 0.0)[2]
            assert (kinds[0] == OPEN) == empty
    assert max(tight) > 0.99
    assert inside


# Peaks that only the rest of third order covers.

MANY = 1000 if os.environ.get("ELASTOCAL_FULL") else 20


def test_claims_below_sharp_peaks_are_refused_by_large_boxes() -> None:
    """V, of no design, makes d at a point as large as it can be against its mean elsewhere."""
    rng = np.random.default_rng(10)
    seen: list[float] = []
    flat: list[float] = []
    for k in range(MANY):
        load = ("steady", "moment", "plane", "free")[k % 4]
        wide = many_springs(rng, "tt" if k % 3 else "ts", load, each=6)
        s, c, columns = wide, len(wide.springs), columns_of(wide)
        x = s.root.mean(axis=0) + rng.uniform(-0.4, 0.4, 2)
        around = s.root[0] + (s.root[1] - s.root[0]) * rng.uniform(size=(150, 2))

        def forms(points: Array, wide: Statement = wide, c: int = c, k: int = columns) -> Array:
            each = rows(wide, points).reshape(len(points), -1, c, k)
            return np.einsum("nrck,nrdk->cd", each, each) / len(points)

        mean = forms(around) + 1e-9 * np.eye(c) * np.trace(forms(around))
        root = np.linalg.cholesky(mean)
        top = np.linalg.eigh(np.linalg.solve(root, np.linalg.solve(root, forms(x[None])).T))[1][
            :, -1
        ]
        V = np.linalg.solve(root.T, top)
        s = replace(s, V=V[:, None])
        boxes = EveryLevel(s, third_derivatives(s, 1e-3, [8, 4 if k % 3 == 0 else 8]))
        d = sensitivity(s, x[None])[0]
        for r in (0.3, 0.6, 1.0):
            away = x + r * rng.choice([-1.0, 1.0], 2) * rng.uniform(0.7, 1.0, 2)
            box = box_about(boxes, s, away, np.full(2, r))
            for share in (0.5, 0.9, 0.99):
                assert boxes.bounds(box[None], share * d)[2][0] != LEAF
            if columns == 1:
                seen.append(d / boxes.bounds(box[None], 0.0)[0][0])
            flat.append(sensitivity(s, away[None])[0] / d)
    assert max(seen) <= 1.0 + 1e-9
    assert max(seen) > 0.2
    assert np.mean(np.array(flat) < 0.5) > 0.25


# Searches and their trees.


@cache
def searched() -> tuple[Statement, Thirds, float]:
    """Two sum coordinates with limits, a slide and a constraint; the largest d that points have."""
    s = with_sums(chance(np.random.default_rng(14), "tts", "steady", columns=1))
    s = replace(one_constraint(s, 0), limited=np.array([False, True, False]))
    low, high = s.joints.lower, s.joints.upper
    root = np.array([low, high])
    root[:, 1] += root[:, 0] if s.mix[1, 0] < 0 else -root[::-1, 0]
    s = replace(s, root=root)
    x = feasible_points(s, 20000)
    return s, third_derivatives(s, 1e-3, [12, 12, 4]), float(sensitivity(s, x).max())


def feasible_points(s: Statement, count: int) -> Array:
    """Points by chance, many of them at limits, that the statement allows."""
    rng = np.random.default_rng(15)
    q = rng.uniform(-0.2, 1.2, (count, len(s.joints))).clip(0.0, 1.0)
    q = s.joints.lower + (s.joints.upper - s.joints.lower) * q
    x = np.linalg.solve(s.mix, q.T).T
    return np.asarray(x[(margins(s, x) >= 0.0).all(axis=1)])


def volume(symbols: bytes, a: int) -> Fraction:
    """What the leaves of a tree have of its root."""
    depths, at, total = [0], 0, Fraction(0)
    while depths:
        depth, symbol = depths.pop(), symbols[at]
        at += 1
        assert symbol < a or symbol >= PENDING
        if symbol < PENDING:
            depths += [depth + 1, depth + 1]
        else:
            total += Fraction(1, 2**depth)
    assert at == len(symbols)
    return total


def test_trees_cover_their_root_and_hold_what_is_feasible() -> None:
    s, third, largest = searched()
    boxes = EveryLevel(s, third)
    claim = 1.05 * largest
    root = divided(boxes, claim, 40)
    search = Branching(boxes, root, 2)
    assert search.prove(claim, lambda: False)
    assert 0.9 * largest <= search.best <= search.proved <= claim
    symbols = symbols_of(root)
    assert is_complete(symbols)
    assert volume(symbols, 3) == 1
    whole = boxes.search(boxes.root, claim, 1 << 20)
    assert whole.largest <= claim
    assert volume(whole.symbols, 3) == 1
    x = feasible_points(s, 1500)
    assert (np.abs(within(s, x)).min(axis=1) < 1e-12).sum() > 300
    d, leaves = sensitivity(s, x), []
    for u in boxes.in_root(x):
        found, alone = leaf_at(boxes, root, u), boxes.leaf(whole.symbols, boxes.root, u)[1]
        assert found is not None
        box, symbol = found
        assert symbol == LEAF
        assert (np.abs(u - box[:3]) <= box[3:] * (1.0 + 1e-9)).all()
        leaves += [box, alone]
    bounds, _, kinds = boxes.bounds(np.array(leaves), claim)
    assert (kinds == LEAF).all()
    assert (bounds >= np.repeat(d, 2) * (1.0 - 1e-12)).all()


@pytest.mark.parametrize("share", [0.5, 0.9, 0.99, 0.999])
def test_false_claims_stay_open(share: float) -> None:
    s, third, largest = searched()
    boxes = EveryLevel(s, third)
    found = boxes.search(boxes.root, share * largest, 4000)
    assert len(found.left) or found.open
    assert not is_complete(found.symbols)
    assert volume(found.symbols, 3) == 1
    assert found.symbols.count(PENDING) == len(found.left)
    assert found.symbols.count(OPEN) == found.open
    part = Region(boxes.root)
    assert proved(part) == np.inf


@pytest.mark.parametrize("load", ["steady", "plane"])
def test_smallest_boxes_stay_open(load: str) -> None:
    s = free_of_constraints(chance(np.random.default_rng(16), "t", load))
    boxes = EveryLevel(s, third_derivatives(s, 1e-3, [16]))
    x = np.linspace(*s.root, 20001)
    largest = float(sensitivity(s, x).max())
    false = boxes.search(boxes.root, 0.9999 * largest, 1 << 20)
    assert not len(false.left)
    assert false.open == false.symbols.count(OPEN) > 0
    assert false.largest >= largest
    true = boxes.search(boxes.root, 1.0001 * largest, 1 << 20)
    assert not true.open
    assert is_complete(true.symbols)
    assert 0.99 * largest < true.best <= largest * (1.0 + 1e-9)
    assert largest <= true.largest <= 1.0001 * largest
    centre = 1.001 * boxes.bounds(boxes.root[None], np.inf)[1][0]
    assert centre > 0.999 * largest or boxes.search(boxes.root, centre, 1).symbols != bytes([LEAF])
    assert true.evaluated < 200
    assert SMALLEST < 1e-6


@pytest.mark.parametrize("most", [1, 2, 3, 7, 50])
def test_searches_that_end_early_leave_the_rest(most: int) -> None:
    """What is left, searched, has the same leaves as one search."""
    s, third, largest = searched()
    boxes = EveryLevel(s, third)
    whole = boxes.search(boxes.root, 1.1 * largest, 1 << 20)
    pieces, todo = [], [(boxes.search(boxes.root, 1.1 * largest, most), 0)]
    found, at = todo[0]
    parts = [boxes.search(box, 1.1 * largest, 1 << 20).symbols for box in found.left]
    for symbol in found.symbols:
        if symbol == PENDING:
            pieces.append(parts[at])
            at += 1
        else:
            pieces.append(bytes([symbol]))
    assert b"".join(pieces) == whole.symbols


# What is out of the ordinary.


def test_what_is_not_a_number_is_never_bounded() -> None:
    for load, bad in product(LOADS, (np.nan, np.inf, 1e155)):
        s = free_of_constraints(chance(np.random.default_rng(17), "tt", load))
        V = s.V.copy()
        V[0, 0] = bad
        with np.errstate(all="ignore"):
            boxes = EveryLevel(replace(s, V=V), no_tables(s))
            tables = no_tables(s)
            rows_table = tables.rows.copy()
            rows_table[0, 0, 0] = np.nan
            other = EveryLevel(s, replace(tables, rows=rows_table))
        for one in (boxes, other):
            box = one.root[None]
            assert one.bounds(box, 1e300)[2][0] != LEAF
            found = one.search(one.root, 1e300, 64)
            assert LEAF not in found.symbols


def test_constraints_that_are_no_numbers_exclude_nothing() -> None:
    s = one_constraint(chance(np.random.default_rng(18), "t"), 0)
    for one in (
        replace(s.constraints[0], offset=np.nan),
        replace(s.constraints[0], normal=np.full(3, np.nan)),
    ):
        boxes = EveryLevel(replace(s, constraints=(one,)), no_tables(s))
        assert boxes.bounds(boxes.root[None], 1e300)[2][0] != OPEN


@pytest.mark.parametrize("threshold", [0.0, -1.0, np.nan, -np.inf])
@pytest.mark.parametrize("load", LOADS)
def test_thresholds_that_nothing_is_below(load: str, threshold: float) -> None:
    s = free_of_constraints(chance(np.random.default_rng(19), "tt", load))
    boxes = EveryLevel(s, no_tables(s))
    assert boxes.bounds(boxes.root[None], threshold)[2][0] != LEAF
    assert LEAF not in boxes.search(boxes.root, threshold, 100).symbols


def test_no_joint_one_and_twelve() -> None:
    s = free_of_constraints(chance(np.random.default_rng(21), "tst"))
    still = replace(s, root=np.tile(s.root[0], (2, 1)))
    boxes, d = EveryLevel(still, no_tables(s)), sensitivity(s, s.root[:1])[0]
    assert boxes.bounds(boxes.root[None], 0.0)[1] == pytest.approx(d)
    assert boxes.search(boxes.root, d * (1.0 + 1e-6), 10).symbols == bytes([LEAF])
    assert boxes.search(boxes.root, d * (1.0 - 1e-6), 10).symbols == bytes([OPEN])
    assert not divided(boxes, 0.9 * d, 8).settled.symbols.strip(bytes([PENDING]))
    long = free_of_constraints(chance(np.random.default_rng(22), "tts" * 4, "moment"))
    boxes = EveryLevel(long, no_tables(long))
    x = boxes.statement_points(np.full((1, 12), 0.5))
    assert boxes.bounds(boxes.root[None], 0.0)[1] == pytest.approx(sensitivity(long, x))
    with pytest.raises(InputError, match="12"):
        EveryLevel(chance(np.random.default_rng(22), "t" * 13), no_tables(long))


def test_as_many_constraints_as_there_may_be() -> None:
    """The last of them counts, with the limits of sums behind it; one more is refused."""
    s = with_sums(one_constraint(chance(np.random.default_rng(23), "tt"), 0))
    loose = replace(s.constraints[0], offset=-99.0)
    never = replace(s.constraints[0], offset=99.0)
    for last, empty in ((loose, False), (never, True)):
        t = replace(s, constraints=(loose,) * 63 + (last,), limited=np.array([False, True]))
        t = replace(t, root=t.root + np.array([[0.0, -3.0], [0.0, 3.0]]))
        boxes = EveryLevel(t, no_tables(t))
        middle = np.concatenate([np.full(2, 0.5), np.full(2, 1e-3)])
        assert (boxes.bounds(middle[None], 0.0)[2][0] == OPEN) == empty
    with pytest.raises(InputError, match="64"):
        EveryLevel(replace(t, constraints=(loose,) * 65), no_tables(t))


def test_coordinates_that_skip_a_joint_are_refused() -> None:
    s = chance(np.random.default_rng(24), "ttt")
    mix = np.eye(3)
    mix[2, 0] = -1.0
    with pytest.raises(InputError, match="follow"):
        EveryLevel(replace(s, mix=mix), no_tables(s))


def test_threads_find_the_same() -> None:
    s, third, largest = searched()
    boxes = EveryLevel(s, third)
    found: list[bytes] = []

    def work() -> None:
        found.append(boxes.search(boxes.root, 1.05 * largest, 3000).symbols)

    threads = [Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4
    assert len(set(found)) == 1


def test_parts_that_are_not_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is claimed of a tree is the worst of its parts, and nothing if one is not known."""
    s, third, largest = searched()
    boxes = EveryLevel(s, third)
    root = divided(boxes, 1.2 * largest, 30)
    monkeypatch.setattr(branching, "_SLICE", 1)  # so that parts have parts
    search = Branching(boxes, root, 1)
    assert search.proved == np.inf
    assert (
        not Branching(boxes, root, 1).prove(1.2 * largest, lambda: True) or search.proved < np.inf
    )
    assert search.prove(1.2 * largest, lambda: False)
    first = search.proved
    assert largest <= first <= 1.2 * largest
    assert root.settled is not None
    for part in root.settled.parts:
        assert part.settled is not None
        assert volume(symbols_of(part), 3) == 1
    # A claim that is false is refused, and what was proved stays.
    assert not search.prove(0.9 * largest, ends_after(0.3))
    assert largest <= search.proved <= first
    # A part of which nothing is known spoils it all.
    root.settled.parts[-1].settled = None
    assert search.proved == np.inf


def ends_after(seconds: float) -> Callable[[], bool]:
    end = time.monotonic() + seconds
    return lambda: time.monotonic() > end


def test_held_variables_take_their_tables_along() -> None:
    """The first variable held: third derivatives are those of the others."""
    s = free_of_constraints(chance(np.random.default_rng(25), "ttt"))
    root = s.root.copy()
    root[1, 0] = root[0, 0]
    s = replace(s, root=root)
    third = third_derivatives(s, 1e-3, [9, 9, 9])
    boxes, x = EveryLevel(s, third), np.array([root[0, 0], *s.root[:, 1:].mean(axis=0)])
    r = np.array([0.0, 0.5, 0.7])
    B, B1, B2 = derivatives(rows_series(s), x)
    b1, b2 = r @ np.linalg.norm(B1, axis=1), 0.5 * r @ np.linalg.norm(B2, axis=2) @ r
    G, H = 2.0 * B1 @ B, 2.0 * (B1 @ B1.T + B2 @ B)
    quadratic = largest_quadratic(G[1:], H[1:, 1:], r[1:])
    expected = np.sqrt(B @ B + quadratic + 2.0 * b1 * b2 + b2**2) + rest_of(third.rows, r)
    bound = boxes.bounds(box_about(boxes, s, x, r)[None], 0.0)[0]
    assert bound == pytest.approx(expected**2, rel=1e-9)


def test_a_witness_against_a_proof_ends_it() -> None:
    """All boxes found to be empty; a bound below what is known; nothing that is known."""
    s, third, largest = searched()
    claim = 1.1 * largest
    x = feasible_points(s, 300)
    x = x[(within(s, x) >= 0.0).all(axis=1)]
    d, none = sensitivity(s, x), np.zeros(0)
    boxes = EveryLevel(s, third)
    root = divided(boxes, claim, 16)
    assert Branching(boxes, root, 1).prove(claim, lambda: False)
    prove._try(s, boxes, root, x, d, claim)
    with pytest.raises(ProofError, match="at most"):
        prove._try(s, boxes, root, x, d, 0.99 * d.max())
    with pytest.raises(ProofError, match="no load case"):
        prove._try(s, boxes, root, x[:0], none, claim)
    never = replace(s, constraints=(shifted(s.constraints[0], 99.0),))
    wrong = EveryLevel(never, third)
    empty = divided(wrong, claim, 16)
    assert Branching(wrong, empty, 1).proved == 0.0
    with pytest.raises(ProofError, match="empty"):
        prove._try(s, wrong, empty, x, d, claim)
