"""What a calibration file holds, as sections: keys, units, and what may stand there."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np

from elastocal.files.models.claims import ProvenanceFile
from elastocal.files.models.model_file import ComplianceFile, CovarianceFile
from elastocal.files.sections import After, Before, Section, fresh
from elastocal.files.study.springs import SpringFile
from elastocal.files.values import (
    AtLeastZero,
    Finite,
    FiniteVector,
    Flag,
    Name,
    Natural,
    Positive,
)
from elastocal.names import flaw

_UNIT = 1e-6  # by which the length of a quaternion may be off


def _label(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError(f"expected a name, which may be empty, found {value!r:.40}")
    if value and (wrong := flaw(value)):
        raise ValueError(wrong)
    return value


def _quaternion(value: Any) -> list[float]:
    plain = isinstance(value, list) and all(
        isinstance(v, (int, float)) and not isinstance(v, bool) for v in value
    )
    if not plain or len(value) != 4:
        raise ValueError(f"expected four numbers [w, x, y, z], found {value!r:.60}")
    if not abs(float(np.linalg.norm(value)) - 1.0) < _UNIT:
        raise ValueError("expected a quaternion of length 1")
    return [float(v) for v in value]


def _dof(value: float | None) -> float | None:
    if value is not None and not value > 0.0:
        raise ValueError(f"expected a positive number or null, found {value:g}")
    return value


Label = Annotated[str, Before(_label)]
Quaternion = Annotated[Any, Before(_quaternion)]


class ReflectorsFile(Section):
    """The tool as its drawing has it."""

    name: Label
    load_point_mm: FiniteVector
    tcp_mm: FiniteVector
    radius_mm: Positive = 30.0
    markers_mm: dict[Name, FiniteVector]
    rotation: Flag = False


class BaseFile(Section):
    """Where the base of the robot stands, in the frame of a station."""

    station: Label
    origin_mm: FiniteVector
    quaternion_wxyz: Quaternion


class MountingFile(Section):
    """Where reflectors and probe of a mounting are, in the frame of the flange."""

    mounting: Label
    markers_mm: dict[Name, FiniteVector]
    probe_wxyz: Quaternion | None = None


class GeometryFile(Section):
    """A geometric error."""

    value: Finite
    unit: Literal["rad", "m"]
    standard_error: AtLeastZero


class FoundComplianceFile(ComplianceFile):
    """A compliance that was found; one that makes several springs names them with their shares."""

    standard_error: AtLeastZero
    springs: dict[Name, Finite] | None = None


class FoundCompensatorFile(Section):
    """A compensator: its spring as it is drawn, and what was found of it."""

    joint: Name
    crank_mm: Positive
    reach_mm: Positive
    angle_deg: Finite
    rest_mm: AtLeastZero
    value: Finite
    unit: Literal["rad/m2"]
    standard_error: AtLeastZero


class ThoughtFile(Section):
    """A payload as it was thought to be."""

    mass_kg: AtLeastZero
    center_mm: FiniteVector
    mass_error_kg: AtLeastZero = 0.0
    center_error_mm: AtLeastZero = 0.0


class FoundPayloadFile(Section):
    """A payload as it was found."""

    mass_kg: Finite
    moment_kg_m: FiniteVector
    fitted: Flag
    thought: ThoughtFile


class StationNoiseFile(Section):
    """What readings of a station scatter by."""

    station: Label
    instrument_mm: AtLeastZero
    model_shared_mm: AtLeastZero
    model_own_mm: AtLeastZero
    model_turned_mrad: AtLeastZero


class FittedFile(Section):
    """How well it fits."""

    poses: Natural
    readings: Natural
    rms_mm: AtLeastZero
    left_out_mm: AtLeastZero
    loss: Literal["squares", "huber", "bisquare"] = "squares"


class CalibrationFile(Section):
    """A whole calibration file."""

    elastocal: Any
    kind: Literal["calibration"]
    made_by: Any = None
    robot: Name
    geometry_sha256: Name
    source: Label = ""
    provenance: ProvenanceFile | None = None
    gravity_m_s2: FiniteVector
    tool: ReflectorsFile
    bases: list[BaseFile]
    mountings: list[MountingFile]
    geometry: dict[Name, GeometryFile]
    compliance: dict[Name, FoundComplianceFile]
    springs: dict[Name, SpringFile] = fresh(dict)
    compensators: dict[Name, FoundCompensatorFile] = fresh(dict)
    payloads: dict[Name, FoundPayloadFile] = fresh(dict)
    covariance: CovarianceFile
    held: list[Name] = fresh(list)
    rests_on_prior: list[Name]
    open: list[dict[Name, Finite]] = fresh(list)
    told: Natural
    dof: Annotated[Finite | None, After(_dof)] = None
    noise: list[StationNoiseFile]
    fit: FittedFile
