"""How long commands take until they say something, until they work, and as a whole.

    python benchmarks/startup.py

Whole processes of one thread on a small terminal, byte code kept, one round after the other over
all commands. Every command is run twice in a round: until it enters the function that does its
work, which ends the process there, and to the end where that is quick. Times are in seconds and as
ratios to `python -c pass` of the same run. Writes benchmarks/results/startup.md.
"""

from __future__ import annotations

import argparse
import os
import pty
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from kr270 import RESULTS, machine, one_thread, write_results

EXAMPLE = Path(__file__).parents[1] / "examples" / "kr270"
WORK = {  # arguments of commands, and where the work of each begins
    "check study.yaml": "planning.study_check:check",
    "plan study.yaml -o other.json": "planning.plan:plan",
    "evaluate study.yaml plan.json --random 0": "planning.certificate:lower_bound",
    "identify study.yaml measured.csv -o model.json": "identification.identify:identify",
    "validate study.yaml truth.json measured.csv": "identification.validation:validate",
    "compensate study.yaml truth.json path.csv": "compensation.compensate:RULES",
}
WHOLE = ("--version", "--help", "plan --help", *(c for c in WORK if c[0] in "civ"))
IMPORTS = ("numpy", "numpy, yaml, elastocal.planning.plan")
UNTIL = """
import os, sys
from importlib.machinery import PathFinder

module, name = sys.argv.pop(1).split(":")


def reached(*_, **__):
    os._exit(77)


class Waiting:
    def find_spec(self, wanted, path=None, target=None):
        if wanted != f"elastocal.{module}":
            return None
        spec = PathFinder.find_spec(wanted, path)
        execute = spec.loader.exec_module

        def exec_module(loaded):
            execute(loaded)
            known = getattr(loaded, name)
            setattr(loaded, name, reached if callable(known) else dict.fromkeys(known, reached))

        spec.loader.exec_module = exec_module
        return spec


sys.meta_path.insert(0, Waiting())
from elastocal.__main__ import main
main()
"""


@dataclass
class Times:
    """What a process took [s], a value for every round.

    Attributes:
        first: Until it wrote anything; only where it did.
        wall: Until it ended.
        processor: Of the processor, its own and the system's.
    """

    first: list[float]
    wall: list[float]
    processor: list[float]


def watched(arguments: list[str], folder: Path, times: Times, ends: int = 0) -> None:
    """Run a process on a terminal of its own."""
    ours, its = pty.openpty()
    unkept = ("PYTHONDONTWRITEBYTECODE", "COLUMNS")
    environment = {k: v for k, v in os.environ.items() if k not in unkept} | {"TERM": "xterm"}
    begun = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, *arguments], cwd=folder, env=environment,
        stdin=its, stdout=its, stderr=its, close_fds=True,
    )  # fmt: skip
    os.close(its)
    heard, said = 0.0, b""
    while part := _read(ours):
        heard = heard or time.perf_counter() - begun
        said += part
    _, status, used = os.wait4(process.pid, 0)
    wall = time.perf_counter() - begun
    process.returncode = os.waitstatus_to_exitcode(status)
    os.close(ours)
    if process.returncode != ends:
        raise RuntimeError(f"{arguments} ended with {process.returncode}: {said.decode()[-2000:]}")
    times.first += [heard] if heard else []
    times.wall.append(wall)
    times.processor.append(used.ru_utime + used.ru_stime)


def _read(terminal: int) -> bytes:
    try:
        return os.read(terminal, 65536)
    except OSError:  # how Linux says that the other side has closed it
        return b""


def campaign(folder: Path) -> None:
    """The files that the commands read."""
    for name in ("study.yaml", "truth.json", "path.csv"):
        shutil.copy(EXAMPLE / name, folder)
    for command in (
        "plan study.yaml",
        "simulate study.yaml plan.json --truth truth.json -o measured.csv",
    ):
        subprocess.run(
            [sys.executable, "-m", "elastocal", *command.split()],
            cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip


def measured(rounds: int, folder: Path) -> dict[str, Times]:
    """Times by what was run, rounds interleaved; the first, which writes byte code, is left out."""
    runs: dict[str, tuple[list[str], int]] = {"`python -c pass`": (["-c", "pass"], 0)}
    runs |= {f"`import {names}`": (["-c", f"import {names}"], 0) for names in IMPORTS}
    for command, work in WORK.items():
        verb = command.split()[0]
        runs[f"`{verb}` until its work begins"] = (["-c", UNTIL, work, *command.split()], 77)
    for command in WHOLE:
        verb = command if "--" in command else command.split()[0]
        runs[f"`{verb}` as a whole"] = (["-m", "elastocal", *command.split()], 0)
    found = {}
    for i in range(rounds + 1):
        if i < 2:
            found = {name: Times([], [], []) for name in runs}
        for name, (arguments, ends) in runs.items():
            watched(arguments, folder, found[name], ends)
    return found


def table(found: dict[str, Times]) -> list[str]:
    """Medians, and their ratios to those of bare Python."""
    lines = [
        "| process | first line | wall | processor | wall, times bare Python | fastest wall |",
        "|:--|--:|--:|--:|--:|--:|",
    ]
    bare = statistics.median(next(iter(found.values())).wall)
    for name, times in found.items():
        wall, processor = statistics.median(times.wall), statistics.median(times.processor)
        first = f"{statistics.median(times.first):.3f}" if times.first else "–"
        lines.append(
            f"| {name} | {first} | {wall:.3f} | {processor:.3f} | {wall / bare:.1f} "
            f"| {min(times.wall):.3f} |"
        )
    return lines


def main() -> None:
    """Run, print, write results/startup.md."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=11, help="runs of every process")
    parser.add_argument("--folder", type=Path, help="with the files of a campaign already")
    parser.add_argument("--out", type=Path, default=RESULTS / "startup.md")
    arguments = parser.parse_args()
    one_thread()
    about = machine("scipy", "typer", "rich")
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        if arguments.folder is None:
            campaign(folder)
        lines = table(measured(arguments.rounds, folder))
    print("\n".join(lines))
    text = [
        "# Start-up",
        f"Made by `benchmarks/startup.py`. {about}. Medians of {arguments.rounds} processes of one "
        "thread, in seconds, on a terminal; byte code is kept.",
        "\n".join(lines),
    ]
    write_results(arguments.out, *text)


if __name__ == "__main__":
    main()
