"""What the columns of a measurement file mean: by name and unit, never by position."""

from __future__ import annotations

import difflib
from collections.abc import Container, Sequence
from dataclasses import dataclass, replace

from elastocal.errors import MeasurementFileError
from elastocal.files.tables.units import UNITS, factor, spelled, split_header, unit_hint
from elastocal.robot.chain import Robot

AXES = ("x", "y", "z")
WORDS = ("experiment", "marker", "state", "valid", "delete")
PLACES = ("series", "station", "mounting", "payload")
"""Words of campaigns in several parts, and of absolute readings."""
LINE = "line"
"""A word that only mappings have: the line of the first file that a row belongs to."""
TIME, STAMP = "time", "time stamp"
ANGLES = ("rx", "ry", "rz")
QUATERNION = ("qw", "qx", "qy", "qz")
NUMBER = "number"
"""Kind of a quantity that has no unit."""
FORCES = tuple(f"F{axis}" for axis in AXES)
TORQUES = tuple(f"T{axis}" for axis in AXES)
MASS = "hanging mass"
DEFLECTIONS = tuple(f"d{axis}" for axis in AXES)
ROTATIONS = tuple(f"dr{axis}" for axis in AXES)


@dataclass(frozen=True)
class Triple:
    """Three columns that are one reading, and those that may say how certain it is.

    Attributes:
        what: What is read, in words.
        values: The columns.
        uncertainties: Columns with its uncertainty: one of these kinds.
        covariances: Columns with the covariances of its axes.
        unit: Unit in which people read them; a thousandth of the SI unit.
        covariance_unit: That of the covariances.
    """

    what: str
    values: tuple[str, ...]
    uncertainties: tuple[tuple[str, ...], ...]
    covariances: tuple[str, ...]
    unit: str
    covariance_unit: str

    @property
    def columns(self) -> tuple[str, ...]:
        """All of them."""
        return (*self.values, *self.noise)

    @property
    def noise(self) -> tuple[str, ...]:
        """Those that say how certain it is."""
        return (*(n for kind in self.uncertainties for n in kind), *self.covariances)


POSITION = Triple(
    "deflection",
    DEFLECTIONS,
    (("u",), ("ux", "uy", "uz"), ("U95",), ("U95x", "U95y", "U95z")),
    ("cxy", "cxz", "cyz"),
    "mm",
    "mm2",
)
ROTATION = Triple(
    "rotation",
    ROTATIONS,
    (("ur",), ("urx", "ury", "urz"), ("U95r",), ("U95rx", "U95ry", "U95rz")),
    ("crxy", "crxz", "cryz"),
    "mrad",
    "mrad2",
)
PLACE = replace(POSITION, what="position", values=AXES)
"""Where a reflector was read."""
TURN = replace(ROTATION, what="orientation", values=ANGLES)
"""How a probe was turned; its values may be a quaternion, too."""
_KINDS: dict[str, str] = {
    **dict.fromkeys(FORCES, "force"),
    **dict.fromkeys(TORQUES, "torque"),
    MASS: "mass",
    **dict.fromkeys(DEFLECTIONS, "length"),
    **dict.fromkeys(AXES, "length"),
    **dict.fromkeys(ROTATION.columns, "rotation"),
    **{name: "length" for names in POSITION.uncertainties for name in names},
    **dict.fromkeys(POSITION.covariances, "covariance"),
    **dict.fromkeys(ROTATION.covariances, "covariance of rotations"),
    **dict.fromkeys(ANGLES, "angle"),
    **dict.fromkeys(QUATERNION, NUMBER),
    TIME: "time",
}
_OF_POSITIONS = {*PLACES, TIME, *ANGLES, *QUATERNION}
"""What only absolute readings have, or campaigns that a mapping explains."""
_CASE_MATTERS = {"u", "ux", "uy", "uz", "ur", "urx", "ury", "urz"}
"""A capital U is an expanded uncertainty by custom, so it must not pass for a standard one."""


@dataclass(frozen=True)
class Meaning:
    """A quantity that a measurement file can have.

    Attributes:
        key: Name in this program: that of the column; "q:" and the name for a joint.
        name: Name of its column.
        kind: Kind of quantity for its unit, empty for words.
    """

    key: str
    name: str
    kind: str = ""

    @property
    def example(self) -> str:
        """A header that would do."""
        if self.kind in ("", NUMBER):
            return self.name
        return f"{self.name} [{next(iter(UNITS[self.kind]))}]"


@dataclass(frozen=True)
class Column:
    """A column that is used.

    Attributes:
        meaning: What is in it.
        index: Its place in the file.
        header: Its header, for messages.
        factor: From its unit to SI.
        unit: Its unit, in our spelling.
        optional: Whether its cells may be empty, where nothing was read.
    """

    meaning: Meaning
    index: int
    header: str
    factor: float = 1.0
    unit: str = ""
    optional: bool = False


def meanings(robot: Robot) -> dict[str, Meaning]:
    """Everything a file for this robot can have, by key; joints first."""
    found = {
        f"q:{joint.name}": Meaning(f"q:{joint.name}", joint.name, joint.kind.quantity)
        for joint in robot.joints
    }
    found |= {name: Meaning(name, name) for name in (*WORDS, *PLACES)}
    found |= {name: Meaning(name, name, kind) for name, kind in _KINDS.items()}
    for joint in robot.joints:
        name, kind = f"torque {joint.name}", "force" if joint.prismatic else "torque"
        found[f"t:{joint.name}"] = Meaning(f"t:{joint.name}", name, kind)
    return found


def raw(name: str) -> Meaning:
    """A column that means nothing here, by whose words rows are chosen."""
    return Meaning(f"raw:{name}", name)


def meaning_named(name: str, robot: Robot) -> Meaning | None:
    """The quantity with this name, in any case if that is unambiguous; None if there is none."""
    known = meanings(robot)
    return next((m for m in known.values() if _places(m, [name], known)), None)


def columns_by_name(
    header: Sequence[str],
    robot: Robot,
    where: str,
    *,
    rotation: bool = True,
    absolute: bool = False,
) -> dict[str, Column]:
    """The columns of a canonical file, by key; columns that mean nothing here are left out.

    Args:
        header: Headers of the file.
        robot: Whose joints it has.
        where: Place of the header, for messages.
        rotation: Whether rotations mean something.
        absolute: Whether positions are absolute readings, and not deflections.

    Raises:
        MeasurementFileError: two columns for one quantity; a unit missing or of the wrong kind.
    """
    known = meanings(robot)
    found: dict[str, Column] = {}
    parts = [split_header(cell) for cell in header]
    names = [name for name, _ in parts]
    _check_capitals(header, names, known, where)
    used = _absolute(known) if absolute else _needed(known, names, rotation=rotation)
    for meaning in used:
        places = _places(meaning, names, known)
        if not places:
            continue
        if len(places) > 1:
            a, b = (header[i] for i in places[:2])
            twice = f"column {a!r} appears twice" if a == b else f"two columns, {a!r} and {b!r}"
            raise MeasurementFileError(f"{where}: {twice}; expected one for {meaning.name!r}")
        index = places[0]
        column = column_of(meaning, index, header[index], parts[index][1], where)
        found[column.meaning.key] = column
    return found


def column_of(meaning: Meaning, index: int, header: str, unit: str | None, where: str) -> Column:
    """The column of a quantity with its unit.

    Raises:
        MeasurementFileError: the unit is missing or of the wrong kind.
    """
    if meaning.key == TIME and not unit:
        meaning = Meaning(STAMP, TIME)
    if not meaning.kind:
        return Column(meaning, index, header)
    if meaning.kind == NUMBER:
        if unit not in (None, "", "-"):
            raise MeasurementFileError(
                f"{where}: column {header!r}: {meaning.name!r} is a number without unit, found "
                f"{unit!r}"
            )
        return Column(meaning, index, header)
    if not unit:
        raise MeasurementFileError(
            f"{where}: column {header!r} has no unit; expected it in brackets, such as "
            f"{meaning.example!r}"
        )
    scale = factor(unit, meaning.kind)
    if scale is None:
        raise MeasurementFileError(
            f"{where}: column {header!r}: unit {unit!r} is not accepted for {meaning.name!r}; "
            f"{unit_hint(unit, meaning.kind)}"
        )
    return Column(meaning, index, header, scale, spelled(unit))


def _check_capitals(
    header: Sequence[str], names: Sequence[str], known: dict[str, Meaning], where: str
) -> None:
    exact = {m.name for m in known.values()}
    for cell, name in zip(header, names, strict=True):
        if name.lower() in _CASE_MATTERS and name not in exact:
            r = "r" if name.lower().startswith("ur") else ""
            unit = (ROTATION if r else POSITION).unit
            raise MeasurementFileError(
                f"{where}: column {cell!r} is ambiguous; write 'u{r} [{unit}]' for standard or "
                f"'U95{r} [{unit}]' for expanded uncertainties (k = 2), per axis"
            )


def _needed(known: dict[str, Meaning], names: Sequence[str], *, rotation: bool) -> list[Meaning]:
    """All quantities but rotations nobody reads, and positions that no `state` makes sense of."""
    states = any(name.lower() == "state" for name in names)
    deflections = any(name.lower() in DEFLECTIONS for name in names)
    without = set(AXES) if deflections and not states else set()
    without |= set() if rotation else set(ROTATION.columns)
    without |= _OF_POSITIONS
    return [m for key, m in known.items() if key not in without and not key.startswith("t:")]


def _absolute(known: dict[str, Meaning]) -> list[Meaning]:
    """All that absolute readings have."""
    without = {*DEFLECTIONS, *ROTATIONS}
    return [meaning for key, meaning in known.items() if key not in without]


def _places(meaning: Meaning, names: Sequence[str], known: dict[str, Meaning]) -> list[int]:
    """Where a quantity stands: under its own name; else in other case, if that is no other's."""
    rivals = [m for m in known.values() if m.key != meaning.key]
    if not meaning.key.startswith("q:") and any(m.name == meaning.name for m in rivals):
        return []  # a joint has this name
    places = [i for i, name in enumerate(names) if name == meaning.name]
    low = meaning.name.lower()
    if places or low in _CASE_MATTERS or any(m.name.lower() == low for m in rivals):
        return places
    return [i for i, name in enumerate(names) if name.lower() == low]


def missing(keys: Sequence[str], found: Container[str], free: Sequence[str], robot: Robot) -> str:
    """'column ... is missing' for the first of `keys` not found, empty if all are.

    Args:
        keys: What is wanted.
        found: What is there.
        free: Headers without a meaning, to say which was probably meant.
        robot: Whose joints are meant.
    """
    known = meanings(robot)
    for key in keys:
        if key in found:
            continue
        meaning = known[key]
        bare = {name: split_header(name)[0].split("(")[0].strip() for name in free}
        near = [n for n, b in bare.items() if b.lower() == meaning.name.lower()]
        near = near or [
            n
            for n, b in bare.items()
            if b and b in difflib.get_close_matches(meaning.name, [b], 1, 0.6)
        ]
        hint = f", found {near[0]!r}" if near else ""
        return f"column {meaning.example!r} is missing{hint}"
    return ""
