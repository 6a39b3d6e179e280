"""A statement as plain data for JSON, and back.

Numbers come back to the last bit. What is missing or has another shape is refused by its key.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.errors import InputError
from elastocal.proof.statement import (
    AnyDirection,
    CarriedSprings,
    ChainJoints,
    DirectionOverPlane,
    HalvedVariable,
    HeldVariable,
    InCone,
    PointByDistance,
    PointOverPlane,
    ProofConstraint,
    ProofLoad,
    Statement,
    SteadyLoad,
)

FORMAT = "elastocal-proof 1"
_KINDS = ("turns", "slides")


def as_data(statement: Statement) -> dict[str, Any]:
    """A statement as dictionaries, lists, texts and numbers."""
    s = statement
    joints = [
        {
            "name": name,
            "kind": _KINDS[int(s.joints.slides[i])],
            "axis": s.joints.axis[i].tolist(),
            "point": s.joints.point[i].tolist(),
            "lower": float(s.joints.lower[i]),
            "upper": float(s.joints.upper[i]),
        }
        for i, name in enumerate(s.joints.names)
    ]
    springs = [
        {
            "name": name,
            "kind": _KINDS[int(s.springs.slides[i])],
            "body": int(s.springs.body[i]),
            "axis": s.springs.axis[i].tolist(),
            "point": s.springs.point[i].tolist(),
        }
        for i, name in enumerate(s.springs.names)
    ]
    halved = [
        {"variable": h.variable, "signs": h.signs.tolist(), "shifts": h.shifts.tolist()}
        for h in s.halved
    ]
    return {
        "format": FORMAT,
        "name": s.name,
        "criterion": s.criterion,
        "source": {"study_sha256": s.study_sha256, "version": s.version},
        "joints": joints,
        "springs": springs,
        "make": s.make.tolist(),
        "unknowns": list(s.unknowns),
        "markers": s.markers.tolist(),
        "sigma": s.sigma,
        "sigma_turn": s.sigma_turn,
        "load": _load_data(s.load),
        "constraints": [_constraint_data(constraint) for constraint in s.constraints],
        "left_out": list(s.left_out),
        "mix": s.mix.tolist(),
        "root": {"lower": s.root[0].tolist(), "upper": s.root[1].tolist()},
        "limited": s.limited.tolist(),
        "held": [{"variable": h.variable, "because": h.because} for h in s.held],
        "halved": halved,
        "V": s.V.tolist(),
        "K": s.K.tolist(),
        "B": s.B.tolist(),
        "count": s.count,
        "largest": s.largest,
        "rho0": s.rho0,
        "witnesses": s.witnesses.tolist(),
        "tables": {"points": s.points.tolist()},
    }


def _load_data(load: ProofLoad) -> dict[str, Any]:
    if isinstance(load, SteadyLoad):
        kind: dict[str, Any] = {"kind": "fixed", "point": load.point.tolist()}
        return kind | {"force": load.force.tolist(), "moment": load.moment.tolist()}
    data: dict[str, Any] = {"point": load.point.tolist(), "size": load.size}
    if isinstance(load, AnyDirection):
        return {"kind": "free"} | data | {"basis": load.basis.tolist()}
    return {"kind": "cone"} | data | {"axis": load.axis.tolist(), "half_angle": load.half_angle}


def _constraint_data(c: ProofConstraint) -> dict[str, Any]:
    if isinstance(c, PointOverPlane):
        where: dict[str, Any] = {"kind": "plane", "point": c.point.tolist()}
        where |= {"normal": c.normal.tolist(), "offset": c.offset}
    elif isinstance(c, DirectionOverPlane):
        where = {"kind": "direction", "axis": c.axis.tolist()}
        where |= {"normal": c.normal.tolist(), "offset": c.offset}
    else:
        where = {"kind": "distance", "point": c.point.tolist(), "center": c.center.tolist()}
        where |= {"weights": c.weights.tolist(), "sign": c.sign, "bound": c.bound}
    return {"name": c.name} | where


def from_data(data: Mapping[str, Any]) -> Statement:
    """The statement that `as_data` made such data of.

    Raises:
        InputError: a key is missing, or what it holds has another kind or shape; names the key.
    """
    of = _Entry(data, "")
    if of.text("format") != FORMAT:
        raise InputError(f"format: expected {FORMAT!r}, found {of.text('format')!r}")
    joints, springs = of.entries("joints"), of.entries("springs")
    source, root, n, c = of.entry("source"), of.entry("root"), len(joints), len(springs)
    unknowns = of.texts("unknowns")
    p = len(unknowns)
    V = of.array("V", p, None)
    r = V.shape[1]
    return Statement(
        name=of.text("name"),
        criterion=of.text("criterion"),
        study_sha256=source.text("study_sha256"),
        version=source.text("version"),
        joints=ChainJoints(
            names=tuple(joint.text("name") for joint in joints),
            slides=np.array([joint.choice("kind", _KINDS) == "slides" for joint in joints]),
            axis=np.reshape([joint.array("axis", 3) for joint in joints], (n, 3)),
            point=np.reshape([joint.array("point", 3) for joint in joints], (n, 3)),
            lower=np.array([joint.number("lower") for joint in joints]),
            upper=np.array([joint.number("upper") for joint in joints]),
        ),
        springs=CarriedSprings(
            names=tuple(spring.text("name") for spring in springs),
            slides=np.array([spring.choice("kind", _KINDS) == "slides" for spring in springs]),
            body=np.array([spring.integer("body", 0, n) for spring in springs]),
            axis=np.reshape([spring.array("axis", 3) for spring in springs], (c, 3)),
            point=np.reshape([spring.array("point", 3) for spring in springs], (c, 3)),
        ),
        make=of.array("make", c, p),
        unknowns=unknowns,
        markers=of.array("markers", None, 3),
        sigma=of.number("sigma"),
        sigma_turn=None if of.is_null("sigma_turn") else of.number("sigma_turn"),
        load=_load_from(of.entry("load")),
        constraints=tuple(_constraint_from(entry) for entry in of.entries("constraints")),
        left_out=of.texts("left_out"),
        mix=of.array("mix", n, n),
        root=np.array([root.array("lower", n), root.array("upper", n)]),
        limited=of.flags("limited", n),
        held=tuple(
            HeldVariable(
                held.integer("variable", 0, n - 1), held.choice("because", ("flat", "base"))
            )
            for held in of.entries("held")
        ),
        halved=tuple(
            HalvedVariable(
                half.integer("variable", 0, n - 1), half.array("signs", n), half.array("shifts", n)
            )
            for half in of.entries("halved")
        ),
        V=V,
        K=of.array("K", p, r),
        B=of.array("B", p, p),
        count=of.integer("count", 1, 10**6),
        largest=None if of.is_null("largest") else of.number("largest"),
        rho0=None if of.is_null("rho0") else of.number("rho0"),
        witnesses=of.array("witnesses", None, n + 3),
        points=of.entry("tables").array("points", None).astype(np.int64),
    )


def _load_from(of: _Entry) -> ProofLoad:
    kind, point = of.choice("kind", ("fixed", "free", "cone")), of.array("point", 3)
    if kind == "fixed":
        return SteadyLoad(point, of.array("force", 3), of.array("moment", 3))
    if kind == "free":
        return AnyDirection(point, of.number("size"), of.array("basis", 3, None))
    return InCone(point, of.number("size"), of.array("axis", 3), of.number("half_angle"))


def _constraint_from(of: _Entry) -> ProofConstraint:
    name, kind = of.text("name"), of.choice("kind", ("plane", "direction", "distance"))
    if kind == "distance":
        return PointByDistance(
            name,
            of.array("point", 3),
            of.array("center", 3),
            of.array("weights", 3),
            of.integer("sign", -1, 1),
            of.number("bound"),
        )
    normal, offset = of.array("normal", 3), of.number("offset")
    if kind == "plane":
        return PointOverPlane(name, of.array("point", 3), normal, offset)
    return DirectionOverPlane(name, of.array("axis", 3), normal, offset)


class _Entry:
    """One dictionary of the data, and where it stands."""

    def __init__(self, data: Any, where: str) -> None:
        if not isinstance(data, Mapping):
            raise InputError(f"{where or 'statement'}: expected keys with values, found {data!r}")
        self._data, self._where = data, where

    def _at(self, key: str) -> str:
        return f"{self._where}.{key}" if self._where else key

    def _value(self, key: str) -> Any:
        if key not in self._data:
            raise InputError(f"{self._at(key)} is missing")
        return self._data[key]

    def _refused(self, key: str, expected: str) -> InputError:
        found = repr(self._value(key))
        shown = found if len(found) <= 60 else f"{found[:60]}…"
        return InputError(f"{self._at(key)}: expected {expected}, found {shown}")

    def is_null(self, key: str) -> bool:
        return self._value(key) is None

    def text(self, key: str) -> str:
        value = self._value(key)
        if not isinstance(value, str):
            raise self._refused(key, "a text")
        return value

    def choice(self, key: str, words: tuple[str, ...]) -> str:
        if self.text(key) not in words:
            raise self._refused(key, " or ".join(words))
        return self.text(key)

    def texts(self, key: str) -> tuple[str, ...]:
        value = self._value(key)
        if not (isinstance(value, list) and all(isinstance(one, str) for one in value)):
            raise self._refused(key, "a list of texts")
        return tuple(value)

    def flags(self, key: str, count: int) -> BoolArray:
        value = self._value(key)
        fits = isinstance(value, list) and len(value) == count
        if not (fits and all(isinstance(one, bool) for one in value)):
            raise self._refused(key, f"a list of {count} times true or false")
        return np.array(value, dtype=bool)

    def number(self, key: str) -> float:
        value = self._value(key)
        if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
            raise self._refused(key, "a finite number")
        return float(value)

    def integer(self, key: str, least: int, most: int) -> int:
        value = self._value(key)
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise self._refused(key, f"an integer from {least} to {most}")
        return value

    def array(self, key: str, *shape: int | None) -> Array:
        """Numbers of a shape; None is any size."""
        expected = " x ".join("any" if size is None else str(size) for size in shape)
        refused = self._refused(key, f"{expected} numbers in lists")
        try:
            found = np.array(self._value(key))
        except ValueError:
            raise refused from None
        if not found.size and shape[0] is None:
            return np.zeros([size or 0 for size in shape])
        if found.dtype.kind not in "if" or found.ndim != len(shape):
            raise refused
        if any(want not in (None, size) for want, size in zip(shape, found.shape, strict=True)):
            raise refused
        if not np.isfinite(found).all():
            raise refused
        return np.asarray(found, dtype=float)

    def entry(self, key: str) -> _Entry:
        return _Entry(self._value(key), self._at(key))

    def entries(self, key: str) -> list[_Entry]:
        value = self._value(key)
        if not isinstance(value, list):
            raise self._refused(key, "a list")
        return [_Entry(one, f"{self._at(key)}[{i}]") for i, one in enumerate(value)]
