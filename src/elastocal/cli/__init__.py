"""The command line: every command reads files, calls one function, writes a file.

Exit codes: 0 done, 2 bad input, 3 infeasible, 4 not identifiable, 130 stopped by the user.
Everything heavy is imported inside the commands, so that --help answers at once.
"""

from elastocal.cli import (  # the order of the commands in --help
    compensate,
    export,
    plan,
    report,
    study,
)
from elastocal.cli.common import app

__all__ = ["app", "compensate", "export", "plan", "report", "study"]
