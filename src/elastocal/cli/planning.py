"""Planning as several commands do it: with a progress bar, and written at once.

Imported by the commands when they run.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from elastocal.cli.ending import undisturbed
from elastocal.cli.stopping import SearchEnd, ended_by
from elastocal.cores import several_cores, usable_cores
from elastocal.planning.certificate import Bound, lower_bound
from elastocal.planning.plan import Plan, plan
from elastocal.study.study import Study
from elastocal.terminal.progress import progress
from elastocal.wording import worded

if TYPE_CHECKING:
    from elastocal.files.plans.proposal_file import Proposal


def planned(study: Study, out: Path, seed: int) -> Plan:
    """Plan a study, and write the plan and its run sheet beside it."""
    with several_cores(usable_cores()), progress("planning") as tell:
        made = plan(study, seed=seed, progress=tell)
    write_pair(made, out)
    return made


def planned_for_now(
    study: Study,
    out: Path,
    seed: int,
    workers: int | None,
    seconds: float | None,
    bound: Bound | None = None,
) -> Plan:
    """The same, but Ctrl-C and the end of so many seconds leave the best plan so far.

    A bound that is known is not searched for again.
    """
    with several_cores(workers or usable_cores()), progress("planning") as say:
        end = SearchEnd(say, seconds)
        with ended_by(end):
            made = plan(study, seed=seed, bound=bound, progress=end.tell, stop=end)
    write_pair(made, out)
    return made


def write_pair(made: Plan, out: Path) -> None:
    """Write a plan and its run sheet beside it."""
    from elastocal.files.plans.plan_file import write_plan, write_run_sheet

    with undisturbed():
        write_plan(made, out)
        write_run_sheet(made, out.with_suffix(".csv"))


def bound(study: Study, seed: int, workers: int | None = None) -> Bound:
    """A bound computed anew, from another stream of random numbers than the planner's."""
    with several_cores(workers or usable_cores()), progress("bound") as tell:
        rng = np.random.default_rng([seed, 1])
        return lower_bound(study, rng, progress=tell)


def note_broken(name: str, proposal: Proposal, judged: Study) -> None:
    """Say on standard error if a plan must not be carried out, where it is shown all the same.

    Args:
        name: What the plan is called.
        proposal: The plan.
        judged: The study, as the plan was made for it.
    """
    from elastocal.planning.assessment import assess, broken

    worth = assess(judged, proposal.load_cases, proposal.repeats)
    found = broken(judged, worth, proposal.load_cases.q, proposal.via)
    if found:
        more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
        print(f"note: {name} must not be run: {worded(found[0])}{more}", file=sys.stderr)
