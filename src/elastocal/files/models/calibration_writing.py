"""Writing a calibrated robot as JSON: what the fit found, so that it predicts the same again.

Lengths of frames and points in millimetres, as keys say; unknowns and their covariance in SI.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from elastocal import __version__
from elastocal.arrays import Array
from elastocal.calibration.calibrated_robot import CalibratedRobot, Origin
from elastocal.elastic.unknowns import Unknowns
from elastocal.files.models.calibration_kind import KIND
from elastocal.files.models.writing import springs_section
from elastocal.files.texts import json_text
from elastocal.robot.chain import Tool
from elastocal.robot.geometry_hash import geometry_hash
from elastocal.robot.rotations import quaternions
from elastocal.writing import write_text


def write_calibration(calibrated: CalibratedRobot, path: str | Path) -> None:
    """Write a calibrated robot; `read_calibration` reads it again.

    Args:
        calibrated: The calibrated robot.
        path: File to write.

    Raises:
        InputError: the place cannot be written to.
    """
    write_text(Path(path), json_text(calibration_document(calibrated)))


def calibration_document(calibrated: CalibratedRobot) -> dict[str, Any]:
    """The content of that file; see docs/file-formats.md."""
    model, robot = calibrated.model, calibrated.model.robot
    compliances = model.compliances
    document: dict[str, Any] = {
        "elastocal": 1,
        "kind": KIND,
        "made_by": f"elastocal {__version__}",
        "robot": robot.name,
        "geometry_sha256": geometry_hash(robot),
        "source": calibrated.source,
        "provenance": _provenance(calibrated.origin),
        "gravity_m_s2": listed(model.gravity),
        "tool": _tool(model.tool),
        "bases": _bases(calibrated),
        "mountings": _mountings(calibrated),
        "geometry": _geometry(calibrated),
        "compliance": _compliance(calibrated),
    }
    if (compliances.springs.joint < 0).any():
        document["springs"] = springs_section(robot, compliances.springs)
    if model.compensators:
        document["compensators"] = _compensators(calibrated)
    if model.payloads:
        document["payloads"] = _payloads(calibrated)
    names, held = calibrated.parameters.names, calibrated.parameters.held
    resting = ~calibrated.seen & ~held
    return document | {
        "covariance": {"order": list(names), "matrix": [listed(r) for r in calibrated.covariance]},
        "held": [names[i] for i in np.flatnonzero(held)],
        "rests_on_prior": [names[i] for i in np.flatnonzero(resting)],
        "open": [_combination(row, names) for row in calibrated.open],
        "told": calibrated.told,
        "dof": float(calibrated.dof) if np.isfinite(calibrated.dof) else None,
        "noise": _noise(calibrated),
        "fit": {
            "poses": calibrated.poses,
            "readings": calibrated.readings,
            "rms_mm": 1e3 * calibrated.fitted,
            "left_out_mm": 1e3 * calibrated.left_out,
            "loss": calibrated.loss,
        },
    }


def listed(values: Array) -> list[float]:
    """Numbers for a document."""
    return [float(v) for v in values]


def _provenance(origin: Origin) -> dict[str, Any]:
    return {
        "study": {"name": origin.study, "sha256": origin.study_sha256},
        "measurements": {"name": origin.measurements, "sha256": origin.measurements_sha256},
        "readings": list(origin.readings),
    }


def _tool(tool: Tool) -> dict[str, Any]:
    return {
        "name": tool.name,
        "load_point_mm": listed(1e3 * tool.load_point),
        "tcp_mm": listed(1e3 * tool.tcp),
        "radius_mm": 1e3 * tool.radius,
        "markers_mm": {
            name: listed(1e3 * point)
            for name, point in zip(tool.marker_names, tool.markers, strict=True)
        },
        "rotation": tool.rotation,
    }


def _bases(calibrated: CalibratedRobot) -> list[dict[str, Any]]:
    turns = quaternions(calibrated.state.base[:, :3, :3])
    return [
        {
            "station": name,
            "origin_mm": listed(1e3 * calibrated.state.base[s, :3, 3]),
            "quaternion_wxyz": listed(turns[s]),
        }
        for s, name in enumerate(calibrated.stations)
    ]


def _mountings(calibrated: CalibratedRobot) -> list[dict[str, Any]]:
    tool, state = calibrated.model.tool, calibrated.state
    probes = quaternions(state.probe)
    found = []
    for m, name in enumerate(calibrated.mountings):
        read = calibrated.parameters.targets[m].astype(bool).tolist()
        entry: dict[str, Any] = {"mounting": name}
        entry["markers_mm"] = {
            marker: listed(1e3 * state.markers[m, k])
            for k, marker in enumerate(tool.marker_names)
            if read[k]
        }
        if read[-1]:
            entry["probe_wxyz"] = listed(probes[m])
        found.append(entry)
    return found


def _geometry(calibrated: CalibratedRobot) -> dict[str, Any]:
    errors = calibrated.model.errors
    deviations = calibrated.standard_error[calibrated.parameters.arm :]
    return {
        name: {
            "value": float(calibrated.state.geometry[g]),
            "unit": errors.kinds[g].unit,
            "standard_error": float(deviations[g]),
        }
        for g, name in enumerate(errors.names)
    }


def _compliance(calibrated: CalibratedRobot) -> dict[str, Any]:
    unknowns = calibrated.model.compliances
    first = calibrated.parameters.arm + calibrated.parameters.geometry
    deviations = calibrated.standard_error[first:]
    found = {}
    for i, (name, kind) in enumerate(zip(unknowns.names, unknowns.kinds, strict=True)):
        entry: dict[str, Any] = {
            "value": float(calibrated.state.compliance[i]),
            "unit": kind.compliance,
            "standard_error": float(deviations[i]),
        }
        made = _made(unknowns, i)
        if made != {name: 1.0}:
            entry["springs"] = made
        found[name] = entry
    return found


def _compensators(calibrated: CalibratedRobot) -> dict[str, Any]:
    p, robot = calibrated.parameters, calibrated.model.robot
    first = p.arm + p.geometry + p.compliances
    return {
        one.name: {
            "joint": robot.joint_names[one.joint],
            "crank_mm": 1e3 * one.crank,
            "reach_mm": 1e3 * one.reach,
            "angle_deg": float(np.degrees(one.angle)),
            "rest_mm": 1e3 * one.rest,
            "value": float(calibrated.state.compensator[i]),
            "unit": "rad/m2",
            "standard_error": float(calibrated.standard_error[first + i]),
        }
        for i, one in enumerate(calibrated.model.compensators)
    }


def _made(unknowns: Unknowns, index: int) -> dict[str, float]:
    """The springs that one unknown makes, with their shares."""
    column = unknowns.make[:, index]
    return {unknowns.springs.names[i]: float(column[i]) for i in np.flatnonzero(column)}


def _payloads(calibrated: CalibratedRobot) -> dict[str, Any]:
    found = {}
    for i, load in enumerate(calibrated.model.payloads):
        mass, *moment = listed(calibrated.state.payload[i])
        found[load.name] = {
            "mass_kg": mass,
            "moment_kg_m": moment,
            "fitted": i in calibrated.parameters.hung,
            "thought": {
                "mass_kg": float(load.mass),
                "center_mm": listed(1e3 * load.center),
                "mass_error_kg": float(load.mass_error),
                "center_error_mm": 1e3 * float(load.center_error),
            },
        }
    return found


def _combination(row: Array, names: tuple[str, ...]) -> dict[str, float]:
    return {names[i]: float(row[i]) for i in np.flatnonzero(row)}


def _noise(calibrated: CalibratedRobot) -> list[dict[str, Any]]:
    return [
        {
            "station": name,
            "instrument_mm": 1e3 * one.instrument,
            "model_shared_mm": 1e3 * one.shared,
            "model_own_mm": 1e3 * one.own,
            "model_turned_mrad": 1e3 * one.turned,
        }
        for name, one in zip(calibrated.stations, calibrated.noise, strict=True)
    ]
