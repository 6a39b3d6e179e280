"""Estimates with their errors as people read them: no more digits than the error leaves.

In: an identification. Out: rows for tables and forest plots, angular and linear springs apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.identification.result import Identification
from elastocal.report.charts.forest import Estimate
from elastocal.report.tables import BarTable, Row
from elastocal.robot.joint_kinds import KINDS, JointKind
from elastocal.wording.numbers import fixed, number, shown_unit
from elastocal.wording.numbers import sure as sure_of


@dataclass(frozen=True)
class Family:
    """The springs of one kind.

    Attributes:
        kind: "angular" or "linear".
        unit: Of the compliances.
        stiffness_unit: Of the stiffnesses.
        compliance: The estimates.
        stiffness: Their inverses, the ends of the intervals swapped.
        table: All of it as text.
    """

    kind: str
    unit: str
    stiffness_unit: str
    compliance: tuple[Estimate, ...]
    stiffness: tuple[Estimate, ...]
    table: BarTable


def families(
    found: Identification, references: Mapping[str, ComplianceModel]
) -> tuple[Family, ...]:
    """Angular and linear springs of an identification, as far as there are any."""
    kinds = [found.model.springs.kinds[i] for i in found.index]
    return tuple(
        _family(found, references, [i for i, own in enumerate(kinds) if own is kind], kind)
        for kind in KINDS
        if kind in kinds
    )


def _family(
    found: Identification,
    references: Mapping[str, ComplianceModel],
    chosen: list[int],
    kind: JointKind,
) -> Family:
    factor, unit = shown_unit(kind.compliance)
    stiff, stiffness_unit = shown_unit(kind.stiffness)
    compliance, stiffness, rows = [], [], []
    for i in chosen:
        name, k = found.identified[i], float(found.compliance[i])
        low, high = (float(v) for v in found.interval[i])
        others = tuple(_of(model, name) for model in references.values())
        linear = float(found.linear[i])
        compliance.append(
            Estimate(
                name,
                factor * k,
                factor * low,
                factor * high,
                factor * linear,
                _scaled(others, factor),
            )
        )
        inverse = Estimate(
            name,
            stiff * _inverse(k),
            stiff * _inverse(high),
            stiff * (1.0 / low if low > 0.0 else np.inf),
            stiff * _inverse(linear),
            tuple(stiff * _inverse(v) for v in others),
        )
        stiffness.append(inverse)
        error = float(found.standard_error[i])
        rows.append(_row(found, compliance[-1], inverse, factor * error, name in found.held))
    sure = sure_of(found.how.confidence)
    heads = (
        "Spring",
        f"Compliance [{unit}]",
        "Standard error",
        f"{sure} interval",
        f"Stiffness [{stiffness_unit}]",
        f"{sure} interval",
        *references,
    )
    table = BarTable(heads, tuple(rows))
    return Family(kind.spring, unit, stiffness_unit, tuple(compliance), tuple(stiffness), table)


def _row(found: Identification, k: Estimate, stiff: Estimate, error: float, held: bool) -> Row:
    decimals = decimals_of(error)
    span = f"{fixed(k.low, decimals)} to {fixed(k.high, decimals)}"
    half = 0.5 * (stiff.high - stiff.low)
    places = decimals_of(half if np.isfinite(half) else 0.1 * abs(stiff.value))
    top = fixed(stiff.high, places) if np.isfinite(stiff.high) else "∞"
    stiffness = fixed(stiff.value, places) if np.isfinite(stiff.value) else "–"
    between = f"{fixed(stiff.low, places)} to {top}" if np.isfinite(stiff.low) else "–"
    if held:
        cells: tuple[str, ...] = (k.name, "0, held", "–", "–", "rigid", "–")
    else:
        cells = (k.name, fixed(k.value, decimals), number(error, 2), span, stiffness, between)
    others = tuple("–" if np.isnan(r) else number(r, 4) for r in k.references)
    return Row(cells + others, state="open" if k.low <= 0.0 and not held else "")


def decimals_of(error: float) -> int:
    """Decimals at which an error keeps two significant digits."""
    if not np.isfinite(error) or error <= 0.0:
        return 2
    return int(np.clip(1 - np.floor(np.log10(error)), 0, 8))


def _of(model: ComplianceModel, name: str) -> float:
    return float(model.of([name])[0]) if name in model.names else float("nan")


def _scaled(values: tuple[float, ...], factor: float) -> tuple[float, ...]:
    return tuple(factor * value for value in values)


def _inverse(value: float) -> float:
    return 1.0 / value if value > 0.0 else float("nan")
