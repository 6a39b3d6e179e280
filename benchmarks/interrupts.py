"""Commands stopped and killed at random times: nothing is lost, every message is true.

Every command works over its own old output in a folder with a campaign. It is sent SIGINT or
SIGKILL at a time drawn from its usual duration, then what it left and what it said are compared:

* inputs are as they were, and every output is an old file or a new one, whole;
* "no file was changed", and names of files that were written, are what the folder shows;
* Ctrl-C does not part a pair of files; a pair parted by SIGKILL is noticed;
* nothing of ours is in a traceback, whatever Python itself ends in.

    python benchmarks/interrupts.py --rounds 100 --seed 0
"""

from __future__ import annotations

import argparse
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from elastocal.files.plans.pair import parted
from elastocal.writing import kind_of_file

EXAMPLE = Path(__file__).parents[1] / "examples" / "kr270"
OLD = 1_000_000_000  # time of files that were not written anew [s]
COMMANDS: dict[str, tuple[str, dict[str, str]]] = {  # arguments; kind of every output
    "plan": (
        "plan study.yaml --count 6 -o out.json", {"out.json": "plan", "out.csv": "run sheet"}),
    "simulate": (
        "simulate study.yaml plan.json --truth truth.json -o m.csv", {"m.csv": "measurements"}),
    "campaigns": (
        "simulate study.yaml plan.json --truth truth.json --campaigns 500 -o c.json "
        "--picture c.svg", {"c.json": "campaigns", "c.svg": "picture"}),
    "identify": ("identify study.yaml measured.csv -o model.json", {"model.json": "model"}),
    "compensate": (
        "compensate study.yaml truth.json path.csv -o out_path.csv",
        {"out_path.csv": "corrected path"}),
    "report": ("report plan.json --quick -o r.html", {"r.html": "report"}),
    "export": (
        "export plan.json --to krl -o job.src", {"job.src": "program", "job.dat": "program"}),
    "check": ("check study.yaml --picture robot.svg", {"robot.svg": "picture"}),
}  # fmt: skip
PAIRS = {"plan", "export"}
_WRITTEN = re.compile(r"stopped; (.*) (?:was|were) written\n")


@dataclass
class Tally:
    """What was seen.

    Attributes:
        ends: How often by signal and end.
        wrong: Sentences on what must not be.
    """

    ends: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)


def started(command: str, folder: Path) -> subprocess.Popen[str]:
    """A command at work in a folder."""
    return subprocess.Popen(
        [sys.executable, "-m", "elastocal", *command.split()],
        cwd=folder,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def prepared(folder: Path) -> dict[str, float]:
    """A campaign in a folder, every output made once; how long every command takes [s]."""
    for name in ("study.yaml", "truth.json", "path.csv"):
        (folder / name).write_bytes((EXAMPLE / name).read_bytes())
    for command in (
        "plan study.yaml",
        "simulate study.yaml plan.json --truth truth.json -o measured.csv",
    ):
        _, said = (process := started(command, folder)).communicate()
        assert process.returncode == 0, said
    times = {}
    for name, (command, _) in COMMANDS.items():
        begun = time.perf_counter()
        _, said = (process := started(command, folder)).communicate()
        assert process.returncode == 0, said
        times[name] = time.perf_counter() - begun
    return times


def tried(name: str, how: signal.Signals, delay: float, folder: Path, tally: Tally) -> None:
    """One command, sent a signal after a while [s]."""
    command, outputs = COMMANDS[name]
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    for path in folder.iterdir():
        os.utime(path, (OLD, OLD))
    process = started(command, folder)
    time.sleep(delay)
    process.send_signal(how)
    _, said = process.communicate(timeout=300)
    after = {path.name: path for path in folder.iterdir()}
    left = {file for file in after if file not in before}
    new = {file for file in outputs if after[file].stat().st_mtime != OLD}
    code = process.returncode
    tally.ends[f"{how.name}, exit {code}, {len(new)} of {len(outputs)} written"] += 1

    def wrong(what: str) -> None:
        tally.wrong.append(f"{command} ({how.name} after {delay:.2f} s, exit {code}): {what}")

    for file, content in before.items():
        if file not in after:
            wrong(f"{file} is gone")
        elif file in outputs:
            kind = kind_of_file(after[file])
            if kind != outputs[file]:
                wrong(f"{file} is {kind or 'not whole'}")
        elif after[file].read_bytes() != content:
            wrong(f"{file} was an input and has changed")
    if "elastocal/" in said:
        wrong(f"a traceback of ours: {said}")
    if how == signal.SIGKILL:
        tally.ends["SIGKILL, a temporary file left"] += bool(left)
        for file in left:
            if not file.startswith("."):
                wrong(f"{file} was left")
            after[file].unlink()
        if name in PAIRS and len(new) == 1:
            tally.ends["SIGKILL, a pair parted"] += 1
    else:
        _look_at_words(code, said, left, new, len(outputs), name in PAIRS, wrong)
    changed = new == {"out.json"} and before["out.json"] != after["out.json"].read_bytes()
    if changed and parted(folder / "out.json") is None:
        wrong("the pair is parted, and nothing notices")


def _look_at_words(
    code: int, said: str, left: set[str], new: set[str], count: int, pair: bool, wrong: object
) -> None:
    """What was said after Ctrl-C, against what there is."""
    assert callable(wrong)
    if left:
        wrong(f"left: {', '.join(left)}")
    if pair and len(new) == 1:
        wrong("Ctrl-C parted a pair")
    if code == 0 and len(new) < count:
        wrong("done, but not all is written")
    if code == 130 and "stopped" not in said and "Traceback" not in said:
        wrong("stopped without a word")
    named = _WRITTEN.search(said)
    listed = set(re.split(r", | and ", named[1])) if named else set()
    if "stopped" in said and listed != new:
        wrong(f"said {said!r}, written are {sorted(new)}")
    if code not in (0, 130, -signal.SIGINT) and "Traceback" not in said:
        wrong(f"ended in {code}: {said}")


def main() -> None:
    """Try commands at random; ends with 1 if anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=20, help="of each signal")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", choices=COMMANDS, action="append", help="commands to try")
    given = parser.parse_args()
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in the background of a shell
        signal.signal(signal.SIGINT, signal.default_int_handler)
    draw, tally = random.Random(given.seed), Tally()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        times = prepared(folder)
        for _ in range(given.rounds):
            for how in (signal.SIGINT, signal.SIGKILL):
                command = draw.choice(given.only or list(COMMANDS))
                # The end is where files are written: half of all signals come there.
                late = draw.random() < 0.5
                share = draw.uniform(0.75, 1.0) if late else draw.uniform(0.0, 1.0)
                tried(command, how, share * times[command], folder, tally)
    for end, count in sorted(tally.ends.items()):
        print(f"{count:5d}  {end}")
    print("\n".join(tally.wrong) or "nothing was lost, and every message was true")
    sys.exit(bool(tally.wrong))


if __name__ == "__main__":
    main()
