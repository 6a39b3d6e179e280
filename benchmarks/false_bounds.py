"""How often is a bound false in thin and divided cells? Seeds against each other.

    python benchmarks/false_bounds.py --seeds 20
    python benchmarks/false_bounds.py --seeds 3 --cells wall seven-axis-box

Every seed gives a bound and a design, both of the same study (`cells/*.yaml`). A bound is *false*
if the best design of all seeds beats it by more than 1e-5 of the criterion; its maximum is *missed*
if a load case that any seed found is more sensitive by more than 1e-5 than what it claims is the
largest. `--long N` adds N distinct fresh starts from the best design. Writes
benchmarks/results/false_bounds.md.
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from kr270 import RESULTS, machine, one_thread, write_results

from elastocal.arrays import Array
from elastocal.design.dual_bound import dual_bound
from elastocal.design.oracle import sensitivity
from elastocal.files.study.study_file import read_study
from elastocal.matrices import square_root
from elastocal.planning.certificate import lower_bound

CELLS = Path(__file__).parent / "cells"
LIMIT = 1e-5
"""Relative deviation in φ from which a bound counts as false."""


class Run(NamedTuple):
    """One bound."""

    cell: str
    seed: int
    upper: float  # no design has a larger φ
    value: float  # φ of the design behind it; 0 if it breaks a constraint
    gradient: Array
    largest: float  # sensitivity it claims to be the largest
    x: Array  # (S, d) support of the design
    starts: int
    attained: int
    narrow: int
    rarest: int
    seconds: float


def run(task: tuple[str, int]) -> Run:
    """One bound from one seed."""
    cell, seed = task
    study = read_study(CELLS / f"{cell}.yaml")
    begun = time.process_time()
    bound = lower_bound(study, np.random.default_rng(seed))
    seconds = time.process_time() - begun
    design = bound.design
    assert design is not None
    dual = design.certificate
    held = (study.space.evaluate(design.x).margins >= -1e-8).all()
    value = float(bound.criterion.value(design.total[None])[0]) if held else 0.0
    return Run(
        cell,
        seed,
        dual.upper,
        value,
        dual.gradient,
        dual.largest,
        np.vstack([design.x, dual.x_largest[None]]),
        dual.starts,
        dual.attained,
        dual.narrow_starts,
        dual.rarest,
        seconds,
    )


def long_search(cell: str, best: Run, starts: int) -> Array:
    """(1, d) the most sensitive load case that very many fresh starts find from the best design."""
    study = read_study(CELLS / f"{cell}.yaml")
    bound = lower_bound(study, np.random.default_rng(best.seed))
    assert bound.design is not None
    target, total = bound.target, bound.design.total
    base = study.prior / study.experiments.count
    rng = np.random.default_rng([best.seed, starts])
    found = dual_bound(study.space, target, total, base, best.x, rng, fresh=starts)  # type: ignore[arg-type]
    return found.x_largest[None]


def judged(cell: str, runs: list[Run], long: int) -> list[str]:
    """A row of the table, and what is wrong."""
    space = read_study(CELLS / f"{cell}.yaml").space
    best = max(runs, key=lambda r: r.value)
    points = np.vstack([r.x for r in runs])
    if long:
        points = np.vstack([points, long_search(cell, best, long)])
    excess = [best.value / r.upper - 1.0 for r in runs]
    missed = [
        float(sensitivity(space, points, square_root(r.gradient)).max()) / r.largest - 1.0
        for r in runs
    ]
    for r, over, beyond in zip(runs, excess, missed, strict=True):
        if over > LIMIT or beyond > LIMIT:
            print(f"{cell} seed {r.seed}: false by {over:+.1e}, maximum missed by {beyond:+.1e}")
    return [
        f"| {cell} | {len(runs)} | {sum(e > LIMIT for e in excess)} "
        f"| {sum(e > LIMIT for e in missed)} | {max(excess):+.1e} | {max(missed):+.1e} "
        f"| {sum(r.value == 0.0 for r in runs)} "
        f"| {min(r.starts for r in runs)} – {max(r.starts for r in runs)} "
        f"| {min(r.narrow for r in runs)} – {max(r.narrow for r in runs)} "
        f"| {min(r.rarest for r in runs)} | {np.median([r.seconds for r in runs]):.1f} |"
    ]


HEAD = [
    "| cell | seeds | false | maximum missed | worst | worst missed | breaks a constraint "
    "| starts | in narrow parts | rarest | CPU s, median |",
    "|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|",
]


def main() -> None:
    """Run, print, write results/false_bounds.md."""
    names = sorted(path.stem for path in CELLS.glob("*.yaml"))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--cells", nargs="*", choices=names, default=names)
    parser.add_argument("--long", type=int, default=0, help="fresh starts from the best design")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path, default=RESULTS / "false_bounds.md")
    arguments = parser.parse_args()
    one_thread()
    about = machine()
    print(about, flush=True)
    seeds = range(arguments.first, arguments.first + arguments.seeds)
    tasks = [(cell, seed) for cell in arguments.cells for seed in seeds]
    runs: dict[str, list[Run]] = {cell: [] for cell in arguments.cells}
    with multiprocessing.get_context("spawn").Pool(arguments.processes) as pool:
        for done in pool.imap_unordered(run, tasks):
            runs[done.cell].append(done)
            print(
                f"{done.cell} seed {done.seed}: bound {done.upper:.9g}, design {done.value:.9g}, "
                f"{done.attained} of {done.starts} starts, {done.seconds:.0f} s",
                flush=True,
            )
    lines = HEAD + [
        row for cell in arguments.cells for row in judged(cell, runs[cell], arguments.long)
    ]
    print("\n".join(lines))
    write_results(
        arguments.out,
        "# False bounds in thin and divided cells",
        f"Made by `benchmarks/false_bounds.py`. {about}. Seeds {seeds[0]} to {seeds[-1]}; false "
        f"and missed begin at {LIMIT:g} of φ.",
        "\n".join(lines),
    )


if __name__ == "__main__":
    main()
