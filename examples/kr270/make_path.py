"""Makes path.csv: 200 points of a milling path on a curved part, round the study's test pose.

python examples/kr270/make_path.py > examples/kr270/path.csv

Another number of points as an argument: … make_path.py 100000 > many.csv
"""

from __future__ import annotations

import csv
import sys

import numpy as np

import elastocal as ec
from elastocal.robot.rotations import from_rotation_vectors, zyx_angles

TEST_POSE = np.radians([[0.0, -56.9, 89.3, 45.1, 76.0, 57.2]])
COUNT = 200
AGAINST_FEED, ACROSS = 280.0, 180.0  # process force [N]


def main() -> None:
    robot = ec.load_robot("kuka-kr270")
    pose = ec.forward_kinematics(robot, TEST_POSE)[0]
    rotation, tcp = pose[:3, :3], pose[:3] @ [*robot.tools["milling"].tcp, 1.0]

    # A lying eight, 240 mm by 120 mm, on a part that bulges by 25 mm.
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    t = np.linspace(0.0, 2.0 * np.pi, count)
    x, y = 0.12 * np.sin(t), 0.06 * np.sin(2.0 * t)
    z = -0.025 * ((x / 0.12) ** 2 + (y / 0.06) ** 2)
    points = tcp + np.stack([x, y, z], axis=1)
    # The tool leans with the part, by up to 6 degrees.
    lean = np.stack([-np.radians(4.0) * y / 0.06, np.radians(6.0) * x / 0.12, 0.0 * t], axis=1)
    turned = from_rotation_vectors(lean) @ rotation
    feed = np.gradient(points, t, axis=0)
    feed /= np.linalg.norm(feed, axis=1, keepdims=True)
    across = np.cross([0.0, 0.0, 1.0], feed)
    force = -AGAINST_FEED * feed - ACROSS * across / np.linalg.norm(across, axis=1, keepdims=True)

    writer = csv.writer(sys.stdout, lineterminator="\n")
    pose_columns = ["x [mm]", "y [mm]", "z [mm]", "A [deg]", "B [deg]", "C [deg]"]
    writer.writerow(["point", *pose_columns, "Fx [N]", "Fy [N]", "Fz [N]"])
    angles = np.degrees(zyx_angles(turned))
    for i in range(count):
        place = [f"{v:.4f}" for v in 1e3 * points[i]]
        leaning = [f"{v:.5f}" for v in angles[i]]
        writer.writerow([i + 1, *place, *leaning, *(f"{v:.2f}" for v in force[i])])


if __name__ == "__main__":
    main()
