"""A calibrated robot as URDF: that of the study with other origins, or a new one.

Compliances, bases, reflectors and payloads stand in an element `<elastocal>` at its end, which
readers that do not know it leave out.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from elastocal.calibration.calibrated_robot import CalibratedRobot
from elastocal.files.models.writing import springs_section
from elastocal.files.study.robot import UrdfRobotFile
from elastocal.files.yaml_lines import parse
from elastocal.reading import bytes_of
from elastocal.robot.geometry_hash import geometry_hash
from elastocal.robot.sinks.urdf import FLANGE, urdf_of
from elastocal.robot.sinks.urdf_origins import with_origins
from elastocal.robot.sinks.urdf_words import element, opened, pose_words, words_of
from elastocal.robot.sources.urdf import LARGEST
from elastocal.writing import signature

KIND = "calibrated urdf"


class CalibratedUrdf(NamedTuple):
    """A URDF, and what is to be said of it."""

    text: str
    tip: str
    """The link that is the flange."""
    source: Path | None
    """The file that it was made from."""
    changed: tuple[str, ...]
    """Joints whose origins are others than in that."""


def calibrated_urdf(
    calibrated: CalibratedRobot, study_text: str, study_file: Path
) -> CalibratedUrdf:
    """The URDF of a calibrated robot.

    Args:
        calibrated: The robot.
        study_text: The study that its drawing is from.
        study_file: Where that stands: files it names are relative to it.

    Raises:
        InputError: the robot file cannot be read, or the robot cannot be said in a URDF.
    """
    extension = extension_lines(calibrated)
    entry = urdf_entry(study_text, study_file)
    if entry is None:
        return CalibratedUrdf(_signed(urdf_of(calibrated.robot, extension)), FLANGE, None, ())
    path = study_file.parent / entry.urdf
    if path.suffix.lower() == ".xacro":
        from elastocal.robot.sources.xacro_text import expanded

        folders = {name: study_file.parent / folder for name, folder in entry.packages.items()}
        data = expanded(path, folders, entry.arguments)
    else:
        data = bytes_of(path, LARGEST)
    found = with_origins(
        data,
        str(path),
        calibrated.model.robot,
        calibrated.robot,
        base=entry.base,
        tip=entry.tip,
        extension=extension,
    )
    return CalibratedUrdf(_signed(found.text), found.tip, path, found.changed)


def urdf_entry(text: str, path: Path) -> UrdfRobotFile | None:
    """What a study says of its robot file, None if it has none."""
    robot = parse(text, path).value["robot"]
    return UrdfRobotFile.of(robot) if isinstance(robot, dict) and "urdf" in robot else None


def _signed(text: str) -> str:
    """The text with our signature in a comment, behind its declaration."""
    first, rest = ("", text) if not text.startswith("<?xml") else text.split("\n", 1)
    declared = first or '<?xml version="1.0" encoding="utf-8"?>'
    return f"{declared}\n<!-- {signature(KIND)} -->\n{rest}"


def extension_lines(calibrated: CalibratedRobot) -> list[str]:
    """The element `<elastocal>`: SI units, frames of the joints as in a URDF."""
    origin = calibrated.origin
    lines = [
        opened(
            "elastocal",
            version=1,
            geometry_sha256=geometry_hash(calibrated.model.robot),
            measurements_sha256=origin.measurements_sha256,
            gravity=words_of(calibrated.model.gravity),
        )
    ]
    lines += [f"  {line}" for line in _springs(calibrated)]
    for s, name in enumerate(calibrated.stations):
        lines.append("  " + element("base", station=name, **pose_words(calibrated.state.base[s])))
    read = calibrated.parameters.targets.astype(bool)
    for m, mounting in enumerate(calibrated.mountings):
        for k, name in enumerate(calibrated.model.tool.marker_names):
            if read[m, k]:
                xyz = words_of(calibrated.state.markers[m, k])
                lines.append("  " + element("reflector", mounting=mounting, name=name, xyz=xyz))
    for load, (mass, *moment) in zip(
        calibrated.model.payloads, calibrated.state.payload.tolist(), strict=True
    ):
        lines.append(
            "  " + element("payload", name=load.name, mass=repr(mass), moment=words_of(moment))
        )
    return [*lines, "</elastocal>"]


def _springs(calibrated: CalibratedRobot) -> list[str]:
    """One element for each spring: where it sits, its compliance, the standard error of that."""
    model = calibrated.compliances
    elsewhere = springs_section(calibrated.robot, model.springs)
    lines = []
    for i, (name, kind) in enumerate(zip(model.names, model.springs.kinds, strict=True)):
        numbers = {
            "value": repr(float(model.compliance[i])),
            "unit": kind.compliance.replace("·", "."),
            "standard_error": repr(float(model.standard_error[i])),
        }
        if name not in elsewhere:
            lines.append(element("compliance", joint=name, **numbers))
            continue
        place = elsewhere[name]
        lines.append(
            element(
                "compliance",
                spring=name,
                carried_by=place["carried_by"],
                type=place["type"],
                axis=words_of(place["axis"]),
                origin=words_of(np.array(place["origin_mm"]) / 1e3),
                **numbers,
            )
        )
    return lines
