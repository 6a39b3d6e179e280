"""Model files: model.json, the compliances of an arm with their uncertainty.

Written by programs or by hand: a file that only says `compliance` or `stiffness` by joint name is
one. JSON, or YAML for people. What else a program found out goes into the opaque sections
`identification` and `diagnostics`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from elastocal import __version__
from elastocal.arrays import Array
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.springs import VirtualJoints
from elastocal.errors import InputError, ModelFileError, StudyError
from elastocal.files.compliance_units import factor_to_si
from elastocal.files.study.springs import (
    extra_springs,
    in_chain_order,
    number_at,
    short,
    springs_section,
)
from elastocal.files.texts import finite, read_text, write_text
from elastocal.files.yaml_lines import Located, LocatedError, Path_, parse
from elastocal.robot.chain import Robot
from elastocal.robot.joint_kinds import JointKind

OPAQUE = ("identification", "diagnostics")
"""Sections that are carried along and not read here."""

_KEYS = (
    "elastocal",
    "kind",
    "made_by",
    "robot",
    "source",
    "provenance",
    "compliance",
    "stiffness",
    "springs",
    "covariance",
    "dof",
    *OPAQUE,
)
_SMALL_ENOUGH_TO_LOCATE = 1_000_000  # bytes; a larger file is a program's, and errors go unlined


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
        sections: Further sections, of those in `OPAQUE`.
    """
    document = finite(model_document(model, robot, provenance=provenance, sections=sections))
    write_text(Path(path), json.dumps(document, indent=2, ensure_ascii=False) + "\n")


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
        "source": model.source,
        "provenance": dict(provenance or {}),
        "compliance": compliance,
    }
    if (springs.joint < 0).any():
        document["springs"] = springs_section(robot, springs)
    if known:
        document["covariance"] = {
            "order": list(springs.names),
            "matrix": [[float(v) for v in row] for row in model.covariance],
        }
        document["dof"] = float(model.dof) if np.isfinite(model.dof) else None
    return document | dict(sections or {})


def read_model(path: str | Path, robot: Robot) -> ComplianceModel:
    """The model in a file.

    Raises:
        ModelFileError: not a model, or not for this robot; names line and key.
    """
    path = Path(path)
    text = read_text(path)
    document = _parse(text, path)
    try:
        return _model(document, robot, path)
    except LocatedError as error:
        raise ModelFileError(f"{_where(text, path, error.path)}: {error}") from None


def model_sections(path: str | Path) -> dict[str, Any]:
    """Provenance and the opaque sections of a model file, as they stand there.

    Raises:
        ModelFileError: not a model file.
    """
    document = _parse(read_text(Path(path)), Path(path))
    return {key: document[key] for key in ("provenance", *OPAQUE) if key in document}


def _parse(text: str, path: Path) -> dict[str, Any]:
    """The document, JSON or YAML, with the keys of a model file."""
    try:
        if text.lstrip().startswith("{"):
            document = json.loads(text, object_pairs_hook=_without_repeats)
        else:
            document = parse(text, path).value
    except json.JSONDecodeError as error:
        raise ModelFileError(
            f"{path}, line {error.lineno}, column {error.colno}: not valid JSON: {error.msg}"
        ) from None
    except RecursionError:
        raise ModelFileError(f"{path}: nested too deeply") from None
    except StudyError as error:
        raise ModelFileError(str(error)) from None
    except ValueError as error:
        raise ModelFileError(f"{path}: not valid JSON: {error}") from None
    if not isinstance(document, dict):
        raise ModelFileError(f"{path}: not a model file; expected sections such as compliance")
    if document.get("kind", "model") != "model":
        raise ModelFileError(f"{path}: this is a {document['kind']!s:.40} file, expected a model")
    version = document.get("elastocal", 1)
    if version != 1:
        raise ModelFileError(
            f"{path}: format version {version!r} is not known; this program reads 1"
        )
    return document


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for key, value in pairs:
        if key in result:
            raise ValueError(f"key {key!r} appears twice in one section")
        result[key] = value
    return result


def _where(text: str, path: Path, key: Path_) -> str:
    """'truth.json, line 5' of a key; the line only where it can be told."""
    if len(text) <= _SMALL_ENOUGH_TO_LOCATE:
        try:
            located: Located = parse(text, path)
        except InputError:
            return str(path)
        return located.where(key)
    return str(path)


def _model(document: dict[str, Any], robot: Robot, path: Path) -> ComplianceModel:
    for key in document:
        if key not in _KEYS:
            raise LocatedError(
                (key,), f"key {key!r} is not known; expected some of {', '.join(_KEYS)}"
            )
    extra = extra_springs(document.get("springs", {}), robot)
    values: dict[str, tuple[float, float | None]] = {}
    for kind in ("compliance", "stiffness"):
        for name, entry in _section(document, kind).items():
            if name in values:
                raise LocatedError(
                    (kind, name), f"spring {name!r} has a compliance and a stiffness; give one"
                )
            joint = _joint_kind(name, extra, robot, (kind, name))
            values[name] = _value(kind, entry, joint, (kind, name))
    if not values:
        raise LocatedError((), "no compliances: give compliance or stiffness by joint name")
    missing = [name for name in extra if name not in values]
    if missing:
        raise LocatedError(("springs", missing[0]), f"spring {missing[0]!r} has no compliance")
    springs = in_chain_order(values, extra, robot)
    errors = {name: error for name, (_, error) in values.items() if error is not None}
    covariance = _covariance(document.get("covariance"), springs.names, errors)
    return ComplianceModel(
        springs=springs,
        compliance=np.array([values[name][0] for name in springs.names]),
        covariance=covariance,
        dof=_dof(document.get("dof")),
        source=str(document.get("source") or path.name),
    )


def _section(document: dict[str, Any], key: str) -> dict[str, Any]:
    section = document.get(key, {})
    if not isinstance(section, dict):
        raise LocatedError((key,), f"{key} must give a section for each joint, by name")
    return section


def _joint_kind(
    name: str, extra: dict[str, VirtualJoints], robot: Robot, where: Path_
) -> JointKind:
    if name in extra:
        return extra[name].kinds[0]
    if name not in robot.joint_names:
        known = ", ".join([*robot.joint_names, *extra])
        raise LocatedError(
            where, f"robot {robot.name!r} has no joint or spring {name!r}; known are {known}"
        )
    return robot.joints[robot.joint_names.index(name)].kind


def _value(kind: str, entry: Any, joint: JointKind, where: Path_) -> tuple[float, float | None]:
    """Compliance and its standard error, SI; None if the file gives no error."""
    name = where[-1]
    unit = joint.compliance if kind == "compliance" else joint.stiffness
    if not isinstance(entry, dict) or "value" not in entry or "unit" not in entry:
        raise LocatedError(
            where, f"{kind} of {name}: expected {{value: ..., unit: {unit}}}, found {short(entry)}"
        )
    for key in entry:
        if key not in ("value", "unit", "standard_error"):
            raise LocatedError((*where, key), f"{kind} of {name}: key {key!r} is not known")
    try:
        factor = factor_to_si(entry["unit"], unit)
    except InputError as error:
        raise LocatedError((*where, "unit"), f"{kind} of {name}: {error}") from None
    value = factor * number_at(entry["value"], (*where, "value"), f"{kind} of {name}")
    deviation = None
    if entry.get("standard_error") is not None:
        what = f"standard error of {name}"
        deviation = factor * number_at(entry["standard_error"], (*where, "standard_error"), what)
        if deviation < 0.0:
            raise LocatedError((*where, "standard_error"), f"{what}: must not be negative")
    if kind == "stiffness":
        if value <= 0.0:
            raise LocatedError(
                (*where, "value"), f"stiffness of {name}: must be positive, found {value:g} {unit}"
            )
        return 1.0 / value, None if deviation is None else deviation / value**2
    if value < 0.0 and not deviation:
        # An estimate may come out below zero; a value that claims to be exact may not.
        raise LocatedError(
            (*where, "value"),
            f"compliance of {name}: must not be negative, found {value:g} {unit}",
        )
    return value, deviation


def _covariance(section: Any, names: tuple[str, ...], errors: dict[str, float]) -> Array:
    """(p, p) in the order of `names`, SI; diagonal if the file gives standard errors alone."""
    own = np.array([errors.get(name, 0.0) for name in names])
    if section is None:
        return np.diag(own**2)
    where: Path_ = ("covariance",)
    if not isinstance(section, dict) or set(section) != {"order", "matrix"}:
        raise LocatedError(where, "covariance must have the keys order and matrix, and no others")
    order, rows = section["order"], section["matrix"]
    if not isinstance(order, list) or sorted(map(str, order)) != sorted(names):
        raise LocatedError(
            (*where, "order"), f"order must name every spring once: {', '.join(names)}"
        )
    p = len(names)
    shaped = isinstance(rows, list) and len(rows) == p
    if not shaped or not all(isinstance(row, list) and len(row) == p for row in rows):
        raise LocatedError((*where, "matrix"), f"matrix must be {p} rows of {p} numbers")
    at = (*where, "matrix")
    matrix = np.array([[number_at(v, at, "covariance") for v in row] for row in rows])
    pick = [order.index(name) for name in names]
    matrix = matrix[np.ix_(pick, pick)]
    scale = np.sqrt(np.maximum(np.abs(np.diagonal(matrix)), 1e-300))
    scaled = matrix / np.outer(scale, scale)
    if not np.allclose(scaled, scaled.T, atol=1e-9):
        raise LocatedError(at, "the covariance matrix is not symmetric")
    if np.linalg.eigvalsh(scaled)[0] < -1e-8 * p:
        raise LocatedError(at, "the covariance matrix has a negative eigenvalue")
    given = [i for i, name in enumerate(names) if name in errors]
    if not np.allclose(own[given], np.sqrt(np.abs(np.diagonal(matrix)))[given], rtol=1e-3):
        raise LocatedError(at, "the covariance matrix contradicts the standard errors")
    return np.asarray(0.5 * (matrix + matrix.T))


def _dof(value: Any) -> float:
    if value is None:
        return float(np.inf)
    dof = number_at(value, ("dof",), "dof")
    if not dof > 0.0:
        raise LocatedError(("dof",), f"dof: expected a positive number or null, found {dof:g}")
    return dof
