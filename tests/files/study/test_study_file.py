"""Study files: defaults and schema are in the units of the keys, values in SI."""

from __future__ import annotations

from elastocal.files.schema import json_schema
from elastocal.files.study.instrument import TrackerFile
from elastocal.files.study.obstacles import CollisionFile
from elastocal.files.study.study_file import StudyFile
from elastocal.files.study.tools import ToolFile


def test_values_are_in_si() -> None:
    tracker = {"position_mm": [3000, 0, 900], "elevation_deg": [-45, 60], "along_um": 10}
    entry = TrackerFile.of(tracker)
    assert entry.position_mm == [3.0, 0.0, 0.9]
    assert entry.along_um == 1e-5
    assert entry.elevation_deg is not None
    assert abs(entry.elevation_deg[1] - 1.0471975511965976) < 1e-15
    assert (entry.beam_radius_mm, CollisionFile().margin_mm, ToolFile().radius_mm) == (
        0.01,
        0.02,
        0.03,
    )


def test_the_schema_for_editors_has_the_defaults_of_the_file() -> None:
    sections = json_schema(StudyFile)["$defs"]
    assert sections["CollisionFile"]["properties"]["margin_mm"]["default"] == 20.0
    assert sections["ToolFile"]["properties"]["radius_mm"]["default"] == 30.0
    assert sections["TrackerFile"]["properties"]["beam_radius_mm"]["default"] == 10.0
