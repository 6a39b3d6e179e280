"""What a path adds: to be read and followed, to be planned for, to be judged.

    python benchmarks/paths.py [--points 100000]

The milling path of `examples/kr270` with as many points, as poses; for one pose of it, for the
path, for its worst point and its worst coordinate. Processor time, so that other work on the
machine matters less.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import elastocal as ec

KR270 = Path(__file__).parents[1] / "examples" / "kr270"


def timed(make: Callable[[], object]) -> tuple[object, float]:
    """What a function returns, and its seconds."""
    start = time.process_time()
    made = make()
    return made, time.process_time() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=100_000)
    points = parser.parse_args().points
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copy(KR270 / "study_path.yaml", folder)
        command = [sys.executable, KR270 / "make_path.py", str(points)]
        with (folder / "path.csv").open("w", encoding="utf-8") as file:
            subprocess.run(command, stdout=file, check=True)
        ec.read_study(KR270 / "study.yaml")  # what is imported is there from now on
        pose, reading = timed(lambda: ec.read_study(KR270 / "study.yaml"))
        print(f"{'read the study of the pose':34s} {reading:6.2f} s")
        path, reading = timed(lambda: ec.read_study(folder / "study_path.yaml"))
        print(f"{f'read the study of {points} points':34s} {reading:6.2f} s")
    assert isinstance(pose, ec.Study)
    assert isinstance(path, ec.Study)
    for what, study in (
        ("the pose", pose),
        ("the path", path),
        ("its worst point", replace(path, criterion="worst")),
        ("its worst coordinate", replace(path, criterion="coordinate")),
    ):
        plan, seconds = timed(lambda study=study: ec.plan(study))
        assert isinstance(plan, ec.Plan)
        _, judging = timed(lambda plan=plan: ec.assess(path, plan.load_cases, plan.repeats))
        worth = ec.assess(path, plan.load_cases, plan.repeats)
        print(
            f"{'plan for ' + what:34s} {seconds:6.2f} s, judged along the path in {judging:.2f} s: "
            f"ρ0 {1e6 * worth.rho0:.3f} µm, worst point {1e6 * worth.criteria['worst']:.3f} µm, "
            f"efficiency {plan.certificate.efficiency:.4f}"
        )


if __name__ == "__main__":
    main()
