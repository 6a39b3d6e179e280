"""A robot of your own: a six-axis arm on a linear axis, from a modified DH table.

The springs of all seven joints are unknown, that of the rail in m/N. A hung weight cannot deflect
the rail or the first arm joint: the force must have a horizontal part.
"""

from __future__ import annotations

import numpy as np

import elastocal as ec
from elastocal.constraints import HalfSpace

ROWS = (  # name, alpha [deg], a [m], d [m], theta [deg], lower, upper [deg, m for the rail]
    ("rail", -90.0, 0.0, 0.0, 0.0, 0.0, 3.0),
    ("J1", 90.0, 0.0, 0.680, 0.0, -170.0, 170.0),
    ("J2", -90.0, 0.260, 0.0, -90.0, -60.0, 140.0),
    ("J3", 0.0, 0.900, 0.0, 0.0, -160.0, 70.0),
    ("J4", -90.0, 0.100, 0.960, 0.0, -180.0, 180.0),
    ("J5", 90.0, 0.0, 0.0, 0.0, -120.0, 120.0),
    ("J6", -90.0, 0.0, 0.150, 0.0, -350.0, 350.0),
)


def robot() -> ec.Robot:
    rows = []
    for name, alpha, a, d, theta, lower, upper in ROWS:
        slides = name == "rail"
        limits = (lower, upper) if slides else np.radians((lower, upper))
        angles = np.radians(theta), np.radians(alpha)
        rows.append(ec.DHRow(name, angles[0], d, a, angles[1], slides, 1.0, *limits))
    return ec.from_dh("arm on a rail", rows, modified=True)


def main() -> None:
    arm = robot()
    springs = ec.joint_springs(arm)
    bracket = ec.Tool("bracket", [0.15, 0.0, 0.30], [[0.15, 0.0, 0.30]], ("M1",))
    spindle = ec.Tool("spindle", [0.0, 0.0, 0.25], [[0.0, 0.0, 0.25]], ("TCP",))
    q = np.append(1.5, np.radians([30.0, 20.0, -10.0, 40.0, 60.0, 0.0]))
    task = ec.LoadCases([q], [[300.0, 200.0, -150.0, 0.0, 0.0, 0.0]])
    pose = ec.test_pose(ec.ElasticArm(arm, springs, spindle), task, 1.0, "deburring")
    force = ec.FreeDirection(800.0, np.array([0.0, 0.0, -1.0]), np.radians(45.0))
    floor = HalfSpace("height of M1 >= 300 mm", bracket.load_point, [0, 0, 1], 0.3)
    experiments = ec.Experiments(bracket, force, count=10, max_configurations=5)
    tracker = ec.Isotropic(0.03e-3)
    study = ec.Study(arm, springs, (pose,), experiments, tracker, (floor,))
    plan = ec.plan(study, seed=0)
    for case, (q, wrench) in enumerate(zip(plan.load_cases.q, plan.load_cases.wrench, strict=True)):
        joints = f"{1e3 * q[0]:5.0f} mm" + "".join(f"{a:7.1f}°" for a in np.degrees(q[1:]))
        print(f"{plan.repeats[case]}× {joints}   force", np.round(wrench[:3]), "N")
    for name, error in zip(springs.names, plan.assessment.standard_error, strict=True):
        print(f"{name:5s} ± {error:.2e}", "m/N" if name == "rail" else "rad/(N·m)")
    print(f"ρ0 = {1e6 * plan.assessment.rho0:.2f} µm, efficiency {plan.certificate.efficiency:.3f}")


if __name__ == "__main__":
    main()
