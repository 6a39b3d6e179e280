"""How processor time grows with experiments, unknowns, joints, candidates and test poses.

    python benchmarks/growth.py [--quick] [--only WORD]

One curve after the other, each the least of some rounds, with the power of its last half: time is
about proportional to size to that power. How `identify` grows with readings says
`fitting.py`. Writes benchmarks/results/growth.md.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from kr270 import RESULTS, machine, one_thread, study
from problems import HERE, bearings

import elastocal as ec
from elastocal.core.library import described
from elastocal.design.approximate import optimal_weights
from elastocal.design.space import information
from elastocal.files.study.study_file import read_study
from elastocal.planning.certificate import lower_bound
from elastocal.robot.chain import Joint, transform
from elastocal.study.criteria import mean_test_pose

Parts = dict[str, Callable[[], object]]
"""What is timed at one size, by name."""


@dataclass(frozen=True)
class Curve:
    """One way to grow.

    Attributes:
        name: What grows.
        law: What should be expected, and why.
        sizes: How far.
        parts: Makes of a size what is timed, on data made beforehand.
        rounds: How often; the least counts.
    """

    name: str
    law: str
    sizes: tuple[int, ...]
    parts: Callable[[int], Parts]
    rounds: int = 2


def _plan(campaign: ec.Study) -> Parts:
    def bound() -> object:
        return lower_bound(campaign, np.random.default_rng(0))

    known = bound()
    return {
        "bound": bound,
        "search": lambda: ec.plan(campaign, bound=known),  # type: ignore[arg-type]
    }


def _unknowns(count: int) -> Parts:
    return _plan(bearings(read_study(HERE / "eighteen.yaml"), (count - 6) // 6))


def _joints(count: int) -> Parts:
    return _plan(snake(count))


def snake(count: int) -> ec.Study:
    """An arm of so many joints, about z and y in turn, .4 m apart; pulled in any direction."""
    up, across = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    joints = [
        Joint(
            f"J{i + 1}",
            transform(None, (0.0, 0.0, 0.4 if i else 0.2)),
            across if i % 2 else up,
            False,
            -2.5,
            2.5,
        )
        for i in range(count)
    ]
    tool = ec.Tool("tip", np.array([0.1, 0.0, 0.1]), np.array([[0.1, 0.0, 0.1]]), ("M1",))
    robot = ec.Robot("snake", tuple(joints), transform(None, (0.05, 0.0, 0.4)), {"tip": tool})
    springs = ec.joint_springs(robot)
    task = ec.LoadCases(np.linspace(0.3, 0.9, count)[None], [[30.0, 50.0, -100.0, 0.0, 0.0, 0.0]])
    pose = ec.test_pose(ec.ElasticArm(robot, springs, tool), task, 1.0, "task")
    force = ec.FreeDirection(100.0, np.array([0.0, 0.0, 1.0]))
    return ec.Study(robot, springs, (pose,), ec.Experiments(tool, force, 12), ec.Isotropic(3e-5))


def _candidates(count: int) -> Parts:
    campaign, rng = study(12), np.random.default_rng(0)
    space, criterion = campaign.space, mean_test_pose(campaign)
    pool = space.sample(count, rng)
    each = information(space.evaluate(pool).blocks)
    return {
        "drawn": lambda: space.sample(count, np.random.default_rng(1)),
        "evaluated": lambda: information(space.evaluate(pool).blocks),
        "best weights": lambda: optimal_weights(criterion, each, np.zeros((5, 5))),
    }


def _test_poses(count: int) -> Parts:
    # Poses of the task scattered about one, as a path is: the plan is for all of them.
    base = read_study(HERE.parent / "examples" / "kr270" / "study.yaml")
    task = base.test_poses[0]
    rng = np.random.default_rng(0)
    q = task.case.q + rng.uniform(-0.3, 0.3, (count, task.case.q.shape[1]))
    cases = ec.LoadCases(q, np.tile(task.case.wrench, (count, 1)))
    arm = ec.ElasticArm(base.robot, base.springs, task.tool)
    path = ec.test_path(arm, cases, 1.0, "path")
    mean, worst = (replace(base, test_poses=(path,), criterion=c) for c in ("test-pose", "worst"))
    plan = ec.plan(mean)
    return {
        "regressors": lambda: ec.test_path(arm, cases, 1.0, "path").regressor,
        "plan, mean": lambda: ec.plan(mean),
        "plan, worst": lambda: ec.plan(worst),
        "assess": lambda: ec.assess(mean, plan.load_cases, plan.repeats),
    }


CURVES = (
    Curve(
        "experiments",
        "No growth beyond a few: a plan has no more than max(6, p + 1) points, the rest are "
        "repeats.",
        (2, 3, 4, 6, 8, 12, 24, 50, 100, 300, 1000),
        lambda count: _plan(study(count)),
    ),
    Curve(
        "unknowns",
        "A configuration costs O(p), its information O(p²), a plan's criterion O(p³). With 6 "
        "joints, 12 experiments and three markers.",
        (6, 12, 18, 24, 30, 36, 42),
        _unknowns,
        1,
    ),
    Curve(
        "joints",
        "With as many unknowns: a configuration costs O(n + p), climbs take more steps.",
        (3, 4, 5, 6, 7, 8, 9),
        _joints,
        1,
    ),
    Curve(
        "candidates",
        "Linear: each is drawn, evaluated and compared once a sweep; weights are on few.",
        (1_000, 10_000, 100_000, 1_000_000),
        _candidates,
    ),
    Curve(
        "test poses",
        "A mean over them is one (p, p) matrix, made once, in linear time; the worst is looked for "
        "among all where a search ends.",
        (1, 10, 100, 1_000, 10_000, 100_000),
        _test_poses,
        1,
    ),
)


def least(parts: Parts, rounds: int) -> dict[str, float]:
    """Smallest processor seconds of each over rounds in which all take turns."""
    best = dict.fromkeys(parts, np.inf)
    for _ in range(rounds):
        for name, call in parts.items():
            begun = time.process_time()
            call()
            best[name] = min(best[name], time.process_time() - begun)
    return best


def power(sizes: list[int], seconds: list[float]) -> float:
    """Power of the size that fits the last half of a curve."""
    half = len(sizes) // 2
    return float(np.polyfit(np.log(sizes[half:]), np.log(seconds[half:]), 1)[0])


def rows(curve: Curve, sizes: tuple[int, ...]) -> Iterator[str]:
    """A curve as Markdown."""
    found = []
    for size in sizes:
        found.append(least(curve.parts(size), curve.rounds))
        print(curve.name, size, {k: round(v, 4) for k, v in found[-1].items()}, flush=True)
    names = list(found[0])
    yield f"## {curve.name.capitalize()}"
    yield ""
    yield f"{curve.law}"
    yield ""
    yield f"| {curve.name} | {' | '.join(f'{name} [s]' for name in names)} |"
    yield "|--:|" + "--:|" * len(names)
    for size, seconds in zip(sizes, found, strict=True):
        cells = " | ".join(f"{seconds[name]:.3g}" for name in names)
        yield f"| {size} | {cells} |"
    if len(sizes) > 3:
        powers = [power(list(sizes), [each[name] for each in found]) for name in names]
        yield f"| power | {' | '.join(f'{value:.2f}' for value in powers)} |"
    yield ""


def main() -> None:
    """Run, print, write results/growth.md."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="every second size, not the largest")
    parser.add_argument("--only", default="", help="curves with this word in their name")
    parser.add_argument("--out", type=Path, default=RESULTS / "growth.md")
    given = parser.parse_args()
    one_thread()
    about = f"{machine()}; {described()}"
    print(about, flush=True)
    ec.plan(study(3))  # what is imported is there from now on
    lines = [
        "# Growth",
        "",
        f"Made by `benchmarks/growth.py` on {time.strftime('%Y-%m-%d')}. {about}.",
        "",
        "Processor seconds on one thread. The last row is the power of the size that fits the last "
        "half of the curve. Readings: `fitting.py`.",
        "",
    ]
    for curve in CURVES:
        if given.only in curve.name:
            lines += rows(curve, curve.sizes[:-1:2] if given.quick else curve.sizes)
            given.out.write_text("\n".join(lines[:-1]) + "\n", encoding="utf-8")
    print(f"wrote {given.out}")


if __name__ == "__main__":
    main()
