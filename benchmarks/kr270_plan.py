"""How long `elastocal plan` takes as a whole process, and how good its plans are, by seed.

    python benchmarks/kr270_plan.py

Start of Python, certificate and files included; rho0 is recomputed from the file it wrote. Races
against other methods are in `races.py`. Writes benchmarks/results/kr270.md.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path

from kr270 import MICRO, RESULTS, STUDY_FILE, machine, one_thread, study, target

from elastocal.core.library import described
from elastocal.files.plans.proposal_file import read_proposal
from elastocal.planning.assessment import assess


def whole_process(count: int, seed: int, folder: Path) -> tuple[float, float]:
    """Processor seconds of `elastocal plan`, and rho0 recomputed from its file."""
    out = folder / "plan.json"
    command = [sys.executable, "-m", "elastocal", "plan", str(STUDY_FILE), "--force"]
    command += ["--count", str(count), "--seed", str(seed), "--out", str(out)]
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    quiet = subprocess.DEVNULL
    process = subprocess.Popen(command, env=environment, stdout=quiet, stderr=quiet)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, command
    campaign = study(count)
    proposal = read_proposal(out, campaign)
    judged = assess(campaign, proposal.load_cases, proposal.repeats)
    assert int(proposal.repeats.sum()) == count
    assert not judged.violations, judged.violations
    return used.ru_utime + used.ru_stime, MICRO * judged.rho0


def process_table(counts: Iterable[int], seeds: int) -> list[str]:
    """As Markdown."""
    lines = [
        "| m | seconds: median (min – max) | rho0: median (worst) | against | within 0.01 % |",
        "|--:|--:|--:|--:|--:|",
    ]
    with tempfile.TemporaryDirectory() as name:
        whole_process(3, 0, Path(name))  # what is compiled to byte code is there from now on
        for count in counts:
            runs = [whole_process(count, seed, Path(name)) for seed in range(seeds)]
            seconds, rho0 = zip(*runs, strict=True)
            goal = target(count)
            hits = sum(value <= goal * 1.0001 for value in rho0)
            lines.append(
                f"| {count} | {_spread(seconds)} | {statistics.median(rho0):.5f} "
                f"({100 * (max(rho0) / goal - 1):+.3f} %) | {goal:.5f} | {hits} of {seeds} |"
            )
            print(lines[-1], flush=True)
    return lines


def _spread(values: Iterable[float]) -> str:
    ordered = sorted(values)
    return f"{statistics.median(ordered):.2f} ({ordered[0]:.2f} – {ordered[-1]:.2f})"


def main() -> None:
    """Run, print, write results/kr270.md."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one seed, m = 3, 12 and 1000")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--out", type=Path, default=RESULTS / "kr270.md")
    given = parser.parse_args()
    one_thread()
    counts, seeds = [2, 3, 4, 6, 12, 1000], given.seeds
    if given.quick:
        counts, seeds = [3, 12, 1000], 1
    about = f"{machine('scipy')}; {described()}"
    print(about, flush=True)
    text = _TEXT.format(
        about=about,
        date=time.strftime("%Y-%m-%d"),
        seeds=seeds,
        processes="\n".join(process_table(counts, seeds)),
    )
    given.out.write_text(text, encoding="utf-8")
    print(f"wrote {given.out}")


_TEXT = """\
# KR 270: a plan as a whole process

Made by `benchmarks/kr270_plan.py` on {date}. {about}.

Processor seconds of `python -m elastocal plan` on one thread: start of Python, reading the study,
bound confirmed from fresh starts, plan, files written. {seeds} seed(s). rho0 in 1e-3 mm, recomputed
from the written file; "against" is the best known rho0, and for m = 1000 the lower bound of any
plan. Against other methods: [races.md](races.md).

{processes}
"""


if __name__ == "__main__":
    main()
