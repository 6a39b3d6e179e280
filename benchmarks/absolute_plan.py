"""A plan for absolute readings: how fast it is certified, and whether what it expects is seen.

    python benchmarks/absolute_plan.py [--campaigns 40]

A KR 270 with one reflector, a weight of 250 kg or none: base, reflector, 25 geometric errors and
five compliances, of which 32 are told apart; 40 poses for four test poses. Printed: time of the
bound and of the plan, ρ0, the bound; then campaigns on virtual robots with errors of half a
millimetre and milliradian, fitted with all unknowns: errors of predictions at the test poses beside
ρ0, and standard errors of compliances beside how far the estimates scatter.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from elastocal.arrays import Array
from elastocal.calibration.arm_model import State
from elastocal.calibration.calibrate import calibrate
from elastocal.calibration.prediction import predicted
from elastocal.elastic.load_cases import LoadCases
from elastocal.files.study.absolute_file import read_absolute_study
from elastocal.files.study.study_file import read_study
from elastocal.measuring.positions import Positions
from elastocal.planning.certificate import lower_bound
from elastocal.planning.plan import Plan, plan
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.study.absolute import AbsoluteStudy, arm_model, unknowns_of

_STUDY = """\
elastocal: 1
name: KR 270, absolute readings
robot: kuka-kr270
identify: [base, tool, geometry, A2, A3, A4, A5, A6]
tools:
  ball: {tcp_mm: [611.5, 0, -460], markers_mm: {M1: [611.5, 0, -460]}}
payloads:
  weight: {mass_kg: 250, center_mm: [611.5, 0, -460]}
experiments: {tool: ball, payload: [none, weight], count: 40}
instrument: {sigma_mm: 0.05}
test_poses:
  - {name: task 1, q_deg: [0, -57, 89, 45, 76, 57], force_N: [0, 0, -500]}
  - {name: task 2, q_deg: [40, -30, 60, -45, 60, 20], force_N: [0, 0, -500]}
  - {name: task 3, q_deg: [-40, -90, 110, 10, 40, 57], force_N: [0, 0, -500]}
  - {name: task 4, q_deg: [-80, -60, 70, 100, 50, -57], force_N: [0, 0, -500]}
"""


def readings(study: AbsoluteStudy, q: Array, wrench: Array, payload: Array) -> Positions:
    """Empty readings of one reflector."""
    count = len(q)
    return Positions(
        study.tool,
        LoadCases(q, wrench),
        tuple(map(str, range(count))),
        np.arange(count),
        np.zeros(count, dtype=np.int64),
        np.zeros((count, 3)),
        np.tile(study.instrument.sigma**2 * np.eye(3), (count, 1, 1)),
        np.zeros(count, dtype=np.int64),
        payload=payload,
        payloads=tuple(p.name for p in study.payloads),
    )


def truth(study: AbsoluteStudy, rng: np.random.Generator) -> State:
    """A robot as robots are."""
    model = arm_model(study)
    base = np.eye(4)[None].copy()
    base[0, :3, :3] = from_rotation_vectors(rng.normal(size=(1, 3)))[0]
    base[0, :3, 3] = rng.normal(size=3)
    markers = np.asarray(study.tool.markers)[None] + 1e-3 * rng.normal(size=(1, 1, 3))
    geometry = 5e-4 * rng.normal(size=len(model.errors))
    soft = 1e-6 * rng.uniform(0.3, 3.0, len(model.compliances))
    hung = np.array([[p.mass, *(p.mass * p.center)] for p in study.payloads])
    return State(base, markers, np.eye(3)[None], geometry, soft, hung)


def campaigns(study: AbsoluteStudy, made: Plan, count: int) -> None:
    """What is left at the test poses, and how compliances scatter."""
    model, rng = arm_model(study), np.random.default_rng(0)
    cases = made.load_cases
    rows = np.repeat(np.arange(len(cases)), made.repeats)
    hung = np.where(cases.wrench[rows].any(axis=1), 0, -1)
    empty = readings(study, cases.q[rows], np.zeros((len(rows), 6)), hung)
    poses = [pose.cases for pose in made.study.test_poses if pose.cases is not None]
    q, wrench = (np.vstack([getattr(c, of) for c in poses]) for of in ("q", "wrench"))
    task = readings(study, q, wrench, np.full(len(q), -1))
    parameters = unknowns_of(study, model, empty)
    left, off, said = [], [], []
    for _ in range(count):
        true = truth(study, rng)
        noise = study.instrument.sigma * rng.normal(size=(len(rows), 3))
        value = noise - predicted(model, empty, parameters, true).error
        found = calibrate(model, replace(empty, value=value), parameters)
        there = [predicted(model, task, parameters, state).error for state in (found.state, true)]
        left.append(((there[0] - there[1]) ** 2).sum(axis=1).mean())
        off.append(found.state.compliance - true.compliance)
        said.append(found.standard_error[parameters.of("compliance")])
    rho0, seen = 1e6 * made.assessment.rho0, 1e6 * np.sqrt(np.mean(left))
    print(f"{count} campaigns: left at the test poses {seen:.2f} µm (RMS), ρ0 {rho0:.2f}")
    names = made.study.springs.names
    for i, name in enumerate(study.springs.names):
        each = (
            float(made.assessment.standard_error[names.index(name)]),
            float(np.mean(np.array(said)[:, i])),
            float(np.sqrt(np.mean(np.array(off)[:, i] ** 2))),
        )
        told = zip(("expected", "said by the fits", "seen"), each, strict=True)
        print(f"  {name}: {', '.join(f'{w} {1e9 * v:.1f}' for w, v in told)} nrad/(N·m)")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=40)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "study.yaml"
        file.write_text(_STUDY, encoding="utf-8")
        study, absolute = read_study(file), read_absolute_study(file)
    start = time.process_time()
    bound = lower_bound(study, np.random.default_rng(0))
    seconds = time.process_time() - start
    print(f"{len(study.springs)} unknowns told apart; bound {1e6 * bound.loss(40):.2f} µm")
    print(f"  in {seconds:.1f} s of CPU")
    start = time.process_time()
    made = plan(study)
    seconds = time.process_time() - start
    lower = 1e6 * (made.certificate.lower_bound or 0.0)
    print(f"plan: ρ0 {1e6 * made.assessment.rho0:.2f} µm, none below {lower:.2f}")
    print(f"  in {seconds:.1f} s of CPU")
    campaigns(absolute, made, options.campaigns)


if __name__ == "__main__":
    main()
