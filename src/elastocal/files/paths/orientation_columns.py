"""Orientations in tables: quaternion, rotation vector, or KUKA's A, B, C; the header says which."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import PathFileError
from elastocal.files.tables.csv_table import ANGLES, PLAIN, TextTable
from elastocal.robot.rotations import (
    from_quaternions,
    from_rotation_vectors,
    from_zyx_angles,
    quaternions,
    rotation_vectors,
    zyx_angles,
)

_ROUNDED = 1e-3  # how far the length of a quaternion may be from 1


@dataclass(frozen=True)
class Form:
    """One way to write orientations.

    Attributes:
        name: What messages call it.
        columns: Names of its columns.
        units: Units they may have, with the factor to SI.
        written: Unit in which they are written.
        matrices: From values (N, c) to rotation matrices (N, 3, 3).
        values: Back.
    """

    name: str
    columns: tuple[str, ...]
    units: Mapping[str, float]
    written: str
    matrices: Callable[[Array], Array]
    values: Callable[[Array], Array]


FORMS = {
    form.name: form
    for form in (
        Form("quaternion", ("qw", "qx", "qy", "qz"), PLAIN, "", from_quaternions, quaternions),
        Form(
            "rotation vector",
            ("rx", "ry", "rz"),
            ANGLES,
            "deg",
            from_rotation_vectors,
            rotation_vectors,
        ),
        Form("A, B, C", ("A", "B", "C"), ANGLES, "deg", from_zyx_angles, zyx_angles),
    )
}


def form_of(table: TextTable, taken: tuple[str, ...] = ()) -> Form | None:
    """The form of the orientations in a table, None if it has none.

    Args:
        table: The table.
        taken: Columns that mean something else.

    Raises:
        PathFileError: a part of a form, or two of them.
    """
    found = []
    for form in FORMS.values():
        there = [c for c in form.columns if c in table.names and c not in taken]
        if there and len(there) < len(form.columns):
            missing = next(c for c in form.columns if c not in there)
            raise PathFileError(
                f"{table.path}, line {table.header_line}: column {missing!r} of the {form.name} "
                "is missing"
            )
        if there:
            found.append(form)
    if len(found) > 1:
        raise PathFileError(
            f"{table.path}, line {table.header_line}: the orientation is given twice, as "
            f"{found[0].name} and as {found[1].name}; keep one"
        )
    return found[0] if found else None


def read_orientations(table: TextTable, form: Form) -> Array:
    """(N, 3, 3) rotation matrices.

    Raises:
        PathFileError: no numbers, or a quaternion that is not of unit length.
    """
    values = table.numbers(form.columns, form.units)
    if form.name == "quaternion":
        length = np.linalg.norm(values, axis=1)
        wrong = np.flatnonzero(np.abs(length - 1.0) > _ROUNDED)
        if len(wrong):
            raise PathFileError(
                f"{table.path}, line {table.rows[wrong[0]][0]}, column 'qw': a quaternion must "
                f"have length 1, found {length[wrong[0]]:.6g}"
            )
    return form.matrices(values)
