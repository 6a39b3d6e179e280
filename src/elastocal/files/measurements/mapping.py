"""Mapping files: from YAML to what the columns of foreign measurement files mean."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError, MeasurementFileError
from elastocal.files.measurements.columns import WORDS, Meaning, meaning_named
from elastocal.files.problems import first_problem
from elastocal.files.sections import (
    After,
    Before,
    Section,
    SectionError,
    Told,
    Variant,
    as_written,
    fresh,
)
from elastocal.files.tables.layout import Style
from elastocal.files.tables.numbers import LARGEST
from elastocal.files.tables.units import factor, split_header, unit_hint
from elastocal.files.texts import is_version, read_text
from elastocal.files.values import Count, DegreeVector, Either, Flag, Name, Number, Vector
from elastocal.files.yaml_lines import Located, Path_, parse
from elastocal.reading import is_character_set
from elastocal.robot.chain import Robot
from elastocal.robot.rotations import from_zyx_angles

_LARGEST = 1_000_000  # bytes
_BARE_UNIT = re.compile(r"\{[^}\"'\n]*\w \[")  # a key with its unit, not quoted, in braces
_DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|", "space": " "}


def _column(value: Any) -> Any:
    number = isinstance(value, int) and not isinstance(value, bool) and value >= 1
    if not (number or isinstance(value, str)):
        hint = "; yes, no, on and off are names in quotes" if isinstance(value, bool) else ""
        found = as_written(value)
        raise ValueError(f"expected the name of a column or its number from 1, found {found}{hint}")
    return value


_Place = Annotated[int | str, Before(_column)]


def _skipped(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= 10_000:
        raise ValueError(f"expected a whole number from 0 to 10000, found {as_written(value)}")
    return value


class ColumnFile(Section):
    """A column of one of several files."""

    file: Count
    column: _Place


class FrameFile(Section):
    """Rotation from the frame of the readings to the base frame."""

    rpy_deg: DegreeVector | None = None
    matrix: list[Vector] | None = None


_Column = Either[_Place, ColumnFile]


def _known_encoding(name: str) -> str:
    if not is_character_set(name):
        raise ValueError(
            f"no encoding {name!r} of text is known; expected one such as utf-8, cp1252, utf-16-le "
            "or gb18030"
        )
    return name


def _usual(value: float) -> float:
    if not abs(value) < LARGEST:
        raise ValueError(f"expected a number below {LARGEST:g}, found {value:g}")
    return value


_Constant = Annotated[
    Annotated[Name, Variant("word")] | Annotated[Number, After(_usual), Variant("number")],
    Told(lambda value: "word" if isinstance(value, str) else "number"),
]
_Constants = Annotated[
    Annotated[_Constant, Variant("one")] | Annotated[list[_Constant], Variant("several")],
    Told(lambda value: "several" if isinstance(value, list) else "one"),
]


class MappingFile(Section):
    """A whole mapping file."""

    elastocal: Literal[1]
    delimiter: Literal["comma", "semicolon", "tab", "bar", "space"] | None = None
    decimal: Literal["point", "comma"] | None = None
    encoding: Annotated[Name, After(_known_encoding)] | None = None
    skip_lines: Annotated[int, Before(_skipped)] = 0
    header: Flag = True
    columns: dict[Name, _Column]
    markers: dict[Name, dict[Name, _Column]] = fresh(dict)
    constants: dict[Name, _Constants] = fresh(dict)
    words: dict[Name, dict[Name, Name]] = fresh(dict)
    frame: FrameFile | None = None
    joints: Literal["model", "controller"] = "model"


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


@dataclass(frozen=True)
class FieldMapping:
    """A mapping file.

    Attributes:
        path: Where it is.
        sha256: Hash of its text.
        style: How the files are written.
        places: Columns that are used.
        constants: What no column says.
        words: Our word for each of theirs, by column.
        rotation: (3, 3) from the frame of the readings to the base; None if they are in it.
        controller: Whether the joint values are those of the controller.
        markers: Markers that have columns of their own.
    """

    path: Path
    sha256: str
    style: Style
    places: tuple[Place, ...]
    constants: tuple[Constant, ...]
    words: dict[str, dict[str, str]]
    rotation: Array | None
    controller: bool
    markers: tuple[str, ...]


def read_mapping(path: str | Path, robot: Robot) -> FieldMapping:
    """The mapping in a file.

    Args:
        path: The file.
        robot: Whose joints it names.

    Raises:
        MeasurementFileError: the file is wrong; the message names line and key.
    """
    path = Path(path)
    text = ""
    try:
        text = read_text(path, largest=_LARGEST)
        document = parse(text, path)
    except InputError as error:
        hint = '; in braces, quote keys with brackets: {"x [mm]": X}'
        raise MeasurementFileError(f"{error}{hint * bool(_BARE_UNIT.search(text))}") from None
    file = _validated(document)
    style = Style(
        _DELIMITERS[file.delimiter] if file.delimiter else None,
        {"point": ".", "comma": ",", None: None}[file.decimal],
        file.encoding,
        file.skip_lines,
        file.header,
    )
    places = tuple(_places(document, file, robot))
    constants = tuple(_constants(document, file, robot))
    _check_once(document, places, constants)
    _check_words(document, file, {place.meaning.key for place in places})
    return FieldMapping(
        path,
        hashlib.sha256(text.encode()).hexdigest(),
        style,
        places,
        constants,
        file.words,
        _rotation(document, file.frame),
        file.joints == "controller",
        tuple(file.markers),
    )


def _validated(document: Located) -> MappingFile:
    value = document.value
    if not isinstance(value, dict):
        raise MeasurementFileError(
            f"{document.where(())}: expected keys such as 'columns:', found {type(value).__name__}"
        )
    if not is_version(value.get("elastocal")):
        raise MeasurementFileError(
            f"{document.where(('elastocal',))}: a mapping file begins with 'elastocal: 1', the "
            f"version of its format; found {value.get('elastocal')!r}"
        )
    try:
        return MappingFile.of(value)
    except SectionError as error:
        raise MeasurementFileError(first_problem(document, error, MappingFile)) from None


def _places(document: Located, file: MappingFile, robot: Robot) -> Iterator[Place]:
    sections: list[tuple[Path_, str, dict[str, Any]]] = [(("columns",), "", file.columns)]
    sections += [(("markers", name), name, columns) for name, columns in file.markers.items()]
    for path, marker, columns in sections:
        for name, column in columns.items():
            where = document.where((*path, name))
            meaning, unit = _quantity(name, robot, where)
            several = isinstance(column, ColumnFile)
            place = column.column if isinstance(column, ColumnFile) else column
            if isinstance(place, str):
                place = " ".join(place.split())
                if not place:
                    raise MeasurementFileError(f"{where}: {name}: the name of the column is empty")
                if not file.header and not re.fullmatch("[0-9]{1,9}", place):
                    raise MeasurementFileError(
                        f"{where}: {name}: with 'header: false' columns have numbers, found "
                        f"{place!r}"
                    )
            if not file.header:
                place = int(place)
            if meaning.kind and unit is None and (isinstance(place, int)):
                raise MeasurementFileError(
                    f"{where}: {name!r} has no unit; expected it in brackets, such as "
                    f"{meaning.example!r}"
                )
            yield Place(meaning, unit, place, column.file if several else None, marker, where)


def _quantity(name: str, robot: Robot, where: str) -> tuple[Meaning, str | None]:
    """The quantity and unit that a key such as 'x [mm]' names."""
    bare, unit = split_header(name)
    meaning = meaning_named(bare, robot)
    if meaning is None:
        raise MeasurementFileError(
            f"{where}: there is no quantity {bare!r}; expected a joint "
            f"({', '.join(robot.joint_names)}) or a column of measurements.csv such as "
            "experiment, marker, state, 'Fx [N]', 'dx [mm]', 'x [mm]', 'u [mm]', 'U95 [mm]'"
        )
    if unit and not meaning.kind:
        raise MeasurementFileError(f"{where}: {bare!r} has no unit, found {unit!r}")
    if unit and factor(unit, meaning.kind) is None:
        raise MeasurementFileError(
            f"{where}: unit {unit!r} is not accepted for {meaning.name!r}; "
            f"{unit_hint(unit, meaning.kind)}"
        )
    return meaning, unit


def _constants(document: Located, file: MappingFile, robot: Robot) -> Iterator[Constant]:
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


def _check_once(
    document: Located, places: tuple[Place, ...], constants: tuple[Constant, ...]
) -> None:
    seen: dict[str, str] = {}
    entries = [(p.key, p.meaning.key, p.where) for p in places]
    entries += [(c.meaning.key, c.meaning.key, c.where) for c in constants]
    wide = {p.meaning.key for p in places if p.marker} | ({"marker"} if _wide(places) else set())
    for key, bare, where in entries:
        twice = key in seen or (key == bare and bare in wide)
        if twice:
            raise MeasurementFileError(
                f"{where}: {bare.removeprefix('q:')!r} is given twice in this mapping"
            )
        seen[key] = where
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


def _check_words(document: Located, file: MappingFile, columns: Collection[str]) -> None:
    """Refuse words that nothing is translated by: of no column, or twice."""
    for name, words in file.words.items():
        where = document.where(("words", name))
        if name not in WORDS:
            raise MeasurementFileError(
                f"{where}: words: {name!r} has no words to translate; expected one of "
                f"{', '.join(WORDS)}"
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


def _wide(places: tuple[Place, ...]) -> bool:
    return any(place.marker for place in places)


def _rotation(document: Located, frame: FrameFile | None) -> Array | None:
    """The rotation of a `frame` section; roll, pitch, yaw about the fixed x, y, z axes."""
    if frame is None:
        return None
    where = document.where(("frame",))
    if (frame.rpy_deg is None) == (frame.matrix is None):
        raise MeasurementFileError(f"{where}: frame: expected either rpy_deg or matrix")
    if frame.rpy_deg is not None:
        return from_zyx_angles(np.array([frame.rpy_deg[::-1]]))[0]
    matrix = np.array(frame.matrix)
    if matrix.shape != (3, 3) or np.abs(matrix @ matrix.T - np.eye(3)).max() > 1e-4:
        raise MeasurementFileError(
            f"{where}: frame: the matrix is no rotation; expected three rows of three numbers, "
            "orthogonal to 1e-4"
        )
    if np.linalg.det(matrix) < 0.0:
        raise MeasurementFileError(
            f"{where}: frame: the matrix is a reflection; expected a right-handed rotation"
        )
    left, _, right = np.linalg.svd(matrix)
    return np.asarray(left @ right)
