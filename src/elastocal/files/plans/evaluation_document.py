"""A judged plan as a document for programs."""

from __future__ import annotations

from typing import Any

from elastocal.files.doubt_entries import doubt_entries
from elastocal.planning.evaluation import Evaluation
from elastocal.wording import worded


def evaluation_document(evaluation: Evaluation) -> dict[str, Any]:
    """What `evaluate --json` says of one plan: millimetres; standard errors in SI."""
    worth, proof, view = evaluation.assessment, evaluation.certificate, evaluation.view
    bound = proof.position_bound
    doubts = (*evaluation.objections, *evaluation.unidentified)
    return {
        "experiments": evaluation.count,
        "configurations": len(evaluation.repeats),
        "rho0_mm": 1e3 * worth.rho0,
        "lower_bound_mm": None if bound is None else 1e3 * bound,
        "efficiency": proof.efficiency,
        "standard_error": worth.standard_error.tolist(),
        "seen": None if view is None else dict(zip(view.markers, view.seen.tolist(), strict=True)),
        "accepted": evaluation.accepted,
        "objections": [worded(doubt) for doubt in doubts],
        "doubts": doubt_entries(doubts),
    }
