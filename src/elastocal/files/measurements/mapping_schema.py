"""The keys of mapping files."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from elastocal.files.measurements.orientations import CONVENTIONS
from elastocal.files.sections import After, Before, Section, Told, Variant, as_written, fresh
from elastocal.files.tables.numbers import LARGEST
from elastocal.files.values import Count, DegreeVector, Either, FileName, Flag, Name, Number, Vector
from elastocal.names import flaw
from elastocal.reading import is_character_set


def is_place(value: Any) -> bool:
    """Whether it can be a column: a name, or a number from 1."""
    number = isinstance(value, int) and not isinstance(value, bool) and value >= 1
    return number or isinstance(value, str)


def no_place(value: Any) -> str:
    """What is said of what cannot be a column."""
    hint = "; yes, no, on and off are names in quotes" if isinstance(value, bool) else ""
    return f"expected the name of a column or its number from 1, found {as_written(value)}{hint}"


def _column(value: Any) -> Any:
    for one in value if isinstance(value, list) else [value]:
        if not is_place(one):
            raise ValueError(no_place(one))
    return value


_Place = Annotated[Any, Before(_column)]
"""A column, or a list of them for a key that names several quantities."""


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


def _listed(value: Any) -> list[str]:
    """One text or a list of texts, each of one visible line; numbers as texts."""
    found = []
    for one in value if isinstance(value, list) else [value]:
        if isinstance(one, bool) or not isinstance(one, (str, int, float)):
            hint = "; yes, no, on and off are words in quotes" if isinstance(one, bool) else ""
            raise ValueError(f"expected a word or a number, found {as_written(one)}{hint}")
        if wrong := flaw(str(one)):
            raise ValueError(wrong)
        found.append(str(one))
    if not found:
        raise ValueError("expected at least one entry, found none")
    return found


Listed = Annotated[Any, Before(_listed)]
"""One entry or several."""


class LayoutFile(Section):
    """How a file is written; what is not said is found out."""

    delimiter: Literal["comma", "semicolon", "tab", "bar", "space"] | None = None
    decimal: Literal["point", "comma"] | None = None
    encoding: Annotated[Name, After(_known_encoding)] | None = None
    skip_lines: Annotated[int, Before(_skipped)] | None = None
    header: Flag | None = None
    comment: Listed | None = None


class OneFile(LayoutFile):
    """One of several files: its layout, its columns, and how its rows belong to the others."""

    columns: dict[Name, Either[_Place, ColumnFile]] = fresh(dict)
    patterns: dict[Name, Listed] = fresh(dict)
    join: Listed | None = None


_Frame = Annotated[
    Annotated[Literal["best-fit"], Variant("word")] | Annotated[FrameFile, Variant("section")],
    Told(lambda value: "word" if isinstance(value, str) else "section"),
]


class MappingFile(LayoutFile):
    """A whole mapping file."""

    elastocal: Literal[1]
    files: list[OneFile] = fresh(list)
    join: Listed | None = None
    columns: dict[Name, Either[_Place, ColumnFile]] = fresh(dict)
    patterns: dict[Name, Listed] = fresh(dict)
    markers: dict[Name, dict[Name, Either[_Place, ColumnFile]]] = fresh(dict)
    constants: dict[Name, _Constants] = fresh(dict)
    words: dict[Name, dict[Name, Name]] = fresh(dict)
    keep: dict[Name, Listed] = fresh(dict)
    foot: Listed | None = None
    positions: Literal["absolute", "states"] | None = None
    orientation: Literal[CONVENTIONS] | None = None  # type: ignore[valid-type]
    frame: _Frame | None = None
    joints: Literal["model", "controller"] = "model"
    plan: FileName | None = None
