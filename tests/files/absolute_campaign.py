"""A small campaign of absolute readings, and files of it as trackers and controllers write them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from elastocal.arrays import Array
from elastocal.elastic.springs import joint_springs
from elastocal.measuring.instrument import Isotropic, PoseProbe
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.payloads import Payload
from elastocal.robot.posture import forward_kinematics
from elastocal.robot.sources import load
from elastocal.study.absolute import AbsoluteStudy

ROBOT: Robot = load("kuka-kr270")
JOINTS = ROBOT.joint_names
MARKERS = np.array([[0.6, 0.0, -0.46], [0.5, 0.15, -0.3]])
STATION = Rotation.from_euler("zyx", [135.0, 1.5, -0.8], degrees=True).as_matrix()
HEAD = np.array([2.5, -3.1, 0.64])  # where the tracker stands, base frame [m]


def study(*, probe: bool = False, markers: int = 2) -> AbsoluteStudy:
    """Two reflectors on a plate, or a probe that reads its orientation, too."""
    names = ("M1", "M2")[:markers]
    tool = Tool("plate", MARKERS[0], MARKERS[:markers], names, rotation=probe)
    instrument = Isotropic(3e-5)
    return AbsoluteStudy(
        ROBOT,
        tool,
        PoseProbe(instrument, 1e-4) if probe else instrument,
        joint_springs(ROBOT, ["A2"]),
        ("base", "tool"),
        payloads=(Payload("plates", 120.0, np.array([0.3, 0.0, 0.0])),),
    )


@dataclass(frozen=True)
class Truth:
    """Joint values (N, 6) [rad], reflectors (N, K, 3) [m] and turns (N, 3, 3), tracker frame."""

    q: Array
    points: Array
    turns: Array


def truth(count: int, seed: int = 1) -> Truth:
    """Poses by chance, and where a tracker sees the reflectors of a rigid arm."""
    rng = np.random.default_rng(seed)
    q = np.round(rng.uniform(-1.0, 1.0, (count, 6)) + np.array([0, -1, 1.5, 0, 0, 0]), 4)
    flange = forward_kinematics(ROBOT, q)
    points = flange[:, None, :3, 3] + np.einsum("nij,kj->nki", flange[:, :3, :3], MARKERS)
    return Truth(q, (points - HEAD) @ STATION, STATION.T @ flange[:, :3, :3])


def rows(found: Truth, *, markers: int = 2) -> list[list[str]]:
    """Cells of each reading: pose, marker, six angles in degrees, x, y, z in millimetres."""
    return [
        [
            str(i + 1),
            f"M{k + 1}",
            *(f"{v:.10f}" for v in np.degrees(found.q[i])),
            *(f"{v:.6f}" for v in 1e3 * found.points[i, k]),
        ]
        for i in range(len(found.q))
        for k in range(markers)
    ]


HEADER = ["experiment", "marker", *(f"{j} [deg]" for j in JOINTS), *(f"{a} [mm]" for a in "xyz")]


def table(header: list[str], cells: list[list[str]], delimiter: str = ",") -> str:
    """A file with a header."""
    return "".join(delimiter.join(row) + "\n" for row in [header, *cells])
