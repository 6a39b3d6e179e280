"""What Python and the compiled core tell each other: the structures of `source/space.h`, as ctypes.

All numbers are doubles or 64-bit integers, all tables C-contiguous. The caller keeps alive what a
structure points to.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

Int = ctypes.c_int64
Real = ctypes.c_double
Pointer = ctypes.c_void_p
ASK = ctypes.CFUNCTYPE(Int, Int, Int, ctypes.POINTER(Real), ctypes.POINTER(Real))


SIGNATURES = {
    "evaluate": (Pointer, Int, Pointer, Pointer, Pointer, Pointer),
    "pull": (Pointer, Int, Pointer, Pointer, Pointer, Pointer, Pointer),
    "feasible": (Pointer, Int, Pointer, Pointer),
    "restore": (Pointer, Int, Pointer, Pointer, Pointer, Int),
    "advance": (Pointer, Pointer, Pointer, Int, Int, Int),
    "bound": (Pointer, Int, Pointer, Real, Pointer, Pointer, Pointer),
    "search": (Pointer, Pointer, Real, Real, Int, Pointer, Int, Pointer, Int, Pointer),
    "leaf": (Int, Pointer, Int, Pointer, Pointer),
}
"""Arguments of what the core exports; everything returns an integer, 0 if all went well."""


class LoadKind(IntEnum):
    """Which forces or moments may act."""

    FIXED = 0
    DIRECTION = 1
    PLANE = 2
    SHARE = 3


MOST_FACES = 64
"""Faces that a solid may have."""


class MarginKind(IntEnum):
    """Kinds of constraints."""

    HALF_SPACE = 0
    MIN_RADIUS = 1
    ELEVATION = 2
    TILT = 3
    JOINT_LIMIT = 4
    HELD_JOINT = 5
    BEAM_RANGE = 6
    ACCEPTANCE_CONE = 7
    HEAD_ELEVATION = 8
    HEAD_AZIMUTH = 9
    DISTINCT = 10
    CLEARANCE = 11
    LINE_OF_SIGHT = 12
    FOREIGN = 13


class PairKind(IntEnum):
    """What a segment is near to."""

    SEGMENT = 0
    PLANE = 1
    BOX = 2


class Closer(IntEnum):
    """How near that is."""

    AS_IT_IS = 0
    BY_FACES = 1
    BY_REACH = 2


class Asked(IntEnum):
    """What the core asks of Python."""

    MARGINS = 0
    PULL = 1
    WORTH = 2


class PlainLoad(ctypes.Structure):
    """Which forces, or moments, may act."""

    _fields_ = (
        ("kind", Int),
        ("zero", Int),
        ("cone", Int),
        ("size", Real),
        ("half_angle", Real),
        ("axis", Real * 3),
        ("basis", Real * 6),
    )


class PlainSolid(ctypes.Structure):
    """A solid that one body carries."""

    _fields_ = (
        ("body", Int),
        ("ends", Real * 6),
        ("radius", Real),
        ("ball", Real),
        ("faces", Int),
        ("face", Pointer),
        ("corners", Int),
        ("corner", Pointer),
        ("rounded", Real),
        ("tips", Int),
        ("tip", Pointer),
        ("fields", Int),
        ("starts", Pointer),
        ("foremost", Pointer),
        ("round", Int),
        ("spokes", Real * 6),
        ("skin", Real),
    )


class PlainPair(ctypes.Structure):
    """Two solids, or one and a plane or box that stands still."""

    _fields_ = (
        ("kind", Int),
        ("first", Int),
        ("second", Int),
        ("closer", Int),
        ("pose", Real * 12),
        ("half", Real * 3),
    )


class PlainMargin(ctypes.Structure):
    """One constraint."""

    _fields_ = (
        ("kind", Int),
        ("at", Int),
        ("along", Int),
        ("sign", Real),
        ("bound", Real),
        ("middle", Real),
        ("place", Real * 3),
        ("q", Pointer),
        ("pairs", Pointer),
        ("count", Int),
        ("horizon", Real),
    )


class PlainNoise(ctypes.Structure):
    """What measures."""

    _fields_ = (
        ("kind", Int),
        ("deviation", Real),
        ("position", Real * 3),
        ("along", Real),
        ("along_per_metre", Real),
        ("across", Real),
        ("across_per_metre", Real),
        ("rotation", Real),
    )


class PlainErrors(ctypes.Structure):
    """What errs besides."""

    _fields_ = (
        ("any", Int),
        *((name, Real) for name in ("discrepancy", "length", "gain", "tilt")),
        *((name, Real) for name in ("repeatability", "turning", "together")),
        ("compliance", Pointer),
        ("rubbing", Pointer),
    )


class PlainSpace(ctypes.Structure):
    """A space of load cases."""

    _fields_ = (
        ("variables", Int),
        ("joints", Int),
        ("moving", Int),
        ("last", Int),
        ("links", Pointer),
        ("carriers", Pointer),
        ("sliding", Pointer),
        ("own", Pointer),
        ("mixing", Pointer),
        ("standing", Pointer),
        ("twists", Int),
        ("springs", Int),
        ("unknowns", Int),
        ("making", Pointer),
        ("maker", Pointer),
        ("made", Pointer),
        ("body", Pointer),
        ("joint", Pointer),
        ("axes", Pointer),
        ("origins", Pointer),
        ("slides", Pointer),
        ("stiff", Pointer),
        ("only", Pointer),
        ("weights", Int),
        ("heavy", Pointer),
        ("centers", Pointer),
        ("pulls", Pointer),
        ("share", Pointer),
        ("carried", Pointer),
        ("points", Int),
        ("locals", Pointer),
        ("markers", Int),
        ("marker", Pointer),
        ("directions", Int),
        ("pointing", Pointer),
        ("noise", PlainNoise),
        ("errors", PlainErrors),
        ("force", PlainLoad),
        ("moment", PlainLoad),
        ("margins", Int),
        ("margin", Pointer),
        ("solids", Int),
        ("solid", Pointer),
    )


class PlainCriterion(ctypes.Structure):
    """A mean of losses."""

    _fields_ = (
        ("unknowns", Int),
        ("losses", Int),
        ("ranks", Pointer),
        ("roots", Pointer),
        ("sharpness", Real),
    )


class PlainGoal(ctypes.Structure):
    """What a batch of problems is after."""

    _fields_ = (
        ("points", Int),
        ("level", Real),
        ("rank", Int),
        ("root", Pointer),
        ("base", Pointer),
        ("criterion", PlainCriterion),
        ("foreign", Int),
        ("asks_worth", Int),
        ("ask", ASK),
    )


class PlainBatch(ctypes.Structure):
    """A batch of problems."""

    _fields_ = (
        ("count", Int),
        *((name, Pointer) for name in ("lower", "upper", "counts")),
        *((name, Pointer) for name in ("x", "value", "margins", "merit", "gradient")),
        *((name, Pointer) for name in ("multipliers", "penalty", "broken", "checkpoint")),
        *((name, Pointer) for name in ("inverse", "fresh", "direction", "length", "gain")),
    )


MOST_JOINTS, MOST_CONDITIONS = 12, 64
"""Joints and constraints that a statement may have."""
PENDING, OPEN, LEAF = 253, 254, 255
"""Boxes that are not halved: not looked at, too small to be, done."""


class PlainCondition(ctypes.Structure):
    """A constraint of a statement: see `source/expansion.h`."""

    _fields_ = (
        ("kind", Int),
        ("point", Real * 3),
        ("normal", Real * 3),
        ("weights", Real * 3),
        ("sign", Real),
        ("offset", Real),
        ("third", Pointer),
    )


class PlainStatement(ctypes.Structure):
    """What is to be bounded, and where: see `source/expansion.h`."""

    _fields_ = (
        ("joints", Int),
        *((name, Pointer) for name in ("axes", "points", "slides", "links", "starts")),
        *((name, Pointer) for name in ("least", "most")),
        ("springs", Int),
        *((name, Pointer) for name in ("bodies", "slide", "spring_axes", "spring_points")),
        ("values", Pointer),
        ("rank", Int),
        ("markers", Int),
        ("marker", Pointer),
        ("turning", Real),
        ("load_point", Real * 3),
        ("loaded", Int),
        ("forms", Int),
        ("forces", Pointer),
        ("moments", Pointer),
        ("twisting", Int),
        ("cone", Int),
        ("cone_axis", Real * 3),
        ("cone_cosine", Real),
        ("conditions", Int),
        ("condition", Pointer),
        *((name, Pointer) for name in ("third", "lower", "upper")),
    )


class PlainOutcome(ctypes.Structure):
    """What a search of a box found."""

    _fields_ = (
        *((name, Int) for name in ("evaluated", "symbols", "pending", "open")),
        ("largest", Real),
        ("best", Real),
        ("at", Real * MOST_JOINTS),
    )


def address(table: np.ndarray[Any, Any]) -> int:
    """Where a table is; quicker than `table.ctypes`."""
    return int(table.__array_interface__["data"][0])


class Memory:
    """Tables that structures point to, kept alive together."""

    def __init__(self) -> None:
        self._kept: list[Any] = []

    def reals(self, values: ArrayLike) -> int:
        """Address of a table of doubles."""
        return self._address(np.ascontiguousarray(values, dtype=np.float64))

    def integers(self, values: ArrayLike) -> int:
        """Address of a table of integers."""
        return self._address(np.ascontiguousarray(values, dtype=np.int64))

    def structures(self, values: Sequence[ctypes.Structure]) -> int | None:
        """Address of an array of structures; None if there are none."""
        if not values:
            return None
        table = (type(values[0]) * len(values))(*values)
        self._kept.append(table)
        return ctypes.addressof(table)

    def _address(self, table: np.ndarray[Any, Any]) -> int:
        self._kept.append(table)
        return address(table)
