"""What a model file says besides its compliances: where they come from, and how good they are.

What is claimed of the compliances is compared with them; the rest must be what its key promises.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.errors import InputError
from elastocal.files.sections import After, Before, OpenSection
from elastocal.files.values import AtLeastZero, Finite, Flag, Matrix, Name, Natural
from elastocal.files.yaml_lines import LocatedError, at
from elastocal.fitting.goodness import quantile
from elastocal.identification.choices import Fitted, LossName, Model, Sigma

AGREE = 1e-3
"""Share by which a claim may differ from what it is claimed of: files of people have few digits."""


class OriginFile(OpenSection):
    """A file something was made from."""

    name: str = ""
    sha256: str = ""


class ProvenanceFile(OpenSection):
    """Files that a model was made from."""

    study: OriginFile | None = None
    measurements: OriginFile | None = None
    models: list[OriginFile] | None = None
    readings: list[str] | None = None
    marks: list[str] | None = None

    def contradiction(self) -> str:
        """The measurements are among the readings: of one file both have the same hash."""
        named, readings = self.measurements or OriginFile(), self.readings or ()
        several = ", " in named.name or " through " in named.name
        if named.sha256 and readings and not several and named.sha256 not in readings:
            return (
                f"the sha256 of measurements, {named.sha256[:16]!r}…, is not among the readings; "
                "one of them was changed"
            )
        return ""


def _confidence(value: float) -> float:
    if not 0.5 <= value < 1.0:
        raise ValueError(f"expected 0.5 to below 1, found {value:g}")
    return value


def _two(value: Any) -> Any:
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"expected two numbers [lower, upper], found {value!r:.80}")
    return value


class IdentificationFile(OpenSection):
    """How a model was found."""

    identified: list[Name] | None = None
    model: Model = "equilibrium"
    sigma: Sigma = "known"
    loss: LossName = "squares"
    fitted: Fitted = "mixed"
    nonnegative: Flag = False
    confidence: Annotated[Finite, After(_confidence)] = 0.95
    interval: dict[str, Annotated[list[Finite], Before(_two)]] | None = None
    linear_model: dict[str, Finite] | None = None
    nuisance: list[dict[str, Any]] | None = None
    joints_alone: dict[str, Any] | None = None
    iterations: Natural | None = None
    experiments: Natural | None = None
    readings: Natural | None = None
    load_cases: list[dict[str, Any]] | None = None


class DiagnosticsFile(OpenSection):
    """What is to be made of a model."""

    remarks: list[str] | None = None
    doubts: list[dict[str, Any]] | None = None
    scale_of_noise: AtLeastZero | None = None
    scale_of_noise_by_kind: dict[str, AtLeastZero | None] | None = None
    chi_square: AtLeastZero | None = None
    degrees_of_freedom: Natural | None = None
    lack_of_fit: dict[str, Any] | None = None
    correlation: Matrix | None = None
    singular_values: list[AtLeastZero] | None = None
    rms_residual_mm: AtLeastZero | None = None
    rms_residual_mrad: AtLeastZero | None = None
    experiments: list[dict[str, Any]] | None = None
    test_poses: list[dict[str, Any]] | None = None


def refuse_false_claims(
    model: ComplianceModel, how: IdentificationFile | None, weak: DiagnosticsFile | None
) -> None:
    """Refuse intervals and correlations that are not those of the compliances.

    Raises:
        LocatedError: the first of them; knows its key.
    """
    if how is None:
        return
    named = tuple(how.identified or ())
    with at("identification"):
        if unknown := [n for n in (*named, *(how.interval or {})) if n not in model.names]:
            raise InputError(f"identification: there is no compliance of {unknown[0]!r:.80}")
        for name, claimed in (how.interval or {}).items():
            bounded = how.nonnegative or how.nuisance is not None
            _refuse_interval(model, name, claimed, how.confidence, bounded=bounded)
    if weak is not None and weak.correlation is not None:
        with at("diagnostics", "correlation"):
            _refuse_correlation(model, named, weak.correlation)


def _refuse_interval(
    model: ComplianceModel, name: str, claimed: list[float], confidence: float, *, bounded: bool
) -> None:
    """Refuse an interval that is not that of a compliance and its standard error."""
    i = model.names.index(name)
    value, error = model.compliance[i], model.standard_error[i]
    dof = float(model.freedom(np.eye(len(model.names))[i : i + 1])[0])
    half, held = quantile(0.5 + 0.5 * confidence, dof) * error, bounded and value == 0.0
    found = value + half * np.array([-1.0, 1.0])
    if held:  # by the estimate without the bound, which was not above zero by more than chance
        limit = quantile(confidence, dof) * error
        found = np.array([0.0, min(max(claimed[1], limit), limit + half)])
    elif bounded:
        found = np.maximum(found, 0.0)
    if (np.abs(found - claimed) > AGREE * half + 1e-6 * abs(value)).any():
        raise LocatedError(
            ("interval", name),
            f"identification.interval.{name}: [{claimed[0]:.6g}, {claimed[1]:.6g}] is not the "
            f"interval of {value:.6g} with standard error {error:.3g}, which is "
            f"[{found[0]:.6g}, {found[1]:.6g}]; leave identification and diagnostics out of a "
            "model that is changed by hand",
        )


def _refuse_correlation(
    model: ComplianceModel, names: tuple[str, ...], claimed: list[list[float]]
) -> None:
    """Refuse correlations that are not those of the covariance."""
    p = len(names)
    if [len(row) for row in claimed] != p * [p]:
        raise InputError(
            f"diagnostics.correlation: expected {p} rows of {p} numbers, as many as are identified"
        )
    index = [model.names.index(name) for name in names]
    scale: Array = np.maximum(model.standard_error[index], 1e-300)
    found = model.covariance[np.ix_(index, index)] / np.outer(scale, scale)
    off = np.abs(found - np.array(claimed))
    if off.size and off.max() > AGREE:
        i, j = divmod(int(off.argmax()), p)
        raise InputError(
            f"diagnostics.correlation: {claimed[i][j]:.4g} of {names[i]} and {names[j]} is not "
            f"that of the covariance, which is {found[i, j]:.4g}"
        )
