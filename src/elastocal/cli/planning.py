"""Planning as several commands do it: with a progress bar, and written at once.

Imported by the commands when they run.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from elastocal.cli.ending import undisturbed
from elastocal.cores import several_cores, usable_cores
from elastocal.files.plans.plan_file import write_plan, write_run_sheet
from elastocal.planning.certificate import Bound, lower_bound
from elastocal.planning.plan import Plan, plan
from elastocal.study.study import Study, with_count
from elastocal.terminal.console import progress


def planned(study: Study, out: Path, seed: int, workers: int | None = None) -> Plan:
    """Plan a study, and write the plan and its run sheet beside it."""
    with several_cores(workers or usable_cores()), progress("planning") as tell:
        made = plan(study, seed=seed, progress=tell)
    with undisturbed():
        write_plan(made, out)
        write_run_sheet(made, out.with_suffix(".csv"))
    return made


def bound(study: Study, count: int, seed: int, workers: int | None = None) -> Bound:
    """A bound computed anew, from another stream of random numbers than the planner's."""
    with several_cores(workers or usable_cores()), progress("bound") as tell:
        rng = np.random.default_rng([seed, 1])
        return lower_bound(with_count(study, count), rng, progress=tell)
