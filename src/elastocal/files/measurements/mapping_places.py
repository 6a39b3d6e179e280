"""The columns, constants and patterns of a mapping file: what its keys name, checked."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.columns import (
    LINE,
    NUMBER,
    PLACES,
    TIME,
    WORDS,
    Meaning,
    meaning_named,
)
from elastocal.files.measurements.mapping_schema import (
    ColumnFile,
    LayoutFile,
    MappingFile,
    no_place,
)
from elastocal.files.measurements.patterns import Pattern, pattern_of
from elastocal.files.tables.layout import COMMENTS, Style
from elastocal.files.tables.units import factor, split_header, unit_hint
from elastocal.files.yaml_lines import Located, Path_
from elastocal.robot.chain import Robot

_DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|", "space": " "}
_DECIMALS = {"point": ".", "comma": ",", None: None}


@dataclass(frozen=True)
class Place:
    """Which column of the files a quantity is in.

    Attributes:
        meaning: The quantity.
        unit: Its unit there; None to take that of the header.
        column: Name of the column, or its number from 1.
        file: Number of the file from 1; None for any that has it.
        marker: The marker it belongs to, empty for all.
        where: Place in the mapping file.
    """

    meaning: Meaning
    unit: str | None
    column: str | int
    file: int | None
    marker: str
    where: str

    @property
    def key(self) -> str:
        """Name of the column in this program."""
        return f"{self.meaning.key}@{self.marker}" if self.marker else self.meaning.key


@dataclass(frozen=True)
class Constant:
    """What is the same in all rows.

    Attributes:
        meaning: The quantity.
        values: One value, or one for each file; SI units or words.
        where: Place in the mapping file.
    """

    meaning: Meaning
    values: tuple[float | str, ...]
    where: str


def style_of(whole: LayoutFile, one: LayoutFile) -> Style:
    """How one file is written: as it says, else as is said of all."""

    def said(key: str, default: Any = None) -> Any:
        values = (getattr(one, key), getattr(whole, key))
        return next((value for value in values if value is not None), default)

    return Style(
        _DELIMITERS.get(said("delimiter")),
        _DECIMALS[said("decimal")],
        said("encoding"),
        said("skip_lines", 0),
        said("header", True),
        tuple(said("comment", COMMENTS)),
    )


def places_of(document: Located, file: MappingFile, robot: Robot) -> Iterator[Place]:
    """The columns that a mapping names.

    Raises:
        MeasurementFileError: a quantity or a unit that there is not, another number of columns.
    """
    sections: list[tuple[Path_, str, dict[str, Any], int | None]] = [
        (("columns",), "", file.columns, None)
    ]
    sections += [(("markers", name), name, each, None) for name, each in file.markers.items()]
    sections += [
        (("files", i, "columns"), "", one.columns, i + 1) for i, one in enumerate(file.files)
    ]
    parts: Sequence[LayoutFile] = file.files or [file]
    headers = [style_of(file, one).header for one in parts]
    for path, marker, columns, of in sections:
        for name, column in columns.items():
            where = document.where((*path, name))
            several = isinstance(column, ColumnFile)
            if several and of is not None:
                raise MeasurementFileError(
                    f"{where}: {name}: 'file' belongs to columns of the whole mapping, not to "
                    "those of one file"
                )
            number = column.file if isinstance(column, ColumnFile) else of
            given = column.column if isinstance(column, ColumnFile) else column
            numbered = not (
                headers[number - 1] if number and len(headers) >= number > 0 else any(headers)
            )
            names, unit = _quantities(name, isinstance(given, list), robot, where)
            single = isinstance(given, list) and len(names) == 1
            given = given if isinstance(given, list) else [given]
            if single or len(given) != len(names):
                if single:
                    path_ = ".".join((*map(str, path), name))
                    raise MeasurementFileError(f"{where}: {path_}: {no_place(given)}")
                raise MeasurementFileError(
                    f"{where}: {name}: expected {len(names)} columns, one for each of "
                    f"{', '.join(m.name for m in names)}, found {len(given)}"
                )
            for meaning, one in zip(names, given, strict=True):
                place = _place(name, one, where, numbered=numbered)
                bare = meaning.kind in ("", NUMBER) or meaning.key == TIME
                if not bare and unit is None and isinstance(place, int):
                    raise MeasurementFileError(
                        f"{where}: {name!r} has no unit; expected it in brackets, such as "
                        f"{meaning.example!r}"
                    )
                yield Place(meaning, unit, place, number, marker, where)


def _place(name: str, place: Any, where: str, *, numbered: bool) -> str | int:
    """The name of a column, single spaces, or its number from 1."""
    if isinstance(place, str):
        place = " ".join(place.split())
        if not place:
            raise MeasurementFileError(f"{where}: {name}: the name of the column is empty")
        if numbered and not re.fullmatch("[0-9]{1,9}", place):
            raise MeasurementFileError(
                f"{where}: {name}: with 'header: false' columns have numbers, found {place!r}"
            )
    return int(place) if numbered else place


def _quantities(
    name: str, several: bool, robot: Robot, where: str
) -> tuple[list[Meaning], str | None]:
    """The quantities that a key names: one, all joints as 'q [deg]', or some as 'x y z [mm]'."""
    bare, unit = split_header(name)
    if not several or meaning_named(bare, robot) is not None:
        meaning, unit = _quantity(name, robot, where)
        return [meaning], unit
    names = {"q": list(robot.joint_names), "torque": [f"torque {n}" for n in robot.joint_names]}
    ending = f" [{unit}]" if unit is not None else ""
    each = names.get(bare, bare.split())
    found = [_quantity(f"{one}{ending}", robot, where)[0] for one in each]
    return found, unit


def _quantity(name: str, robot: Robot, where: str) -> tuple[Meaning, str | None]:
    """The quantity and unit that a key such as 'x [mm]' names."""
    bare, unit = split_header(name)
    meaning = Meaning(LINE, LINE) if bare == LINE else meaning_named(bare, robot)
    if meaning is None:
        raise MeasurementFileError(
            f"{where}: there is no quantity {bare!r}; expected a joint "
            f"({', '.join(robot.joint_names)}) or a column of measurements.csv such as "
            "experiment, marker, state, 'Fx [N]', 'dx [mm]', 'x [mm]', 'u [mm]', 'U95 [mm]'"
        )
    if unit and meaning.kind in ("", NUMBER):
        raise MeasurementFileError(f"{where}: {bare!r} has no unit, found {unit!r}")
    if unit and factor(unit, meaning.kind) is None:
        raise MeasurementFileError(
            f"{where}: unit {unit!r} is not accepted for {meaning.name!r}; "
            f"{unit_hint(unit, meaning.kind)}"
        )
    return meaning, unit


def patterns_of(document: Located, file: MappingFile) -> Iterator[Pattern]:
    """The patterns of a mapping, checked."""
    sections: list[tuple[Path_, dict[str, Any], int | None]] = [
        (("patterns",), file.patterns, None)
    ]
    sections += [
        (("files", i, "patterns"), one.patterns, i + 1) for i, one in enumerate(file.files)
    ]
    for path, patterns, of in sections:
        for column, texts in patterns.items():
            where = document.where((*path, column))
            tried = tuple(pattern_of(text, where) for text in texts)
            yield Pattern(" ".join(column.split()), of, tried, where)


def constants_of(document: Located, file: MappingFile, robot: Robot) -> Iterator[Constant]:
    """What no column says, in SI units."""
    for name, given in file.constants.items():
        where = document.where(("constants", name))
        meaning, unit = _quantity(name, robot, where)
        values = given if isinstance(given, list) else [given]
        if not values:
            raise MeasurementFileError(f"{where}: {name}: expected a value, found an empty list")
        if not meaning.kind:
            words = (f"{v:g}" if isinstance(v, float) else v for v in values)
            yield Constant(meaning, tuple(words), where)
            continue
        if unit is None:
            raise MeasurementFileError(
                f"{where}: {name!r} has no unit; expected it in brackets, such as "
                f"{meaning.example!r}"
            )
        scale = factor(unit, meaning.kind)
        assert scale is not None
        numbers = []
        for value in values:
            if not isinstance(value, float):
                raise MeasurementFileError(f"{where}: {name}: expected a number, found {value!r}")
            numbers.append(scale * value)
        yield Constant(meaning, tuple(numbers), where)


def check_once(
    document: Located, places: tuple[Place, ...], constants: tuple[Constant, ...]
) -> None:
    """Refuse a quantity that is given twice, or not for every marker."""
    seen: dict[str, set[int | None]] = {}
    entries = [(p.key, p.meaning.key, p.file, p.where) for p in places]
    entries += [(c.meaning.key, c.meaning.key, -1, c.where) for c in constants]
    wide = {p.meaning.key for p in places if p.marker} | (
        {"marker"} if any(p.marker for p in places) else set()
    )
    for key, bare, file, where in entries:
        files = seen.setdefault(key, set())
        again = file in files or (file == -1 and files)
        if again or (key == bare and bare in wide):
            raise MeasurementFileError(twice(bare, where))
        files.add(file)
    by_marker: dict[str, set[str]] = {}
    for place in places:
        if place.marker:
            by_marker.setdefault(place.marker, set()).add(place.meaning.key)
    for marker, keys in by_marker.items():
        lacking = sorted(wide - {"marker"} - keys)
        if lacking:
            raise MeasurementFileError(
                f"{document.where(('markers', marker))}: marker {marker!r} has no column for "
                f"{lacking[0]!r}, which other markers have"
            )


def twice(key: str, where: str) -> str:
    """What is said of a quantity for which a mapping has two places."""
    return f"{where}: {key.removeprefix('q:')!r} is given twice in this mapping"


def check_words(document: Located, file: MappingFile, columns: set[str]) -> None:
    """Refuse words that nothing is translated by: of no column, or twice."""
    for name, words in file.words.items():
        where = document.where(("words", name))
        if name not in (*WORDS, *PLACES):
            raise MeasurementFileError(
                f"{where}: words: {name!r} has no words to translate; expected one of "
                f"{', '.join((*WORDS, *PLACES))}"
            )
        if name not in columns:
            raise MeasurementFileError(
                f"{where}: words of {name!r}, for which this mapping names no column; expected "
                f"{name!r} under 'columns'"
            )
        seen: dict[str, str] = {}
        for theirs, ours in words.items():
            if seen.setdefault(theirs.lower(), ours) != ours:
                raise MeasurementFileError(
                    f"{document.where(('words', name, theirs))}: words of {name!r}: {theirs!r} is "
                    f"{ours!r} here and {seen[theirs.lower()]!r} in other letters; small and "
                    "capital ones are not told apart"
                )
