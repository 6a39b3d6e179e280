"""Section of a validation: the error before and after the model, and whether it keeps its word.

In: validation. Out: the section.
"""

from __future__ import annotations

import numpy as np

from elastocal.identification.validation import Validation, doubts_of_validation, summary
from elastocal.report.charts.dumbbells import dumbbell_chart
from elastocal.report.charts.strips import Strips, strips_chart
from elastocal.report.contents import Contents
from elastocal.report.layout import two_widths
from elastocal.report.section import Chapter, PageSection, Values
from elastocal.report.tables import BarTable, Row
from elastocal.wording import worded
from elastocal.wording.lists import counted
from elastocal.wording.numbers import length, number, percent, sure


def validation_chapter(contents: Contents) -> Chapter | None:
    """The section of the validation."""
    found = contents.validation
    if found is None:
        return None
    return Chapter("Validation", (PageSection("validation", "Before and after", _values(found)),))


def removed(found: Validation) -> float:
    """Share of the deflection, as root mean square, that the model removes."""
    before = summary(found.before).rms
    return 1.0 - summary(found.after).rms / before if before > 0.0 else float("nan")


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
    before, after = found.by_experiment(found.before), found.by_experiment(found.after)
    band = f"{sure(found.confidence)} prediction interval"
    strips = Strips(found.after, found.half_width, data.case, data.names, band)
    sizes = summary(found.before), summary(found.after)
    rows = tuple(
        Row((name, length(a), length(b), percent(1.0 - b / a) if a > 0.0 else "–"))
        for name, a, b in (
            ("Root mean square", sizes[0].rms, sizes[1].rms),
            ("Mean", sizes[0].mean, sizes[1].mean),
            ("Largest", sizes[0].largest, sizes[1].largest),
        )
    )
    return {
        "removed": percent(removed(found)),
        "before": length(sizes[0].rms),
        "after": length(sizes[1].rms),
        "origin": origin(found),
        "kept_aside": found.kept_aside,
        "dumbbells": two_widths(lambda w: dumbbell_chart(before, after, data.names, w)),
        "table": BarTable(("Length of the error", "Before", "After", "Removed"), rows),
        "inside": percent(found.inside),
        "predicted": found.coordinates,
        "promised": sure(found.confidence),
        "p_value": number(found.p_value, 2),
        "likely": bool(found.p_value >= 1e-3),
        "strips": two_widths(lambda w: strips_chart(strips, w)),
        "strips_remark": strips.remark,
        "remarks": validation_remarks(found),
        "unknown": int((~np.isfinite(found.half_width)).any(axis=1).sum()),
    }
