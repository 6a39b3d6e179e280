"""Plans side by side in thousands of virtual campaigns: what they promise and what they keep.

The truth bends as a real arm does: the deflections are those of the nonlinear equilibrium.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import elastocal as ec

FOLDER = Path(__file__).parent / "kr270"
PUBLISHED = [  # three configurations of the paper, each measured four times
    [0.0, -93.5, 125.0, -118.7, -62.4, -168.9],
    [0.0, -103.4, 93.4, -147.9, 105.8, 93.2],
    [0.0, -98.9, 113.8, 50.6, -38.6, 16.8],
]


def row(name: str, promised: float, errors: np.ndarray) -> None:
    low, median, high = 1e6 * np.quantile(errors, [0.05, 0.5, 0.95])
    rms, mean = 1e6 * np.sqrt(np.mean(errors**2)), 1e6 * errors.mean()
    print(f"{name:12}{1e6 * promised:8.3f}{rms:8.3f}{mean:8.3f}{low:8.3f}{median:8.3f}{high:8.3f}")


def main() -> None:
    study = ec.read_study(FOLDER / "study.yaml")
    truth = ec.read_model(FOLDER / "truth.json", study.robot)
    best = ec.plan(study, seed=0)
    load = best.load_cases.wrench[:1]
    published = ec.LoadCases(np.radians(PUBLISHED), np.repeat(load, 3, axis=0))
    plans = {"planned": (best.load_cases, best.repeats), "published": (published, np.full(3, 4))}
    found = ec.campaigns(study, truth, plans, 2000, seed=1, random=100)

    print("position error after compensation [µm], 2000 campaigns of 12 experiments")
    print(f"{'plan':12}{'ρ0':>8}{'RMS':>8}{'mean':>8}{'5 %':>8}{'median':>8}{'95 %':>8}")
    for one in found.plans:
        row(one.name, one.rho0, one.total)
    row("100 random", found.random.rho0, found.random.total)

    linear = ec.campaigns(study, truth, plans, 2000, seed=1, how=ec.Fit(model="linear"))
    for how, result in (("iterated fit", found), ("linear fit", linear)):
        one = result.plans[0]
        bias, cover = np.abs(one.bias).max(), 100 * one.coverage.min()
        print(f"{how}: bias up to {bias:.2f} standard errors, 95 % intervals hold {cover:.1f} %")


if __name__ == "__main__":
    main()
