"""The continuous design in the certificate of a plan.json, read back."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import PlanFileError
from elastocal.files.plans.load_case_entries import finite_at, read_load_cases
from elastocal.robot.chain import Robot


class CertifiedDesign(NamedTuple):
    """What a certificate rests on."""

    support: LoadCases
    """S load cases of the continuous design."""
    weights: Array
    """(S,) their weights; they sum to 1."""
    peak: LoadCases
    """The load case where the sensitivity is largest."""


def certified_design(section: dict[str, Any], robot: Robot, where: str) -> CertifiedDesign | None:
    """The continuous design in the section `certificate`; None if there is none.

    Raises:
        PlanFileError: it is not for this robot; names the key.
    """
    entries = section.get("continuous_design")
    if entries is None:
        return None
    support = read_load_cases(entries, robot, f"{where}, continuous_design")
    weights = np.array(
        [finite_at(entry["weight"], f"{where}: weight of a load case") for entry in entries]
    )
    if not ((weights >= 0.0).all() and weights.sum() > 0.0):
        raise PlanFileError(f"{where}: the weights of continuous_design must be shares of 1")
    peak = read_load_cases([section.get("peak")], robot, f"{where}, peak")
    return CertifiedDesign(support, frozen(weights / weights.sum()), peak)
