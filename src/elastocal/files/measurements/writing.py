"""The canonical measurement file, written."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.errors import InputError
from elastocal.files.measurements.columns import (
    FORCES,
    POSITION,
    ROTATION,
    TORQUES,
    Triple,
)
from elastocal.files.measurements.uncertainty import six_of
from elastocal.measuring.measurements import Measurements
from elastocal.robot.chain import Robot
from elastocal.writing import cell, signature, table_row, write_text


def write_measurements(measurements: Measurements, robot: Robot, path: str | Path) -> None:
    """Write the canonical file: one row for each reading, deflections, degrees and millimetres.

    Rotations stand in the first row of their experiment. Uncertainties are written if the readings
    have their own; otherwise those of the instrument hold, which the study knows.

    Args:
        measurements: What to write.
        robot: Whose joints they are.
        path: Name of the file.

    Raises:
        InputError: they were read between two loads, for which deflections have no column.
    """
    m = measurements
    if m.cases.preloaded:
        raise InputError(
            "readings between two loads are not written: deflections have no column for the first"
        )
    header = ["experiment", "marker"]
    header += [f"{joint.name} [{joint.kind.key}]" for joint in robot.joints]
    header += [f"{name} [N]" for name in FORCES]
    columns = [robot.shown_scale * m.cases.q, m.cases.wrench[:, :3]]
    if m.cases.wrench[:, 3:].any():
        header += [f"{name} [N.m]" for name in TORQUES]
        columns.append(m.cases.wrench[:, 3:])
    parts = [_columns(m, POSITION, ~m.rotations)]
    if m.tool.rotation:
        parts.append(_columns(m, ROTATION, m.rotations))
    header += [name for names, _ in parts for name in names]
    cases = [",".join(f"{v + 0.0:.12g}" for v in row) for row in np.hstack(columns).tolist()]
    out = io.StringIO()
    out.write(f"# {signature('measurements', 'version 1')}\n")
    out.write(table_row(header))
    experiment = [cell(name) for name in m.names]
    marker = [cell(name) for name in m.tool.marker_names]
    blank = [",".join([""] * len(names)) for names, _ in parts]
    cells = [
        [",".join(f"{v + 0.0:.10g}" for v in row) for row in rows.tolist()] for _, rows in parts
    ]
    for i, k, *readings in _rows(m):
        found = (
            none if reading is None else some[reading]
            for reading, some, none in zip(readings, cells, blank, strict=False)
        )
        out.write(f"{experiment[i]},{marker[k]},{cases[i]},{','.join(found)}\n")
    write_text(Path(path), out.getvalue())


def _rows(m: Measurements) -> Iterator[tuple[int, int, int | None, int | None]]:
    """Experiment and marker of each row, and the readings it has: a position, a rotation.

    A rotation without a position in its experiment has a row of its own.
    """
    case, target = m.case.tolist(), m.marker.tolist()
    waiting: dict[int, list[int]] = {}
    for reading in np.flatnonzero(m.rotations).tolist():
        waiting.setdefault(case[reading], []).append(reading)
    for reading in np.flatnonzero(~m.rotations).tolist():
        rotations = waiting.get(case[reading])
        yield case[reading], target[reading], reading, rotations.pop(0) if rotations else None
    for i, rotations in waiting.items():
        for reading in rotations:
            yield i, 0, None, reading


def _columns(m: Measurements, of: Triple, own: BoolArray) -> tuple[list[str], Array]:
    """Headers, and (R, k) values of all readings, of which only the `own` are of this kind."""
    names, noise = _noise_columns(m, of, own)
    return [f"{name} [{of.unit}]" for name in of.values] + names, np.hstack(
        [1e3 * m.deflection, noise]
    )


def _noise_columns(m: Measurements, of: Triple, own: BoolArray) -> tuple[list[str], Array]:
    """Headers and (R, k) values of the uncertainties: one per reading, three, or all six."""
    if not (m.own_uncertainty and own.any()):
        return [], np.zeros((len(m), 0))
    six = six_of(m.covariance)
    u = 1e3 * np.sqrt(six[:, :3])
    one, three = of.uncertainties[:2]
    header = [f"{name} [{of.unit}]" for name in three]
    if six[own, 3:].any():
        header += [f"{name} [{of.covariance_unit}]" for name in of.covariances]
        return header, np.hstack([u, 1e6 * six[:, 3:]])
    if np.ptp(u[own], axis=1).any():
        return header, u
    return [f"{one[0]} [{of.unit}]"], u[:, :1]
