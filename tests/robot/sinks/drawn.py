"""The robots of the examples as their studies have them: base and tip as named there."""

from __future__ import annotations

from pathlib import Path

import yaml

from elastocal.robot.chain import Robot
from elastocal.robot.sources.urdf import from_urdf


def ends_of(path: Path) -> dict[str, str]:
    """Base and tip, as the study beside a URDF names them."""
    entry = yaml.safe_load((path.parent / "study.yaml").read_text("utf-8"))["robot"]
    return {key: entry[key] for key in ("base", "tip") if key in entry}


def drawn(path: Path) -> Robot:
    """The robot of a URDF, as the study beside it has it."""
    return from_urdf(path, **ends_of(path))
