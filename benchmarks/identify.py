"""How long `identify` takes as a whole process, reading included.

    python benchmarks/identify.py [folder]

Three markers on the KR 270; every experiment has a configuration of its own, which is the worst
case. Compared in the same run with SciPy's general solver on the same equilibria, and with
`numpy.linalg.lstsq` on the regressor alone.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

import elastocal as ec
from elastocal.arrays import Array
from elastocal.simulation.true_robot import true_robot
from elastocal.simulation.virtual_campaign import Reality

HERE = Path(__file__).parent
MARKERS = "markers_mm: {M1: [611.5, 0, -460], M2: [200, 300, 100], M3: [200, -300, 100]}"


def campaign(folder: Path, experiments: int, *, nuisance: bool = False) -> Path:
    """A study and a measurement file of three readings for each experiment.

    With nuisance the study has the preset, and the robot what that says, by chance.
    """
    text = (HERE.parent / "examples" / "kr270" / "study.yaml").read_text("utf-8")
    study_path = folder / "study.yaml"
    text = text.replace("markers_mm: {M1: [611.5, 0, -460]}", MARKERS)
    study_path.write_text(text + ("\nnuisance: typical\n" if nuisance else ""), "utf-8")
    study = ec.read_study(study_path)
    truth = ec.read_model(HERE.parent / "examples" / "kr270" / "truth.json", study.robot)
    rng = np.random.default_rng(0)
    cases = study.space.load_cases(study.space.sample(experiments, rng))
    robot = true_robot(study, truth, np.random.default_rng(1))
    reality = Reality(loads=robot.loads, errors=robot.errors)
    once = np.ones(experiments, dtype=np.int64)
    data = ec.simulate(study, robot.model, cases, once, rng, reality=reality)
    path = folder / f"{experiments}.csv"
    ec.write_measurements(data, study.robot, path)
    return path


def whole_process(folder: Path, path: Path) -> float:
    """Seconds of `elastocal identify`, start-up included."""
    command = [sys.executable, "-m", "elastocal", "identify", "study.yaml", path.name]
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    start = time.perf_counter()
    subprocess.run(command, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


def in_process(folder: Path, path: Path) -> tuple[float, float, float]:
    """Seconds of `identify`, of SciPy's solver on the equilibrium, of lstsq on the regressor."""
    study = ec.read_study(folder / "study.yaml")
    data = ec.read_measurements(path, study)
    arm, flat = study.arm, data.deflection.reshape(len(data.cases), -1)

    def left(micro: Array) -> Array:
        return (flat - ec.loaded_deflection(arm, 1e-6 * micro, data.cases)).ravel() / study.sigma

    times = []
    start = time.perf_counter()
    found = ec.identify(arm, data)
    times.append(time.perf_counter() - start)
    start = time.perf_counter()
    other = least_squares(left, np.ones(len(arm.springs)), x_scale="jac")
    times.append(time.perf_counter() - start)
    np.testing.assert_allclose(1e-6 * other.x, found.compliance, rtol=1e-6)
    start = time.perf_counter()
    rows = ec.regressor(arm, data.cases)
    np.linalg.lstsq(rows.reshape(-1, len(arm.springs)) * 1e-6, flat.ravel(), rcond=None)
    times.append(time.perf_counter() - start)
    return times[0], times[1], times[2]


def main() -> None:
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(sys.argv[1] if len(sys.argv) > 1 else temporary)
        small = campaign(folder, 1000)
        own, general, linear = in_process(folder, small)
        print(f"1000 experiments x 3 markers, in process: identify {own:.3f} s")
        print(f"  SciPy least_squares on the equilibrium: {general / own:.1f} times as long")
        print(f"  lstsq on the linear regressor:          {linear / own:.2f} times as long")
        seconds = sorted(whole_process(folder, small) for _ in range(5))
        print(f"  whole process: {seconds[2]:.2f} s (median of 5)")
        large = campaign(folder, 333_334)
        seconds = sorted(whole_process(folder, large) for _ in range(3))
        peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 2**20
        print(f"1 000 002 rows, whole process: {seconds[1]:.1f} s (median of 3), {peak:.2f} GiB")


if __name__ == "__main__":
    main()
