"""`check-proof`: whether the record of a proof holds, by a checker that shares nothing with it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from elastocal.cli.common import Json, app, print_json

NOT_VERIFIED = 1
"""Exit code for a proof that does not hold, or of which not every box was bounded."""


@app.command("check-proof")
def check_proof_command(
    proof: Annotated[
        Path, typer.Argument(metavar="PROOF", help="Record of a proof.", show_default=False)
    ],
    seconds: Annotated[
        float | None, typer.Option(help="Stop after that long: then it is not verified.", min=0.0)
    ] = None,
    sample: Annotated[
        int | None,
        typer.Option(help="So many boxes by chance only: then it is not verified.", min=1),
    ] = None,
    as_json: Json = False,
) -> None:
    """Bound every box of a proof again, slowly and by other means; verified, or exit code 1."""
    from elastocal.files.plans.proof_record import LARGEST, statement_of
    from elastocal.proof.check_proof import check
    from elastocal.reading import bytes_of
    from elastocal.terminal.progress import progress
    from elastocal.terminal.proofs import show_verdict
    from elastocal.wording.proofs import boxes

    statement = statement_of(bytes_of(proof, LARGEST), proof)
    with progress("checking") as tell:

        def told(done: int, of: int) -> None:
            tell(f"{boxes(done)} of {of}", done / max(of, 1))

        verdict = check(proof, seconds=seconds, sample=sample, progress=told)
    if as_json:
        print_json(
            {
                "verified": verdict.verified,
                "complete": verdict.complete,
                "leaves": verdict.leaves,
                "checked": verdict.checked,
                "message": verdict.message,
                "lower_bound": statement.rho0,
                "experiments": statement.count,
                "criterion": statement.criterion,
                "study": statement.name,
                "study_sha256": statement.study_sha256,
                "left_out": list(statement.left_out),
            }
        )
    else:
        show_verdict(statement, proof.name, verdict.message)
    if not verdict.verified:
        raise typer.Exit(NOT_VERIFIED)
