"""How often a tracker that was knocked is found out, and how often one that was not is blamed.

    python benchmarks/knocks.py [--campaigns 100] [--robot NAME]

Campaigns of `absolute_coverage.py` with one station, knocked after any reading but the first and
last 8 % by ten times the noise of a coordinate, any way; or left in peace. Once four reflectors on
the foot are read in five blocks, once the readings of the arm alone must tell.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np
from absolute_coverage import ROBOTS, drawn_truth, model_of, visits

from elastocal.calibration.calibrate import calibrate
from elastocal.calibration.doubts import doubts
from elastocal.calibration.knocks import likeliest_knocks
from elastocal.calibration.parameters import parameters_of
from elastocal.calibration.stations import KNOCKED, STILL, station_motions
from elastocal.simulation.absolute_campaign import Foot, alike, simulated_positions

_POSES = 60
_TIMES = 10.0  # the noise of a coordinate


def tried(name: str, campaigns: int, kind: dict[str, float], *, knocked: bool) -> str:
    """One line of the table."""
    cell = ROBOTS[name]()
    model, targets = model_of(cell), len(cell.tool.markers)
    foot, arm, where, still = 0, 0, 0, 0
    for c in range(campaigns):
        rng = np.random.default_rng(c)
        truth = drawn_truth(cell, rng, kind.get("loose", 0.0), kind.get("wave", 0.0))
        station = truth.stations[0]
        after = int(rng.integers(0.08 * targets * _POSES, 0.92 * targets * _POSES))
        way = rng.normal(size=3)
        way *= _TIMES * cell.sigma / np.linalg.norm(way)
        if knocked:
            station = replace(station, bumped_after=after, bump=np.append(way, np.zeros(3)))
        truth = replace(truth, stations=(station,), foot=Foot(rng.normal(size=(4, 3)), 5))
        poses = replace(visits(cell, _POSES, rng), station=np.zeros(_POSES))
        read = simulated_positions(truth, cell.tool, poses, rng, covariance=alike(cell.sigma))
        (motion,) = station_motions(read)
        foot += motion.verdict == KNOCKED
        still += motion.verdict == STILL
        read = replace(read, foot=None)
        fit = calibrate(model, read, parameters_of(model, read))
        if any(doubt.code == "tracker-knocked" for doubt in doubts(fit)):
            arm += 1
            (knock,) = likeliest_knocks(fit)
            where += knock.first < after <= knock.last
    what = "knocked" if knocked else "in peace"
    inside = f"{where} of {arm}" if knocked else "–"
    return f"| {what} | {campaigns} | {foot} ({still} still) | {arm} | {inside} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--campaigns", type=int, default=100)
    parser.add_argument("--robot", choices=ROBOTS)
    options = parser.parse_args()
    print("| robot | joints | tracker | campaigns | by the foot | by the arm | place right |")
    print("|---|---|---|---|---|---|---|")
    for robot in ROBOTS:
        if options.robot not in (None, robot):
            continue
        for name, kind in (("as drawn", {}), ("wave and loose", {"loose": 0.5, "wave": 1.0})):
            for knocked in (True, False):
                line = tried(robot, options.campaigns, kind, knocked=knocked)
                print(f"| {robot} | {name} {line}", flush=True)


if __name__ == "__main__":
    main()
