"""A campaign as one HTML page that works offline, on a phone and on paper.

In: values the core made. Out: HTML text. Nothing is computed here but where things are drawn.
jinja2 and plotly are imported when a report is made, not when this package is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from elastocal.report.contents import Contents
    from elastocal.report.sections.calibration import CalibrationContents

__all__ = ["calibration_html", "html"]


def html(contents: Contents) -> str:
    """A campaign, as far as it has come, as one self-contained HTML page.

    Args:
        contents: The stages there are, and what to compare them with.

    Returns:
        HTML text that needs no network: styles, pictures and the 3D views are inside.

    Raises:
        InputError: there is nothing to show.
    """
    from elastocal.report.page import render

    return render(contents)


def calibration_html(contents: CalibrationContents) -> str:
    """A calibration from absolute readings as one self-contained HTML page."""
    from elastocal.report.page import render_calibration

    return render_calibration(contents)
