"""How often does the search for what is missing find something in a right model?

    python benchmarks/candidates.py --campaigns 1000

Virtual campaigns of a KR 270 whose springs are those of the model, pulled in every direction, with
four kinds of noise; then campaigns of one with a spring more, of a size at which a test that knows
it finds it nearly always. An alarm is false if anything is called missing in the former, and right
if the first that is called missing is that spring. Writes benchmarks/results/candidates.md.
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from kr270 import RESULTS, machine, one_thread, write_results

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import joint_springs
from elastocal.identification.candidate_columns import Candidate, candidates
from elastocal.identification.candidates import what_is_missing
from elastocal.identification.choices import Sigma
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.result import Identification
from elastocal.measuring.measurements import Measurements
from elastocal.robot.sources import kuka_kr270

SIGMA = 5e-5  # m
TRUTH = np.array([0.45, 0.302, 0.406, 3.002, 3.303, 2.365]) * 1e-6  # rad/(N·m)
COUNTS = (8, 12, 20, 43)
FOREARM = Candidate("turning", "A3", "x")
VISIBLE = 48.0  # squared size of what is missing, over the noise, beside the fit

Noise = Callable[[Array, Array, np.random.Generator], Array]
"""Errors (m, 3) of deflections (m, 3) under forces (m,)."""


def _outliers(deflection: Array, force: Array, rng: np.random.Generator) -> Array:
    far = rng.random(len(force)) < 0.05
    return rng.normal(size=deflection.shape) * SIGMA * np.where(far, 8.0, 1.0)[:, None]


NOISES: dict[str, Noise] = {
    "constant": lambda d, f, rng: SIGMA * rng.normal(size=d.shape),
    "proportional to the force": lambda d, f, rng: (
        SIGMA * rng.normal(size=d.shape) * (f / np.sqrt(np.mean(f**2)))[:, None]
    ),
    "5 % outliers of 8 σ": _outliers,
    "loads off by 3 % each": lambda d, f, rng: (
        SIGMA * rng.normal(size=d.shape) + 0.03 * d * rng.normal(size=(len(f), 1))
    ),
}


class Task(NamedTuple):
    """Campaigns of one kind."""

    count: int
    noise: str
    sigma: Sigma
    missing: bool
    campaigns: int


def campaign(task: Task, seed: int) -> tuple[Identification, Candidate | None]:
    """One campaign, and what is missing in its model."""
    rng = np.random.default_rng([seed, task.count])
    robot = kuka_kr270()
    arm = ElasticArm(robot, joint_springs(robot), robot.tools["calibration"])
    while True:
        q = rng.uniform(robot.lower, robot.upper, (task.count, 6))
        force = rng.normal(size=(task.count, 3))
        force *= rng.uniform(300.0, 2500.0, (task.count, 1)) / np.linalg.norm(
            force, axis=1, keepdims=True
        )
        cases = LoadCases(q, np.hstack([force, np.zeros_like(force)]))
        rows = regressor(arm, cases)
        scaled = rows.reshape(-1, 6) / np.linalg.norm(rows.reshape(-1, 6), axis=0)
        if np.linalg.cond(scaled) < 30.0:  # else nobody would have measured there
            break
    deflection = rows @ TRUTH
    data = Measurements(
        arm.tool,
        cases,
        tuple(map(str, range(task.count))),
        np.arange(task.count),
        np.zeros(task.count, dtype=int),
        deflection,
        np.broadcast_to(SIGMA**2 * np.eye(3), (task.count, 3, 3)),
    )
    how = Fit("linear", task.sigma)
    if task.missing:
        exact = identify(arm, data, how)
        column = dict(candidates(exact))[FOREARM].reshape(-1, 1)
        flat = rows.reshape(-1, 6)
        beside = column - flat @ np.linalg.lstsq(flat, column, rcond=None)[0]
        size = np.sqrt(VISIBLE) * SIGMA / np.linalg.norm(beside)
        deflection = deflection + size * column.reshape(-1, 3)
    error = NOISES[task.noise](deflection, np.linalg.norm(force, axis=1), rng)
    found = identify(arm, replace(data, deflection=deflection + error), how)
    return found, FOREARM if task.missing else None


class Row(NamedTuple):
    """What came of it."""

    task: Task
    alarms: float
    right: float
    notes: float
    seconds: float


def run(task: Task) -> Row:
    """All campaigns of a task."""
    alarms = right = notes = 0
    seconds = 0.0
    for seed in range(task.campaigns):
        found, missing = campaign(task, seed)
        begun = time.process_time()
        result = what_is_missing(found)
        seconds += time.process_time() - begun
        alarms += bool(result.missing)
        right += bool(result.missing) and result.missing[0].candidate == missing
        notes += not result.missing and bool(result.doubts)
    return Row(task, *(n / task.campaigns for n in (alarms, right, notes, seconds)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    one_thread()
    sigmas: tuple[Sigma, ...] = ("estimated", "known")
    wrong = [Task(n, e, s, False, given.campaigns) for n in COUNTS for s in sigmas for e in NOISES]
    lacking = [
        Task(n, "constant", s, True, given.campaigns // 4 + 1) for n in COUNTS for s in sigmas
    ]
    begun = machine()
    with multiprocessing.Pool(given.workers) as pool:
        rows = pool.map(run, wrong + lacking, chunksize=1)
    write_results(
        RESULTS / "candidates.md",
        "# What is missing in a model: false and right alarms",
        f"Made by `benchmarks/candidates.py`. {begun}. {given.campaigns} campaigns each.",
        "\n".join(
            [
                "| experiments | noise | σ | alarms in right models % | notes % | search, CPU ms |",
                "|--:|:--|:--|--:|--:|--:|",
                *(
                    f"| {t.count} | {t.noise} | {t.sigma} | {100 * row.alarms:.1f} | "
                    f"{100 * row.notes:.1f} | {1e3 * row.seconds:.0f} |"
                    for row in rows
                    if not (t := row.task).missing
                ),
            ]
        ),
        f"With a spring about x of A3 more, whose squared size beside the fit is {VISIBLE:g} times "
        "that of the noise:",
        "\n".join(
            [
                "| experiments | σ | alarms % | that name this spring % | notes % |",
                "|--:|:--|--:|--:|--:|",
                *(
                    f"| {t.count} | {t.sigma} | {100 * row.alarms:.1f} | {100 * row.right:.1f} | "
                    f"{100 * row.notes:.1f} |"
                    for row in rows
                    if (t := row.task).missing
                ),
            ]
        ),
    )


if __name__ == "__main__":
    main()
