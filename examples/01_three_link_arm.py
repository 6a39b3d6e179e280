"""Plan the three-link arm of the paper's section 5 and compare with its published plans.

One test pose, a unit force in any direction, noise of unit size. The published plans are for the
same problem; their ρ0² is recomputed in docs/validation.md.
"""

from __future__ import annotations

import numpy as np

import elastocal as ec

PUBLISHED = {1: 1.93514, 2: 0.80415, 3: 0.5112, 4: 0.39048}  # ρ0²/σ², Table 2 of the paper


def main() -> None:
    robot = ec.load_robot("three-link")
    springs = ec.joint_springs(robot)
    tip = robot.tools["tip"]
    task = ec.LoadCases(np.radians([[0.0, 60.0, -45.0]]), [[0.0, 0.29, -0.96, 0.0, 0.0, 0.0]])
    pose = ec.test_pose(ec.ElasticArm(robot, springs, tip), task, 1.0, "task")
    force = ec.FreeDirection(1.0, np.array([0.0, 0.0, 1.0]))
    print("experiments   ρ0² published   ρ0² here   no plan below")
    for count, published in PUBLISHED.items():
        experiments = ec.Experiments(tip, force, count)
        study = ec.Study(robot, springs, (pose,), experiments, ec.Isotropic(1.0))
        plan = ec.plan(study, seed=0)
        found, bound = plan.assessment.rho0**2, plan.certificate.lower_bound**2
        print(f"{count:11d} {published:15.5f} {found:10.5f} {bound:15.5f}")


if __name__ == "__main__":
    main()
