"""A space of load cases as plain structures, as the compiled core takes it.

In: `LoadCaseSpace`. Out: `layout.PlainSpace`, with a margin for every constraint; those of a kind
that the core does not know are foreign.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import (
    AcceptanceCone,
    BeamRange,
    Clearance,
    Constraint,
    Distinct,
    Elevation,
    HalfSpace,
    HeadAzimuth,
    HeadElevation,
    HeldJoint,
    JointLimit,
    LineOfSight,
    MinRadius,
    Tilt,
    clearance,
    line_of_sight,
)
from elastocal.constraints.collision.distance import Pairs
from elastocal.constraints.collision.shell import far_apart_first
from elastocal.constraints.collision.solid import Solid
from elastocal.constraints.collision.support import FIELDS, by_direction, spanned
from elastocal.core import layout
from elastocal.core.layout import Closer, LoadKind, MarginKind, Memory, PairKind
from elastocal.elastic.absorbed import KnownErrors
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, Load, ThereOrNot
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.unknowns import Unknowns
from elastocal.measuring.instrument import Instrument, LaserTracker, positions_of


class Described(Protocol):
    """What the core is told of a space of load cases; see `LoadCaseSpace`."""

    @property
    def arm(self) -> ElasticArm: ...
    @property
    def force(self) -> Load: ...
    @property
    def moment(self) -> Load: ...
    @property
    def constraints(self) -> Sequence[Constraint]: ...
    @property
    def instrument(self) -> Instrument: ...
    @property
    def parameters(self) -> int: ...
    @property
    def unknowns(self) -> Unknowns: ...
    @property
    def errors(self) -> KnownErrors | None: ...
    @property
    def lower(self) -> Array: ...
    @property
    def upper(self) -> Array: ...


class PlainSpaceOf:
    """A space of load cases as structures.

    Attributes:
        space: The structure.
        foreign: Numbers of the constraints that only Python knows.
        columns: Number of margins, cones of loads included.
    """

    def __init__(self, space: Described, memory: Memory) -> None:
        """`memory` keeps what the structures point to."""
        self._points: list[Array] = []
        self._directions: list[Array] = []
        self._solids: list[layout.PlainSolid] = []
        self._memory = memory
        robot, tool = space.arm.robot, space.arm.tool
        springs, joint, share = space.arm.twists
        weights = space.arm.weights
        self._point(tool.load_point)
        markers = [self._point(marker) for marker in tool.markers]
        margins = [self._margin(constraint) for constraint in space.constraints]
        self.foreign = [c for c, m in enumerate(margins) if m.kind == MarginKind.FOREIGN]
        m = robot.last
        links = np.concatenate([robot.links[:m], robot.branches, robot.links[m:]])
        loads = [_load(load) for load in (space.force, space.moment)]
        self.columns = len(margins) + sum(load.cone for load in loads)
        self.space = layout.PlainSpace(
            variables=len(space.lower),
            joints=len(robot.joints),
            moving=len(robot.moving),
            last=m,
            links=memory.reals(links),
            carriers=memory.integers(robot.carriers),
            sliding=memory.integers(robot.sliding),
            own=memory.integers(robot.place),
            mixing=memory.reals(robot.mixing) if robot.followers else None,
            standing=memory.reals(robot.standing),
            twists=len(springs),
            springs=len(space.arm.springs),
            unknowns=space.parameters,
            **_making(space, memory),
            body=memory.integers(springs.body),
            joint=memory.integers(joint),
            axes=memory.reals(springs.axis),
            origins=memory.reals(springs.origin),
            slides=memory.integers(springs.prismatic),
            stiff=memory.integers(space.arm.springs.stiff),
            only=memory.integers(space.arm.springs.only),
            weights=len(weights),
            heavy=memory.integers([body for body, _, _ in weights]),
            centers=memory.reals([center for _, center, _ in weights] or [0.0]),
            pulls=memory.reals([force for _, _, force in weights] or [0.0]),
            share=None if share is None else memory.reals(share),
            carried=memory.integers(np.searchsorted(springs.body, np.arange(1, m + 1))),
            points=len(self._points),
            locals=memory.reals(self._points),
            markers=len(markers),
            marker=memory.integers(markers),
            directions=len(self._directions),
            pointing=memory.reals(np.reshape(self._directions, (-1, 3))),
            noise=_noise(space),
            errors=_errors(space.errors, memory),
            force=loads[0],
            moment=loads[1],
            margins=len(margins),
            margin=memory.structures(margins),
            solids=len(self._solids),
            solid=memory.structures(self._solids),
        )

    def _point(self, point: Array) -> int:
        return _placed(self._points, point)

    def _margin(self, c: Constraint) -> layout.PlainMargin:
        """The constraint as the core has it; FOREIGN if it is of another kind."""
        kind = type(c)
        if isinstance(c, Distinct) and kind is Distinct:
            q = self._memory.reals([c.q, c.counts])
            return layout.PlainMargin(kind=MarginKind.DISTINCT, bound=c.least, q=q)
        if isinstance(c, JointLimit) and kind is JointLimit:
            return layout.PlainMargin(
                kind=MarginKind.JOINT_LIMIT, at=c.joint, sign=c.sign, bound=c.bound
            )
        if isinstance(c, HeldJoint) and kind is HeldJoint:
            return layout.PlainMargin(kind=MarginKind.HELD_JOINT, at=c.joint, bound=c.value)
        if isinstance(c, HalfSpace) and kind is HalfSpace:
            return self._at(MarginKind.HALF_SPACE, c.point, place=c.normal, bound=c.offset)
        if isinstance(c, MinRadius) and kind is MinRadius:
            return self._at(MarginKind.MIN_RADIUS, c.point, bound=c.radius)
        if isinstance(c, Elevation) and kind is Elevation:
            return self._along(MarginKind.ELEVATION, c.axis, bound=c.limit)
        if isinstance(c, Tilt) and kind is Tilt:
            return self._along(MarginKind.TILT, c.axis, place=c.towards, bound=c.limit)
        if isinstance(c, AcceptanceCone) and kind is AcceptanceCone:
            margin = self._along(
                MarginKind.ACCEPTANCE_CONE, c.axis, place=c.position, bound=c.limit
            )
            margin.at = self._point(c.point)
            return margin
        if isinstance(c, BeamRange | HeadElevation) and kind in (BeamRange, HeadElevation):
            bounded = MarginKind.BEAM_RANGE if kind is BeamRange else MarginKind.HEAD_ELEVATION
            return self._at(bounded, c.point, place=c.position, sign=c.sign, bound=c.bound)
        if isinstance(c, HeadAzimuth) and kind is HeadAzimuth:
            return self._at(
                MarginKind.HEAD_AZIMUTH, c.point, place=c.position, bound=c.half, middle=c.middle
            )
        if isinstance(c, Clearance) and kind is Clearance and _is_known(c.pairs):
            return layout.PlainMargin(
                kind=MarginKind.CLEARANCE,
                bound=c.keep,
                horizon=c.keep + clearance.PLENTY,
                pairs=self._memory.structures(self._pairs(c.pairs)),
                count=len(c.pairs),
            )
        if isinstance(c, LineOfSight) and kind is LineOfSight:
            start = self._placed_solids(c.solids)
            pairs = [_pair(0, start + s, solid) for s, solid in enumerate(c.solids)]
            return self._at(
                MarginKind.LINE_OF_SIGHT,
                c.point,
                place=c.position,
                bound=c.radius,
                horizon=c.radius + line_of_sight.PLENTY,
                pairs=self._memory.structures(pairs),
                count=len(pairs),
            )
        return layout.PlainMargin(kind=MarginKind.FOREIGN)

    def _at(self, kind: MarginKind, point: Array, **numbers: Any) -> layout.PlainMargin:
        numbers["place"] = tuple(numbers.get("place", (0.0, 0.0, 0.0)))
        return layout.PlainMargin(kind=kind, at=self._point(point), **numbers)

    def _along(self, kind: MarginKind, axis: Array, **numbers: Any) -> layout.PlainMargin:
        numbers["place"] = tuple(numbers.get("place", (0.0, 0.0, 0.0)))
        return layout.PlainMargin(kind=kind, along=_placed(self._directions, axis), **numbers)

    def _pairs(self, pairs: Pairs) -> list[layout.PlainPair]:
        start = self._placed_solids(pairs.solids, pairs)
        found = []
        for (first, second), faced in zip(pairs.index, pairs.faced, strict=True):
            pair = _pair(start + first, start + second, pairs.solids[second])
            if not (pairs.exact[first] and pairs.exact[second]):
                pair.closer = Closer.BY_REACH
            elif faced:
                pair.closer = Closer.BY_FACES
            found.append(pair)
        return found

    def _placed_solids(self, solids: Sequence[Solid], pairs: Pairs | None = None) -> int:
        """The number that the first of them has now; with all that some pairs ask of them."""
        start = len(self._solids)
        faced, closed = pairs is not None and pairs.faced.any(), pairs is None or pairs.closed
        for solid in solids:
            ends = tuple(np.ravel(solid.segment))
            plain = layout.PlainSolid(solid.body, ends, solid.radius, solid.ball)
            if faced and solid.kind != "plane":
                shell = solid.shell
                plain.faces, plain.rounded = len(shell.faces), shell.radius
                plain.face = self._memory.reals(shell.faces)
                plain.corners = len(shell.corners)
                plain.corner = self._memory.reals(far_apart_first(shell.corners))
            if not closed and solid.kind != "plane":
                span = spanned(solid)
                plain.tips, plain.tip = len(span.points), self._memory.reals(span.points)
                plain.round, plain.spokes = int(span.spokes.any()), tuple(np.ravel(span.spokes))
                plain.skin = span.skin
                if len(span.points) > _FEW:
                    starts, foremost = by_direction(span.points)
                    plain.fields = FIELDS
                    plain.starts, plain.foremost = map(self._memory.integers, (starts, foremost))
            self._solids.append(plain)
        return start


_FEW = 12  # points that are looked at one by one


def _pair(first: int, second: int, other: Solid) -> layout.PlainPair:
    """What a segment or a beam is near to."""
    if other.kind == "plane":
        pose = tuple(other.pose[:3].T.ravel())
        return layout.PlainPair(kind=PairKind.PLANE, first=first, second=second, pose=pose)
    if other.boxed:
        pose = tuple(other.box_pose[:3].T.ravel())
        half = tuple(other.half)
        return layout.PlainPair(PairKind.BOX, first, second, pose=pose, half=half)
    return layout.PlainPair(PairKind.SEGMENT, first, second)


def _placed(known: list[Array], wanted: Array) -> int:
    """Where a vector is among those known; appended if it is new."""
    for i, one in enumerate(known):
        if np.array_equal(one, wanted):
            return i
    known.append(wanted)
    return len(known) - 1


def _is_known(pairs: Pairs) -> bool:
    """Whether the core has room for what stands in for the shapes."""
    return all(len(solid.faces) <= layout.MOST_FACES for solid in pairs.solids)


def _making(space: Described, memory: Memory) -> dict[str, int]:
    """Which unknowns make each spring, and how much of it; nothing where each is a spring."""
    unknowns = space.unknowns
    if unknowns.plain and space.parameters == len(unknowns):
        return {}
    spring, unknown = np.nonzero(unknowns.make)
    return {
        "making": memory.integers(np.searchsorted(spring, np.arange(len(unknowns.springs) + 1))),
        "maker": memory.integers(unknown),
        "made": memory.reals(unknowns.make[spring, unknown]),
    }


def _load(load: Load) -> layout.PlainLoad:
    if isinstance(load, FixedVector):
        return layout.PlainLoad(
            kind=LoadKind.FIXED,
            zero=int(not load.value.any()),
            axis=tuple(load.value),
            size=load.size,
        )
    if isinstance(load, FreeDirection):
        return layout.PlainLoad(
            kind=LoadKind.DIRECTION,
            cone=int(load.is_cone),
            size=load.largest,
            half_angle=load.half_angle,
            axis=tuple(load.axis),
        )
    if isinstance(load, ThereOrNot):
        return layout.PlainLoad(kind=LoadKind.SHARE, size=load.size, axis=tuple(load.value))
    return layout.PlainLoad(
        kind=LoadKind.PLANE, size=load.largest, basis=tuple(load.basis.T.ravel())
    )


def _noise(space: Described) -> layout.PlainNoise:
    instrument, rotation = positions_of(space.instrument), space.instrument.sigma_rotation or 0.0
    if isinstance(instrument, LaserTracker):
        return layout.PlainNoise(
            kind=1,
            position=tuple(instrument.position),
            along=instrument.along,
            along_per_metre=instrument.along_per_metre,
            across=instrument.across,
            across_per_metre=instrument.across_per_metre,
            rotation=rotation,
        )
    return layout.PlainNoise(kind=0, deviation=instrument.sigma, rotation=rotation)


def _errors(known: KnownErrors | None, memory: Memory) -> layout.PlainErrors:
    if known is None:
        return layout.PlainErrors()
    sizes = known.sizes
    return layout.PlainErrors(
        any=1,
        discrepancy=sizes.discrepancy,
        length=sizes.discrepancy_length,
        gain=sizes.gain,
        tilt=sizes.tilt,
        repeatability=sizes.repeatability,
        turning=sizes.common_tilt / known.unit,
        together=known.together,
        compliance=memory.reals(known.compliance),
        rubbing=memory.reals(known.rubbing),
    )
