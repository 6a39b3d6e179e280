"""The command line: every command reads files, calls one function, writes a file.

Exit codes: 0 done, 2 bad input, 3 infeasible, 4 not identifiable, 130 stopped by the user.
Everything heavy is imported inside the commands, so that --help answers at once.
"""

from elastocal.cli import export, plan, report, study  # the order of the commands in --help
from elastocal.cli.common import app

__all__ = ["app", "export", "plan", "report", "study"]
