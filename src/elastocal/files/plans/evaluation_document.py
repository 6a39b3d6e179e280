"""A judged plan as a document for programs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from elastocal.files.doubt_entries import doubt_entries
from elastocal.files.plans.blind_section import blind_section
from elastocal.files.plans.covariance_section import covariance_section
from elastocal.files.plans.path_entries import path_entries
from elastocal.files.plans.promise_section import promise_section
from elastocal.files.plans.proved_section import proved_section
from elastocal.planning.evaluation import Evaluation
from elastocal.study.study import Study
from elastocal.wording import worded


def evaluation_document(
    evaluation: Evaluation, study: Study, better: Mapping[str, Mapping[str, float]]
) -> dict[str, Any]:
    """What `evaluate --json` says of one plan: millimetres; standard errors in SI.

    Args:
        evaluation: The plan, judged.
        study: By which study.
        better: Share of the points at which it is better, by path and other plan.
    """
    worth, proof, view = evaluation.assessment, evaluation.certificate, evaluation.view
    bound = proof.position_bound
    doubts = (*evaluation.objections, *evaluation.unidentified)
    return {
        "measured": evaluation.measured,
        "experiments": evaluation.count,
        "configurations": len(evaluation.repeats),
        "rho0_mm": 1e3 * worth.rho0,
        "lower_bound_mm": None if bound is None else 1e3 * bound,
        "efficiency": proof.efficiency,
        "certificate": proof.kind,
        **proved_section(proof),
        "rho0_each_mm": {
            pose.name: 1e3 * rho
            for pose, rho in zip(study.test_poses, worth.rho0_each, strict=True)
        },
        "paths": {
            name: entry | {"better_than": dict(better.get(name, {}))}
            for name, entry in path_entries(study, worth).items()
        },
        "standard_error": worth.standard_error.tolist(),
        "covariance": covariance_section(study.fitted, worth.covariance),
        **promise_section(study, worth.promise),
        **blind_section(evaluation.blind),
        "after_a_loss": None
        if worth.loss is None
        else {
            "configuration": worth.loss.load_case,
            "rho0_mm": 1e3 * worth.loss.rho0 if np.isfinite(worth.loss.rho0) else None,
        },
        "seen": None if view is None else dict(zip(view.markers, view.seen.tolist(), strict=True)),
        "accepted": evaluation.accepted,
        "objections": [worded(doubt) for doubt in doubts],
        "remarks": [worded(doubt) for doubt in evaluation.remarks],
        "doubts": doubt_entries((*doubts, *evaluation.remarks)),
    }
