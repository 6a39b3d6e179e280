"""Model files: model.json, the compliances of an arm with their uncertainty.

Written by programs or by hand: a file that only says `compliance` or `stiffness` by joint name is
one. JSON, or YAML for people. What else a program found out goes into the opaque sections
`identification` and `diagnostics`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, ValidationError

from elastocal.arrays import Array
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.springs import VirtualJoints
from elastocal.errors import InputError, ModelFileError, StudyError
from elastocal.files.compliance_units import factor_to_si
from elastocal.files.problems import first_problem
from elastocal.files.study.springs import SpringFile, extra_springs, in_chain_order
from elastocal.files.texts import is_version, json_document, read_text
from elastocal.files.values import Finite, Matrix, Name, Positive, Section
from elastocal.files.yaml_lines import Located, LocatedError, at, parse
from elastocal.robot.chain import Robot
from elastocal.robot.joint_kinds import JointKind

_SMALL_ENOUGH_TO_LOCATE = 1_000_000  # bytes; a larger file is a program's, and errors go unlined


def _entry(value: Any) -> Any:
    if not isinstance(value, dict):
        raise ValueError(f"expected {{value: ..., unit: ...}}, found {str(value)[:40]}")
    return value


def _not_negative(value: float | None) -> float | None:
    if value is not None and value < 0.0:
        raise ValueError("must not be negative")
    return value


def _above_zero(value: float | None) -> float | None:
    if value is not None and not value > 0.0:
        raise ValueError(f"expected a positive number or null, found {value:g}")
    return value


class ComplianceFile(Section):
    """A compliance in a unit of its joint; without a standard error it claims to be exact."""

    value: Finite
    unit: Any
    standard_error: Annotated[Finite | None, AfterValidator(_not_negative)] = None


class StiffnessFile(ComplianceFile):
    """A stiffness instead."""

    value: Positive


class CovarianceFile(Section):
    """The covariance of the compliances, SI."""

    order: list[Name]
    matrix: Matrix


class ModelFile(Section):
    """A whole model file; what is not said of its keys is carried along and not read here."""

    elastocal: Any = 1
    kind: Any = "model"
    made_by: Any = None
    robot: Any = None
    source: Any = None
    provenance: Any = None
    compliance: dict[Name, Annotated[ComplianceFile, BeforeValidator(_entry)]] = Field(
        default_factory=dict
    )
    stiffness: dict[Name, Annotated[StiffnessFile, BeforeValidator(_entry)]] = Field(
        default_factory=dict
    )
    springs: dict[Name, SpringFile] = Field(default_factory=dict)
    covariance: CovarianceFile | None = None
    dof: Annotated[Finite | None, AfterValidator(_above_zero)] = None
    identification: Any = None
    diagnostics: Any = None


def read_model(path: str | Path, robot: Robot) -> ComplianceModel:
    """The model in a file.

    Raises:
        ModelFileError: not a model, or not for this robot; names line and key.
    """
    path = Path(path)
    text = read_text(path)
    document = _parse(text, path)
    try:
        return model_of(ModelFile.model_validate(document), robot, path.name)
    except ValidationError as error:
        message = first_problem(_located(document, text, path), error, ModelFile)
    except LocatedError as error:
        message = f"{_located(document, text, path).where(error.path)}: {error}"
    raise ModelFileError(message)


def model_sections(path: str | Path) -> dict[str, Any]:
    """Provenance and the opaque sections of a model file, as they stand there; what is none: empty.

    Raises:
        ModelFileError: not a model file.
    """
    document = _parse(read_text(Path(path)), Path(path))
    sections = {key: document.get(key) for key in ("provenance", "identification", "diagnostics")}
    return {key: section if isinstance(section, dict) else {} for key, section in sections.items()}


def _parse(text: str, path: Path) -> dict[str, Any]:
    """The document, JSON or YAML, with the keys of a model file."""
    if text.lstrip().startswith("{"):
        document = json_document(text, path, ModelFileError)
    else:
        try:
            document = parse(text, path).value
        except StudyError as error:
            raise ModelFileError(str(error)) from None
    if not isinstance(document, dict):
        raise ModelFileError(f"{path}: not a model file; expected sections such as compliance")
    if document.get("kind", "model") != "model":
        raise ModelFileError(f"{path}: this is a {document['kind']!s:.40} file, expected a model")
    version = document.get("elastocal", 1)
    if not is_version(version):
        raise ModelFileError(
            f"{path}: format version {version!r} is not known; this program reads 1"
        )
    return document


def _located(document: dict[str, Any], text: str, path: Path) -> Located:
    """The document with its lines, if they can be told."""
    try:
        return parse(text if len(text) <= _SMALL_ENOUGH_TO_LOCATE else "", path)
    except InputError:
        return Located(document, {}, path)


def model_of(file: ModelFile, robot: Robot, name: str) -> ComplianceModel:
    """The model of a validated file called `name`; every error knows its place in it."""
    extra = extra_springs(file.springs, robot)
    values: dict[str, tuple[float, float | None]] = {}
    for quantity, section in (("compliance", file.compliance), ("stiffness", file.stiffness)):
        for spring, entry in section.items():
            with at(quantity, spring):
                if spring in values:
                    raise InputError(
                        f"spring {spring!r} has a compliance and a stiffness; give one"
                    )
                kind = _joint_kind(spring, extra, robot)
                values[spring] = _compliance(quantity, spring, entry, kind)
    if not values:
        raise LocatedError((), "no compliances: give compliance or stiffness by joint name")
    missing = [spring for spring in extra if spring not in values]
    if missing:
        raise LocatedError(("springs", missing[0]), f"spring {missing[0]!r} has no compliance")
    springs = in_chain_order(values, extra, robot)
    errors = {spring: error for spring, (_, error) in values.items() if error is not None}
    with at("covariance"):
        covariance = _covariance(file.covariance, springs.names, errors)
    return ComplianceModel(
        springs=springs,
        compliance=np.array([values[spring][0] for spring in springs.names]),
        covariance=covariance,
        dof=np.inf if file.dof is None else file.dof,
        source=str(file.source or name),
    )


def _joint_kind(name: str, extra: dict[str, VirtualJoints], robot: Robot) -> JointKind:
    if name in extra:
        return extra[name].kinds[0]
    if name not in robot.joint_names:
        known = ", ".join([*robot.joint_names, *extra])
        raise InputError(f"robot {robot.name!r} has no joint or spring {name!r}; known are {known}")
    return robot.joints[robot.joint_names.index(name)].kind


def _compliance(
    quantity: str, name: str, entry: ComplianceFile, joint: JointKind
) -> tuple[float, float | None]:
    """Compliance and its standard error, SI; None if the file gives no error."""
    unit = getattr(joint, quantity)
    try:
        factor = factor_to_si(entry.unit, unit)
    except InputError as error:
        raise LocatedError(("unit",), f"{quantity} of {name}: {error}") from None
    value = factor * entry.value
    deviation = None if entry.standard_error is None else factor * entry.standard_error
    if quantity == "stiffness":
        return 1.0 / value, None if deviation is None else deviation / value**2
    if value < 0.0 and not deviation:
        # An estimate may come out below zero; a value that claims to be exact may not.
        raise LocatedError(
            ("value",), f"compliance of {name}: must not be negative, found {value:g} {unit}"
        )
    return value, deviation


def _covariance(
    section: CovarianceFile | None, names: tuple[str, ...], errors: dict[str, float]
) -> Array:
    """(p, p) in the order of `names`, SI; diagonal if the file gives standard errors alone."""
    own = np.array([errors.get(name, 0.0) for name in names])
    if section is None:
        return np.diag(own**2)
    if sorted(section.order) != sorted(names):
        raise LocatedError(("order",), f"order must name every spring once: {', '.join(names)}")
    p = len(names)
    with at("matrix"):
        if [len(row) for row in section.matrix] != p * [p]:
            raise InputError(f"matrix must be {p} rows of {p} numbers")
        pick = [section.order.index(name) for name in names]
        matrix = np.array(section.matrix)[np.ix_(pick, pick)]
        scale = np.sqrt(np.maximum(np.abs(np.diagonal(matrix)), 1e-300))
        with np.errstate(over="ignore"):  # no correlation is beyond 1, least of all infinite
            scaled = np.clip(matrix / np.outer(scale, scale), -2.0, 2.0)
        if not np.allclose(scaled, scaled.T, atol=1e-9):
            raise InputError("the covariance matrix is not symmetric")
        if np.linalg.eigvalsh(scaled)[0] < -1e-8 * p:
            raise InputError("the covariance matrix has a negative eigenvalue")
        given = [i for i, name in enumerate(names) if name in errors]
        if not np.allclose(own[given], np.sqrt(np.abs(np.diagonal(matrix)))[given], rtol=1e-3):
            raise InputError("the covariance matrix contradicts the standard errors")
    return np.asarray(0.5 * (matrix + matrix.T))
