"""One command per verb: read files, call one function, write a file.

Exit codes: 0 done, 1 a fault of ours, 2 bad input, 3 infeasible, 4 not identifiable, 130 stopped
by the user; `ending.py` has them.
Everything heavy is imported inside the commands, so that --help answers at once. Commands do not
import each other: what several need is in `inputs`, `planning`, `refit`, `stages` and `programs`.
"""

from importlib import import_module

from elastocal.cli.common import app

__all__ = ["app"]

FAMILIES = (
    "study",
    "plan",
    "export",
    "simulate",
    "identify",
    "compensate",
    "report",
    "view",
    "demo",
)
"""Modules of this folder, in the order in which --help lists their commands."""

for family in FAMILIES:
    import_module(f"elastocal.cli.{family}")
