"""A virtual robot that bends where real ones do, and what the promise of a plan is worth on it.

Foot, bearings, links and tool give way besides the joints, joints rub, loads are not quite what is
recorded: all drawn by chance from what the study says, which the campaign does not know.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import elastocal as ec

FOLDER = Path(__file__).parent / "kr270"


def main() -> None:
    """Measure two robots, fit each with nuisance and without, and compare with what is promised."""
    study = ec.read_study(FOLDER / "study_aslant.yaml")
    joints = ec.read_model(FOLDER / "truth.json", study.robot)
    plan = ec.read_proposal(FOLDER / "plan_aslant.csv", study)
    promise = ec.assess(study, plan.load_cases, plan.repeats).promise
    assert promise is not None
    print(f"promised {1e6 * promise.rho0:.0f} µm, with 95 % below {1e6 * promise.limit:.0f} µm;")
    print(f"without nuisance the same plan would claim {1e6 * promise.without:.1f} µm")
    path = study.test_poses[1]
    for seed in (1, 2):
        rng = np.random.default_rng(seed)
        robot = ec.true_robot(study, joints, rng)
        reality = ec.Reality(loads=robot.loads, errors=robot.errors)
        read = ec.simulate(study, robot.model, plan.load_cases, plan.repeats, rng, reality=reality)
        found = ec.identify(study.arm, read, nuisance=study.nuisance)
        assert found.alone is not None
        with_it, without = (
            1e6 * ec.error_left(study, path, model, robot)
            for model in (found.model, found.alone.model)
        )
        print(
            f"robot {seed}: {with_it:.0f} µm left along the path; by the joints alone {without:.0f}"
        )


if __name__ == "__main__":
    main()
