"""Mapping files: what the columns of a foreign measurement file mean."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from elastocal.files.schema.values import Count, Flag, Name, Number, Section, Vector


class ColumnFile(Section):
    """A column of one of several files."""

    file: Count
    column: Annotated[int, Field(ge=1)] | str


class FrameFile(Section):
    """Rotation from the frame of the readings to the base frame."""

    rpy_deg: Vector | None = None
    matrix: list[Vector] | None = None


Place = Annotated[int, Field(ge=1, strict=True)] | Annotated[str, Field(strict=True)] | ColumnFile


class MappingFile(Section):
    """A whole mapping file."""

    elastocal: Literal[1]
    delimiter: Literal["comma", "semicolon", "tab", "bar", "space"] | None = None
    decimal: Literal["point", "comma"] | None = None
    encoding: Name | None = None
    skip_lines: Annotated[int, Field(ge=0, le=10_000, strict=True)] = 0
    header: Flag = True
    columns: dict[Name, Place]
    markers: dict[Name, dict[Name, Place]] = Field(default_factory=dict)
    constants: dict[Name, Number | Name | list[Number | Name]] = Field(default_factory=dict)
    words: dict[Name, dict[Name, Name]] = Field(default_factory=dict)
    frame: FrameFile | None = None
    joints: Literal["model", "controller"] = "model"
