"""Elastocal against what its users would do without it: one run, same problems, one thread each.

    python benchmarks/races.py [--quick] [--only WORD]

Processor seconds until each method first holds a feasible plan within 10, 1, .1 and .01 % of the
best one known, its best plan, and for elastocal the whole time and what the certificate leaves to
gain. What the others are is in `baselines.py`, the problems in `problems.py`. pyoptex is no extra
of this project: `pip install pyoptex` where it is to race. Writes benchmarks/results/races.md.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from baselines import METHODS, multistart, verify
from kr270 import MICRO, RESULTS, machine, one_thread
from problems import Problem, problems

import elastocal.design.breeding as breeding
import elastocal.design.exact as exact
from elastocal.core.library import described
from elastocal.planning.assessment import assess
from elastocal.planning.plan import plan

WITHIN = (0.1, 1e-2, 1e-3, 1e-4)
OURS = "elastocal"
QUICK = 0.1  # share of the caps that a quick run gives


@dataclass(frozen=True)
class Run:
    """One run of one method.

    Attributes:
        trace: (seconds, rho0 [1e-3 mm]) whenever it was better than before; all feasible.
        seconds: Until it stopped, by itself or at the cap.
        construction: Seconds before its clock began.
        starts: Plans that were polished or made; 0 where that means nothing.
        gap: What the certificate leaves to gain in rho0; None if there is none.
        remark: Why there is no result.
    """

    trace: list[tuple[float, float]]
    seconds: float
    construction: float = 0.0
    starts: int = 0
    gap: float | None = None
    remark: str = ""

    @property
    def best(self) -> float:
        """Smallest rho0 [1e-3 mm]; infinite if no plan was found."""
        return min((rho0 for _, rho0 in self.trace), default=np.inf)

    def reached(self, rho0: float) -> float:
        """Seconds until rho0 was at most this; infinite if never."""
        return next((seconds for seconds, value in self.trace if value <= rho0), np.inf)


@contextmanager
def watched(trace: list[tuple[float, float]], problem: Problem) -> Iterator[None]:
    """Note the best plan after every batch that elastocal refines.

    The search tells nothing as often as that, so its `refine` is wrapped for the time of a run.
    What it maximises may have a floor: rho0 is recomputed for the best of a batch, on a clock that
    stands still meanwhile.
    """
    refine = exact.refine
    standing = 0.0

    def noted(*args: Any, **kwargs: Any) -> exact.Plans:
        nonlocal standing
        plans = refine(*args, **kwargs)
        now = time.process_time()
        first = int(plans.value.argmax())
        if plans.value[first] > 0.0:
            cases = problem.study.space.load_cases(plans.x[first])
            rho0 = MICRO * assess(problem.study, cases, plans.counts[first]).rho0
            if not trace or rho0 < trace[-1][1]:
                trace.append((now - standing, rho0))
        standing += time.process_time() - now
        return plans

    exact.refine = breeding.refine = noted
    try:
        yield
    finally:
        exact.refine = breeding.refine = refine


def elastocal(problem: Problem, seed: int) -> Run:
    """One call of `plan`: the bound, then the search, at last the ways and the certificate."""
    trace: list[tuple[float, float]] = []
    begun = time.process_time()
    with watched(trace, problem):
        found = plan(problem.study, seed=seed)
    # The whole time is that of a second call, which is not watched.
    trace = [(seconds - begun, rho0) for seconds, rho0 in trace]
    begun = time.process_time()
    again = plan(problem.study, seed=seed)
    seconds = time.process_time() - begun
    assert again.assessment.rho0 == found.assessment.rho0
    assert not found.assessment.violations
    trace.append((seconds, MICRO * found.assessment.rho0))
    bound = found.certificate.lower_bound
    return Run(trace, seconds, gap=found.assessment.rho0 / bound - 1.0)


def baseline(method: str, problem: Problem, seed: int) -> Run:
    """One multistart; every plan that it claims is checked by elastocal's `assess`."""
    if "pyoptex" in method and find_spec("pyoptex") is None:
        return Run([], 0.0, remark="not installed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            found = multistart(method, problem, seed)
        except Exception as error:  # a solver that gives up is a result
            return Run([], 0.0, remark=f"{type(error).__name__}: {str(error)[:60]}")
    verify(problem, found.trace)
    trace = [(step.seconds, step.rho0) for step in found.trace]
    return Run(trace, found.seconds, found.construction, found.starts)


def race(problem: Problem, seed: int) -> dict[str, Run]:
    """All methods on one problem."""
    runs = {OURS: elastocal(problem, seed)}
    for method in METHODS:
        runs[method] = baseline(method, problem, seed)
    return runs


def table(problem: Problem, runs: dict[str, Run]) -> list[str]:
    """One problem as Markdown."""
    best = min(problem.best_known, *(run.best for run in runs.values()))
    study = problem.study
    lines = [
        f"### {title(problem)}",
        "",
        f"{len(study.springs)} unknowns, best known ρ0 {best:.5f} µm; baselines stop at "
        f"{problem.cap:g} s.",
        "",
        "| method | 10 % | 1 % | .1 % | .01 % | best ρ0 | above best | certified gap | whole "
        "| starts |",
        "|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for name, run in runs.items():
        cells = [shown(run.reached(best * (1.0 + share))) for share in WITHIN]
        if np.isfinite(run.best):
            cells += [f"{run.best:.5f}", f"{100.0 * (run.best / best - 1.0):.3f} %"]
        else:
            cells += [run.remark or "none", "–"]
        cells.append("none" if run.gap is None else f"{100.0 * run.gap:.2g} %")
        built = f"{run.construction:.1f} + " if run.construction >= 0.1 else ""
        cells += [f"{built}{run.seconds:.2f}", str(run.starts or "–")]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return lines


def summary(results: list[tuple[Problem, dict[str, Run]]]) -> list[str]:
    """Where elastocal is ahead of the best of the others, where behind, by how much."""
    lines = [
        "| problem | to 10 % | to 1 % | to .1 % | to .01 % |",
        "|:--|:--|:--|:--|:--|",
    ]
    for problem, runs in results:
        best = min(problem.best_known, *(run.best for run in runs.values()))
        cells = []
        for share in WITHIN:
            goal = best * (1.0 + share)
            others = {name: run.reached(goal) for name, run in runs.items() if name != OURS}
            rival = min(others, key=others.__getitem__)
            ours, theirs = runs[OURS].reached(goal), others[rival]
            if np.isinf(theirs):
                cells.append("nobody" if np.isinf(ours) else f"{shown(ours)} s, no other")
            else:
                ratio = theirs / ours
                word = "never" if np.isinf(ours) else f"× {ratio:.2g}"
                cells.append(f"{word} ({rival})")
        lines.append(f"| {title(problem)} | {' | '.join(cells)} |")
    return lines


def title(problem: Problem) -> str:
    """What tables call a problem."""
    return f"{problem.name}, m = {problem.study.experiments.count}"


def shown(seconds: float) -> str:
    return "–" if np.isinf(seconds) else f"{seconds:.2f}"


def main() -> None:
    """Run, print, write results/races.md."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a tenth of the time")
    parser.add_argument("--only", default="", help="problems with this word in their name")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=RESULTS / "races.md")
    given = parser.parse_args()
    one_thread()
    about = f"{machine('scipy', 'casadi', 'cvxpy', 'clarabel', 'pyoptex')}; {described()}"
    print(about, flush=True)
    field = [p for p in problems(QUICK if given.quick else 1.0) if given.only in title(p)]
    race(replace(field[0], cap=0.5), given.seed)  # what is imported is there from now on
    results, tables = [], []
    for problem in field:
        runs = race(problem, given.seed)
        results.append((problem, runs))
        tables += [*table(problem, runs), ""]
        print("\n".join([*table(problem, runs), *summary([(problem, runs)])]), flush=True)
    text = _TEXT.format(
        about=about,
        date=time.strftime("%Y-%m-%d"),
        seed=given.seed,
        summary="\n".join(summary(results)),
        tables="\n".join(tables),
    )
    given.out.write_text(text, encoding="utf-8")
    print(f"wrote {given.out}")


_TEXT = """\
# Races

Made by `benchmarks/races.py` on {date}, seed {seed}. {about}.

Processor seconds on one thread until a method first holds a feasible plan within so much of the
best ρ0 known, which is the best of this run or of the record. ρ0 in µm. "whole": until the method
ended, with construction of the solver before the clock where it took .1 s or more; elastocal's has
the certificate in it. Every plan of every method is feasible by elastocal's own `assess`.

## How many times as fast as the fastest of the others

Below 1 the method in brackets is faster than elastocal. "no other": none got there before its cap.

{summary}

## Problem by problem

{tables}"""


if __name__ == "__main__":
    main()
