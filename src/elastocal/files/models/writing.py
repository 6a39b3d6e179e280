"""Writing model.json: SI units, each named; without the reader's schema, which is slow to start."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from elastocal import __version__
from elastocal.arrays import Array
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.springs import VirtualJoints
from elastocal.files.texts import json_text
from elastocal.robot.chain import Robot, T_body_joint
from elastocal.robot.geometry_hash import geometry_hash
from elastocal.writing import write_text


def write_model(
    model: ComplianceModel,
    path: str | Path,
    robot: Robot,
    *,
    provenance: Mapping[str, Any] | None = None,
    sections: Mapping[str, Any] | None = None,
) -> None:
    """Write model.json.

    Args:
        model: The model.
        path: File to write.
        robot: The robot the model belongs to.
        provenance: Where it comes from: hashes of study, plan, measurements.
        sections: Further sections, `identification` and `diagnostics`.
    """
    document = model_document(model, robot, provenance=provenance, sections=sections)
    write_text(Path(path), json_text(document))


def model_document(
    model: ComplianceModel,
    robot: Robot,
    *,
    provenance: Mapping[str, Any] | None = None,
    sections: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """The content of model.json: SI units, each named; see `write_model`."""
    springs = model.springs
    known = bool(model.covariance.any())
    compliance = {}
    for i, (name, kind) in enumerate(zip(springs.names, springs.kinds, strict=True)):
        compliance[name] = {"value": float(model.compliance[i]), "unit": kind.compliance}
        if known:
            compliance[name]["standard_error"] = float(model.standard_error[i])
    document: dict[str, Any] = {
        "elastocal": 1,
        "kind": "model",
        "made_by": f"elastocal {__version__}",
        "robot": robot.name,
        "geometry_sha256": geometry_hash(robot),
        "source": model.source,
        "provenance": dict(provenance or {}),
        "compliance": compliance,
    }
    if (springs.joint < 0).any():
        document["springs"] = springs_section(robot, springs)
    if known:
        document["covariance"] = _matrix(springs, model.covariance)
        document["dof"] = float(model.dof) if np.isfinite(model.dof) else None
        if np.isfinite(model.dof) and (model.by_noise != model.covariance).any():
            document["covariance_by_noise"] = _matrix(springs, model.by_noise)
        if (model.at_task != model.covariance).any():
            document["covariance_at_task"] = _matrix(springs, model.at_task)
    if model.model_error > 0.0:
        document["model_error_mm"] = 1e3 * float(model.model_error)
    if model.noise != 1.0:
        document["noise_scale"] = float(model.noise)
    return document | dict(sections or {})


def _matrix(springs: VirtualJoints, matrix: Array) -> dict[str, Any]:
    return {
        "order": list(springs.names),
        "matrix": [[float(v) for v in row] for row in matrix],
    }


def springs_section(robot: Robot, springs: VirtualJoints) -> dict[str, Any]:
    """Where the springs sit that are not in a joint, in frames that files use."""
    section = {}
    for i in np.flatnonzero(springs.joint < 0):
        body = int(springs.body[i])
        own = np.linalg.inv(T_body_joint(robot, body))
        origin = own[:3, :3] @ springs.origin[i] + own[:3, 3]
        section[springs.names[i]] = {
            "carried_by": robot.moving[body - 1].name if body else "base",
            "type": springs.kinds[i].name,
            "axis": [float(v) for v in own[:3, :3] @ springs.axis[i]],
            "origin_mm": [1e3 * float(v) for v in origin],
        }
    return section
