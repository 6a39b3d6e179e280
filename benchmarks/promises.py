"""What plans of a KR 270 promise at best, with springs and errors that arms have.

    python benchmarks/promises.py

Twelve readings, hung weight or a force within 45° of it with three reflectors and A1 identified
too; without nuisance, with springs across every joint of 30 nrad/(N·m) that are symmetric tensors,
with the springs of the preset, and with all of it. Each number is that of the plan made for it,
beside the bound that no plan passes, what is left if a configuration is lost, and the largest
error that the test of fit sees half of the time. Writes benchmarks/results/promises.md.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from kr270 import RESULTS, machine, one_thread, write_results

from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.springs import VirtualJoints, joint_springs
from elastocal.elastic.unknowns import Unknowns
from elastocal.files.study.study_file import parse_study
from elastocal.planning.plan import Plan, plan
from elastocal.robot.chain import Robot
from elastocal.robot.sources import USUAL
from elastocal.study.study import Study
from elastocal.study.two_steps import with_nuisance

STUDY = """
elastocal: 1
name: KR 270 milling cell
robot: kuka-kr270
identify: [IDENTIFIED]
tools:
  milling: {tcp_mm: [986, 0, 0]}
  calibration: {load_point_mm: [611.5, 0, -460], markers_mm: {MARKERS}}
test_poses:
  - {name: milling, tool: milling, q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2], force_N: [0, 280, -180]}
experiments:
  tool: calibration
  FORCE
  count: 12
instrument: {sigma_mm: 0.03}
constraints:
  workspace: {min_z_mm: 800, min_radius_mm: 600}
  elevation: {axis: z, max_deg: 30}
"""
FIRST = "M1: [611.5, 0, -460]"
CELLS = {
    "hung weight": ("A2, A3, A4, A5, A6", FIRST, "force_N: [0, 0, -2500]"),
    "cone of 45°, three reflectors, A1 too": (
        "A1, A2, A3, A4, A5, A6",
        f"{FIRST}, M2: [611.5, 0, 460], M3: [300, 400, 0]",
        "max_force_N: 2500\n  direction: {axis: [0, 0, -1], half_angle_deg: 45}",
    ),
}
SIZE = 30e-9  # rad/(N·m)


def study_of(cell: str, nuisance: str = "") -> Study:
    """A cell, with what a line says of nuisance."""
    identified, markers, force = CELLS[cell]
    text = STUDY.replace("IDENTIFIED", identified).replace("MARKERS", markers)
    return parse_study(text.replace("FORCE", force) + nuisance, Path("study.yaml"))


def tensors(robot: Robot) -> Nuisance:
    """A symmetric tensor of springs across every joint, each of this size about every axis."""
    joints = joint_springs(robot)
    springs, unknowns, deviation = [], [], []
    for j, name in enumerate(joints.names):
        u, v = np.linalg.svd(joints.axis[j][None])[2][1:]
        springs += [(f"{name}{i}", j, axis) for i, axis in enumerate((u, v, (u + v) / 2**0.5))]
        unknowns += [f"tilt of {name}, {part}" for part in ("one", "other", "coupled")]
        deviation += [SIZE, SIZE, SIZE / np.sqrt(2.0)]
    own = np.array([j for _, j, _ in springs])
    made = VirtualJoints(
        tuple(name for name, _, _ in springs),
        joints.body[own],
        np.array([axis for _, _, axis in springs]),
        joints.origin[own],
        np.zeros(len(own), dtype=bool),
    )
    one = [[1.0, 0.0, -1.0], [0.0, 1.0, -1.0], [0.0, 0.0, 2.0]]  # u vᵀ + v uᵀ by three axes
    u = np.zeros(len(unknowns))
    return Nuisance(
        Unknowns(tuple(unknowns), made, np.kron(np.eye(len(joints)), one)),
        u,
        np.array(deviation),
        np.arange(len(u)) % 3 == 2,
        ("of the benchmark",) * len(u),
        np.array(USUAL["kuka-kr270"]),
        CaseErrors(),
    )


def without_errors(study: Study) -> Study:
    """The springs of the preset alone."""
    assert study.nuisance is not None
    return replace(study, nuisance=replace(study.nuisance, errors=CaseErrors()))


MODELS: dict[str, Callable[[str], Study]] = {
    "no nuisance": study_of,
    "tensors of 30 nrad/(N·m)": lambda cell: with_nuisance(
        study_of(cell), tensors(study_of(cell).robot)
    ),
    "springs of the preset": lambda cell: without_errors(study_of(cell, "nuisance: typical\n")),
    "the preset": lambda cell: study_of(cell, "nuisance: typical\n"),
}


def row(cell: str, model: str, made: Plan, seconds: float) -> str:
    """A line of the table."""
    worth, proof, blind = made.assessment, made.certificate, made.blind
    lost = np.inf if worth.loss is None else worth.loss.rho0
    seen = max((e.error for e in blind.visible), default=0.0) if blind else np.nan
    unseen = max((e.error for e in blind.invisible), default=0.0) if blind else np.nan
    numbers = (worth.promised, proof.lower_bound, lost, seen, unseen)
    shown = " | ".join("–" if not x else f"{1e6 * x:.4g}" for x in numbers)
    end = f"{proof.efficiency:.3f} | {seconds:.0f} |"
    return f"| {cell} | {model} | {len(made.repeats)} | {shown} | {end}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="cells or models with this in their name")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=RESULTS / "promises.md")
    args = parser.parse_args()
    one_thread()
    head = (
        "# What plans of a KR 270 promise",
        f"`python benchmarks/promises.py`; {machine()}",
        "Twelve readings, σ .03 mm; µm at the test pose. Blind: the largest error left by an\n"
        "effect that the test of fit sees half of the time; invisible: by one that it cannot see,\n"
        "at a size that is hard to believe.",
    )
    lines = [
        "| load | nuisance | configurations | promised | bound | after a loss | blind | invisible "
        "| efficiency | s of CPU |",
        "|:--|:--|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for cell in CELLS:
        for model, study in MODELS.items():
            if args.only and args.only not in f"{cell} {model}":
                continue
            begun = time.process_time()
            made = plan(study(cell), seed=args.seed)
            lines.append(row(cell, model, made, time.process_time() - begun))
            print(lines[-1], flush=True)
    write_results(args.out, *head, "\n".join(lines))


if __name__ == "__main__":
    main()
