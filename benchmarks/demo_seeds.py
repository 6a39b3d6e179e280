"""Does the demonstration keep what it promises, whatever the robot?

    python benchmarks/demo_seeds.py --seeds 100

The plan of the demonstration on virtual robots, each with springs, loads, friction and noise of its
own, drawn by chance: its nonlinear equilibrium is measured, identified, and the milling path is
compensated. What is left in truth is held against the 95 % limits that were stated: by the plan,
and with the fit. The same readings are fitted once more with nuisance switched off, which is the
negative control. Writes benchmarks/results/demo_seeds.md.
"""

from __future__ import annotations

import argparse
import multiprocessing
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from kr270 import RESULTS, machine, one_thread, write_results

import elastocal as ec
from elastocal.arrays import IntArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.cartesian import limit_left
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.planning.promise import promise
from elastocal.simulation.true_robot import true_robot
from elastocal.simulation.virtual_campaign import Reality
from elastocal.simulation.with_nuisance import error_left
from elastocal.squares import largest_likely, weights_of

EXAMPLE = Path(__file__).parent.parent / "examples" / "kr270"


class Robot(NamedTuple):
    """What one robot came to [m]: left in truth and stated limit, with nuisance and without."""

    left: float
    limit: float
    left_alone: float
    limit_alone: float


@cache
def demonstration() -> tuple[ec.Study, ec.LoadCases, IntArray, ComplianceModel]:
    """Study, plan and true joints of the demonstration."""
    study = ec.read_study(EXAMPLE / "study_aslant.yaml")
    plan = ec.read_proposal(EXAMPLE / "plan_aslant.csv", study)
    return study, plan.load_cases, plan.repeats, ec.read_model(EXAMPLE / "truth.json", study.robot)


def campaign(seed: int) -> Robot:
    """Draw, measure, identify and judge a robot."""
    study, cases, repeats, joints = demonstration()
    rng = np.random.default_rng([seed, 7])
    true = true_robot(study, joints, rng)
    reality = Reality(loads=true.loads, errors=true.errors)
    data = ec.simulate(study, true.model, cases, repeats, rng, reality=reality)
    found = ec.identify(study.arm, data, nuisance=study.nuisance)
    assert found.alone is not None
    path = study.test_poses[1]
    assert path.cases is not None
    assert path.tool is not None
    told = []
    for model in (found.model, found.alone.model):
        arm = ElasticArm(study.robot, model.springs, path.tool, study.gravity)
        told += [error_left(study, path, model, true), limit_left(arm, model, path.cases)]
    return Robot(*told)


def stated() -> tuple[float, float, float, float]:
    """What the plan promises and its limit, with nuisance and without [m]."""
    study, cases, repeats, _ = demonstration()
    told = promise(study, cases, repeats)
    assert told is not None
    bare = ec.with_nuisance(study, None)
    worth, path = ec.assess(bare, cases, repeats), bare.test_poses[1]
    form = np.einsum("nri,nrj->ij", path.regressors, path.regressors) / len(path.regressors)
    limit = largest_likely(weights_of(form, worth.covariance)[0])
    return told.rho0, told.limit, worth.rho0, limit


def table(robots: list[Robot]) -> str:
    """Both ways to fit, side by side."""
    rho0, limit, rho0_alone, limit_alone = stated()
    rows = [
        "| fit | promised µm | with 95 % below µm | left in truth, RMS µm | largest µm | inside "
        "the limit of the plan % | inside the limit stated with the fit % |",
        "|:--|--:|--:|--:|--:|--:|--:|",
    ]
    for name, said, most, left, own in (
        ("with nuisance", rho0, limit, [r.left for r in robots], [r.limit for r in robots]),
        (
            "nuisance switched off",
            rho0_alone,
            limit_alone,
            [r.left_alone for r in robots],
            [r.limit_alone for r in robots],
        ),
    ):
        size = np.array(left)
        rms = np.sqrt(np.mean(size**2))
        rows.append(
            f"| {name} | {1e6 * said:.1f} | {1e6 * most:.1f} | {1e6 * rms:.1f} | "
            f"{1e6 * size.max():.1f} | {100 * np.mean(size <= most):.0f} | "
            f"{100 * np.mean(size <= np.array(own)):.0f} |"
        )
    return "\n".join(rows)


def main() -> None:
    """Write the page."""
    one_thread()
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--seeds", type=int, default=100)
    words.add_argument("--workers", type=int, default=2)
    words.add_argument("--out", type=Path, default=RESULTS / "demo_seeds.md")
    given = words.parse_args()
    begun = machine()
    with multiprocessing.Pool(given.workers) as pool:
        robots = pool.map(campaign, range(given.seeds), chunksize=1)
    write_results(
        given.out,
        "# The demonstration, on one robot after the other",
        f"Made by `benchmarks/demo_seeds.py`. {begun}. {given.seeds} virtual robots.",
        table(robots),
        "Along the milling path, without the friction and the discrepancy of the task itself, "
        "which no calibration takes away.",
    )


if __name__ == "__main__":
    main()
