"""One command per verb: read files, call one function, write a file.

Exit codes: 0 done, 1 a fault of ours or a proof that is not verified, 2 bad input, 3 infeasible,
4 not identifiable, 130 stopped by the user; `ending.py` has them.
Everything heavy is imported inside the commands, so that --help answers at once. Commands do not
import each other: what several need is in `inputs`, `planning`, `refit`, `stages` and `programs`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from elastocal.cli.number_options import Application

FAMILIES = {
    "study": ("init", "check"),
    "plan": ("plan", "evaluate"),
    "check_proof": ("check-proof",),
    "export": ("export",),
    "simulate": ("simulate",),
    "identify": ("identify", "validate"),
    "compensate": ("compensate",),
    "report": ("report",),
    "view": ("view",),
    "demo": ("demo",),
}
"""Modules of this folder with their commands, in the order in which --help lists these."""


def application(word: str = "") -> Application:
    """The command line: all commands, or those of one family if `word` is a command of it."""
    families = [family for family, verbs in FAMILIES.items() if word in verbs]
    for family in families or FAMILIES:
        import_module(f"elastocal.cli.{family}")
    app: Application = import_module("elastocal.cli.common").app
    return app


def __getattr__(name: str) -> Any:
    if name != "app":
        raise AttributeError(f"module 'elastocal.cli' has no attribute {name!r}")
    return application()
