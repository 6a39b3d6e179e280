"""What moves readings and tools besides the springs that are identified, as a section of a study.

Sizes are standard uncertainties: of positive effects, about zero, so their root mean squares.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.case_errors import CaseErrors, Cell
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.effects import (
    FOOT_SLIDING,
    FOOT_TURNING,
    TOOL_SLIDING,
    Size,
    besides,
    effects_of,
    tilt_of,
)
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.springs import VirtualJoints
from elastocal.elastic.typical import ERRORS, by_mass, by_rated_torque, foot_sliding, typical_sizes
from elastocal.errors import InputError
from elastocal.files.sections import After, Section, fresh
from elastocal.files.values import Either, Name, NonNegative, Positive, Share
from elastocal.files.yaml_lines import at
from elastocal.robot.chain import Robot
from elastocal.robot.sources import USUAL

_LEAST = 1e-5  # n of SI: below that nothing gives way, and a prior drowns all else
_STEEPEST = 45.0  # degrees by which nobody pulls aslant without seeing it


def _of_size(value: float) -> float:
    if 0.0 < value < _LEAST:
        raise ValueError(f"expected 0, or at least {_LEAST:g}, found {value:g}")
    return value / 1e9


def _of_micro(value: float) -> float:
    if 0.0 < value < 1e-3 * _LEAST:
        raise ValueError(f"expected 0, or at least {1e-3 * _LEAST:g}, found {value:g}")
    return value / 1e6


def _tilted(value: float) -> float:
    if value > _STEEPEST:
        raise ValueError(
            f"expected a standard uncertainty of at most {_STEEPEST:g}°, found {value:g}"
        )
    return math.radians(value)


_Nano = Annotated[NonNegative, After(_of_size)]
_Micro = Annotated[NonNegative, After(_of_micro)]
_PositiveMicro = Annotated[Positive, After(lambda value: value / 1e6)]
_Metres = Annotated[NonNegative, After(lambda value: value / 1e3)]
_Radians = Annotated[NonNegative, After(_tilted)]

_CELLS: dict[str, Cell] = {"same-cell": "same", "exact": "exact", "other-cell": "other"}
_SAID = "given in the study"


class LoadErrorsFile(Section):
    """How well the loads are known."""

    relative: Share | None = None
    common_relative: Share | None = None
    tilt_deg: _Radians | None = None
    common_tilt_deg: _Radians | None = None
    process_force: Literal["same-cell", "exact", "other-cell"] = "same-cell"


class DiscrepancyFile(Section):
    """What no model explains."""

    share: Share = 0.0
    mm: _Metres = 0.0


class NuisanceFile(Section):
    """What moves readings and tools besides."""

    preset: Literal["none", "typical"] = "none"
    mean: Literal["zero", "positive"] = "zero"
    compliance_urad_per_Nm: dict[Name, _PositiveMicro] = fresh(dict)
    compliance_um_per_N: dict[Name, _PositiveMicro] = fresh(dict)
    rated_torque_Nm: dict[Name, Positive] = fresh(dict)
    foot_turning_nrad_per_Nm: _Nano | None = None
    foot_sliding_nm_per_N: _Nano | None = None
    tilt_nrad_per_Nm: dict[Name, _Nano] = fresh(dict)
    tool_sliding_um_per_N: _Micro | None = None
    load: LoadErrorsFile = fresh(dict)
    friction: Share | None = None
    discrepancy: Either[Share, DiscrepancyFile] | None = None
    repeatability_mm: _Metres | None = None


@dataclass(frozen=True)
class KnownJoints:
    """What else says how soft the joints are.

    Attributes:
        builtin: Name by which the robot is built in; empty if it is not.
        models: Models of earlier campaigns that the study names, the one that counts most last.
    """

    builtin: str = ""
    models: tuple[ComplianceModel, ...] = ()


def nuisance_of(
    entry: Literal["none", "typical"] | NuisanceFile | None,
    robot: Robot,
    told: KnownJoints,
    springs: VirtualJoints,
) -> Nuisance | None:
    """The nuisance of a study; None if there is none.

    Args:
        entry: The section.
        robot: The robot.
        told: What else says how soft its joints are.
        springs: What the study identifies, or knows: no effect that these are is nuisance.

    Raises:
        InputError: a joint is unknown, or slides; sizes are wanted that scale with compliances
            which nothing says.
    """
    if isinstance(entry, str):
        entry = NuisanceFile(preset=entry)
    if entry is None:
        return None
    errors = _errors(entry)
    nominal, origin, unknown = _nominal(entry, robot, told)
    scaled = entry.preset == "typical" or errors.scaled
    if scaled and unknown:
        raise InputError(_NOTHING_SAYS.format(", ".join(unknown)))
    sizes = typical_sizes(robot, nominal, origin) if entry.preset == "typical" else {}
    effects = effects_of(robot, sizes | _said(entry, robot, typical=bool(sizes)))
    effects = besides(robot, effects, springs)
    if not len(effects.unknowns) and not errors.any:
        return None
    centred = entry.mean == "zero"
    mean = np.where(centred | effects.signed, 0.0, _POSITIVE_MEAN)
    share = np.where(centred | effects.signed, 1.0, np.sqrt(1.0 - _POSITIVE_MEAN**2))
    return Nuisance(
        effects.unknowns,
        mean * effects.deviation,
        share * effects.deviation,
        effects.signed,
        effects.source,
        nominal,
        errors,
    )


_POSITIVE_MEAN = math.sqrt(2.0 / math.pi)  # of |N(0, 1)|: what is positive has a mean

_NOTHING_SAYS = (
    "its sizes scale with the compliances of the joints, and nothing says those of {}; give "
    "compliance_urad_per_Nm or rated_torque_Nm by joint, or the masses of the robot"
)


def _said(entry: NuisanceFile, robot: Robot, *, typical: bool) -> dict[str, Size]:
    """Sizes that the study gives by name, in place of typical ones."""
    for joint in entry.tilt_nrad_per_Nm:
        with at("tilt_nrad_per_Nm", joint):
            (place,) = robot.index([joint])
            if robot.prismatic[place]:
                raise InputError(f"joint {joint!r} slides; the tilt of a guide is not modelled")
    given = {
        FOOT_TURNING: entry.foot_turning_nrad_per_Nm,
        FOOT_SLIDING: entry.foot_sliding_nm_per_N,
        **{tilt_of(joint): size for joint, size in entry.tilt_nrad_per_Nm.items()},
        TOOL_SLIDING: entry.tool_sliding_um_per_N,
    }
    said = {name: Size(size, _SAID) for name, size in given.items() if size is not None}
    if typical and FOOT_TURNING in said and FOOT_SLIDING not in said:
        said[FOOT_SLIDING] = foot_sliding(said[FOOT_TURNING].deviation)
    return said


def _errors(entry: NuisanceFile) -> CaseErrors:
    """Errors of load cases: what is said, else those of the preset."""
    base = ERRORS if entry.preset == "typical" else CaseErrors()
    off, load = entry.discrepancy, entry.load
    share, length = (off.share, off.mm) if isinstance(off, DiscrepancyFile) else (off, None)
    said = {
        "friction": entry.friction,
        "discrepancy": share,
        "discrepancy_length": length,
        "gain": load.relative,
        "tilt": load.tilt_deg,
        "repeatability": entry.repeatability_mm,
        "common_gain": load.common_relative,
        "common_tilt": load.common_tilt_deg,
    }
    sizes = {name: getattr(base, name) if size is None else size for name, size in said.items()}
    return CaseErrors(**sizes, process_force=_CELLS[load.process_force])


def _nominal(
    entry: NuisanceFile, robot: Robot, told: KnownJoints
) -> tuple[Array, str, tuple[str, ...]]:
    """(n,) compliances of the joints, where they are from, and turning joints that nothing knows.

    What says more stands above what says less: the study, models of earlier campaigns, the usual
    ones of a built-in robot, rated torques, masses.
    """
    known: dict[str, float] = {}
    origins: list[str] = []

    def tell(origin: str, more: Mapping[str, float]) -> None:
        if any(name in robot.joint_names for name in more):
            known.update(more)
            origins.insert(0, origin)

    mass = by_mass(robot)
    if mass is not None:
        tell("the mass of the robot", dict(zip(robot.joint_names, mass.tolist(), strict=True)))
    rated = entry.rated_torque_Nm
    with at("rated_torque_Nm"):
        robot.index(list(rated))
    tell("rated torques", {name: by_rated_torque(torque) for name, torque in rated.items()})
    if told.builtin in USUAL:
        usual = dict(zip(robot.joint_names, USUAL[told.builtin], strict=True))
        tell("joints of the usual order", usual)
    for model in told.models:
        found = zip(model.names, model.compliance.tolist(), strict=True)
        tell(f"joints as in {model.source}", {name: k for name, k in found if k > 0.0})
    for key in ("compliance_urad_per_Nm", "compliance_um_per_N"):
        with at(key):
            robot.index(list(getattr(entry, key)))
        tell("joints as given in the study", getattr(entry, key))
    nominal = np.array([known.get(name, 0.0) for name in robot.joint_names])
    unknown = [j.name for j in robot.joints if not j.prismatic and not known.get(j.name)]
    return nominal, ", ".join(dict.fromkeys(origins)), tuple(unknown)
