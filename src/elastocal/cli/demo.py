"""`demo`: the whole job on the robot of the paper, with a virtual robot in place of a real one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from elastocal.cli.common import Overwrite, Seed, app


@app.command("demo")
def demo_command(
    folder: Annotated[Path, typer.Argument(help="Folder to write to.")] = Path("demo"),
    force: Overwrite = False,
    seed: Seed = 0,
) -> None:
    """Do the whole job on the KUKA KR 270 of the paper, from plan to corrected path and report."""
    from elastocal.cli.virtual_job import do_job

    do_job(folder, seed, force)
