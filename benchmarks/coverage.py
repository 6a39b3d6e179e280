"""How often intervals hold the truth: priors beside estimated noise, nuisance, errors of loads.

    python benchmarks/coverage.py [--campaigns 2000] [--part joints|mixed]

Virtual campaigns of the KR 270 with linear readings, every number of them drawn anew: noise, what
was known before, springs that nobody asks for (positive, tensors without a negative eigenvalue,
with the root mean square that the study states), errors of load cases. Printed are the shares of
95 % intervals that hold the truth, the smallest and the largest over the compliances, and of the
displacement at the test pose.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.case_errors import common_columns, own_covariance, shared_covariance
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import merged
from elastocal.errors import ElastocalError
from elastocal.files.study.study_file import parse_study
from elastocal.fitting.goodness import quantiles
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.result import Identification
from elastocal.measuring.measurements import Measurements
from elastocal.simulation.true_robot import sizes
from elastocal.study.study import Study

_HUNG = "force_N: [0, 0, -2500]"
_FREE = "max_force_N: 2500, direction: free"
_STUDY = """\
elastocal: 1
robot: kuka-kr270
identify: [{joints}]
tools:
  milling: {{tcp_mm: [986, 0, 0]}}
  calibration: {{load_point_mm: [611.5, 0, -460], markers_mm: {{M1: [611.5, 0, -460]{more}}}}}
test_poses:
  - name: milling
    tool: milling
    q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2]
    force_N: [0, 280, -180]
experiments: {{tool: calibration, count: 12, {force}}}
instrument: {{sigma_mm: 0.03}}
constraints: {{collision: off, floor: off}}
{nuisance}
"""
_TRUTH = {"A1": 0.623, "A2": 0.302, "A3": 0.406, "A4": 3.002, "A5": 3.303, "A6": 2.365}
_MARKERS = ", M2: [611.5, 0, 460], M3: [300, 400, 0]"


@dataclass(frozen=True)
class Case:
    """One kind of campaign.

    Attributes:
        name: What is printed.
        study: The study.
        which: (m,) configuration of each experiment.
        ratio: Promised noise over the true one.
        prior: Standard error of what is known before over the compliances; 0 for nothing.
        sigma: "known" or "estimated".
    """

    name: str
    study: Study
    which: Array
    ratio: float
    prior: float
    sigma: str


def study_of(joints: str, force: str, nuisance: str = "", markers: str = "") -> Study:
    """A study of the KR 270."""
    from pathlib import Path

    text = _STUDY.format(joints=joints, force=force, nuisance=nuisance, more=markers)
    return parse_study(text, Path("coverage.yaml"))


def of_joints() -> Iterator[Case]:
    """The joints alone under a hung weight, noise estimated."""
    study = study_of("A2, A3, A4, A5, A6", _HUNG)
    for prior in (0.0, 0.1):
        for which in ([0, 1], [0, 0, 1, 1, 2], [0, 0, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2]):
            for ratio in (0.1, 1.0, 10.0):
                known = f"prior {100 * prior:.0f} %" if prior else "no prior"
                name = f"{known}, {len(which)} in {len(set(which))}, promised/true {ratio:g}"
                yield Case(name, study, np.array(which), ratio, prior, "estimated")


def mixed() -> Iterator[Case]:
    """With nuisance, free forces, all six joints."""
    every = "A1, A2, A3, A4, A5, A6"
    springs = "nuisance: {preset: typical, load: {relative: 0, common_relative: 0, tilt_deg: 0}, "
    quiet = springs + "friction: 0, discrepancy: 0}"
    one = study_of(every, _FREE, quiet)
    three = study_of(every, _FREE, quiet, _MARKERS)
    repeated, apart = np.repeat(np.arange(4), 3), np.arange(12)
    for ratio in (0.1, 1.0, 10.0):
        yield Case(
            f"springs, 4 x 3, promised/true {ratio:g}", one, repeated, ratio, 0.0, "estimated"
        )
    positive = study_of(every, _FREE, quiet.replace("{", "{mean: positive, ", 1))
    yield Case("springs, mean: positive, 4 x 3", positive, repeated, 1.0, 0.0, "estimated")
    yield Case("springs, three markers, 4 x 3", three, repeated, 1.0, 0.0, "estimated")
    yield Case("springs, prior 10 %, 4 x 3", one, repeated, 1.0, 0.1, "estimated")
    loads = springs.replace(
        "relative: 0, common_relative: 0", "relative: .01, common_relative: .01"
    )
    for name, text in (
        ("springs, loads 1 % each and common", loads + "friction: 0, discrepancy: 0}"),
        ("springs, discrepancy 8 %", springs + "friction: 0, discrepancy: .08}"),
        ("the whole preset", "nuisance: typical"),
    ):
        yield Case(f"{name}, 12 x 1", study_of(every, _FREE, text), apart, 1.0, 0.0, "known")
    preset = study_of(every, _FREE, "nuisance: typical")
    for ratio in (0.3, 1.0):
        name = f"the whole preset, 4 x 3, σ estimated, promised/true {ratio:g}"
        yield Case(name, preset, repeated, ratio, 0.0, "estimated")
    three = study_of(every, _FREE, "nuisance: typical", _MARKERS)
    name = "the whole preset, three markers, 4 x 3, σ estimated"
    yield Case(name, three, repeated, 1.0, 0.0, "estimated")


def held(case: Case, campaigns: int) -> tuple[Array, float, int]:
    """(p,) shares of intervals that hold the truth, that at the test pose; campaigns refused."""
    study, rng = case.study, np.random.default_rng(7)
    base = study.space.load_cases(study.space.sample(int(case.which.max()) + 1, rng))
    cases = LoadCases(base.q[case.which], base.wrench[case.which])
    truth = np.array([_TRUTH[name] for name in study.springs.names]) * 1e-6
    drawn = _drawer(study, cases, truth, rng)
    inside, at_pose, refused = np.zeros(len(truth)), 0, 0
    for _ in range(campaigns):
        read, moved = drawn()
        noise = 3e-5
        data = _measured(
            study, cases, read + noise * rng.normal(size=read.shape), noise * case.ratio
        )
        prior = None
        if case.prior:
            error = case.prior * truth
            guess = truth + error * rng.normal(size=len(truth))
            prior = ComplianceModel(study.springs, guess, np.diag(error**2))
        try:
            found = identify(
                study.arm, data, Fit("linear", case.sigma), prior=prior, nuisance=study.nuisance
            )
        except ElastocalError:
            refused += 1
            continue
        low, high = found.interval.T
        inside += (low <= truth) & (truth <= high)
        at_pose += _holds(study, found, moved)
    count = max(campaigns - refused, 1)
    return inside / count, at_pose / count, refused


def _drawer(
    study: Study, cases: LoadCases, truth: Array, rng: np.random.Generator
) -> Callable[[], tuple[Array, Array]]:
    """Draws readings without noise, and what the loads of the task move the tool by in truth."""
    nuisance, arm = study.nuisance, study.arm
    (pose,) = study.test_poses
    assert pose.case is not None
    assert pose.tool is not None
    if nuisance is None:
        rows, there = regressor(arm, cases), pose.regressor
        return lambda: (rows @ truth, there @ truth)
    springs = merged(arm.springs, nuisance.unknowns.springs)
    bent = replace(arm, springs=springs)
    rows = regressor(bent, cases)
    task = ElasticArm(study.robot, springs, pose.tool.at_tcp)
    there = regressor(task, pose.case)[0]
    own = [springs.names.index(name) for name in arm.springs.names]
    made = [springs.names.index(name) for name in nuisance.unknowns.springs.names]

    def draw() -> tuple[Array, Array]:
        size = sizes(nuisance, rng)
        compliance = np.zeros(len(springs))
        compliance[own], compliance[made] = truth, nuisance.unknowns.make @ size
        read = rows @ compliance
        read = read + _errors(nuisance, bent, compliance, cases, rng)
        return read, there @ compliance

    return draw


def _errors(
    nuisance: Nuisance,
    arm: ElasticArm,
    compliance: Array,
    cases: LoadCases,
    rng: np.random.Generator,
) -> Array:
    """(N, m) errors of load cases, of experiments and of all loads, drawn."""
    errors = nuisance.errors
    total = np.zeros((len(cases), 3 * len(arm.tool.targets)))
    if errors.any_shared:
        spread = shared_covariance(errors, arm, compliance, cases)
        each = {}
        for i, number in enumerate(cases.distinct.tolist()):
            if number not in each:
                each[number] = _root(spread[i]) @ rng.normal(size=total.shape[1])
            total[i] += each[number]
    if errors.any_own:
        for i, spread_i in enumerate(own_covariance(errors, arm, compliance, cases)):
            total[i] += _root(spread_i) @ rng.normal(size=total.shape[1])
    names, columns = common_columns(errors, arm, compliance, cases)
    return np.asarray(total + columns @ rng.normal(size=len(names)))


def _root(covariance: Array) -> Array:
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def _measured(study: Study, cases: LoadCases, read: Array, sigma: float) -> Measurements:
    tool = study.experiments.tool
    count, markers = len(cases), len(tool.markers)
    values = read.reshape(-1, 3)
    return Measurements(
        tool, cases, tuple(f"E{i}" for i in range(count)), np.repeat(np.arange(count), markers),
        np.tile(np.arange(markers), count), values,
        np.broadcast_to(sigma**2 * np.eye(3), (len(values), 3, 3)),
    )  # fmt: skip


def _holds(study: Study, found: Identification, moved: Array) -> float:
    """Share of the coordinates at the test pose whose interval holds the truth."""
    (pose,) = study.test_poses
    assert pose.case is not None
    assert pose.tool is not None
    model = found.model
    rows = regressor(ElasticArm(study.robot, model.springs, pose.tool.at_tcp), pose.case)[0]
    error = np.sqrt(np.einsum("ip,pq,iq->i", rows, model.covariance, rows))
    half = quantiles(0.975, model.freedom(rows)) * error
    return float(np.mean(np.abs(rows @ model.compliance - moved) <= half))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--campaigns", type=int, default=2000)
    parser.add_argument("--part", choices=("joints", "mixed"))
    options = parser.parse_args()
    print("| campaigns | compliances, % | at the test pose, % | refused |")
    print("|---|---|---|---|")
    parts = {"joints": of_joints, "mixed": mixed}
    for name, cases in parts.items():
        if options.part in (None, name):
            for case in cases():
                share, there, refused = held(case, options.campaigns)
                low, high = 100 * share.min(), 100 * share.max()
                print(
                    f"| {case.name} | {low:.1f} … {high:.1f} | {100 * there:.1f} | {refused} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
