"""Correct a milling path with identified compliances, and judge it with the true ones.

python examples/08_compensate_a_path.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import elastocal as ec

FOLDER = Path(__file__).parent / "kr270"
CALIBRATION_POSES = [  # the plan of `make demo`
    [0.00, -50.79, 63.06, 147.44, -101.66, 86.21],
    [0.00, -55.46, -72.40, -119.39, -56.59, -179.27],
    [0.00, -1.69, -3.80, 121.75, -39.54, -11.18],
]


def main() -> None:
    study = ec.read_study(FOLDER / "study.yaml")
    truth = ec.read_model(FOLDER / "truth.json", study.robot)
    cases = ec.LoadCases(
        np.radians(CALIBRATION_POSES), np.tile([0.0, 0.0, -2500.0, 0.0, 0.0, 0.0], (3, 1))
    )
    rng = np.random.default_rng(0)
    measured = ec.simulate(study, truth, cases, np.array([7, 3, 2]), rng)
    found = ec.identify(study.arm, measured).model
    # A vertical load cannot move A1; say a second campaign found it, 2 % too large.
    a1 = 1.02 * truth.of(["A1"])
    second = ec.ComplianceModel(
        ec.joint_springs(study.robot, ["A1"]), a1, np.diag((0.02 * a1) ** 2)
    )
    model = ec.merged_models([found, second])

    pose = study.test_poses[0]
    assert pose.tool is not None
    assert pose.case is not None
    task = ec.read_path(FOLDER / "path.csv", study.robot, pose.tool, pose.case.q[0])
    done = ec.compensate(ec.ElasticArm(study.robot, model.springs, pose.tool), model, task.cases)
    true_arm = ec.ElasticArm(study.robot, truth.springs, pose.tool)
    left = ec.residual(true_arm, truth, done)

    def rms(vectors: np.ndarray) -> float:
        return 1e3 * float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))

    print(f"{len(done)} points, {int(done.converged.sum())} corrected")
    print(f"position error without compensation  {rms(done.before):7.4f} mm")
    print(f"with it, as the model sees it        {rms(done.after):7.4f} mm")
    print(f"with it, expected (ρ0 of each point) {rms(done.rho0[:, None]):7.4f} mm")
    print(f"with it, in truth                    {rms(left):7.4f} mm")


if __name__ == "__main__":
    main()
