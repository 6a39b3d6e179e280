"""Motion between experiments, and the times of a campaign."""

from __future__ import annotations

from elastocal.files.schema.values import Name, Number, Positive, Section


class MotionFile(Section):
    """How fast the robot moves between experiments, and where it starts and ends."""

    max_speed_deg_s: Positive | dict[Name, Positive] | None = None
    max_speed_mm_s: Positive | dict[Name, Positive] | None = None
    home_deg: dict[Name, Number] | list[Number] | None = None
    home_mm: dict[Name, Number] | None = None


class CampaignFile(Section):
    """How long things take."""

    measure_min: Number | None = None
    settle_s: Number | None = None
    change_load_min: Number | None = None
