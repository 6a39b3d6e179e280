"""Options of commands that prove bounds, and what is wrong with them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from elastocal.cli.common import writable
from elastocal.errors import InputError

Prove = Annotated[
    bool,
    typer.Option("--prove", help="Also prove the bound: a theorem about the model, with a record."),
]
ProveSeconds = Annotated[
    float, typer.Option(help="Prove for so long at most; a later run goes on.", min=0.0)
]
ProveGap = Annotated[
    float,
    typer.Option(
        help="Per cent below the bound of the search that are near enough.", min=1e-4, max=99.0
    ),
]
Record = Annotated[
    Path | None,
    typer.Option("--proof", help="Record of the proof; beside the plan if not given."),
]


def refuse_record(record: Path, inputs: list[Path], *, taken: bool) -> None:
    """Refuse a file for the record that is read, or that another record is written to."""
    if taken:
        raise InputError(
            "--proof names one file, and these plans need several proofs: of other numbers of "
            "experiments, or by other criteria; leave it out, then each is beside its plan"
        )
    writable(record, *inputs)


def belongs_to_prove(prove: bool, proof: Path | None) -> None:
    """Refuse a record without a proof."""
    if proof is not None and not prove:
        raise InputError("--proof belongs to --prove, which is not given")
