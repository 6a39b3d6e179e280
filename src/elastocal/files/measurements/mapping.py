"""Mapping files: from YAML to what the columns of foreign measurement files mean."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError, MeasurementFileError
from elastocal.files.measurements.columns import LINE
from elastocal.files.measurements.mapping_places import (
    Constant,
    Place,
    check_once,
    check_words,
    constants_of,
    patterns_of,
    places_of,
    style_of,
)
from elastocal.files.measurements.mapping_schema import FrameFile, LayoutFile, MappingFile
from elastocal.files.measurements.patterns import SPLIT, Pattern
from elastocal.files.problems import first_problem
from elastocal.files.sections import SectionError
from elastocal.files.tables.layout import Style
from elastocal.files.texts import is_version, read_text
from elastocal.files.yaml_lines import Located, Path_, parse
from elastocal.robot.chain import Robot
from elastocal.robot.rotations import from_zyx_angles

_LARGEST = 1_000_000  # bytes
_BARE_UNIT = re.compile(r"\{[^}\"'\n]*\w \[")  # a key with its unit, not quoted, in braces
ORDER = "order"
"""Rows of a file belong to those of the others in their order."""


@dataclass(frozen=True)
class FieldMapping:
    """A mapping file.

    Attributes:
        path: Where it is.
        sha256: Hash of its text.
        styles: How each file is written; one for all where it does not tell them apart.
        places: Columns that are used.
        patterns: How the words of columns are split.
        joins: By which words the rows of each file belong to those of the first; () in their
            order. One for all behind the first where it does not tell them apart.
        constants: What no column says.
        words: Our word for each of theirs, by column.
        keep: By which words rows are chosen, by column.
        foot: Names of reflectors that stand still.
        absolute: Whether positions are absolute readings; None if that is not said.
        orientation: What the three angles of a probe are, None if not said.
        rotation: (3, 3) from the frame of the readings to the base; None if they are in it.
        best_fit: Whether that rotation is to be found from the unloaded positions.
        controller: Whether the joint values are those of the controller.
        plan: Plan that says the joints, relative to the mapping; None: a column does.
        markers: Markers that have columns of their own.
    """

    path: Path
    sha256: str
    styles: tuple[Style, ...]
    places: tuple[Place, ...]
    patterns: tuple[Pattern, ...]
    joins: tuple[tuple[str, ...], ...]
    constants: tuple[Constant, ...]
    words: dict[str, dict[str, str]]
    keep: dict[str, tuple[str, ...]]
    foot: tuple[str, ...]
    absolute: bool | None
    orientation: str | None
    rotation: Array | None
    best_fit: bool
    controller: bool
    plan: str | None
    markers: tuple[str, ...]

    def style(self, i: int) -> Style:
        """How the file with this index is written."""
        return self.styles[i if len(self.styles) > 1 else 0]

    def join(self, i: int) -> tuple[str, ...]:
        """By which words the rows of the file with this index belong to those of the first."""
        return self.joins[i if len(self.styles) > 1 else min(i, 1)]


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
    parts: Sequence[LayoutFile] = file.files or [file]
    patterns = tuple(patterns_of(document, file))
    places = tuple(places_of(document, file, robot))
    constants = tuple(constants_of(document, file, robot))
    split = {word for pattern in patterns for word in pattern.words}
    check_once(document, places, constants)
    check_words(document, file, {place.meaning.key for place in places} | split)
    if not places:
        raise MeasurementFileError(f"{document.where(())}: key 'columns' is missing")
    return FieldMapping(
        path,
        hashlib.sha256(text.encode()).hexdigest(),
        tuple(style_of(file, one) for one in parts),
        places,
        patterns,
        _joins(document, file),
        constants,
        file.words,
        {name: tuple(values) for name, values in file.keep.items()},
        tuple(file.foot or ()),
        None if file.positions is None else file.positions == "absolute",
        file.orientation,
        None if isinstance(file.frame, str) else _rotation(document, file.frame),
        file.frame == "best-fit",
        file.joints == "controller",
        file.plan,
        tuple(file.markers),
    )


def _joins(document: Located, file: MappingFile) -> tuple[tuple[str, ...], ...]:
    """How each file belongs to the first: what it says, else what is said of all."""
    found = []
    entries = [(("files", i), one.join) for i, one in enumerate(file.files)]
    paths: list[tuple[Path_, Any]] = [*entries] if entries else [((), None), ((), None)]
    for i, (path, own) in enumerate(paths):
        join = own if own is not None else file.join
        where = document.where((*path, "join"))
        wrong = [] if join in (None, [ORDER]) else [w for w in join if w not in (*SPLIT, LINE)]
        if wrong:
            raise MeasurementFileError(
                f"{where}: join: expected {ORDER}, {LINE}, or some of {', '.join(SPLIT)}; found "
                f"{wrong[0]!r}"
            )
        if i == 0 and own is not None:
            raise MeasurementFileError(
                f"{where}: join: the first file is the one to which the others are joined"
            )
        if join is not None and LINE in join and len(join) > 1:
            raise MeasurementFileError(f"{where}: join: {LINE!r} says the row alone")
        found.append(() if i == 0 or join in (None, [ORDER]) else tuple(join))
    return tuple(found)


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
