"""Deflections of a whole campaign as programs of laser trackers and controllers write them.

Points stand in the frame of the tracker, of a robot that is not where its joints and tool say by
some tenths of a millimetre; names say pose, reflector and state together.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np
from scipy.spatial.transform import Rotation

from elastocal.arrays import Array
from elastocal.elastic.deflections import loaded_deflection
from elastocal.elastic.load_cases import LoadCases
from elastocal.robot.posture import forward_kinematics
from elastocal.study.study import Study
from tests.files.campaign import STUDY_TEXT, study

TEXT = STUDY_TEXT.replace(
    "M2: [500, 150, -300]", "M2: [500, 150, -300], M3: [420, -180, -350]"
).replace("force_N: [0, 0, -2500], count: 3", "force_N: [0, 0, -1500], count: 12")
TRUTH = np.array([0.35, 0.41, 3.0, 3.1, 2.4]) * 1e-6
MASS = 1500.0 / 9.80665
RPY = (-0.7, 1.3, 137.2)  # degrees, tracker to base
TURN = Rotation.from_euler("ZYX", RPY[::-1], degrees=True).as_matrix()
HEAD = np.array([2.5, -3.1, 0.64])
BEGIN = datetime(2026, 11, 2, 9, 14, 5)


@dataclass(frozen=True)
class Exported:
    """N poses: joint values (N, 6) [rad], unloaded and loaded points (N, K, 3) [m], tracker frame,
    and what the deflections are in the base frame (N, K, 3) [m]."""

    study: Study
    q: Array
    unloaded: Array
    loaded: Array
    deflection: Array


def exported(
    count: int = 12, seed: int = 3, *, off: float = 4e-4, noise: float = 0.0, turn: Array = TURN
) -> Exported:
    """A campaign under a hung weight; the robot is `off` [m] from its model, smoothly."""
    what, rng = study(TEXT), np.random.default_rng(seed)
    lower, upper = what.limits
    q = np.round(np.radians(np.degrees(rng.uniform(0.6 * lower, 0.6 * upper, (count, 6)))), 6)
    wrench = np.zeros((count, 6))
    wrench[:, 2] = -1500.0
    moved = loaded_deflection(what.arm, TRUTH, LoadCases(q, wrench)).reshape(count, -1, 3)
    flange = forward_kinematics(what.robot, q)
    markers = what.experiments.tool.markers
    points = flange[:, None, :3, 3] + np.einsum("nij,kj->nki", flange[:, :3, :3], markers)
    points = points + off * np.sin(7.0 * np.arange(count)[:, None, None] + np.arange(3))
    first, second = points, points + moved
    first = first + noise * rng.normal(size=first.shape)
    second = second + noise * rng.normal(size=second.shape)
    return Exported(what, q, (first - HEAD) @ turn, (second - HEAD) @ turn, moved)


def inspector(found: Exported) -> dict[str, str]:
    """Two comment lines, no header, commas, mm; groups name pose and state. Joints by the pose."""
    lines = ["// Points in millimetres, frame of the instrument",
             "// Collection, Group, Target, X, Y, Z, Timestamp"]  # fmt: skip
    for i in range(len(found.q)):
        for name, points in (("UL", found.unloaded), ("L", found.loaded)):
            for k, p in enumerate(points[i]):
                time = BEGIN + timedelta(seconds=47 * len(lines))
                cells = ["KR270", f"Pose{i + 1:02d}_{name}", f"M{k + 1}"]
                cells += [f"{1e3 * v:.4f}" for v in p]
                lines.append(",".join([*cells, time.isoformat()]))
    joints = ["Pose,A1,A2,A3,A4,A5,A6,Load kg"]
    joints += [
        ",".join([f"Pose{i + 1:02d}", *(f"{v:.5f}" for v in np.degrees(q)), f"{MASS:.3f}"])
        for i, q in enumerate(found.q)
    ]
    return {"points.txt": "\n".join(lines) + "\n", "joints.csv": "\n".join(joints) + "\n"}


INSPECTOR = """\
elastocal: 1
files:
  - header: false
    columns: {marker: 3, "x y z [mm]": [4, 5, 6]}
    patterns: {2: 'Pose(?P<experiment>\\d+)_(?P<state>UL|L)'}
  - join: experiment
    columns: {"q [deg]": [A1, A2, A3, A4, A5, A6], "hanging mass [kg]": Load kg}
    patterns: {Pose: 'Pose(?P<experiment>\\d+)'}
words: {state: {UL: unloaded, L: loaded}}
frame: {rpy_deg: [-0.7, 1.3, 137.2]}
"""


def works(found: Exported) -> dict[str, str]:
    """Semicolons, decimal commas, metres; one name says all. The joints are numbered."""
    lines = ["Objekt;X [m];Y [m];Z [m];Unsicherheit [µm];Zeit"]
    for i in range(len(found.q)):
        for k in range(found.unloaded.shape[1]):
            for name, points in (("unbelastet", found.unloaded), ("belastet", found.loaded)):
                time = BEGIN + timedelta(seconds=40 * len(lines))
                cells = [f"{v:.7f}" for v in points[i, k]] + ["15.0"]
                cells = [cell.replace(".", ",") for cell in cells]
                cells = [f"P{i + 1:02d} M{k + 1} {name}", *cells]
                lines.append(";".join([*cells, time.strftime("%d.%m.%Y %H:%M:%S")]))
    joints = ["Nr\tJ1\tJ2\tJ3\tJ4\tJ5\tJ6"]
    joints += [
        "\t".join([f"{i + 1}", *(f"{v:.5f}" for v in np.degrees(q))]) for i, q in enumerate(found.q)
    ]
    return {"points.csv": "\n".join(lines) + "\n", "joints.txt": "\n".join(joints) + "\n"}


WORKS = """\
elastocal: 1
join: experiment
columns:
  x y z [m]: [X, Y, Z]
  "u [um]": Unsicherheit
  q [deg]: [J1, J2, J3, J4, J5, J6]
files:
  - patterns: {Objekt: 'P(?P<experiment>\\d+) (?P<marker>M\\d) (?P<state>\\w+)'}
  - columns: {experiment: Nr}
words: {state: {unbelastet: unloaded, belastet: loaded}}
constants: {"hanging mass [kg]": 152.957}
frame: {rpy_deg: [-0.7, 1.3, 137.2]}
"""


PLANNED = """\
elastocal: 1
header: false
columns: {marker: 3, "x y z [mm]": [4, 5, 6]}
patterns: {2: 'Pose(?P<experiment>\\d+)_(?P<state>UL|L)'}
words: {state: {UL: unloaded, L: loaded}}
frame: {rpy_deg: [-0.7, 1.3, 137.2]}
"""


def plan(found: Exported) -> str:
    """The plan of the campaign, as a table."""
    lines = [",".join(["configuration", *(f"A{i} [deg]" for i in range(1, 7)),
                       "Fx [N]", "Fy [N]", "Fz [N]", "repeats"])]  # fmt: skip
    lines += [
        ",".join([f"C{i}", *(f"{v:.6f}" for v in np.degrees(q)), "0", "0", "-1500", "1"])
        for i, q in enumerate(found.q)
    ]
    return "\n".join(lines) + "\n"
