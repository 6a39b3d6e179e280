"""What holds for all tests: hypothesis tries the same in every run, Ctrl-C is heard, and no
plan asks for anything twice.

A shell takes Ctrl-C from what runs in the background, and from what that starts: the programs
under test would not stop.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

import elastocal.planning.plan as planning
import elastocal.terminal.progress as progress
from elastocal.study.study import Study

settings.register_profile("same", derandomize=True, deadline=None)
settings.load_profile("same")

os.environ["ELASTOCAL_TRACEBACK"] = "1"  # a fault of ours says where it is
progress.SILENCE = 600.0  # what a command says must not depend on how busy the machine is

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def no_plan_asks_twice() -> Iterator[None]:
    """No plan of any study of any test has two load cases of the same information.

    But plans that were made robust: of configurations that tell the same one may be lost.

    Said again in another way than the planner says it: if neither εM̄ + D nor εM̄ - D has a
    negative eigenvalue they are the same: D the difference of two informations and M̄ the mean.
    """
    search = planning._searched

    def watched(study: Study, *rest: Any) -> Any:
        found = search(study, *rest)
        if found.as_good is not None:
            return found
        each = study.space.information(found.cases)
        mean = np.einsum("i,ijk->jk", found.repeats / found.repeats.sum(), each)
        root = np.sqrt(np.where(np.diagonal(mean) > 0.0, np.diagonal(mean), 1.0))
        each, mean = each / np.outer(root, root), mean / np.outer(root, root)
        for i, j in combinations(range(len(each)), 2):
            lowest = [
                np.linalg.eigvalsh(3e-4 * mean + sign * (each[i] - each[j])).min()
                for sign in (1.0, -1.0)
            ]
            assert min(lowest) < -1e-9, f"load cases {i + 1} and {j + 1} tell the same"
        return found

    planning._searched = watched
    yield
    planning._searched = search
