"""Plan files: plan.json for programs, plan.csv for people; both are read back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from elastocal import __version__
from elastocal.arrays import Array, IntArray
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import PlanFileError
from elastocal.files.doubt_entries import doubt_entries
from elastocal.files.plans.blind_section import blind_section, mends_section
from elastocal.files.plans.covariance_section import covariance_section
from elastocal.files.plans.document import document_of
from elastocal.files.plans.done_section import done_section
from elastocal.files.plans.known_section import known_section
from elastocal.files.plans.load_case_entries import columns, load_case_entries, load_cases_hash
from elastocal.files.plans.path_entries import path_entries
from elastocal.files.plans.promise_section import promise_section
from elastocal.files.plans.proof_record import proof_beside
from elastocal.files.plans.proposal_file import (
    Proposal,
    bound_key,
    proposal_in,
    read_proposal,
    study_for,
)
from elastocal.files.plans.proved_section import proved_section
from elastocal.files.plans.robust_section import robust_section
from elastocal.files.plans.via_points import VIA, via_document
from elastocal.files.study.embedded_study import study_in
from elastocal.files.tables.csv_table import is_table
from elastocal.files.texts import json_text, read_text, text_hash
from elastocal.planning.assessment import Assessment, assess
from elastocal.planning.certificate import (
    Certificate,
    Progress,
    certificate,
    confirmed,
    lower_bound,
    with_proof,
)
from elastocal.planning.evaluation import beyond_reach
from elastocal.planning.plan import Plan
from elastocal.planning.proved import Proved
from elastocal.planning.to_validate import ToValidate
from elastocal.robot.chain import Robot
from elastocal.robot.joint_kinds import KINDS
from elastocal.study.criteria import CRITERIA
from elastocal.study.study import Study
from elastocal.wording import worded
from elastocal.wording.plans import NOT_TRIED
from elastocal.writing import signature, table_row, write_text


def study_hash(study: Study) -> str:
    """SHA-256 of the study file's text."""
    return text_hash(study.text)


def write_plan(plan: Plan, path: str | Path) -> None:
    """Write plan.json."""
    write_text(Path(path), _text(plan))


def _text(plan: Plan) -> str:
    """The text of plan.json."""
    return json_text(plan_document(plan))


def read_plan(
    path: str | Path,
    study: Study | None = None,
    *,
    seed: int = 0,
    progress: Progress | None = None,
) -> Plan:
    """The plan in a file, JSON or CSV by its ending.

    What the file claims of its worth is not read: assessment and certificate are computed anew,
    for the criterion and the count it was made for. `evaluate` judges its claims. What it claims to
    be proved counts if the record of the proof is beside it and shows that.

    Args:
        path: The file.
        study: The study it is for; None for the one embedded in it.
        seed: Of the bound, which takes another stream of random numbers than that of `plan`.
        progress: Told what is going on.

    Raises:
        PlanFileError: not a plan, or not for this robot; names row, column or key.
        StudyError: the embedded study cannot be read.
    """
    proposal, study = read_with_study(path, study)
    proved, _ = proof_beside(proposal, study, Path(path).parent)
    return judged(proposal, study, seed=seed, proved=proved, progress=progress)


def read_with_study(path: str | Path, study: Study | None = None) -> tuple[Proposal, Study]:
    """A plan file, read once, and the study that is given or else embedded in it.

    Raises:
        PlanFileError: not a plan, not for this robot, or without a study where none is given.
        StudyError: the embedded study cannot be read.
    """
    path = Path(path)
    if study is not None:
        return read_proposal(path, study), study
    if is_table(path):
        raise PlanFileError(f"{path}: a run sheet has no study in it; name the study with --study")
    document = document_of(read_text(path), path)
    study = study_in(document, path)
    return proposal_in(document, path, study.robot), study


def judged(
    proposal: Proposal,
    study: Study,
    *,
    seed: int = 0,
    proved: Proved | None = None,
    progress: Progress | None = None,
) -> Plan:
    """A proposal as a plan: its worth and its certificate are computed, see `read_plan`.

    Args:
        proposal: The plan as somebody claims it.
        study: The study it is for, as it is written.
        seed: Of the bound.
        proved: What is proved of the bound, which counts unless the new one refutes it.
        progress: Told what is going on.
    """
    study = study_for(proposal, study)
    bound = lower_bound(study, np.random.default_rng([seed, 1]), progress=progress)
    x = study.space.points(proposal.load_cases)
    bound = confirmed(study, bound, x, np.random.default_rng(0))
    worth = assess(study, proposal.load_cases, proposal.repeats)
    proof = certificate(study, bound, worth, proposal.count)
    if proved is not None and proved.loss <= beyond_reach(bound, proposal.count, proof.lower_bound):
        proof = with_proof(proof, bound.aim, proved)
    return Plan(
        load_cases=proposal.load_cases,
        repeats=proposal.repeats,
        assessment=worth,
        certificate=proof,
        criterion=study.criterion,
        seed=proposal.seed or 0,
        study=study,
        free_joints=proposal.free_joints,
        turns_with_load=proposal.turns_with_load,
        via=proposal.via,
        stopped_after=proposal.claims.get("stopped_after"),
        as_good=proposal.claims.get("as_good"),
        bound=bound,
    )


def plan_document(plan: Plan) -> dict[str, Any]:
    """The content of plan.json: degrees, millimetres, newtons."""
    study, worth = plan.study, plan.assessment
    robot, times = study.robot, plan.schedule
    via = via_document(robot, plan.via)
    cases = []
    for i, case in enumerate(load_case_entries(robot, plan.load_cases)):
        near = worth.nearest[i]
        kind = next(kind for kind in KINDS if kind.unit == near.unit)
        cases.append(
            case
            | {
                "repeats": int(plan.repeats[i]),
                "done_after_min": float(times.ends[i]) / 60.0,
                "nearest_constraint": {
                    "name": near.name,
                    "margin": kind.scale * near.margin,
                    "unit": kind.key,
                },
            }
        )
    springs = study.springs
    errors = zip(springs.names, springs.units, worth.standard_error, strict=True)
    return {
        "elastocal": 1,
        "kind": "plan",
        "made_by": f"elastocal {__version__}",
        "study": _origin(study),
        "criterion": plan.criterion,
        "seed": plan.seed,
        "experiments": plan.count,
        "searches": _searches(plan),
        "free_joints": list(plan.free_joints),
        **({"turns_with_load": plan.turns_with_load} if plan.turns_with_load else {}),
        "load_cases": cases,
        **via,
        "load_cases_sha256": load_cases_hash(cases, via.get("via", [])),
        "schedule": {
            "hours": times.hours,
            **{f"{what.replace(' ', '_')}_min": value for what, value in times.minutes.items()},
        },
        **({} if study.done is None else {"after": done_section(robot, study.done)}),
        **({} if study.known is None else {"known": known_section(robot, study.known)}),
        "rho0_mm": 1e3 * worth.rho0,
        "rho0_each_mm": {
            pose.name: 1e3 * rho
            for pose, rho in zip(study.test_poses, worth.rho0_each, strict=True)
        },
        **_paths(study, worth),
        "standard_error": {
            name: {"value": float(error), "unit": unit} for name, unit, error in errors
        },
        "covariance": covariance_section(study.fitted, worth.covariance),
        **promise_section(study, worth.promise),
        **robust_section(plan),
        **blind_section(plan.blind),
        **mends_section(plan.mends),
        "remarks": [worded(doubt) for doubt in plan.doubts],
        "doubts": doubt_entries(plan.doubts),
        "criteria": _criteria(worth.criteria),
        "certificate": _certificate(robot, plan.certificate),
    }


_NOT_CONCAVE = "this criterion is not concave: no bound is known"


def _searches(plan: Plan) -> dict[str, Any]:
    """How the plan was searched for."""
    said: dict[str, Any] = {"count": plan.searches, "apart": plan.apart}
    return said if plan.stopped_after is None else said | {"stopped_after": plan.stopped_after}


def _origin(study: Study) -> dict[str, Any]:
    """The study that a plan is made from, and the robot and path files it names."""
    origin: dict[str, Any] = {
        "name": study.name,
        "sha256": study_hash(study),
        "text": study.text,
    }
    if study.robot.sha256:
        origin["robot_sha256"] = study.robot.sha256
    if study.prior_file[1]:
        origin["prior_sha256"] = study.prior_file[1]
    if study.path_hashes:
        origin["paths_sha256"] = study.path_hashes
    return origin


def _paths(study: Study, worth: Assessment) -> dict[str, Any]:
    """The worst point along each path."""
    worst = path_entries(study, worth)
    return {"paths": worst} if worst else {}


def _criteria(values: dict[str, float]) -> dict[str, float]:
    lengths = {name for name in values if CRITERIA[name].is_position_error}
    return {
        f"{name}_mm" if name in lengths else name: 1e3 * value if name in lengths else value
        for name, value in values.items()
    }


def _certificate(robot: Robot, certificate: Certificate) -> dict[str, Any]:
    if certificate.kind == "none":
        return {
            "kind": "none",
            "criterion": certificate.criterion,
            "why": NOT_TRIED if certificate.stopped else _NOT_CONCAVE,
        }
    assert certificate.peak is not None
    assert certificate.support is not None
    assert certificate.weights is not None
    bound = certificate.position_bound
    return {
        "kind": certificate.kind,
        "criterion": certificate.criterion,
        # The other criteria are compared by efficiency: their losses have units of their own.
        **({} if bound is None else {bound_key(certificate): 1e3 * bound}),
        "efficiency": certificate.efficiency,
        "fresh_starts": certificate.fresh_starts,
        "attained": certificate.attained,
        "narrow_starts": certificate.narrow_starts,
        "narrow_attained": certificate.narrow_attained,
        "rarest": certificate.rarest,
        "missed": certificate.missed,
        "floored": certificate.floored,
        **({"left_out": list(map(worded, certificate.left_out))} if certificate.floored else {}),
        "peak": {
            **next(load_case_entries(robot, certificate.peak)),
            "ratio": certificate.peak_ratio,
        },
        "continuous_design": [
            case | {"weight": float(weight)}
            for case, weight in zip(
                load_case_entries(robot, certificate.support), certificate.weights, strict=True
            )
        ],
        **proved_section(certificate),
    }


def write_run_sheet(plan: Plan, path: str | Path) -> None:
    """Write plan.csv: one row per configuration, in order of execution."""
    nearest = [near.name for near in plan.assessment.nearest]
    lines = _run_sheet(plan.study.robot, plan, nearest, f"plan {text_hash(_text(plan))[:12]}")
    write_text(Path(path), "".join(lines))


def write_validation_sheet(robot: Robot, cases: ToValidate, path: str | Path) -> None:
    """Write the same of configurations to validate with."""
    write_text(Path(path), "".join(_run_sheet(robot, cases, cases.nearest, "to validate with")))


class _Executed(Protocol):
    """Load cases in order of execution; see `Plan`."""

    @property
    def load_cases(self) -> LoadCases: ...
    @property
    def repeats(self) -> IntArray: ...
    @property
    def via(self) -> tuple[Array, ...]: ...


def _run_sheet(
    robot: Robot, executed: _Executed, nearest: Sequence[str], what: str
) -> Iterator[str]:
    sealed = signature("run sheet", what)
    yield table_row([*columns(robot), "repeats", "nearest constraint", sealed])
    scale, count = robot.shown_scale, len(executed.load_cases)
    for i in range(count + 1):
        for q in executed.via[i] if executed.via else ():
            passed = [f"{value:.4f}" for value in scale * q]
            yield table_row([VIA, *passed, *["0"] * 6, 0, "passed without stopping", ""])
        if i == count:
            break
        joints = [f"{value:.4f}" for value in scale * executed.load_cases.q[i]]
        loads = [f"{value + 0.0:.9g}" for value in executed.load_cases.wrench[i]]
        yield table_row([i + 1, *joints, *loads, int(executed.repeats[i]), nearest[i], ""])
