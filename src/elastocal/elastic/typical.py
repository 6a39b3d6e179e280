"""Typical: how large the springs and errors are that nobody states, with their sources.

In: a robot, compliances of its joints. Out: the size of each effect, as a root mean square: the
effects are positive, and their priors centred on zero. docs/typical.md says it in words.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.effects import FOOT_SLIDING, FOOT_TURNING, TOOL_SLIDING, Size, tilt_of
from elastocal.elastic.long_links import long_links
from elastocal.robot.chain import Robot

BEARING = 0.2
"""Tilt over turn of a reducer with its main bearing; data sheets have 0.03 to 0.25."""
WRIST = 0.1
"""The same in a wrist: shafts drive it that twist, and the bearing does not."""
LINK = 1.0
"""What lies between two long links, over the stiffest joint; beams, and a FANUC R-2000iC."""
COLUMN = 0.25
"""The same of the short column behind the first joint; beams."""
FOOT = 0.3
"""Foot, over the stiffest joint: slab on its bed; 0.1 if anchored in a floor, 1 on a pallet."""
FOOT_RADIUS = 0.6
"""Sliding over turning of a foot is the square of this [m]: a slab on its bed."""
TOOL = 3e-7
"""A bracket of 0.3 m [m/N]; 5e-8 for a spindle on a solid flange; beam, and the FANUC."""
ERRORS = CaseErrors(
    friction=0.08,
    discrepancy=0.08,
    gain=0.005,
    tilt=float(np.radians(0.5)),
    common_gain=0.003,
)
"""Friction: lost motion of reducers. Discrepancy: the FANUC, papers have 0.03 at best. Load: a
calibrated cell, a cable."""
RATED = 1e-3
"""Turn of a reducer at its rated torque [rad]; data sheets have 0.5 to 1.5 mrad."""
MASS = 3e-4
"""Compliance of the stiffest joint times the mass of the arm [kg·rad/(N·m)]: thin tubes."""
WRIST_SOFTER = 8.0
"""Wrist joints over the stiffest joint, where nothing but a mass is known; heavy arms."""


def typical_sizes(robot: Robot, compliance: Array, origin: str = "") -> dict[str, Size]:
    """Size of every effect, by name.

    Args:
        robot: The robot.
        compliance: (n,) compliances of its joints; those of sliding joints do not count.
        origin: Where these are from, for the sentences.

    Source: docs/typical.md.
    """
    turning = ~robot.prismatic
    stiffest = float(compliance[turning].min()) if turning.any() else 0.0
    long = long_links(robot)
    main = _last_main_joint(long)
    ending = f" ({origin})" if origin else ""
    slab = f"{FOOT:g} of the stiffest joint: a slab on its bed{ending}"
    sizes = {
        FOOT_TURNING: Size(FOOT * stiffest, slab),
        FOOT_SLIDING: foot_sliding(FOOT * stiffest),
    }
    for j, name in enumerate(robot.joint_names):
        if not turning[j]:
            continue
        own = BEARING if j <= main else WRIST
        link = LINK if long[j] else COLUMN if j == 0 else 0.0
        why = f"bearing {own:g} of the joint"
        if link:
            beam = "long link" if long[j] else "column"
            why += f" and {beam} {link:g} of the stiffest one"
        sizes[tilt_of(name)] = Size(
            float(np.hypot(own * compliance[j], link * stiffest)), why + ending
        )
    sizes[TOOL_SLIDING] = Size(TOOL, "a bracket of 0.3 m")
    return sizes


def foot_sliding(turning: float) -> Size:
    """How a foot slides that turns so much [rad/(N·m)]."""
    return Size(turning * FOOT_RADIUS**2, f"that of its turning, times ({FOOT_RADIUS:g} m)²")


def by_rated_torque(torque: float) -> float:
    """Compliance of a turning joint with this rated torque [N·m]."""
    return RATED / torque


def by_mass(robot: Robot) -> Array | None:
    """(n,) compliances as arms of this mass have; None where the masses are not known."""
    mass = sum(body.mass for body in robot.masses)
    if not mass > 0.0:
        return None
    long = long_links(robot)
    softer = np.where(np.arange(len(long)) > _last_main_joint(long), WRIST_SOFTER, 1.0)
    return np.asarray(np.where(robot.prismatic, 0.0, MASS / mass * softer))


def _last_main_joint(long: BoolArray) -> int:
    """The joint after which the wrist begins; the last one where no link is long."""
    return int(np.flatnonzero(long)[-1]) if long.any() else len(long) - 1
