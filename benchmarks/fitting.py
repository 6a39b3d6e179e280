"""What it takes to fit: `identify` over the number of readings, and many virtual campaigns.

    python benchmarks/fitting.py [--before PATH] [--most 1000000]

Processor seconds of whole processes on one thread, without any extra package, least of some rounds.
With `--before`, the sources of another version (a folder with `elastocal` in `src`), both are run
in turn on the same files, and the ratio is given. Three markers on the KR 270; every experiment has
a configuration of its own, which is the worst case. Writes benchmarks/results/fitting.md.
`--nuisance` prints the same of fits with `nuisance: typical`, and writes nothing.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from identify import campaign
from kr270 import RESULTS, machine, one_thread

EXAMPLE = Path(__file__).parents[1] / "examples" / "kr270"
SOURCES = Path(__file__).parents[1] / "src"
READINGS = (100, 1_000, 3_000, 10_000, 100_000, 1_000_000)
WITH_NUISANCE = (300, 3_000)
CAMPAIGNS = (2_000, 20_000)
LARGE = 10_000  # readings from which growth is fitted


@dataclass(frozen=True)
class Spent:
    """What a process took: processor seconds, and its largest memory [GiB]."""

    seconds: float
    memory: float


def spent(sources: Path, folder: Path, bare: Path, *arguments: str) -> Spent:
    """What a command takes with the sources of a version; `bare` hides the extra packages."""
    path = os.pathsep.join(map(str, (bare, sources)))
    environment = {**os.environ, "PYTHONPATH": path}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    command = [sys.executable, "-m", "elastocal", *arguments, "--force"]
    quiet = subprocess.DEVNULL
    process = subprocess.Popen(command, cwd=folder, env=environment, stdout=quiet, stderr=quiet)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(command)} ended with {process.returncode}")
    return Spent(used.ru_utime + used.ru_stime, used.ru_maxrss / 2**20)


def least(sources: list[Path], folder: Path, bare: Path, rounds: int, *command: str) -> list[Spent]:
    """The least that a command takes with each of the sources, which take turns."""
    runs = [[spent(one, folder, bare, *command) for one in sources] for _ in range(rounds)]
    return [
        Spent(min(r.seconds for r in each), max(r.memory for r in each))
        for each in zip(*runs, strict=True)
    ]


def exponent(readings: list[int], seconds: list[float]) -> float:
    """Growth of what is beyond the start, as a power of the number of readings."""
    large = [(r, s - seconds[0]) for r, s in zip(readings, seconds, strict=True) if r >= LARGE]
    if len(large) < 2:
        return float("nan")
    return float(np.polyfit(*np.log(np.array(large)).T, 1)[0])


def table(title: str, counts: list[int], found: list[list[Spent]]) -> list[str]:
    """Rows of Markdown; the last of the versions is the one that the others are compared with."""
    before = len(found[0]) > 1
    lines = [
        f"| {title} | seconds | peak GiB |" + (" before | peak GiB | ratio |" if before else "")
    ]
    lines.append("|--:|--:|--:|" + ("--:|--:|--:|" if before else ""))
    for count, each in zip(counts, found, strict=True):
        now = each[-1]
        row = f"| {count:,} | {now.seconds:.2f} | {now.memory:.2f} |".replace(",", " ")
        if before:
            then = each[0]
            ratio = then.seconds / now.seconds
            row += f" {then.seconds:.2f} | {then.memory:.2f} | {ratio:.1f} |"
        lines.append(row)
    return lines


def main() -> None:
    one_thread()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--before", type=Path, help="folder of another version")
    parser.add_argument("--most", type=int, default=READINGS[-1], help="most readings")
    parser.add_argument("--nuisance", action="store_true", help="of fits with nuisance, printed")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--out", type=Path, default=RESULTS)
    given = parser.parse_args()
    sources = [given.before.resolve() / "src"] if given.before else []
    sources.append(SOURCES)
    lines = ["# Fits", "", f"Made by `benchmarks/fitting.py`. {machine()}", ""]
    lines += [(__doc__ or "").split("\n\n")[2].replace("\n", " "), ""]
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        bare = folder / "bare"
        bare.mkdir()
        (bare / "pyarrow.py").write_text("raise ImportError('an extra package')\n", "utf-8")
        every = WITH_NUISANCE if given.nuisance else READINGS
        counts = [count for count in every if count <= given.most]
        found = []
        for count in counts:
            experiments = -(-count // 3)
            with ProcessPoolExecutor(1, get_context("spawn")) as apart:
                # Elsewhere, for a process begins with the largest memory of the one that starts it.
                made = apart.submit(campaign, folder, experiments, nuisance=given.nuisance)
                file = made.result()
            command = "identify", "study.yaml", file.name
            rounds = given.rounds if count <= 100_000 else max(1, given.rounds - 1)
            found.append(least(sources, folder, bare, rounds, *command))
            print(f"{count} readings:", *(f"{s.seconds:.2f} s" for s in found[-1]), flush=True)
        if given.nuisance:
            return
        lines += ["## `identify`", "", *table("readings", counts, found), ""]
        growth = [
            exponent(counts, [each[i].seconds for each in found]) for i in range(len(sources))
        ]
        lines += [
            f"From {LARGE:,} readings on, less the start, it grows with their number to the power "
            f"of {growth[-1]:.2f}" + (f" ({growth[0]:.2f} before)." if given.before else "."),
            "",
        ]
        for name in ("study.yaml", "truth.json"):
            (folder / name).write_text((EXAMPLE / name).read_text("utf-8"), "utf-8")
        spent(SOURCES, folder, bare, "plan", "study.yaml")
        found = []
        for number in CAMPAIGNS:
            command = "simulate", "study.yaml", "plan.json", "--truth", "truth.json"
            more = "--campaigns", str(number)
            found.append(least(sources, folder, bare, given.rounds, *command, *more))
            print(f"{number} campaigns:", *(f"{s.seconds:.2f} s" for s in found[-1]), flush=True)
        lines += ["## `simulate --campaigns`", "", *table("campaigns", list(CAMPAIGNS), found), ""]
        more = [found[1][i].seconds - found[0][i].seconds for i in range(len(sources))]
        lines += [
            f"From {CAMPAIGNS[0]:,} to {CAMPAIGNS[1]:,} campaigns: {more[-1]:.2f} s more"
            + (f" ({more[0]:.2f} s before)." if given.before else ".")
        ]
    (given.out / "fitting.md").write_text("\n".join(lines) + "\n", "utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
