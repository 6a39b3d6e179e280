"""Model files: model.json, the compliances of an arm with their uncertainty.

Written by programs or by hand: a file that only says `compliance` or `stiffness` by joint name is
one. JSON, or YAML for people. What else a program found out stands in `provenance`,
`identification` and `diagnostics`; what they claim of the compliances must be true.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, TypeVar

import numpy as np

from elastocal.arrays import Array, unset
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.springs import VirtualJoints
from elastocal.elastic.tensors import against_the_load
from elastocal.elastic.true_loads import TrueLoads
from elastocal.errors import InputError, ModelFileError, StudyError
from elastocal.files.compliance_units import factor_to_si
from elastocal.files.models.claims import (
    AGREE,
    DiagnosticsFile,
    IdentificationFile,
    ProvenanceFile,
    refuse_false_claims,
)
from elastocal.files.models.true_frames import TrueFrameFile
from elastocal.files.models.true_loads import TrueLoadsFile
from elastocal.files.problems import first_problem
from elastocal.files.sections import After, Before, Section, SectionError, fresh
from elastocal.files.study.springs import SpringFile, extra_springs, in_chain_order
from elastocal.files.texts import is_version, json_document, read_text
from elastocal.files.values import Finite, Matrix, Name, NonNegative, Positive
from elastocal.files.yaml_lines import Located, LocatedError, at, parse
from elastocal.matrices import is_covariance, is_symmetric
from elastocal.names import flaw
from elastocal.robot.chain import Robot
from elastocal.robot.geometry_hash import geometry_hash
from elastocal.robot.joint_kinds import JointKind

_Made = TypeVar("_Made")
_LEAST_ERROR = 1e-30  # standard error [SI] whose square is still a number to reckon with
_LONGEST_SOURCE = 2000  # characters: several names, where models were put together
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
    standard_error: Annotated[Finite | None, After(_not_negative)] = None


class StiffnessFile(ComplianceFile):
    """A stiffness instead."""

    value: Positive


class CovarianceFile(Section):
    """The covariance of the compliances, SI."""

    order: list[Name]
    matrix: Matrix


class ModelFile(Section):
    """A whole model file."""

    elastocal: Any = 1
    kind: Any = "model"
    made_by: Any = None
    robot: Name | None = None
    geometry_sha256: Name | None = None
    source: Any = None
    provenance: ProvenanceFile | None = None
    compliance: dict[Name, Annotated[ComplianceFile, Before(_entry)]] = fresh(dict)
    stiffness: dict[Name, Annotated[StiffnessFile, Before(_entry)]] = fresh(dict)
    springs: dict[Name, SpringFile] = fresh(dict)
    covariance: CovarianceFile | None = None
    covariance_by_noise: CovarianceFile | None = None
    covariance_at_task: CovarianceFile | None = None
    model_error_mm: Annotated[Finite, After(_not_negative)] = 0.0
    dof: Annotated[Finite | None, After(_above_zero)] = None
    noise_scale: Annotated[Finite | None, After(_above_zero)] = None
    identification: IdentificationFile | None = None
    diagnostics: DiagnosticsFile | None = None
    true_loads: TrueLoadsFile | None = None
    true_frames: dict[Name, TrueFrameFile] | None = None
    true_compensators_N_per_mm: dict[Name, NonNegative] | None = None


def read_model(path: str | Path, robot: Robot, *, believed: bool = True) -> ComplianceModel:
    """The model in a file.

    Args:
        path: The file.
        robot: The robot it must be for.
        believed: Whether the file alone says what the compliances are; else they are going to be
            compared with a fit, and what it claims of them besides is not looked at.

    Raises:
        ModelFileError: not a model, not for this robot, or one that contradicts itself; names
            line and key.
    """

    def model(file: ModelFile, _: dict[str, Any]) -> ComplianceModel:
        found = model_of(file, robot, Path(path).name)
        if believed:
            refuse_false_claims(found, file.identification, file.diagnostics)
        return found

    return read_through(Path(path), model)


def model_sections(path: str | Path) -> dict[str, dict[str, Any]]:
    """What a model file says besides its model, as it stands there; empty where nothing is said.

    Raises:
        ModelFileError: not a model file, or a section that is none; names line and key.
    """
    document = read_through(Path(path), lambda _, document: document)
    return {key: document.get(key) or {} for key in ("provenance", "identification", "diagnostics")}


def true_loads_in(path: str | Path) -> TrueLoads | None:
    """How loads of a virtual robot differ from what is recorded; None if the file does not say.

    Raises:
        ModelFileError: not a model file.
    """

    def loads(file: ModelFile, _: dict[str, Any]) -> TrueLoads | None:
        with at("true_loads"):
            return None if file.true_loads is None else file.true_loads.loads()

    return read_through(Path(path), loads)


def readings_in(path: str | Path) -> tuple[str, ...]:
    """Hashes of all files with readings that a model file says it counts, however far back.

    Raises:
        ModelFileError: not a model file.
    """
    section = model_sections(path)["provenance"]
    measured = (section.get("measurements") or {}).get("sha256")
    return (*(section.get("readings") or ()), *((measured,) if measured else ()))


def read_through(path: Path, made: Callable[[ModelFile, dict[str, Any]], _Made]) -> _Made:
    """What is made of a model file; every error names file, line and key."""
    text = read_text(path)
    document = _parse(text, path)
    try:
        return made(ModelFile.of(document), document)
    except SectionError as error:
        message = first_problem(_located(document, text, path), error, ModelFile)
    except LocatedError as error:
        message = f"{_located(document, text, path).where(error.path)}: {error}"
    raise ModelFileError(message)


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
    _refuse_another_robot(file, robot)
    with at("source"):
        if wrong := flaw(str(file.source or ""), _LONGEST_SOURCE):
            raise InputError(wrong)
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
                values[spring] = _compliance(quantity, spring, entry, kind, spring in extra)
    if not values:
        raise LocatedError((), "no compliances: give compliance or stiffness by joint name")
    missing = [spring for spring in extra if spring not in values]
    if missing:
        raise LocatedError(("springs", missing[0]), f"spring {missing[0]!r} has no compliance")
    springs = in_chain_order(values, extra, robot)
    _refuse_pushing(springs, values)
    errors = {spring: error for spring, (_, error) in values.items() if error is not None}
    covariance = _covariance("covariance", file.covariance, springs.names, errors)
    _refuse_tiny(springs.names, np.sqrt(np.maximum(np.diagonal(covariance), 0.0)), errors)
    by_noise = unset()
    if file.covariance_by_noise is not None:
        key = "covariance_by_noise"
        by_noise = _covariance(key, file.covariance_by_noise, springs.names, {})
        if (np.diagonal(by_noise) > (1.0 + AGREE) * np.diagonal(covariance)).any():
            raise LocatedError((key,), f"{key} is a part of the covariance, and larger than that")
    at_task = unset()
    if file.covariance_at_task is not None:
        key = "covariance_at_task"
        at_task = _covariance(key, file.covariance_at_task, springs.names, {})
        _refuse_other_task(key, at_task, covariance)
    return ComplianceModel(
        springs=springs,
        compliance=np.array([values[spring][0] for spring in springs.names]),
        covariance=covariance,
        dof=np.inf if file.dof is None else file.dof,
        source=str(file.source or name),
        noise_part=by_noise,
        noise=1.0 if file.noise_scale is None else file.noise_scale,
        task_covariance=at_task,
        model_error=1e-3 * file.model_error_mm,
    )


def _refuse_pushing(springs: VirtualJoints, values: dict[str, tuple[float, float | None]]) -> None:
    """Refuse springs that claim to be exact and push, if none at their place outweighs them."""
    compliance = np.array([values[name][0] for name in springs.names])
    for name in against_the_load(springs, compliance):
        if not values[name][1]:
            raise LocatedError(
                ("compliance", name, "value"),
                f"compliance of {name}: must not be negative, found {values[name][0]:g} "
                f"{springs.kinds[springs.names.index(name)].compliance}; no spring at its place "
                "outweighs it",
            )


def _refuse_tiny(names: tuple[str, ...], found: Array, given: dict[str, float]) -> None:
    """Refuse standard errors that would outweigh all that can be measured."""
    for name, error in zip(names, found, strict=True):
        error = given.get(name, float(error))
        if 0.0 < error < _LEAST_ERROR:
            raise LocatedError(
                ("compliance", name, "standard_error") if name in given else ("covariance",),
                f"the standard error of {name} is {error:g}; expected at least {_LEAST_ERROR:g} in "
                "SI, or 0 for what is exact",
            )


def _refuse_another_robot(file: ModelFile, robot: Robot) -> None:
    if file.robot is not None and file.robot != robot.name:
        raise LocatedError(
            ("robot",), f"robot: this is a model of {file.robot!r:.80}, not of {robot.name!r}"
        )
    if file.geometry_sha256 is not None and file.geometry_sha256 != geometry_hash(robot):
        raise LocatedError(
            ("geometry_sha256",),
            "geometry_sha256: this is a model of a robot whose joint axes are elsewhere than those "
            f"of {robot.name!r} here; identify it again, or take this key out if that is meant",
        )


def _joint_kind(name: str, extra: dict[str, VirtualJoints], robot: Robot) -> JointKind:
    if name in extra:
        return extra[name].kinds[0]
    if name not in robot.joint_names:
        known = ", ".join([*robot.joint_names, *extra])
        raise InputError(f"robot {robot.name!r} has no joint or spring {name!r}; known are {known}")
    return robot.joints[robot.joint_names.index(name)].kind


def _compliance(
    quantity: str, name: str, entry: ComplianceFile, joint: JointKind, beside: bool
) -> tuple[float, float | None]:
    """Compliance and its standard error, SI; None if the file gives no error.

    That of a spring beside the joints may be negative, if those at its place outweigh it.
    """
    unit = getattr(joint, quantity)
    try:
        factor = factor_to_si(entry.unit, unit)
    except InputError as error:
        raise LocatedError(("unit",), f"{quantity} of {name}: {error}") from None
    value = factor * entry.value
    deviation = None if entry.standard_error is None else factor * entry.standard_error
    if quantity == "stiffness":
        return 1.0 / value, None if deviation is None else deviation / value**2
    if value < 0.0 and not deviation and not beside:
        # An estimate may come out below zero; a value that claims to be exact may not.
        raise LocatedError(
            ("value",), f"compliance of {name}: must not be negative, found {value:g} {unit}"
        )
    return value, deviation


def _refuse_other_task(key: str, at_task: Array, covariance: Array) -> None:
    """Refuse a promise for tasks that no gain common to all loads makes of the covariance.

    Source: ours; covariances of k and of (1 + g) k differ by a matrix of rank two.
    """
    size = np.sqrt(np.diagonal(covariance))
    size = np.where(size > 0.0, size, 1.0)
    apart = np.linalg.svd((at_task - covariance) / np.outer(size, size), compute_uv=False)
    if (apart[2:] > AGREE).any():
        raise LocatedError(
            (key,), f"{key} differs from the covariance by more than a gain of all loads makes"
        )


def _covariance(
    key: str, section: CovarianceFile | None, names: tuple[str, ...], errors: dict[str, float]
) -> Array:
    """(p, p) in the order of `names`, SI; diagonal if the file gives standard errors alone."""
    own = np.array([errors.get(name, 0.0) for name in names])
    if section is None:
        return np.diag(own**2)
    if sorted(section.order) != sorted(names):
        raise LocatedError(
            (key, "order"), f"{key}: order must name every spring once: {', '.join(names)}"
        )
    p = len(names)
    with at(key, "matrix"):
        if [len(row) for row in section.matrix] != p * [p]:
            raise InputError(f"{key}: matrix must be {p} rows of {p} numbers")
        pick = [section.order.index(name) for name in names]
        matrix = np.array(section.matrix)[np.ix_(pick, pick)]
        if not is_symmetric(matrix):
            raise InputError(f"{key}: the matrix is not symmetric")
        if not is_covariance(matrix):
            raise InputError(f"{key}: the matrix has a negative eigenvalue")
        given = [i for i, name in enumerate(names) if name in errors]
        found = np.sqrt(np.abs(np.diagonal(matrix)))
        if wrong := [i for i in given if abs(own[i] - found[i]) > AGREE * found[i]]:
            i = wrong[0]
            raise InputError(
                f"{key}: the matrix contradicts the standard errors: that of "
                f"{names[i]} is {own[i]:.6g} beside it and {found[i]:.6g} in it"
            )
    return np.asarray(0.5 * (matrix + matrix.T))
