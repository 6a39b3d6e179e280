"""Tables of Denavit and Hartenberg as CSV: the calibrated robot, beside its drawing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from elastocal.arrays import Array
from elastocal.robot.rotations import zyx_angles
from elastocal.robot.sinks.dh import DHTable
from elastocal.writing import signature, table_row

KIND = "dh table"
_FORMS = {
    False: "classic: Rot_z(theta + q) Trans_z(d) Trans_x(a) Rot_x(alpha)",
    True: "modified: Trans_x(a) Rot_x(alpha) Rot_z(theta + q) Trans_z(d)",
}
_WITH_BETA = {
    False: "classic with beta: Rot_z(theta + q) Trans_z(d) Trans_x(a) Rot_x(alpha) Rot_y(beta)",
    True: "modified with beta: Trans_x(a) Rot_x(alpha) Rot_y(beta) Rot_z(theta + q) Trans_z(d)",
}


def dh_text(table: DHTable, drawn: DHTable, about: Sequence[str]) -> str:
    """The text of a table, with all digits.

    Args:
        table: The calibrated robot.
        drawn: The robot as drawn, in the same form.
        about: Lines on where it comes from.
    """
    head = [*about, f"{(_FORMS if table.plain else _WITH_BETA)[table.modified]}; q of a joint that",
            "slides counts in d; q times sign."]  # fmt: skip
    head += far_words(table)
    for what, T in (("base", table.T_base_first), ("flange", table.T_last_flange)):
        if np.abs(T - np.eye(4)).max() > 1e-12:
            side = "before the first row" if what == "base" else "behind the last row"
            head.append(f"{what}, {side}: {_frame(T)}")
    lines = [f"# {line}\n" for line in [*head, signature(KIND)]]
    columns = ["theta [deg]", "d [mm]", "a [mm]", "alpha [deg]"]
    columns += [] if table.plain else ["beta [deg]"]
    shown = len(columns)
    lines.append(table_row(["joint", "type", "sign", *columns, *(f"drawn {c}" for c in columns)]))
    for i, row in enumerate(table.rows):
        kind = "prismatic" if row.prismatic else "revolute"
        numbers = [*_numbers(table, i)[:shown], *_numbers(drawn, i)[:shown]]
        lines.append(table_row([row.name, kind, int(row.sign), *map(_shown, numbers)]))
    return "".join(lines)


def far_words(table: DHTable) -> list[str]:
    """What is said of rows that need beta."""
    found = []
    for row, beta, far in zip(table.rows, table.beta.tolist(), table.far.tolist(), strict=True):
        if beta:
            away = f"{far:.{0 if far > 10.0 else 2}f} m away" if np.isfinite(far) else "nowhere"
            found.append(
                f"{row.name}: its axis is nearly parallel to the one beside it, their common "
                f"normal is {away}; beta stands in place of so large a d (Hayati)"
            )
    return found


def _numbers(table: DHTable, i: int) -> list[float]:
    row = table.rows[i]
    angles = np.degrees([row.theta, row.alpha, table.beta[i]])
    return [float(angles[0]), 1e3 * row.d, 1e3 * row.a, float(angles[1]), float(angles[2])]


def _frame(T: Array) -> str:
    """A frame in words: X, Y, Z in mm and A, B, C in degrees."""
    values = [*(1e3 * T[:3, 3]), *np.degrees(zyx_angles(T[None, :3, :3])[0])]
    shown = " ".join(f"{n} {_shown(float(v))}" for n, v in zip("XYZABC", values, strict=True))
    return f"{shown} [mm, deg; Rot_z(A) Rot_y(B) Rot_x(C)]"


def _shown(value: float) -> str:
    """A number with all its digits, without a minus before zero."""
    return repr(value + 0.0)
