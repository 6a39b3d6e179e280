"""KUKA KR 270 (2000 series) with the paper's machining and calibration tools.

Frames at home (all joints zero): x forward along both arms, z up; every frame is parallel to the
base. Flange x runs along axis 6, flange z is up at home.

Source: lengths from Table 3 of the paper; axes, offsets and tools recovered from eq. (38) and
Table 6 (docs/validation.md); joint limits as published by the maker for this series.
"""

from __future__ import annotations

import numpy as np

from elastocal.robot.chain import Joint, Robot, Tool, transform

_JOINTS = (  # name, axis at home, origin from the previous joint [m], limits [deg]
    ("A1", (0, 0, -1), (0.0, 0.0, 0.0), (-185.0, 185.0)),
    ("A2", (0, 1, 0), (0.350, 0.0, 0.750), (-140.0, 0.0)),
    ("A3", (0, 1, 0), (1.250, 0.0, 0.0), (-119.0, 155.0)),
    ("A4", (-1, 0, 0), (0.0, 0.0, -0.055), (-350.0, 350.0)),
    ("A5", (0, 1, 0), (1.100, 0.0, 0.0), (-122.5, 122.5)),
    ("A6", (-1, 0, 0), (0.0, 0.0, 0.0), (-350.0, 350.0)),
)
USUAL = (0.623e-6, 0.302e-6, 0.406e-6, 3.002e-6, 3.303e-6, 2.365e-6)
"""Compliances of the order published for heavy six-axis robots [rad/(N·m)]: those of no robot."""
_MILLING = (0.986, 0.0, 0.0)
_CALIBRATION = (0.6115, 0.0, -0.460)


def kuka_kr270() -> Robot:
    """The robot of the paper's section 6."""
    joints = tuple(
        Joint(name, transform(None, origin), np.array(axis), False, *np.radians(limits))
        for name, axis, origin, limits in _JOINTS
    )
    tools = {
        "milling": Tool("milling", np.array(_MILLING), np.array([_MILLING]), ("TCP",)),
        "calibration": Tool(
            "calibration", np.array(_CALIBRATION), np.array([_CALIBRATION]), ("M1",)
        ),
    }
    return Robot("kuka-kr270", joints, tools=tools)
