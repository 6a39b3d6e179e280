"""Section of a validation: the error before and after the model, and whether it keeps its word.

In: validation. Out: the section.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from elastocal.identification.validation import Validation, doubts_of_validation
from elastocal.measuring.measurements import Quantity
from elastocal.report.charts.dumbbells import dumbbell_chart
from elastocal.report.contents import Contents
from elastocal.report.layout import two_widths
from elastocal.report.section import Chapter, PageSection, Values
from elastocal.report.sections.identification import reading_strips
from elastocal.report.tables import BarTable, Row
from elastocal.wording import worded
from elastocal.wording.lists import counted
from elastocal.wording.numbers import percent, probability, small, sure


def validation_chapter(contents: Contents) -> Chapter | None:
    """The section of the validation."""
    found = contents.validation
    if found is None:
        return None
    return Chapter("Validation", (PageSection("validation", "Before and after", _values(found)),))


@dataclass(frozen=True)
class Removed:
    """What the model removes of the readings of one kind.

    Attributes:
        what: What it is called: "deflection" or "rotation".
        share: Share removed, as root mean square.
        before: Root mean square before, with its unit.
        after: After.
    """

    what: str
    share: str
    before: str
    after: str


def removed(found: Validation, kind: Quantity) -> Removed:
    """What the model removes of the readings of one kind."""
    before, after = (size.rms for size in found.sizes(kind))
    return Removed(
        "deflection" if kind.unit == "m" else kind.name,
        percent(1.0 - after / before if before > 0.0 else float("nan")),
        small(before, kind.unit),
        small(after, kind.unit),
    )


def origin(found: Validation) -> str:
    """What the model was judged on, in words."""
    experiments = counted(len(found.measurements.cases), "experiment")
    if found.kept_aside:
        return f"{experiments} that took no part in the identification"
    return (
        f"{experiments} of the identification itself, each left out in turn; nothing was kept aside"
    )


def validation_remarks(found: Validation) -> tuple[str, ...]:
    """What should make one doubt the model."""
    return tuple(f"validation: {worded(doubt)}" for doubt in doubts_of_validation(found))


def _values(found: Validation) -> Values:
    """Errors with and without the model."""
    data = found.measurements
    band = f"{sure(found.confidence)} prediction interval"
    return {
        "removed": [removed(found, kind) for kind in data.quantities],
        "origin": origin(found),
        "kept_aside": found.kept_aside,
        "each": [(_dumbbells(found, kind), _table(found, kind)) for kind in data.quantities],
        "inside": percent(found.inside),
        "predicted": found.coordinates,
        "promised": sure(found.confidence),
        "p_value": probability(found.p_value),
        "likely": bool(found.p_value >= 1e-3),
        "tested": found.tested,
        "strips": [
            reading_strips(found.after, found.half_width, data, kind, band)
            for kind in data.quantities
        ],
        "remarks": validation_remarks(found),
        "unknown": int((~np.isfinite(found.half_width)).any(axis=1).sum()),
    }


def _dumbbells(found: Validation, kind: Quantity) -> Markup:
    """Errors of one kind, experiment by experiment."""
    data = found.measurements
    before, after = (found.by_experiment(error, kind) for error in (found.before, found.after))
    return two_widths(lambda w: dumbbell_chart(before, after, data.names, w, kind.unit))


def _table(found: Validation, kind: Quantity) -> BarTable:
    """Sizes of the errors of one kind."""
    before, after = found.sizes(kind)
    rows = tuple(
        Row(
            (
                name,
                small(a, kind.unit),
                small(b, kind.unit),
                percent(1.0 - b / a) if a > 0.0 else "–",
            )
        )
        for name, a, b in (
            ("Root mean square", before.rms, after.rms),
            ("Mean", before.mean, after.mean),
            ("Largest", before.largest, after.largest),
        )
    )
    what = "Length of the error" if kind.unit == "m" else "Angle of the error"
    return BarTable((what, "Before", "After", "Removed"), rows)
