"""The tree of boxes of a proof, in parts that are searched one by one and may be searched again.

A part is a box; its tree is a byte a box in depth-first order: the variable that is halved, LEAF
for what is done, PENDING for a further part. So a tree and those of its parts are one tree.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.core.layout import LEAF, OPEN, PENDING
from elastocal.proof.boxes import Boxes, BoxSearch


@dataclass(frozen=True)
class BoxTree:
    """A search of a part.

    Attributes:
        largest: Bound of d over the leaves that it came to.
        symbols: Its boxes.
        parts: Those it did not come to, in the order of their symbols.
    """

    largest: float
    symbols: bytes
    parts: tuple[Region, ...]


class Region:
    """A box that is searched, with what is known of it so far.

    Attributes:
        box: (2a,) centre and half-widths in [0, 1].
        settled: What is known of it; None: nothing.
        current: What a search finds that goes on; None: there is none.
    """

    def __init__(self, box: Array, settled: BoxTree | None = None) -> None:
        self.box, self.settled = box, settled
        self.current: BoxTree | None = None


def proved(part: Region) -> float:
    """No feasible point of the part has a larger d; infinite as long as nothing is known."""
    return min(_of(part.settled), _of(part.current))


def _of(tree: BoxTree | None) -> float:
    if tree is None:
        return np.inf
    return max([tree.largest, *(proved(part) for part in tree.parts)])


def settle(part: Region) -> None:
    """Keep the better of what was known and what the search that has ended found."""
    for tree in (part.settled, part.current):
        for inner in () if tree is None else tree.parts:
            settle(inner)
    if part.current is not None and _of(part.current) <= _of(part.settled):
        part.settled = part.current
    part.current = None


def unproved(part: Region, threshold: float) -> Iterator[Region]:
    """Parts to be searched, so that d is at most the threshold everywhere."""
    if part.settled is None or part.settled.largest > threshold:
        yield part
        return
    for inner in part.settled.parts:
        yield from unproved(inner, threshold)


def take(part: Region, found: BoxSearch) -> tuple[Region, ...]:
    """Put what a search of a part found into it; the parts that it left."""
    parts = tuple(Region(box) for box in found.left)
    part.current = BoxTree(found.largest, found.symbols, parts)
    return parts


def symbols_of(part: Region) -> bytes:
    """The tree of a part with those of its parts in it; PENDING where nothing is known."""
    if part.settled is None:
        return bytes([PENDING])
    if not part.settled.parts:
        return part.settled.symbols
    return joined(part.settled.symbols, [symbols_of(p) for p in part.settled.parts])


def joined(symbols: bytes, parts: Sequence[bytes]) -> bytes:
    """A tree with those of its parts in it, in the order of their symbols."""
    pieces = symbols.split(bytes([PENDING]))
    return b"".join(piece for pair in zip(pieces, [*parts, b""], strict=True) for piece in pair)


def is_complete(symbols: bytes) -> bool:
    """Whether no box of a tree was left."""
    return bytes([PENDING]) not in symbols and bytes([OPEN]) not in symbols


def halves(box: Array, k: int) -> tuple[Array, Array]:
    """The lower and the upper half, (2a,) each, of a box halved in variable k."""
    lower = box.copy()
    lower[len(box) // 2 + k] *= 0.5
    upper = lower.copy()
    lower[k] -= lower[len(box) // 2 + k]
    upper[k] += upper[len(box) // 2 + k]
    return lower, upper


def divided(boxes: Boxes, aim: float, parts: int) -> Region:
    """The root, halved until there are about so many parts; what is empty is done.

    Args:
        boxes: The statement.
        aim: Boxes with a bound below it are not halved.
        parts: How many parts there are to be.
    """
    everything = boxes.root[None]
    symbol, child, where = [PENDING], [-1], [everything[0]]
    level = [0]
    while level and len(level) < parts:
        _, _, splits = boxes.bounds(np.array([where[node] for node in level]), aim)
        following: list[int] = []
        for node, k in zip(level, splits.tolist(), strict=True):
            if k == OPEN:  # no point of it is feasible
                symbol[node] = LEAF
                continue
            if k in (LEAF, PENDING):
                continue
            symbol[node], child[node] = k, len(symbol)
            for box in halves(where[node], k):
                following.append(len(symbol))
                symbol.append(PENDING)
                child.append(-1)
                where.append(box)
        level = following
    order, way = [], [0]
    while way:
        node = way.pop()
        order.append(node)
        if symbol[node] < PENDING:
            way += [child[node] + 1, child[node]]
    left = tuple(Region(where[node]) for node in order if symbol[node] == PENDING)
    return Region(everything[0], BoxTree(0.0, bytes(symbol[node] for node in order), left))


def leaf_at(boxes: Boxes, part: Region, point: Array) -> tuple[Array, int] | None:
    """The leaf that a point, (a,) of [0, 1], is in.

    Returns:
        Its box and its symbol; None where nothing is known.
    """
    tree = part.settled
    if tree is None:
        return None
    at, box = boxes.leaf(tree.symbols, part.box, point)
    if at < 0:
        return None
    symbol = tree.symbols[at]
    if symbol != PENDING:
        return box, symbol
    return leaf_at(boxes, tree.parts[tree.symbols.count(bytes([PENDING]), 0, at)], point)
