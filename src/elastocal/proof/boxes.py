"""Boxes of a statement in compiled code: bounds of d over them, and searches that halve them.

A box is (2a,) numbers of [0, 1]: centre and half-widths of the a variables of a statement that the
core moves; x = lower + (upper - lower) u over the root.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.core import layout
from elastocal.core.layout import Int, Memory, PlainCondition, PlainOutcome, PlainStatement, address
from elastocal.core.library import Library
from elastocal.errors import InputError
from elastocal.proof.folded import Folded, folded
from elastocal.proof.statement import (
    DirectionOverPlane,
    InCone,
    PointByDistance,
    ProofConstraint,
    Statement,
    SteadyLoad,
)
from elastocal.proof.trigonometric import Thirds

SMALLEST = 1e-7
"""Half-width of boxes that are not halved any more [rad or m]."""
_LARGEST_TREE = 1 << 22  # boxes of one search
_MOST_LEFT = 1 << 14  # boxes that one search leaves


@dataclass(frozen=True)
class BoxSearch:
    """What a search of one box found.

    Attributes:
        symbols: The tree in depth-first order: see `Statement`'s record.
        left: (L, 2a) boxes that it did not come to, in the order of their symbols.
        evaluated: Boxes that were looked at.
        open: Boxes that are too small to be halved and not bounded.
        largest: Bound of d over all boxes that it came to.
        best: Largest d at a feasible centre; -1 if none was met.
        at: (a,) where that was [rad or m].
    """

    symbols: bytes
    left: Array
    evaluated: int
    open: int
    largest: float
    best: float
    at: Array


class Boxes:
    """A statement with its tables, compiled.

    Attributes:
        variables: (a,) which variables of the statement boxes have.
    """

    def __init__(self, library: Library, statement: Statement, third: Thirds) -> None:
        """Tables are those of the statement.

        Raises:
            InputError: the core has no room for so many joints or constraints.
        """
        self._memory, self._statement = Memory(), statement
        arm = folded(statement)
        self.variables = arm.variables
        self._plain = _plain(statement, arm, third, self._memory)
        self._bound, self._search, self._leaf = (
            library.function(name) for name in ("bound", "search", "leaf")
        )
        for name in ("bound", "search", "leaf"):
            function = getattr(self, f"_{name}")
            function.argtypes, function.restype = layout.SIGNATURES[name], Int

    @property
    def root(self) -> Array:
        """(2a,) the whole of it."""
        return np.full(2 * len(self.variables), 0.5)

    def in_root(self, x: Array) -> Array:
        """(N, a) of [0, 1] for points (N, n) of the statement."""
        lower, upper = self._statement.root[:, self.variables]
        width = np.where(upper > lower, upper - lower, 1.0)
        return np.asarray(np.clip((x[:, self.variables] - lower) / width, 0.0, 1.0))

    def statement_points(self, u: Array) -> Array:
        """(N, n) points of the statement for (N, a) of [0, 1]."""
        lower, upper = self._statement.root[:, self.variables]
        x = np.tile(self._statement.root[0], (len(u), 1))
        x[:, self.variables] = lower + (upper - lower) * u
        return x

    def bounds(self, boxes: Array, aim: float) -> tuple[Array, Array, IntArray]:
        """Bounds of d over N boxes, (N, 2a).

        Returns:
            (N,) bounds, infinite where there is none; (N,) d at the centres; (N,) the variable to
            be halved, `layout.LEAF` if the bound is at most `aim`, `layout.OPEN` if no point of
            the box is feasible, `layout.PENDING` if there is no variable.
        """
        boxes = np.ascontiguousarray(boxes, dtype=float)
        bounds, values = np.zeros(len(boxes)), np.zeros(len(boxes))
        splits = np.zeros(len(boxes), dtype=np.int64)
        tables = [address(table) for table in (bounds, values, splits)]
        _checked(self._bound(self._at, len(boxes), address(boxes), aim, *tables))
        return bounds, values, splits

    def search(self, box: Array, threshold: float, most: int) -> BoxSearch:
        """Halve a box, (2a,), until d is below `threshold` in all parts; `most` evaluations."""
        box = np.ascontiguousarray(box, dtype=float)
        symbols = np.empty(min(2 * most + 64, _LARGEST_TREE), dtype=np.uint8)
        left = np.empty((_MOST_LEFT, len(box)))
        out = PlainOutcome()
        most = min(most, len(symbols) // 2 - 16)
        _checked(
            self._search(
                self._at,
                address(box),
                threshold,
                SMALLEST,
                most,
                address(symbols),
                len(symbols),
                address(left),
                len(left),
                ctypes.addressof(out),
            )
        )
        return BoxSearch(
            symbols=symbols[: out.symbols].tobytes(),
            left=left[: out.pending].copy(),
            evaluated=out.evaluated,
            open=out.open,
            largest=out.largest,
            best=out.best,
            at=frozen(list(out.at)[: len(self.variables)]),
        )

    def leaf(self, symbols: bytes, box: Array, point: Array) -> tuple[int, Array]:
        """The leaf of the tree of a box that a point, (a,) of [0, 1], is in.

        Returns:
            Number of its symbol, -1 if the tree ends before; its box (2a,).
        """
        box, point = np.array(box, dtype=float), np.ascontiguousarray(point, dtype=float)
        tree = np.frombuffer(symbols, dtype=np.uint8)
        found = self._leaf(len(point), address(tree), len(tree), address(point), address(box))
        return int(found), box

    @property
    def _at(self) -> int:
        return ctypes.addressof(self._plain)


def _checked(answer: int) -> None:
    if answer == -1:
        raise MemoryError
    assert answer == 0, "a search left more boxes than there is room for"


def _plain(s: Statement, arm: Folded, third: Thirds, memory: Memory) -> PlainStatement:
    if len(arm.axis) > layout.MOST_JOINTS or len(s.constraints) > layout.MOST_CONDITIONS:
        raise InputError(
            f"proofs are for at most {layout.MOST_JOINTS} joints that count and "
            f"{layout.MOST_CONDITIONS} constraints, found {len(arm.axis)} and {len(s.constraints)}"
        )
    load, directions = s.load, s.directions
    moment = load.moment if isinstance(load, SteadyLoad) else np.zeros(3)
    if directions is None:
        assert isinstance(load, SteadyLoad)
        directions = load.force[:, None]
    cone = load if isinstance(load, InCone) and load.half_angle < np.pi / 2.0 else None
    point = arm.placed(load.point)
    markers = [arm.placed(marker) for marker in s.markers]
    loaded = [m for m, marker in enumerate(markers) if np.array_equal(marker, point)]
    forms = directions.shape[1]
    return PlainStatement(
        joints=len(arm.axis),
        axes=memory.reals(arm.axis),
        points=memory.reals(arm.point),
        slides=memory.integers(arm.slides),
        links=memory.reals(arm.links),
        starts=memory.reals(arm.starts),
        least=memory.reals(arm.least),
        most=memory.reals(arm.most),
        springs=len(arm.bodies),
        bodies=memory.integers(arm.bodies),
        slide=memory.integers(arm.spring_slides),
        spring_axes=memory.reals(arm.spring_axis),
        spring_points=memory.reals(arm.spring_point),
        values=memory.reals(arm.values / s.sigma),
        rank=arm.values.shape[1],
        markers=len(markers),
        marker=memory.reals(markers if markers else [0.0]),
        turning=0.0 if s.sigma_turn is None else s.sigma / s.sigma_turn,
        load_point=tuple(point),
        loaded=loaded[0] if loaded else -1,
        forms=forms,
        forces=memory.reals(directions.T),
        moments=memory.reals(np.tile(moment, (forms, 1))),
        twisting=int(bool(moment.any())),
        cone=int(cone is not None),
        cone_axis=(0.0, 0.0, 0.0) if cone is None else tuple(cone.axis),
        cone_cosine=0.0 if cone is None else float(np.cos(cone.half_angle)),
        conditions=len(s.constraints),
        condition=memory.structures(_conditions(s.constraints, arm, third.constraints, memory)),
        third=memory.reals(_of(third.rows, arm)),
        lower=memory.reals(s.root[0, arm.variables]),
        upper=memory.reals(s.root[1, arm.variables]),
    )


def _conditions(
    constraints: Sequence[ProofConstraint], arm: Folded, third: Array, memory: Memory
) -> list[PlainCondition]:
    found = []
    for constraint, table in zip(constraints, third, strict=True):
        if isinstance(constraint, DirectionOverPlane):
            kind, point = 1, arm.turned(constraint.axis)
        else:
            kind, point = 0, arm.placed(constraint.point)
        plain = PlainCondition(
            kind=kind, point=tuple(point), sign=1.0, third=memory.reals(_of(table, arm))
        )
        if isinstance(constraint, PointByDistance):
            plain.kind, plain.sign = 2, float(constraint.sign)
            plain.normal, plain.weights = tuple(constraint.center), tuple(constraint.weights)
            plain.offset = constraint.sign * constraint.bound**2
        else:
            plain.normal, plain.offset = tuple(constraint.normal), constraint.offset
        found.append(plain)
    return found


def _of(table: Array, arm: Folded) -> Array:
    """(a, a, a) what a table says of the joints that move."""
    return table[np.ix_(arm.variables, arm.variables, arm.variables)]
