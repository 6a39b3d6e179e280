"""Which of many pairs of solids is nearest, for a batch of postures.

Three sieves, each for all postures at once but the last: balls around the solids, capsules and
boxes around them, and, where those are not all that is known of the solids, their faces, or coal
pair by pair. From a plane all have closed forms. What is farther than the horizon is not measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, NamedTuple
from uuid import uuid4

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, frozen
from elastocal.constraints.collision.coal_distance import PairDistance, Placements
from elastocal.constraints.collision.segments import (
    between_segments,
    segment_and_box,
    segment_and_plane,
)
from elastocal.constraints.collision.shell import Stack, parted, stacked
from elastocal.constraints.collision.solid import Solid
from elastocal.constraints.collision.support import largest, lowest
from elastocal.robot.posture import Posture


class NearestPairs(NamedTuple):
    """The nearest pair of each of N postures."""

    value: Array  # (N,) signed distance less its slack [m], at most the horizon
    pair: IntArray  # (N,) which pair, -1 where all are beyond the horizon
    distance: Array  # (N,) signed distance of that pair; the horizon where there is none
    first: Array  # (3, N) nearest point of its first solid, fixed to that solid's body
    second: Array  # (3, N) of its second
    normal: Array  # (3, N) unit vector along which the first one gets away; 0 if there is none


@dataclass(frozen=True)
class Pairs:
    """Pairs of solids that must not touch; the first moves, in a box or a plane is only a second.

    Attributes:
        solids: The S solids.
        index: (P, 2) which two of them.
    """

    solids: tuple[Solid, ...]
    index: tuple[tuple[int, int], ...]
    _coal: dict[int, PairDistance] = field(default_factory=dict, repr=False, compare=False)
    _key: str = field(default_factory=lambda: uuid4().hex, repr=False, compare=False)

    def __reduce__(self) -> tuple[Any, ...]:
        # What coal needs takes long to make: a process makes it once, however often it is told.
        return _known, (self._key, self.solids, self.index)

    @cached_property
    def first(self) -> IntArray:
        """(P,) the first of each pair."""
        return frozen([i for i, _ in self.index], np.int64)

    @cached_property
    def second(self) -> IntArray:
        """(P,) the second of each pair."""
        return frozen([j for _, j in self.index], np.int64)

    @cached_property
    def radius(self) -> Array:
        """(S,) radii of the capsules [m]."""
        return frozen([solid.radius for solid in self.solids])

    @cached_property
    def ball(self) -> Array:
        """(S,) radii of balls around the solids [m]."""
        return frozen([solid.ball for solid in self.solids])

    @cached_property
    def exact(self) -> BoolArray:
        """(S,) whether capsule or box is the solid itself, or all of it but faces."""
        return frozen([solid.exact for solid in self.solids], np.bool_)

    @cached_property
    def faced(self) -> BoolArray:
        """(P,) whether there are faces that may show more distance than capsules and boxes do."""
        faces = [len(solid.faces) > 0 for solid in self.solids]
        found = [(faces[i] or faces[j]) and bool(self.exact[[i, j]].all()) for i, j in self.index]
        return frozen(found, np.bool_)

    @cached_property
    def shells(self) -> Stack:
        """Faces and corners of the S solids."""
        return stacked([solid.shell for solid in self.solids])

    @cached_property
    def groups(self) -> list[tuple[IntArray, Solid | None]]:
        """Pairs of two segments, then pairs with each box or plane: (their numbers, that)."""
        still = [solid.boxed or solid.kind == "plane" for solid in self.solids]
        boxed = [s if still[s] else -1 for s in self.second.tolist()]
        kinds = sorted(set(boxed))
        return [
            (np.flatnonzero(np.array(boxed) == kind), self.solids[kind] if kind >= 0 else None)
            for kind in kinds
        ]

    def __len__(self) -> int:
        return len(self.index)

    def of(self, pair: int) -> tuple[Solid, Solid]:
        """The two solids of a pair."""
        first, second = self.index[pair]
        return self.solids[first], self.solids[second]

    @property
    def closed(self) -> bool:
        """Whether all distances have closed forms."""
        return bool(self.exact[[i for pair in self.index for i in pair]].all())

    def coal(self, pair: int) -> PairDistance:
        """The distance of a pair that has no closed form."""
        if pair not in self._coal:
            self._coal[pair] = PairDistance(*self.of(pair))
        return self._coal[pair]


@lru_cache(maxsize=64)
def _seen(key: str) -> dict[str, Pairs]:
    """The pairs that came to this process under a key."""
    return {}


def _known(key: str, solids: tuple[Solid, ...], index: tuple[tuple[int, int], ...]) -> Pairs:
    """The pairs of that key as they came first."""
    return _seen(key).setdefault(key, Pairs(solids, index, _key=key))


def nearest(
    pairs: Pairs, posture: Posture, horizon: float, slack: Array | float = 0.0
) -> NearestPairs:
    """The nearest pair of every posture.

    Args:
        pairs: P pairs.
        posture: N postures.
        horizon: Distances beyond this are not measured but said to be this [m]; may be infinite.
        slack: (P, N) what to take off each distance before they are compared [m].

    Source: ours.
    """
    count = posture.count
    found = _Entries(pairs, posture, horizon, np.broadcast_to(slack, (len(pairs), count)))
    value = np.full((len(pairs), count), horizon)
    exact = found.exact
    value[found.pair[exact], found.case[exact]] = found.value[exact]
    if not exact.all():
        _measure(found, pairs, posture, value)
    if not len(pairs):
        return _nothing(count, horizon)
    best = value.argmin(axis=0)
    least = value[best, np.arange(count)]
    entry = np.full((len(pairs), count), -1)
    entry[found.pair, found.case] = np.arange(len(found.pair))
    chosen = np.where(least < horizon, entry[best, np.arange(count)], -1)
    seen = chosen >= 0
    result = _nothing(count, horizon)
    k = chosen[seen]
    result.value[:] = least
    result.pair[seen] = best[seen]
    result.distance[seen] = found.distance[k]
    result.first[:, seen], result.second[:, seen] = found.first[:, k], found.second[:, k]
    result.normal[:, seen] = found.normal[:, k]
    return result


def _nothing(count: int, horizon: float) -> NearestPairs:
    return NearestPairs(
        np.full(count, horizon),
        np.full(count, -1, dtype=np.int64),
        np.full(count, horizon),
        np.zeros((3, count)),
        np.zeros((3, count)),
        np.zeros((3, count)),
    )


class _Entries:
    """Pairs at postures that the balls leave, measured by capsules and boxes: K of them."""

    def __init__(self, pairs: Pairs, posture: Posture, horizon: float, slack: Array) -> None:
        self.pairs, self.posture = pairs, posture
        ends = [
            posture.point(solid.segment[e], solid.body) for solid in pairs.solids for e in (0, 1)
        ]
        self.ends: Array = np.array(ends).reshape(len(pairs.solids), 2, 3, posture.count)
        near = self._ball_gaps() - slack < horizon
        self.pair, self.case = np.nonzero(near)
        total = len(self.pair)
        self.distance = np.zeros(total)
        self.first, self.second = np.zeros((3, total)), np.zeros((3, total))
        self.normal = np.zeros((3, total))
        self.exact = np.zeros(total, dtype=bool)
        if total:
            self._measure_all()
        self.value = self.distance - slack[self.pair, self.case]

    def _ball_gaps(self) -> Array:
        """(P, N) lower bounds of the distances: balls around the first, balls or boxes second."""
        p = self.pairs
        middle = 0.5 * (self.ends[:, 0] + self.ends[:, 1])
        gaps = np.empty((len(p), middle.shape[2]))
        for chosen, box in p.groups:
            if box is None:
                apart = middle[p.first[chosen]] - middle[p.second[chosen]]
                gap = np.sqrt((apart**2).sum(axis=1))
                gap -= p.ball[p.second[chosen], None]
            elif box.kind == "plane":
                off = middle[p.first[chosen]] - box.pose[:3, 3:]
                gap = (box.pose[:3, 2:3] * off).sum(axis=1)
            else:
                rotation, centre = box.box_pose[:3, :3], box.box_pose[:3, 3:]
                off = np.abs(rotation.T @ (middle[p.first[chosen]] - centre)) - box.half[:, None]
                gap = np.sqrt((np.maximum(off, 0.0) ** 2).sum(axis=1))
                # Inside, the nearest face is what the ball says something of.
                gap += np.minimum(off.max(axis=1), 0.0)
            gaps[chosen] = gap - p.ball[p.first[chosen], None]
        return gaps

    def _measure_all(self) -> None:
        """Distances of segments from each other in one go, from boxes and planes one by one."""
        p = self.pairs
        for chosen, box in p.groups:
            here = np.isin(self.pair, chosen) if len(p.groups) > 1 else slice(None)
            pair, case = self.pair[here], self.case[here]
            if not len(pair):
                continue
            i, j = p.first[pair], p.second[pair]
            a, b = self.ends[i, 0, :, case].T, self.ends[i, 1, :, case].T
            outer = 0.0 if box else p.radius[j]
            if box is None:
                c, d = self.ends[j, 0, :, case].T, self.ends[j, 1, :, case].T
                found = between_segments(a, b, c, d)
            elif box.kind == "plane":
                found = segment_and_plane(a, b, box.pose)
            else:
                pose = box.box_pose
                found = segment_and_box(a, b, pose[:3, :3], pose[:3, 3], box.half)
            self.exact[here] = p.exact[i] & p.exact[j] & ~p.faced[pair]
            self.distance[here] = found.distance - p.radius[i] - outer
            self.first[:, here] = found.first - p.radius[i] * found.normal
            self.second[:, here] = found.second + outer * found.normal
            self.normal[:, here] = found.normal
            if box is not None and box.kind == "plane" and not self.exact[here].all():
                self._settle(box, np.flatnonzero(np.isin(self.pair, chosen) & ~self.exact))

    def say(self, k: IntArray, distance: Array, points: Sequence[Array]) -> None:
        """New distances of entries, with both points and the direction."""
        self.value[k] = distance + self.value[k] - self.distance[k]  # less the slack
        self.distance[k] = distance
        self.first[:, k], self.second[:, k], self.normal[:, k] = points

    def _settle(self, plane: Solid, k: IntArray) -> None:
        """From a plane every solid has a closed form: its lowest point is the nearest."""
        solids = self.pairs.first[self.pair[k]]
        for solid in np.unique(solids).tolist():
            here = k[solids == solid]
            normal = self.normal[:, here]
            point = lowest(self.posture, self.pairs.solids[solid], self.case[here], normal)
            distance = ((point - plane.pose[:3, 3:]) * normal).sum(axis=0)
            if self.pairs.exact[solid]:  # what stands in for a shape is inside its capsule, too
                higher = distance > self.distance[here]
                here, point, normal = here[higher], point[:, higher], normal[:, higher]
                distance = distance[higher]
            self.distance[here], self.first[:, here] = distance, point
            self.second[:, here] = point - distance * normal
        self.exact[k] = True


def _measure(found: _Entries, pairs: Pairs, posture: Posture, value: Array) -> None:
    """Measure what may still be the nearest of its posture; bounds rise, never fall."""
    best = value.min(axis=0)
    open_ = np.flatnonzero(~found.exact & (found.value < best[found.case]))
    by_coal = open_[~pairs.faced[found.pair[open_]]]
    _sharpen(found, by_coal, pairs, posture)
    places = Placements(posture) if len(by_coal) else None
    # First the most promising pair of every posture, then what that leaves open.
    open_ = open_[np.argsort(found.value[open_], kind="stable")]
    _, front = np.unique(found.case[open_], return_index=True)
    for k in (open_[front], np.delete(open_, front)):
        k = k[found.value[k] < best[found.case[k]]]
        faced = pairs.faced[found.pair[k]]
        _by_faces(found, k[faced], pairs, posture, best)
        _note(found, k[faced], value, best)
        k = k[~faced]
        for pair in np.unique(found.pair[k]).tolist():
            here = k[found.pair[k] == pair]
            here = here[found.value[here] < best[found.case[here]]]
            if len(here):
                assert places is not None
                distance, *points = pairs.coal(pair)(places, found.case[here])
                found.say(here, distance, points)
                _note(found, here, value, best)


def _note(found: _Entries, k: IntArray, value: Array, best: Array) -> None:
    """Values of entries that are measured now, in the table of pairs and as the least."""
    pair, case = found.pair[k], found.case[k]
    value[pair, case] = np.minimum(value[pair, case], found.value[k])
    np.minimum.at(best, case, found.value[k])


def _by_faces(found: _Entries, k: IntArray, pairs: Pairs, posture: Posture, best: Array) -> None:
    """Measure what stands in for shapes: faces may show more distance than capsules and boxes."""
    if not len(k):
        return
    pair, known = found.pair[k], found.distance[k]
    which = pairs.first[pair], pairs.second[pair]
    enough = best[found.case[k]] + known - found.value[k]  # then another pair is nearer
    distance, *points = parted(posture, pairs.shells, *which, found.case[k], known, enough)
    new = distance > known
    found.say(k[new], distance[new], [point[:, new] for point in points])


def _sharpen(found: _Entries, open_: IntArray, pairs: Pairs, posture: Posture) -> None:
    """Raise bounds by the support functions of the solids, along the direction that is known."""
    case, normal = found.case[open_], found.normal[:, open_]
    apart = np.zeros(len(open_))
    for sign, index in ((-1.0, pairs.first), (1.0, pairs.second)):
        which = index[found.pair[open_]]
        for solid in np.unique(which).tolist():
            k = which == solid
            apart[k] -= largest(posture, pairs.solids[solid], case[k], sign * normal[:, k])
    gain = np.maximum(apart - found.distance[open_], 0.0)
    found.distance[open_] += gain
    found.value[open_] += gain
