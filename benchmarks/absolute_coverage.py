"""How often intervals of calibrations from absolute positions hold the truth.

    python benchmarks/absolute_coverage.py [--campaigns 500] [--robot NAME] [--kind NAME]

Campaigns on true arms that no Denavit-Hartenberg number made: every frame displaced at random, sag
by work of the loads (`simulation/absolute_truth.py`). 25 campaigns share one arm. Truth in the
unknowns of the model is a fit to many readings without noise; only what readings tell is compared,
free of combinations that nothing tells. Printed are the shares of 95 % intervals that hold it: of
all unknowns that are said to be seen together, the lowest and the highest of single ones; of
positions at fresh poses, as the mean and as a new reading; and the smallest interval that rests
on what was known before.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from elastocal.arrays import Array
from elastocal.calibration.arm_model import ArmModel, State
from elastocal.calibration.calibrate import Calibration, calibrate
from elastocal.calibration.parameters import parameters_of
from elastocal.calibration.prediction import predicted
from elastocal.elastic.springs import joint_springs
from elastocal.elastic.unknowns import each_spring
from elastocal.fitting.goodness import quantiles
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.geometry import geometric_errors
from elastocal.robot.payloads import Payload
from elastocal.robot.rotations import from_rotation_vectors, rotation_vectors
from elastocal.robot.shapes import BodyMass
from elastocal.robot.sources import DHRow, from_dh, kuka_kr270
from elastocal.simulation.absolute_campaign import (
    AbsoluteTruth,
    TrueStation,
    Visits,
    alike,
    simulated_positions,
)
from elastocal.simulation.absolute_truth import TrueArm, drawn_displacements

_GRAVITY = np.array([0.0, 0.0, -9.80665])
_PER_ARM = 25
_FRESH = 20


@dataclass(frozen=True)
class Cell:
    """A robot as drawn with what it carries, and how large everything is.

    Attributes:
        robot: With masses.
        compliance: (n,) of its joints [rad/(N·m) or m/N].
        tool: Three reflectors.
        payload: What hangs on it in half of the poses.
        sigma: Standard deviation of a coordinate of a reading [m].
        lower: (n,) joint values from which poses are drawn [rad or m].
        upper: (n,) up to these.
    """

    robot: Robot
    compliance: Array
    tool: Tool
    payload: Payload
    sigma: float
    lower: Array
    upper: Array


def kr270() -> Cell:
    """A heavy arm of six turning joints."""
    masses = (
        BodyMass(1, 300.0, np.array([0.1, 0.0, 0.3])),
        BodyMass(2, 250.0, np.array([0.0, 0.0, 0.6])),
        BodyMass(3, 200.0, np.array([0.0, 0.05, 0.2])),
        BodyMass(4, 60.0, np.array([0.0, 0.0, 0.4])),
        BodyMass(5, 30.0, np.zeros(3)),
    )
    robot = replace(kuka_kr270(), masses=masses)
    points = np.array([[0.4, 0.1, 0.0], [0.3, -0.2, 0.1], [0.35, 0.0, 0.25]])
    return Cell(
        robot,
        np.array([0.623, 0.302, 0.406, 3.002, 3.303, 2.365]) * 1e-6,
        Tool("tool", np.array([0.3, 0.0, 0.0]), points, ("R1", "R2", "R3")),
        Payload("weight", 200.0, np.array([0.3, 0.0, 0.1])),
        3e-5,
        np.maximum(0.8 * robot.lower, -2.5),
        np.minimum(0.8 * robot.upper, 2.5),
    )


def stanford() -> Cell:
    """The arm of Stanford: two joints that turn, one that slides, a wrist."""
    quarter = np.pi / 2
    rows = [
        DHRow("J1", 0.0, 0.4, 0.0, -quarter, False, 1.0, -2.5, 2.5),
        DHRow("J2", 0.0, 0.15, 0.0, quarter, False, 1.0, -2.0, 2.0),
        DHRow("J3", -quarter, 0.0, 0.0, 0.0, True, 1.0, 0.3, 1.0),
        DHRow("J4", 0.0, 0.0, 0.0, -quarter, False, 1.0, -2.5, 2.5),
        DHRow("J5", 0.0, 0.0, 0.0, quarter, False, 1.0, -1.8, 1.8),
        DHRow("J6", 0.0, 0.2, 0.0, 0.0, False, 1.0, -2.5, 2.5),
    ]
    robot = from_dh("stanford", rows, modified=False)
    masses = tuple(
        BodyMass(b, m, np.array([0.02, 0.03, 0.05]))
        for b, m in enumerate((9.0, 6.0, 15.0, 3.0, 2.0), 1)
    )
    points = np.array([[0.1, 0.05, 0.0], [-0.05, -0.1, 0.05], [0.0, 0.08, 0.12]])
    return Cell(
        replace(robot, masses=masses),
        np.array([2e-6, 2e-6, 5e-7, 2e-5, 2e-5, 3e-5]),
        Tool("tool", np.array([0.0, 0.0, 0.1]), points, ("R1", "R2", "R3")),
        Payload("weight", 10.0, np.array([0.05, 0.0, 0.1])),
        2e-5,
        robot.lower,
        robot.upper,
    )


def seven() -> Cell:
    """A redundant arm of common proportions."""
    quarter = np.pi / 2
    turns = [-quarter, quarter, quarter, -quarter, -quarter, quarter, 0.0]
    lengths = [0.36, 0.0, 0.42, 0.0, 0.4, 0.0, 0.126]
    rows = [
        DHRow(f"J{i + 1}", 0.0, d, 0.0, alpha, False, 1.0, -2.0, 2.0)
        for i, (alpha, d) in enumerate(zip(turns, lengths, strict=True))
    ]
    robot = from_dh("seven", rows, modified=False)
    masses = tuple(
        BodyMass(b, m, np.array([0.0, 0.03, 0.05]))
        for b, m in enumerate((4.0, 4.0, 3.0, 2.7, 1.7, 1.8), 1)
    )
    points = np.array([[0.08, 0.03, 0.02], [-0.05, -0.07, 0.04], [0.0, 0.05, 0.1]])
    return Cell(
        replace(robot, masses=masses),
        np.array([5e-5, 5e-5, 6e-5, 6e-5, 1e-4, 1e-4, 1e-4]),
        Tool("tool", np.array([0.0, 0.0, 0.1]), points, ("R1", "R2", "R3")),
        Payload("weight", 7.0, np.array([0.02, 0.0, 0.08])),
        2e-5,
        robot.lower,
        robot.upper,
    )


ROBOTS: dict[str, Callable[[], Cell]] = {"kr270": kr270, "stanford": stanford, "seven": seven}
KINDS = {
    "as promised": {},
    "noise twice as promised": {"noise": 2.0},
    "joints stand loosely": {"loose": 1.0},
    "joints wave and stand loosely": {"loose": 0.5, "wave": 1.0},
}
"""What is unlike the model, in units of the noise at arm's length."""


@dataclass
class Counts:
    """What was counted over campaigns: hits and trials."""

    names: tuple[str, ...]
    inside: Array
    seen: Array
    means: list[float]
    readings: list[float]
    smallest: float = np.inf

    @property
    def share(self) -> Array:
        """Of each unknown that was ever seen."""
        often = self.seen > 0
        return np.asarray(self.inside[often] / self.seen[often])


def model_of(cell: Cell) -> ArmModel:
    """All geometric errors and the compliances of all joints."""
    springs = each_spring(joint_springs(cell.robot))
    return ArmModel(
        cell.robot, cell.tool, geometric_errors(cell.robot), springs, _GRAVITY, (cell.payload,)
    )


def drawn_truth(cell: Cell, rng: np.random.Generator, loose: float, wave: float) -> AbsoluteTruth:
    """A cell as it may be, with two stations."""
    robot, n = cell.robot, len(cell.robot.joints)
    reach = np.where(robot.prismatic, 1.0, 1.0)
    arm = TrueArm(
        robot,
        drawn_displacements(robot, 3e-4, 3e-4, rng),
        joint_springs(robot),
        cell.compliance * rng.uniform(0.7, 1.3, n),
        _GRAVITY,
        (cell.payload,),
        wave=wave * cell.sigma / reach * rng.uniform(0.5, 1.5, n),
        waves=np.where(robot.prismatic, 30.0, rng.integers(1, 4, n)),
        phase=rng.uniform(0.0, 2 * np.pi, n),
        loose=np.full(n, loose * cell.sigma),
    )
    stations = []
    for _ in range(2):
        T = np.eye(4)
        T[:3, :3] = from_rotation_vectors(rng.normal(size=(1, 3)))[0]
        T[:3, 3] = 3.0 * rng.normal(size=3)
        stations.append(TrueStation(T))
    markers = cell.tool.markers + 1e-3 * rng.normal(size=cell.tool.markers.shape)
    return AbsoluteTruth(arm, markers[None], tuple(stations))


def visits(cell: Cell, count: int, rng: np.random.Generator) -> Visits:
    """Random poses, every other one with the payload, the first half read from one station."""
    q = rng.uniform(cell.lower, cell.upper, (count, len(cell.lower)))
    turns = np.arange(count)
    return Visits(q, payload=turns % 2 - 1, station=2 * turns // count)


def values_of(found: Calibration, truth: State) -> Array:
    """(U,) by how much the unknowns of a calibration are off."""
    p = found.parameters
    own = found.state
    turn = own.base[:, :3, :3] @ truth.base[:, :3, :3].transpose(0, 2, 1)
    base = np.hstack([own.base[:, :3, 3] - truth.base[:, :3, 3], rotation_vectors(turn)])
    tools = [
        own.markers[m, k] - truth.markers[m, k] for m, k in np.argwhere(p.targets[:, :-1]).tolist()
    ]
    return np.concatenate(
        [
            base.ravel(),
            np.ravel(tools),
            own.geometry - truth.geometry,
            own.compliance - truth.compliance,
        ]
    )


def told_part(found: Calibration) -> Array:
    """(U, U) unknowns without what nothing tells: rows are combinations that are told."""
    scale = found.standard_error
    open_ = found.redundancy.open / scale
    if not len(open_):
        return np.eye(len(scale))
    q = np.linalg.qr(open_.T)[0]
    return (np.eye(len(scale)) - q @ q.T) * scale[:, None] / scale[None, :]


def campaign(
    cell: Cell,
    model: ArmModel,
    truth: AbsoluteTruth,
    exact: State,
    fresh: tuple[Visits, Positions],
    rng: np.random.Generator,
    noise: float,
    counts: Counts,
    from_nothing: bool,
) -> None:
    """One campaign, counted; the fit starts from the truth, for it finds the same from nothing."""
    make = partial(simulated_positions, truth, cell.tool, covariance=alike(cell.sigma))
    positions = make(visits(cell, 60, rng), rng, noise=noise)
    parameters = parameters_of(model, positions)
    found = calibrate(model, positions, parameters, start=None if from_nothing else exact)
    t = float(quantiles(0.975, np.array([found.dof]))[0])
    combined = told_part(found)
    error = combined @ values_of(found, exact)
    half = t * np.sqrt(np.einsum("ij,jk,ik->i", combined, found.covariance, combined))
    seen = found.redundancy.seen
    counts.inside += (np.abs(error) <= half) & seen
    counts.seen += seen
    resting = ~seen[parameters.arm :]
    own = (t * found.standard_error / prior_of(found))[parameters.arm :]
    if resting.any():
        counts.smallest = min(counts.smallest, float(own[resting].min()))
    there = predicted(model, fresh[1], parameters, found.state)
    spread = np.einsum("rcu,uv,rcv->rc", there.rows, found.covariance, there.rows)
    counts.means.append(float((np.abs(there.error) <= t * np.sqrt(spread)).mean()))
    again = make(fresh[0], rng, noise=noise)
    read = predicted(model, again, parameters, found.state).error
    station = again.station
    each = cell.sigma**2 + found.noise.own[station] ** 2 + found.noise.shared[station] ** 2
    whole = np.sqrt(spread + each[:, None])
    counts.readings.append(float((np.abs(read) <= t * whole).mean()))


def prior_of(found: Calibration) -> Array:
    """(U,) standard uncertainty of each unknown before; infinite where nothing was known."""
    size = np.linalg.norm(found.parameters.rows, axis=0)
    return np.asarray(1.0 / np.maximum(size, 1e-300))


def covered(cell: Cell, campaigns: int, kind: dict[str, float], seed: int) -> Counts:
    """Counts over campaigns of one kind."""
    rng = np.random.default_rng(seed)
    model = model_of(cell)
    counts = None
    for c in range(campaigns):
        if c % _PER_ARM == 0:
            truth = drawn_truth(cell, rng, kind.get("loose", 0.0), kind.get("wave", 0.0))
            still = replace(truth, arm=replace(truth.arm, loose=np.zeros(len(cell.lower))))
            exactly = partial(
                simulated_positions, still, cell.tool, covariance=alike(1e-7), noise=0.0
            )
            many = exactly(visits(cell, 200, rng), rng)
            parameters = parameters_of(model, many)
            exact = calibrate(model, many, parameters).state
            poses = visits(cell, _FRESH, rng)
            fresh = (poses, exactly(poses, rng))
        if counts is None:
            u = len(parameters)
            counts = Counts(parameters.names, np.zeros(u), np.zeros(u), [], [])
        first = c % _PER_ARM == 0
        campaign(cell, model, truth, exact, fresh, rng, kind.get("noise", 1.0), counts, first)
    assert counts is not None
    return counts


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--campaigns", type=int, default=500)
    parser.add_argument("--robot", choices=ROBOTS)
    parser.add_argument("--kind", choices=KINDS)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--each", action="store_true", help="every unknown by itself")
    options = parser.parse_args()
    print(
        "| robot | campaigns | seen, % | lowest … highest | positions, % | readings, % "
        "| smallest open interval over its prior | s each |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for robot, make in ROBOTS.items():
        for name, kind in KINDS.items():
            if options.robot not in (None, robot) or options.kind not in (None, name):
                continue
            start = time.process_time()
            counts = covered(make(), options.campaigns, kind, options.seed)
            took = (time.process_time() - start) / options.campaigns
            share = 100.0 * counts.share
            print(
                f"| {robot} | {name} | {100 * counts.inside.sum() / counts.seen.sum():.1f} "
                f"| {share.min():.1f} … {share.max():.1f} | {100 * np.mean(counts.means):.1f} "
                f"| {100 * np.mean(counts.readings):.1f} | {counts.smallest:.2f} | {took:.2f} |",
                flush=True,
            )
            if options.each:
                for n, i, s in zip(counts.names, counts.inside, counts.seen, strict=True):
                    print(f"    {n:24s} {100 * i / max(s, 1):5.1f} of {int(s)}", flush=True)


if __name__ == "__main__":
    main()
