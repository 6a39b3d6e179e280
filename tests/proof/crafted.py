"""Statements whose V is chosen so that B and its derivatives at a point are what a test asks for.

Only there a single term of a bound stands alone, and shows whether it is as large as it must be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.core.layout import OPEN
from elastocal.core.library import levels
from elastocal.proof.boxes import Boxes, BoxSearch
from elastocal.proof.series import rows_series
from elastocal.proof.statement import CarriedSprings, ChainJoints, Statement
from elastocal.proof.trigonometric import Thirds
from tests.proof.statements import load_of, unit

Given = tuple[tuple[int, ...], Array]
"""Variables by which B is differentiated, and what comes out."""


def many_springs(
    rng: np.random.Generator, kinds: str, load: str, *, each: int = 14, markers: int = 1
) -> Statement:
    """A chain with so many springs on every body, each of them unknown."""
    n = len(kinds)
    c = each * (n + 1)
    lower = np.array([-1.0 if kind == "s" else -3.0 for kind in kinds])
    return Statement(
        name="crafted",
        criterion="test-pose",
        study_sha256="0" * 64,
        version="0",
        joints=ChainJoints(
            tuple(f"J{i}" for i in range(n)),
            np.array([kind == "s" for kind in kinds]),
            unit(rng, n),
            rng.normal(size=(n, 3)),
            lower,
            -lower,
        ),
        springs=CarriedSprings(
            tuple(f"S{j}" for j in range(c)),
            rng.random(c) < 0.2,
            np.repeat(np.arange(n + 1), each),
            unit(rng, c),
            rng.normal(size=(c, 3)),
        ),
        make=np.eye(c),
        unknowns=tuple(f"k{j}" for j in range(c)),
        markers=rng.normal(size=(markers, 3)),
        sigma=1.0,
        sigma_turn=None,
        load=load_of(load, rng),
        constraints=(),
        V=np.eye(c),
        K=np.ones((c, 1)),
        B=np.eye(c),
        count=1,
    )


class Derivatives:
    """B at x (n,) and its derivatives there as matrices that V is multiplied by."""

    def __init__(self, s: Statement, x: Array) -> None:
        self._s, self._x, self._series = s, x, rows_series(s)

    def by(self, *variables: int) -> Array:
        """(rows k, c) of the derivative by these variables; rows of B first, then its columns."""
        place = self._series.variables.tolist()
        orders = [0] * len(place)
        for variable in variables:
            orders[place.index(variable)] += 1
        c, k = len(self._s.V), columns_of(self._s)
        each = self._series.at(self._x[None], orders).reshape(-1, c, k)
        return np.asarray(each.transpose(0, 2, 1).reshape(-1, c))


def columns_of(s: Statement) -> int:
    return 1 if s.directions is None else s.directions.shape[1]


def with_rows(s: Statement, x: Array, given: Sequence[Given]) -> Statement:
    """The statement with the one column V that makes derivatives of B at x (n,) what is given.

    Args:
        s: A statement of `many_springs`.
        x: Where.
        given: By which variables, and the derivative: (rows,), or (rows, k) for a free load; (1,)
            of all of them.
    """
    of, k = Derivatives(s, x), columns_of(s)
    left = [of.by(*variables) for variables, _ in given]
    right = [
        np.broadcast_to(value, (len(m) // k, k) if k > 1 else len(m)).ravel()
        for m, (_, value) in zip(left, given, strict=True)
    ]
    matrix, wanted = np.concatenate(left), np.concatenate(right)
    V = np.linalg.lstsq(matrix, wanted, rcond=1e-10)[0]
    assert np.abs(matrix @ V - wanted).max() < 1e-8, "it cannot be had"
    return replace(s, V=V[:, None])


def with_largest(s: Statement, silent: Array, loud: Array) -> Statement:
    """The statement with the one column V of silent V = 0 for which |loud V| is largest, and 1."""
    _, sizes, turned = np.linalg.svd(silent)
    nothing = turned[int((sizes > 1e-9 * sizes[0]).sum()) :].T
    V = nothing @ np.linalg.svd(loud @ nothing)[2][0]
    size = np.linalg.norm(loud @ V)
    assert size > 1e-6, "it cannot be had"
    return replace(s, V=V[:, None] / size)


def box_about(boxes: Boxes, s: Statement, x: Array, r: Array) -> Array:
    """(2a,) the box x ± r, both (n,), in [0, 1]."""
    lower, upper = s.root
    width = np.where(upper > lower, upper - lower, 1.0)
    return np.concatenate([(x - lower) / width, r / width])[
        np.concatenate([boxes.variables, boxes.variables + len(s.joints)])
    ]


def least_aim(boxes: Boxes, box: Array, high: float, to: float = 1e-11) -> float:
    """The least aim below which a box is found to be; of a steady load that is its bound."""
    low, bound = 0.0, float(boxes.bounds(box[None], high)[0][0])
    assert bound <= high
    if bound != high:
        return bound
    while high - low > to * high:
        middle = 0.5 * (low + high)
        if boxes.bounds(box[None], middle)[0][0] <= middle:
            high = middle
        else:
            low = middle
    return high


class EveryLevel(Boxes):
    """The boxes of a statement at all levels of instructions, which must say the same."""

    def __init__(self, statement: Statement, third: Thirds) -> None:
        first, *self._others = [Boxes(core, statement, third) for core in levels().values()]
        vars(self).update(vars(first))

    def bounds(self, boxes: Array, aim: float) -> tuple[Array, Array, IntArray]:
        bounds, values, splits = super().bounds(boxes, aim)
        for other in self._others:
            same = other.bounds(boxes, aim)
            np.testing.assert_array_equal(splits, same[2])
            for one, another in zip((bounds, values), same, strict=False):
                np.testing.assert_array_equal(one[splits != OPEN], another[splits != OPEN])
        return bounds, values, splits

    def search(self, box: Array, threshold: float, most: int) -> BoxSearch:
        found = super().search(box, threshold, most)
        if len(found.left) == 0:  # else it depends on how many boxes are looked at side by side
            for other in self._others:
                assert other.search(box, threshold, most).symbols == found.symbols
        return found


def no_tables(s: Statement) -> Thirds:
    """Tables that say nothing: for functions of second order, and for boxes without width."""
    n = len(s.joints)
    none = np.zeros((len(s.constraints), n, n, n))
    return Thirds(np.zeros((n, n, n)), none, np.zeros(n), 1.0)
