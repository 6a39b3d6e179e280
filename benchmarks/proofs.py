"""What can be proved, and how fast: branch and bound on the examples and some harder cells.

    python benchmarks/proofs.py --seconds 600 --only KR

One thread unless --threads says otherwise. Processor seconds include tables, reductions and the
prediction, not the numerical bound that is proved. Writes benchmarks/results/proofs.md.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path

import kr270
import numpy as np
from kr270 import MICRO, RESULTS, machine, one_thread, write_results
from problems import EXAMPLES, without_clearances

from elastocal.constraints import HalfSpace
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, Load
from elastocal.files.study.study_file import read_study
from elastocal.planning.certificate import lower_bound
from elastocal.proof.prove import Proof, prove
from elastocal.study.study import Study

DOWN = np.array([0.0, 0.0, -1.0])


def loaded(study: Study, force: Load) -> Study:
    """The study with other forces."""
    return replace(study, experiments=replace(study.experiments, force=force))


def example(name: str) -> Study:
    """A study of the examples, with nothing watched for collisions."""
    return without_clearances(read_study(EXAMPLES / name / "study.yaml"))


def two_poses_above(height: float) -> Study:
    """The KR 270 with its marker above a height [m] as the one constraint, for two test poses."""
    study, other = kr270.study(12), kr270.study(12, matrix="A0+")
    marker = study.experiments.tool.markers[0]
    above = HalfSpace("height", marker, [0.0, 0.0, 1.0], height)
    return replace(study, constraints=(above,), test_poses=study.test_poses + other.test_poses)


def problems() -> dict[str, Study]:
    """All of them, by name."""
    eighteen = read_study(Path(__file__).parent / "eighteen.yaml")
    hung = loaded(eighteen, FixedVector(eighteen.experiments.force.size * DOWN))
    size = kr270.study(12).experiments.force.size
    return {
        "KR 270, A0": kr270.study(12),
        "KR 270, A0+": kr270.study(12, matrix="A0+"),
        "KR 270, half-space, two test poses": two_poses_above(2.4),
        "three links, free force": example("three-link"),
        "UR10e, weight": example("robots/cobot-ur10e"),
        "SCARA": example("robots/scara-700"),
        "gantry": example("robots/gantry-5"),
        "KR 270, free force": loaded(kr270.study(12), FreeDirection(size, DOWN)),
        "KR 270, cone of 45°": loaded(kr270.study(12), FreeDirection(size, DOWN, np.pi / 4.0)),
        "KR 270, 18 unknowns, weight": hung,
        "arm on a rail, slanted force": loaded(
            example("robots/rail-arm"), FixedVector(np.array([900.0, 0.0, -1560.0]))
        ),
        "KR 270, 18 unknowns, cone": eighteen,
        "seven joints, weight": example("robots/arm-7r"),
    }


class Clock:
    """Processor seconds since it was made, and until each gap."""

    def __init__(self) -> None:
        self._begun = time.process_time()
        self.steps: dict[float, float] = {}

    @property
    def now(self) -> float:
        """Seconds."""
        return time.process_time() - self._begun

    def proved(self, gap: float, _: float) -> None:
        """A gap is proved."""
        self.steps[gap] = self.now


def row(name: str, study: Study, proof: Proof, clock: Clock) -> str:
    """One line of the table."""
    until = ", ".join(f"{100.0 * gap:g} %: {s:.1f}" for gap, s in clock.steps.items())
    first = ", ".join(f"{100.0 * gap:g} %: {s:.1f}" for gap, s in proof.predicted)
    held = ", ".join(study.robot.joint_names[h.variable] for h in proof.statement.held) or "–"
    root = np.sqrt(study.experiments.count)
    return (
        f"| {name} | {len(proof.statement.active)} | {held} | {len(proof.statement.halved)} "
        f"| {MICRO * proof.numerical * root:.5g} | {MICRO * proof.loss * root:.5g} "
        f"| {100.0 * proof.gap:.2g} | {proof.boxes / 1e6:.3g} | {clock.now:.1f} | {until} "
        f"| {first} | {proof.ended} |"
    )


def main() -> None:
    """Prove them one after the other."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seconds", type=float, default=600.0)
    options.add_argument("--threads", type=int, default=1)
    options.add_argument("--only", default="")
    options.add_argument("--gap", type=float, default=1e-4)
    options.add_argument("--out", type=Path, default=RESULTS / "proofs.md")
    chosen = options.parse_args()
    one_thread()
    lines = [
        machine("numpy"),
        "",
        "| problem | angles | held | halved | numerical | proved | gap, % | million boxes "
        "| seconds | seconds until a gap | predicted for it alone | ended |",
        "|:--|--:|:--|--:|--:|--:|--:|--:|--:|:--|:--|:--|",
    ]
    for name, study in problems().items():
        if chosen.only not in name:
            continue
        bound = lower_bound(study, np.random.default_rng(0))
        clock = Clock()
        proof = prove(
            study,
            bound,
            seconds=chosen.seconds,
            gap=chosen.gap,
            threads=chosen.threads,
            proved=clock.proved,
        )
        lines.append(row(name, study, proof, clock))
        print(lines[-1], flush=True)
    write_results(chosen.out, lines[0], "\n".join(lines[2:]))


if __name__ == "__main__":
    main()
