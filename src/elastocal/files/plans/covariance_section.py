"""The covariance of compliances by name, as a section of plan.json and of what `evaluate` says."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.unknowns import Unknowns
from elastocal.errors import PlanFileError
from elastocal.files.plans.done_section import square
from elastocal.files.plans.load_case_entries import section_at
from elastocal.files.sections import NOTHING, Before, PartSection
from elastocal.robot.joint_kinds import KINDS


def _names(value: Any) -> list[str]:
    if not isinstance(value, list) or len({str(name) for name in value}) != len(value):
        raise ValueError(" must be a list of names, each once")
    return [str(name) for name in value]


def _units(value: Any) -> list[str]:
    known = [unit for kind in KINDS for unit in (kind.compliance, kind.unit)]
    if not isinstance(value, list) or any(unit not in known for unit in value):
        raise ValueError(f" must be a list of {' or '.join(known)}")
    return value


class PlanCovarianceFile(PartSection):
    """The section `covariance`: SI, in the units of the compliances multiplied."""

    order: Annotated[list[str], Before(_names)] = NOTHING
    unit: Annotated[list[str], Before(_units)] | None = None
    matrix: Annotated[list[list[float]], Before(square)] = NOTHING


def covariance_section(fitted: Unknowns, covariance: Array) -> dict[str, Any]:
    """The section `covariance`, of (p, p) in the order of the unknowns."""
    return {
        "order": list(fitted.names),
        "unit": list(fitted.units),
        "matrix": covariance.tolist(),
    }


def claimed_covariance(entry: Any, where: str) -> tuple[tuple[str, ...], Array] | None:
    """Names and matrix of the section as they stand there; None if a plan leaves it open.

    Raises:
        PlanFileError: it is wrong; names the key.
    """
    rows = entry.get("matrix") if isinstance(entry, dict) else None
    if isinstance(rows, list) and any(isinstance(row, list) and None in row for row in rows):
        return None  # infinite: the plan does not identify everything, and says so
    section = section_at(PlanCovarianceFile, entry, where)
    if len(section.order) != len(section.matrix):
        raise PlanFileError(f"{where}: order must name each of the {len(section.matrix)} rows")
    if section.unit is not None and len(section.unit) != len(section.order):
        raise PlanFileError(f"{where}: unit must be one for each of the {len(section.order)} rows")
    return tuple(section.order), np.array(section.matrix)
