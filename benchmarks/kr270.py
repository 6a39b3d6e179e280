"""The planning problem of the benchmarks: the paper's KUKA KR 270 campaign.

`kr270.yaml` beside this file is the study: fixed vertical force of 2500 N, sigma 0.03 mm, the
constraints of the paper's Table 4. Its test pose is given by its regressor exactly as printed in
the paper's eq. (38), "A0"; that matrix without its negative entries, with which the paper's own
Table 7 was computed, is "A0+".
"""

from __future__ import annotations

import os
import platform
import sys
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from elastocal.files.study.study_file import read_study
from elastocal.study.study import Study, TestPose

STUDY_FILE = Path(__file__).parent / "kr270.yaml"
RESULTS = Path(__file__).parent / "results"

BEST_KNOWN = {
    2: 7.83321,
    3: 6.01815,
    4: 4.95902,
    6: 3.97310,
    8: 3.41289,
    12: 2.79525,
    24: 1.96894,
    100: 0.96449,
}
"""Smallest rho0 known for m experiments with A0 [1e-3 mm]."""

BOUND = {"A0": 9.64460, "A0+": 7.44092}
"""True lower bounds of rho0·sqrt(m) [1e-3 mm]."""

MICRO = 1e6
"""rho0 in metres times this is in 1e-3 mm, the unit of every table here."""


def study(count: int, *, matrix: str = "A0") -> Study:
    """The campaign with `count` experiments, judged by "A0" or "A0+"."""
    campaign = read_study(STUDY_FILE)
    printed = campaign.test_poses[0].regressor
    chosen = {"A0": printed, "A0+": np.where(printed > 0.0, printed, 0.0)}[matrix]
    return replace(
        campaign,
        test_poses=(TestPose(matrix, chosen),),
        experiments=replace(campaign.experiments, count=count),
    )


def target(count: int) -> float:
    """What a plan of `count` experiments is measured against [1e-3 mm].

    The best known rho0; the lower bound where no plan is on record.
    """
    return BEST_KNOWN.get(count, BOUND["A0"] / count**0.5)


def one_thread() -> None:
    """Start this program again with one thread if need be: only then do times compare.

    BLAS reads the number of threads when it is loaded, so it is too late to set it here.
    """
    wanted = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    if any(os.environ.get(name) != value for name, value in wanted.items()):
        os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | wanted)


def machine(*packages: str) -> str:
    """One line on what the numbers were measured with."""
    parts = [
        f"{_processor()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} at the start",
        f"{platform.system()}, Python {platform.python_version()}",
    ]
    for package in ("numpy", *packages):
        try:
            parts.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            parts.append(f"{package} not installed")
    return "; ".join(parts)


def write_results(out: Path, *parts: str) -> None:
    """Write a page of results: its paragraphs and tables."""
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    print(f"wrote {out}")


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return f"{line.split(':', 1)[1].strip()} ({platform.machine()})"
    return platform.processor() or platform.machine()
