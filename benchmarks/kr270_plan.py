"""Time to a good plan: elastocal, CasADi + IPOPT and SciPy SLSQP on one problem in one run.

    python benchmarks/kr270_plan.py

Part 1 measures `python -m elastocal plan` as a whole process, certificate and file included, and
recomputes rho0 from the file it wrote. Part 2 measures when each method first holds a feasible
plan within 1 %, 0.1 % and 0.01 % of the best known rho0. Writes benchmarks/results/kr270.md.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from baselines import METHODS, multistart, verify
from kr270 import MICRO, RESULTS, STUDY_FILE, machine, one_thread, study, target

import elastocal.design.exact as exact
import elastocal.planning.plan as planning
from elastocal.files.plans.proposal_file import read_proposal
from elastocal.planning.assessment import assess
from elastocal.study.study import Study

TOLERANCES = (1e-2, 1e-3, 1e-4)
WHOLE = "elastocal plan(), bound first"
SEARCH = "elastocal, search alone"
RIVAL = "CasADi + IPOPT, random starts"  # what the ratios are taken against


class Run(NamedTuple):
    """One run of one method."""

    trace: list[tuple[float, float]]  # (seconds, best rho0 so far [1e-3 mm])
    seconds: float  # until it stopped, by itself, at the goal or at the cap
    construction: float = 0.0  # seconds before its clock began

    def reached(self, rho0: float) -> float:
        """Seconds until rho0 was at most this; inf if never."""
        return next((seconds for seconds, value in self.trace if value <= rho0), np.inf)


# --- Part 1: the whole process ------------------------------------------------------------------


def whole_process(count: int, seed: int, folder: Path) -> tuple[float, float]:
    """Seconds of `elastocal plan` from start to exit, and rho0 recomputed from its file."""
    out = folder / "plan.json"
    command = [sys.executable, "-m", "elastocal", "plan", str(STUDY_FILE)]
    command += ["--count", str(count), "--seed", str(seed), "--out", str(out)]
    begun = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    seconds = time.perf_counter() - begun
    campaign = study(count)
    proposal = read_proposal(out, campaign)
    judged = assess(campaign, proposal.load_cases, proposal.repeats)
    assert int(proposal.repeats.sum()) == count
    assert not judged.violations, judged.violations
    return seconds, MICRO * judged.rho0


def process_table(counts: Iterable[int], seeds: int) -> list[str]:
    """Part 1 as markdown."""
    lines = [
        "| m | seconds: median (min – max) | rho0: median (worst) | against | within 0.01 % |",
        "|--:|--:|--:|--:|--:|",
    ]
    with tempfile.TemporaryDirectory() as name:
        for count in counts:
            runs = [whole_process(count, seed, Path(name)) for seed in range(seeds)]
            seconds, rho0 = zip(*runs, strict=True)
            goal = target(count)
            hits = sum(value <= goal * 1.0001 for value in rho0)
            lines.append(
                f"| {count} | {_spread(seconds)} | {statistics.median(rho0):.5f} "
                f"({100 * (max(rho0) / goal - 1):+.3f} %) | {goal:.5f} | {hits} of {seeds} |"
            )
            _say(lines[-1])
    return lines


# --- Part 2: time to a tolerance ----------------------------------------------------------------


@contextmanager
def _watched_refine(trace: list[tuple[float, float]]) -> Iterator[None]:
    """Note the best value after every batch that elastocal's search refines.

    The search has no hook that tells values as they are found, so its `refine` is wrapped for the
    time of the measurement. Plans that break a constraint have the value 0 and never count.
    """
    refine = exact.refine

    def watched(*args: Any, **kwargs: Any) -> exact.Plans:
        plans = refine(*args, **kwargs)
        value = float(plans.value.max(initial=0.0))
        if value > 0.0:
            trace.append((time.perf_counter(), MICRO / value**0.5))
        return plans

    exact.refine = watched
    try:
        yield
    finally:
        exact.refine = refine


@contextmanager
def _noted_start(begun: list[float]) -> Iterator[None]:
    """Note when `plan` is done with the bound and begins to search."""
    search = planning.exact_design

    def noted(*args: Any, **kwargs: Any) -> exact.ExactDesign:
        begun.append(time.perf_counter())
        return search(*args, **kwargs)

    planning.exact_design = noted
    try:
        yield
    finally:
        planning.exact_design = search


def elastocal_runs(campaign: Study, seed: int) -> dict[str, Run]:
    """One call of `plan`, read on two clocks: from its start, and from the start of the search."""
    trace: list[tuple[float, float]] = []
    searching: list[float] = []
    begun = time.perf_counter()
    with _watched_refine(trace), _noted_start(searching):
        planning.plan(campaign, seed=seed)
    ended = time.perf_counter()
    return {
        name: Run([(t - origin, rho0) for t, rho0 in trace], ended - origin)
        for name, origin in ((WHOLE, begun), (SEARCH, searching[0]))
    }


def baseline_run(method: str, campaign: Study, seed: int, cap: float) -> Run:
    """One multistart, its plans checked by elastocal's `assess`."""
    goal = target(campaign.experiments.count) * (1.0 + TOLERANCES[-1])
    found = multistart(method, campaign, seed, cap=cap, goal=goal)
    verify(campaign, found.trace)
    trace = [(step.seconds, step.rho0) for step in found.trace]
    return Run(trace, found.seconds, found.construction)


def race(
    counts: Iterable[int], seeds: int, cap: float, methods: list[str]
) -> dict[int, dict[str, list[Run]]]:
    """All methods on all m, interleaved by seed so that a busy minute hits all alike."""
    results: dict[int, dict[str, list[Run]]] = {}
    for count in counts:
        campaign = study(count)
        runs: dict[str, list[Run]] = {name: [] for name in (WHOLE, SEARCH, *methods)}
        for seed in range(seeds):
            for name, run in elastocal_runs(campaign, seed).items():
                runs[name].append(run)
            for method in methods:
                runs[method].append(baseline_run(method, campaign, seed, cap))
        results[count] = runs
        for line in race_rows(count, runs, cap):
            _say(line)
    return results


def race_rows(count: int, runs: dict[str, list[Run]], cap: float) -> list[str]:
    """One markdown row per method."""
    rows = []
    for name, each in runs.items():
        cells = []
        for tolerance in TOLERANCES:
            goal = target(count) * (1.0 + tolerance)
            cells.append(_times([run.reached(goal) for run in each]))
            cells.append(_ratio(_median_time(runs[RIVAL], goal), _median_time(each, goal), cap))
        ends = [min((value for _, value in run.trace), default=np.inf) for run in each]
        worst = 100.0 * (max(ends) / target(count) - 1.0)
        construction = statistics.median(run.construction for run in each)
        shown = f"{construction:.2f}" if construction else "–"
        rows.append(f"| {count} | {name} | {' | '.join(cells)} | {worst:+.3f} % | {shown} |")
    return rows


def race_table(results: dict[int, dict[str, list[Run]]], cap: float) -> list[str]:
    """Part 2 as markdown."""
    return [
        "| m | method | 1 % [s] | × | 0.1 % [s] | × | 0.01 % [s] | × | worst seed ends at "
        "| construction [s] |",
        "|--:|:--|--:|--:|--:|--:|--:|--:|--:|--:|",
        *(row for count, runs in results.items() for row in race_rows(count, runs, cap)),
    ]


def verdict(results: dict[int, dict[str, list[Run]]], cap: float) -> list[str]:
    """Where elastocal's whole plan() is faster than the best baseline, and where it is not."""
    lines = []
    for tolerance in TOLERANCES:
        faster, slower, nobody = [], [], []
        for count, runs in results.items():
            goal = target(count) * (1.0 + tolerance)
            rivals = {
                name: _median_time(each, goal) for name, each in runs.items() if name in METHODS
            }
            rival = min(rivals, key=rivals.__getitem__)
            ours, theirs = _median_time(runs[WHOLE], goal), rivals[rival]
            if np.isinf(ours) and np.isinf(theirs):
                nobody.append(f"m = {count}")
            elif ours < theirs:
                gain = f"> {cap / ours:.1f}" if np.isinf(theirs) else f"{theirs / ours:.1f}"
                faster.append(f"m = {count} ({gain}× against {rival})")
            else:
                loss = "never there" if np.isinf(ours) else f"{ours / theirs:.1f}× slower"
                slower.append(f"m = {count} ({loss} than {rival})")
        lines.append(
            f"* To {100 * tolerance:g} %: faster than every baseline at "
            f"{', '.join(faster) or 'no m'}; slower at {', '.join(slower) or 'no m'}"
            + (f"; no median run got there at {', '.join(nobody)}." if nobody else ".")
        )
    return lines


def _median_time(runs: list[Run], rho0: float) -> float:
    """Median seconds to rho0, counting a run that never got there as infinite."""
    times = sorted(run.reached(rho0) for run in runs)
    return times[(len(times) - 1) // 2]


def _times(times: list[float]) -> str:
    """Median (min – max), and how many got there at all."""
    got = [t for t in times if np.isfinite(t)]
    if not got:
        return "not within"
    ordered = sorted(times)
    middle = ordered[(len(ordered) - 1) // 2]
    shown = f"{middle:.2f}" if np.isfinite(middle) else "not within"
    if len(times) > 1:
        last = f"{ordered[-1]:.2f}" if np.isfinite(ordered[-1]) else "…"
        shown += f" ({ordered[0]:.2f} – {last})"
    return shown if len(got) == len(times) else f"{shown}, {len(got)} of {len(times)}"


def _ratio(rival: float, own: float, cap: float) -> str:
    if np.isinf(own):
        return "–"
    return f"> {cap / own:.2g}" if np.isinf(rival) else f"{rival / own:.2g}"


def _spread(values: Iterable[float]) -> str:
    ordered = sorted(values)
    return f"{statistics.median(ordered):.2f} ({ordered[0]:.2f} – {ordered[-1]:.2f})"


def _say(line: str) -> None:
    print(line, flush=True)


def main() -> None:
    """Run, print, write results/kr270.md."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one seed, m = 3, 6 and 12")
    parser.add_argument("--seeds", type=int, default=5, help="seeds of part 2")
    parser.add_argument("--process-seeds", type=int, default=10, help="seeds of part 1")
    parser.add_argument("--cap", type=float, default=20.0, help="seconds per baseline run")
    parser.add_argument("--out", type=Path, default=RESULTS / "kr270.md")
    arguments = parser.parse_args()
    one_thread()
    counts, process_counts = [2, 3, 4, 6, 12], [2, 3, 4, 6, 12, 1000]
    seeds, process_seeds = arguments.seeds, arguments.process_seeds
    if arguments.quick:
        counts, process_counts, seeds, process_seeds = [3, 6, 12], [3, 12, 1000], 1, 1
    about = machine("scipy", "casadi")
    _say(about)
    processes = process_table(process_counts, process_seeds)
    results = race(counts, seeds, arguments.cap, list(METHODS))
    text = _TEXT.format(
        about=about,
        cap=arguments.cap,
        seeds=seeds,
        process_seeds=process_seeds,
        processes="\n".join(processes),
        race="\n".join(race_table(results, arguments.cap)),
        verdict="\n".join(verdict(results, arguments.cap)),
        rival=RIVAL,
    )
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    arguments.out.write_text(text, encoding="utf-8")
    _say(f"wrote {arguments.out}")


_TEXT = """\
# KR 270: time to a plan

Made by `benchmarks/kr270_plan.py`. {about}. One thread throughout; rho0 in 1e-3 mm.

## The whole process: `python -m elastocal plan`

Start of Python, reading the study, bound confirmed from fresh starts, plan, files written.
{process_seeds} seed(s). rho0 is recomputed from the written file; "against" is the best known
rho0, and for m = 1000 the lower bound of any plan.

{processes}

## Time to within a tolerance of the best known rho0

{seeds} seed(s), medians (min – max); a run that does not get there counts as infinite. Baselines
stop after {cap:g} s, elastocal when it thinks it is done. × is the time of "{rival}" over that of
the row: above 1 the row is faster. "elastocal plan(), bound first" is one call of `plan`, which
first spends its time on the lower bound that the baselines do not give; "search alone" is the same
run with the clock started after the bound (from m = 6 its starts come from the bound's design, so
that this clock flatters it). elastocal's times are those at which a batch of plans is finished.
Construction of the CasADi problem is not in its times. The plans of all baselines were recomputed
and found feasible by elastocal's `assess`.

{race}

{verdict}
"""


if __name__ == "__main__":
    main()
