"""`view`: the robot of a study in a local web page."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastocal.cli.common import (
    StudyPath,
    app,
    note_parted,
)

if TYPE_CHECKING:
    from elastocal.study.study import Study
    from elastocal.viewer.subject import Subject


@app.command("view")
def view_command(
    study_file: StudyPath,
    plan: Annotated[
        Path | None, typer.Option(help="Plan to step through (JSON or CSV).", show_default=False)
    ] = None,
    model: Annotated[
        list[Path] | None,
        typer.Option(help="Compliances, to show deflections; several for different joints."),
    ] = None,
    port: Annotated[int, typer.Option(help="Port on this machine.", min=1, max=65535)] = 8080,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Do not open the page in a browser.")
    ] = False,
) -> None:
    """Show the robot, its plan and its deflections in a web page on this machine only."""
    import logging

    from elastocal.cli.inputs import models_at
    from elastocal.files.study.study_file import read_study
    from elastocal.fitting.goodness import quantile
    from elastocal.viewer.live import serve
    from elastocal.viewer.local_server import check_port, viser_module

    viser_module()
    check_port(port)
    shown = _subject(read_study(study_file), plan)
    if model:
        compliances = models_at(model, shown.study.robot)
        shown = replace(shown, model=compliances, width=quantile(0.975, compliances.dof))

    def ready(address: str) -> None:
        print(f"showing {study_file} at {address} (this machine only); Ctrl-C to stop", flush=True)
        if not no_browser:
            import webbrowser

            webbrowser.open(address)

    # Whoever connects and sends nonsense would fill the terminal with what libraries log of it.
    logging.getLogger().addHandler(logging.NullHandler())
    serve(shown, port, ready)
    print("\nstopped")


def _subject(study: Study, plan: Path | None) -> Subject:
    """The study with the poses of a plan, and what its certificate tells of any place."""
    from elastocal.cli.origins import note_origin, refuse_false_claims
    from elastocal.cli.planning import note_broken
    from elastocal.files.plans.proof_record import proof_beside
    from elastocal.files.plans.proposal_file import read_proposal, study_for
    from elastocal.planning.sensitivity import sensitivity
    from elastocal.study.criteria import CRITERIA
    from elastocal.viewer.subject import Subject, stops_of
    from elastocal.wording import worded
    from elastocal.wording.proofs import claimed_kind

    if plan is None:
        return Subject(study, stops_of(study))
    note_parted([plan])
    proposal = read_proposal(plan, study)
    written, study = study, study_for(proposal, study)
    note_origin(plan.name, proposal, written, study.known)
    refuse_false_claims(plan.name, proposal, written)
    note_broken(plan.name, proposal, study)
    known = peak = None
    if proposal.certified is not None:
        known, peak = sensitivity(study, *proposal.certified), proposal.certified.peak
    stops = stops_of(study, proposal.load_cases, proposal.repeats, peak, proposal.via)
    proved, doubt = proof_beside(proposal, written, plan.parent)
    if proved is None and doubt is not None:
        print(f"note: {plan.name}: {worded(doubt)}", file=sys.stderr)
    length = CRITERIA[study.criterion].is_position_error
    said = claimed_kind(
        proposal.claims.get("kind", "none"),
        proposal.claims.get("lower_bound") if length else None,
        proved,
    )
    return Subject(study, stops, sensitivity=known, certificate=said)
