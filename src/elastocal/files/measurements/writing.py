"""The canonical measurement file, written."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from elastocal.arrays import Array
from elastocal.files.measurements.columns import COVARIANCES, DEFLECTIONS, FORCES, TORQUES
from elastocal.files.measurements.uncertainty import six_of
from elastocal.files.texts import write_text
from elastocal.measuring.measurements import Measurements
from elastocal.robot.chain import Robot


def write_measurements(measurements: Measurements, robot: Robot, path: str | Path) -> None:
    """Write the canonical file: one row for each reading, deflections, degrees and millimetres.

    Uncertainties are written if the readings have their own; otherwise those of the instrument
    hold, which the study knows.

    Args:
        measurements: What to write.
        robot: Whose joints they are.
        path: Name of the file.
    """
    m = measurements
    header = ["experiment", "marker"]
    header += [f"{joint.name} [{joint.kind.key}]" for joint in robot.joints]
    header += [f"{name} [N]" for name in FORCES]
    columns = [robot.shown_scale * m.cases.q, m.cases.wrench[:, :3]]
    if m.cases.wrench[:, 3:].any():
        header += [f"{name} [N.m]" for name in TORQUES]
        columns.append(m.cases.wrench[:, 3:])
    names, noise = _noise_columns(m)
    header += [f"{name} [mm]" for name in DEFLECTIONS] + names
    cases = [",".join(f"{v + 0.0:.12g}" for v in row) for row in np.hstack(columns).tolist()]
    values = np.hstack([1e3 * m.deflection, noise]).tolist()
    out = io.StringIO()
    out.write("# elastocal measurements, version 1\n")
    csv.writer(out, lineterminator="\n").writerow(header)
    experiment = [_quoted(name) for name in m.names]
    marker = [_quoted(name) for name in m.tool.marker_names]
    for i, k, row in zip(m.case.tolist(), m.marker.tolist(), values, strict=True):
        numbers = ",".join(f"{v + 0.0:.10g}" for v in row)
        out.write(f"{experiment[i]},{marker[k]},{cases[i]},{numbers}\n")
    write_text(Path(path), out.getvalue())


def _noise_columns(m: Measurements) -> tuple[list[str], Array]:
    """Headers and (R, k) values of the uncertainties: one per reading, three, or all six."""
    if not (m.own_uncertainty and len(m)):
        return [], np.zeros((len(m), 0))
    six = six_of(m.covariance)
    u = 1e3 * np.sqrt(six[:, :3])
    if six[:, 3:].any():
        header = ["ux [mm]", "uy [mm]", "uz [mm]", *(f"{name} [mm2]" for name in COVARIANCES)]
        return header, np.hstack([u, 1e6 * six[:, 3:]])
    if np.ptp(u, axis=1).any():
        return ["ux [mm]", "uy [mm]", "uz [mm]"], u
    return ["u [mm]"], u[:, :1]


def _quoted(name: str) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="").writerow([name])
    written = out.getvalue()
    # A name that begins with # would make its row a comment.
    return f'"{written}"' if written.startswith("#") else written
