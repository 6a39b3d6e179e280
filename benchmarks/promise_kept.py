"""Is what plans promise with nuisance what virtual robots are left with?

    python benchmarks/promise_kept.py --campaigns 300

Plans of different loads, reflectors and repeats; each campaign draws a robot, measures its
nonlinear equilibrium and identifies it with `identify`. The root mean square error left at the
milling pose should be within 10 % of the promise. Fits of the joints alone, on the same robots, are
the negative control. Writes benchmarks/results/promise_kept.md.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from kr270 import RESULTS, machine, one_thread, write_results

import elastocal as ec
from elastocal.arrays import IntArray
from elastocal.elastic.case_errors import CaseErrors
from elastocal.simulation.campaigns import Campaigns

EXAMPLE = Path(__file__).parent.parent / "examples" / "kr270"
Plan = tuple[ec.LoadCases, IntArray]


def aslant(markers: int = 3) -> ec.Study:
    """The study of the demonstration, judged at its pose alone, with so many reflectors."""
    study = ec.read_study(EXAMPLE / "study_aslant.yaml")
    tool = study.experiments.tool
    pose = replace(study.test_poses[0], weight=1.0)
    fewer = replace(tool, markers=tool.markers[:markers], marker_names=tool.marker_names[:markers])
    experiments = replace(study.experiments, tool=fewer)
    return replace(study, test_poses=(pose,), experiments=experiments)


def hung(folder: Path) -> ec.Study:
    """The paper's campaign under a hung weight, with nuisance."""
    text = (EXAMPLE / "study.yaml").read_text("utf-8") + "nuisance: typical\n"
    path = folder / "hung.yaml"
    path.write_text(text, encoding="utf-8")
    return ec.read_study(path)


def springs_alone(study: ec.Study) -> ec.Study:
    """The study without errors of load cases."""
    assert study.nuisance is not None
    return ec.with_nuisance(study, replace(study.nuisance, errors=CaseErrors()))


def at_random(study: ec.Study, count: int, times: int = 1) -> Plan:
    """Random load cases that the study allows, each measured so often."""
    space = study.space
    cases = space.load_cases(space.sample(count, np.random.default_rng(5)))
    return cases, np.full(count, times, dtype=np.int64)


def cases(folder: Path) -> dict[str, tuple[ec.Study, Plan]]:
    """Studies with plans, by what they are."""
    three, one, down = aslant(), aslant(1), hung(folder)
    made = ec.read_proposal(EXAMPLE / "plan_aslant.csv", three)
    demo = (made.load_cases, made.repeats)
    paper = ec.read_proposal(EXAMPLE / "published" / "m3-times-4.csv", down)
    return {
        "aslant, 3 reflectors, the demonstration's plan": (three, demo),
        "the same, springs alone": (springs_alone(three), demo),
        "the same, 1 reflector": (one, demo),
        "aslant, 3 reflectors, 12 random configurations": (three, at_random(three, 12)),
        "aslant, 3 reflectors, 4 random configurations, 3 times": (three, at_random(three, 4, 3)),
        "hung, 3 published configurations, 4 times": (down, (paper.load_cases, paper.repeats)),
        "hung, 12 random configurations": (down, at_random(down, 12)),
    }


def row(name: str, study: ec.Study, plan: Plan, number: int, workers: int) -> str:
    """What a plan promises, and what is left."""
    truth = ec.read_model(EXAMPLE / "truth.json", study.robot)

    def campaigns(how: ec.Fit) -> Campaigns:
        named = {name: plan}
        return ec.campaigns(study, truth, named, number, seed=1, workers=workers, how=how).plans[0]

    found, alone = campaigns(ec.Fit()), campaigns(ec.Fit(fitted="joints"))
    claimed = ec.assess(ec.with_nuisance(study, None), *plan).rho0
    values = (
        f"{1e6 * claimed:.1f}",
        f"{1e6 * alone.rms:.0f}",
        f"{1e6 * found.rho0:.1f}",
        f"{1e6 * found.rms:.1f}",
        f"{found.rms / found.rho0:.2f}",
        f"{100 * found.within:.0f}",
        f"{100 * found.coverage.min():.0f} … {100 * found.coverage.max():.0f}",
        f"{100 * alone.coverage.min():.0f} … {100 * alone.coverage.max():.0f}",
    )
    return f"| {name} | {' | '.join(values)} |"


def main() -> None:
    """Write the page."""
    import tempfile

    one_thread()
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--campaigns", type=int, default=300)
    words.add_argument("--workers", type=int, default=1)
    words.add_argument("--out", type=Path, default=RESULTS / "promise_kept.md")
    given = words.parse_args()
    begun = machine()
    with tempfile.TemporaryDirectory() as folder:
        rows = [
            row(name, study, plan, given.campaigns, given.workers)
            for name, (study, plan) in cases(Path(folder)).items()
        ]
    write_results(
        given.out,
        "# What plans promise, and what virtual robots are left with",
        f"Made by `benchmarks/promise_kept.py`. {begun}. {given.campaigns} robots for each row.",
        "\n".join(
            [
                "| plan, 12 experiments | claimed without nuisance µm | left then µm | promised "
                "with it µm | left µm | left / promised | inside the 95 % limit % | 95 % intervals "
                "of joints cover % | without nuisance % |",
                "|:--|--:|--:|--:|--:|--:|--:|--:|--:|",
                *rows,
            ]
        ),
    )


if __name__ == "__main__":
    main()
