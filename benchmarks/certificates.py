"""How often is a lower bound false? Many seeded runs of the continuous design.

    python benchmarks/certificates.py 100

A bound is false if it lies above the true one by more than 1e-5: some plan would beat it. It is
slack if it lies below by more than 1e-5: sound, but less than was promised. The true bounds are
the values to which all long runs of independent programs agree. Writes
benchmarks/results/certificates.md.
"""

from __future__ import annotations

import argparse
import multiprocessing
import statistics
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from kr270 import BOUND, MICRO, RESULTS, machine, one_thread, study, write_results

from elastocal.design.continuous import continuous_design
from elastocal.study.criteria import mean_test_pose

LIMIT = 1e-5
"""Relative deviation in rho0 from which a bound counts as false or slack."""


class Run(NamedTuple):
    """One bound."""

    matrix: str
    seed: int
    excess: float  # bound over the true one, minus 1
    converged: bool
    starts: int  # fresh random ones
    attained: int  # of them that reached the maximum
    seconds: float


def run(task: tuple[str, int]) -> Run:
    """One continuous design from one seed."""
    matrix, seed = task
    campaign = study(12, matrix=matrix)
    begun = time.perf_counter()
    design = continuous_design(
        campaign.space, mean_test_pose(campaign), np.random.default_rng(seed)
    )
    seconds = time.perf_counter() - begun
    excess = MICRO / design.certificate.upper**0.5 / BOUND[matrix] - 1.0
    dual = design.certificate
    return Run(matrix, seed, excess, design.gap < 1e-4, dual.starts, dual.attained, seconds)


def table(runs: list[Run]) -> list[str]:
    """Counts, worst cases and times as markdown."""
    lines = [
        "| test pose | runs | false | slack | not converged | highest | lowest "
        "| fewest fresh starts at the maximum | seconds: median (min – max) |",
        "|:--|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for matrix in BOUND:
        some = [r for r in runs if r.matrix == matrix]
        excess, seconds = [r.excess for r in some], [r.seconds for r in some]
        rare = min(some, key=lambda r: r.attained / r.starts)
        lines.append(
            f"| {matrix} | {len(some)} | {sum(e > LIMIT for e in excess)} "
            f"| {sum(e < -LIMIT for e in excess)} | {sum(not r.converged for r in some)} "
            f"| {max(excess):+.1e} | {min(excess):+.1e} | {rare.attained} of {rare.starts} "
            f"| {statistics.median(seconds):.2f} ({min(seconds):.2f} – {max(seconds):.2f}) |"
        )
    return lines


def main() -> None:
    """Run, print, write results/certificates.md."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", type=int, nargs="?", default=100, help="seeds per test pose")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path, default=RESULTS / "certificates.md")
    arguments = parser.parse_args()
    one_thread()
    about = machine()
    print(about, flush=True)
    seeds = range(arguments.first, arguments.first + arguments.runs)
    tasks = [(matrix, seed) for seed in seeds for matrix in BOUND]
    runs = []
    with multiprocessing.get_context("spawn").Pool(arguments.processes) as pool:
        for done in pool.imap_unordered(run, tasks):
            runs.append(done)
            if abs(done.excess) > LIMIT or not done.converged:
                print(f"{done.matrix} seed {done.seed}: {done.excess:+.2e}", flush=True)
    lines = table(runs)
    beside = "One process of one thread"
    if arguments.processes > 1:
        beside = f"{arguments.processes} processes of one thread each, which slow each other down"
    print("\n".join(lines))
    parts = [
        "# False bounds",
        f"Made by `benchmarks/certificates.py`. {about}. {beside}. Seeds {seeds[0]} to "
        f"{seeds[-1]}. Deviations are relative, in rho0; false and slack begin at {LIMIT:g}.",
        "\n".join(lines),
    ]
    write_results(arguments.out, *parts)


if __name__ == "__main__":
    main()
