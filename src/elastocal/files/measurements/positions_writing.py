"""Absolute readings, written as a measurement file."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from elastocal.files.measurements.columns import AXES
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot
from elastocal.robot.rotations import from_rotation_vectors, quaternions
from elastocal.writing import cell, signature, table_row, write_text


def write_positions(positions: Positions, robot: Robot, path: str | Path) -> None:
    """Write one row for each reading of a reflector: degrees, millimetres, seconds.

    The orientation of a probe, a quaternion, stands in the first row of its pose. Uncertainties are
    those of the instrument, which the study knows; readings of a foot have no place here.
    """
    p = positions
    header = ["experiment", "marker"]
    header += [f"{joint.name} [{joint.kind.key}]" for joint in robot.joints]
    header += [f"{axis} [mm]" for axis in AXES]
    turned, timed = bool(p.rotations.any()), bool(np.isfinite(p.time).all())
    header += ["qw", "qx", "qy", "qz"] * turned
    header += ["payload"] * bool(p.payloads)
    header += ["station"] * (len(p.stations) > 1) + ["time [s]"] * timed
    turns = {
        int(p.case[r]): quaternions(from_rotation_vectors(p.value[[r]]))[0]
        for r in np.flatnonzero(p.rotations)
    }
    shown = robot.shown_scale * p.cases.q
    out = io.StringIO()
    out.write(f"# {signature('positions', 'version 1')}\n")
    out.write(table_row(header))
    for r in np.flatnonzero(~p.rotations).tolist():
        case = int(p.case[r])
        row = [cell(p.names[case]), cell(p.tool.marker_names[p.marker[r]])]
        row += [f"{value + 0.0:.12g}" for value in shown[case]]
        row += [f"{1e3 * value + 0.0:.10g}" for value in p.value[r]]
        if turned:
            turn = turns.pop(case, None)
            row += [""] * 4 if turn is None else [f"{value + 0.0:.12g}" for value in turn]
        if p.payloads:
            carried = int(p.payload[case])
            row.append("none" if carried < 0 else cell(p.payloads[carried]))
        if len(p.stations) > 1:
            row.append(cell(p.stations[p.station[r]]))
        if timed:
            row.append(f"{p.time[r]:.10g}")
        out.write(",".join(row) + "\n")
    write_text(Path(path), out.getvalue())
