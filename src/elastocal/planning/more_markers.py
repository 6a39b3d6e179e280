"""More markers: the same study, with two more of them read."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.robot.rotations import frame_about
from elastocal.study.study import Study

_APART = 0.3  # further markers from the first [m]
_ENOUGH = 3  # markers from which on no more are proposed


def with_markers(study: Study) -> Study | None:
    """The study with two more markers beside the first; None if it has three, or turns are read."""
    tool = study.experiments.tool
    if len(tool.markers) >= _ENOUGH or tool.rotation:
        return None
    first = tool.markers[0]
    size = float(np.linalg.norm(first))
    frame = frame_about(first / size) if size else np.eye(3)
    markers = np.vstack([tool.markers, first + _APART * frame[:, :2].T])
    names = (*tool.marker_names, "further 1", "further 2")
    more = replace(tool, markers=markers, marker_names=names)
    return replace(study, experiments=replace(study.experiments, tool=more))
