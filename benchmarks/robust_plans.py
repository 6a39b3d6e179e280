"""What it costs that plans of a KR 270 withstand a loss, and see what their model lacks.

    python benchmarks/robust_plans.py

The cells of promises.py without nuisance, twelve readings. Each row is the plan for what it asks;
blind errors are those that `plan` lists, the largest of what is visible. Beside them the largest of
springs about every axis across the joints, by steps of a quarter of a degree, but within 15° of an
axis that no reading shows. Writes benchmarks/results/robust_plans.md.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from kr270 import RESULTS, machine, one_thread, write_results
from promises import CELLS, study_of

from elastocal.fitting.power import seen_half
from elastocal.planning.blind import UNSEEN
from elastocal.planning.blind_columns import columns_of
from elastocal.planning.plan import Plan, plan
from elastocal.study.robustness import Robustness
from elastocal.study.study import Study

HUNG, CONE = CELLS
ASKED: list[tuple[str, int | None, Robustness | None]] = [
    (HUNG, None, None),
    (HUNG, None, Robustness(loss=1.25)),
    (HUNG, 4, Robustness(loss=2.1, within=1.05)),
    (HUNG, 6, Robustness(loss=2.1, within=1.05)),
    (HUNG, None, Robustness(within=1.05)),
    (HUNG, None, Robustness(loss=1.5, blind=16e-6)),
    (CONE, None, None),
    (CONE, None, Robustness(loss=1.25)),
    (CONE, 8, Robustness(loss=1.285, within=1.05)),
    (CONE, None, Robustness(within=1.05)),
    (CONE, None, Robustness(loss=1.25, blind=8e-6)),
]
CLOSE = 15.0  # degrees


def about_every_axis(study: Study, made: Plan) -> float:
    """Largest blind error of springs about all axes across joints, and of long links [m]."""
    told = columns_of(study, made.load_cases, made.repeats)
    assert told is not None
    half, first, worst = seen_half(told.dof), 0, 0.0
    angles = np.arange(0.0, 180.0, 0.25)
    c, s = np.cos(np.radians(angles)), np.sin(np.radians(angles))
    shares = np.column_stack([c * c, s * s, c * s])
    for family in told.families:
        own = slice(first, first + family.columns)
        first += family.columns
        if not family.plane:
            continue
        squares = np.einsum("ai,ij,aj->a", shares, told.seen[own, own], shares)
        sizes = np.sqrt(half / np.maximum(squares, 1e-300))
        hidden = angles[family.largest < UNSEEN * sizes]
        apart = np.abs((angles[:, None] - hidden + 90.0) % 180.0 - 90.0)
        seen = apart.min(axis=1, initial=90.0) > CLOSE
        left = np.linalg.norm(told.left[:, own] @ shares.T, axis=0)
        worst = max(worst, float((left * np.minimum(sizes, family.largest))[seen].max()))
    return worst


def said(wish: Robustness | None) -> str:
    """What is asked for, as a study has it."""
    if wish is None:
        return "–"
    keys = {
        "loss": wish.loss,
        "blind_um": None if wish.blind is None else round(1e6 * wish.blind, 3),
        "within": wish.within,
    }
    return ", ".join(f"{key}: {value:g}" for key, value in keys.items() if value is not None)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=RESULTS / "robust_plans.md")
    args = parser.parse_args()
    one_thread()
    lines = [
        "| load | at most | robust | configurations | ρ0 | bound | after a loss | blind | "
        "about every axis | min at the cell | s of CPU |",
        "|:--|--:|:--|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for cell, most, wish in ASKED:
        study = study_of(cell)
        experiments = replace(study.experiments, robust=wish, max_configurations=most)
        study = replace(study, experiments=experiments)
        begun = time.process_time()
        made = plan(study, seed=args.seed)
        seconds = time.process_time() - begun
        worth, blind = made.assessment, made.blind
        assert worth.loss is not None
        assert blind is not None
        sizes = (
            worth.rho0,
            made.certificate.lower_bound,
            worth.loss.rho0,
            max(effect.error for effect in blind.visible),
            about_every_axis(study, made),
        )
        shown = " | ".join(f"{1e6 * size:.4g}" for size in sizes)
        lines.append(
            f"| {cell} | {most or 12} | {said(wish)} | {len(made.repeats)} | {shown} "
            f"| {made.schedule.total / 60.0:.0f} | {seconds:.0f} |"
        )
        print(lines[-1], flush=True)
    head = (
        "# Robust plans of a KR 270",
        f"`python benchmarks/robust_plans.py`; {machine()}",
        "Twelve readings, σ .03 mm, no nuisance; µm at the test pose. Blind: the largest error\n"
        "left by an effect that the test of fit sees half of the time, as `plan` lists them;\n"
        "about every axis: the same of springs about all axes across joints and in long links,\n"
        "but near those that no reading shows.",
    )
    write_results(args.out, *head, "\n".join(lines))


if __name__ == "__main__":
    main()
