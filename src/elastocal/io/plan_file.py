"""Plan files: plan.json for programs, plan.csv for people; both can be read back."""

from __future__ import annotations

import csv
import hashlib
import io
import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from elastocal import __version__
from elastocal.arrays import Array, IntArray
from elastocal.certification import Certificate
from elastocal.criteria import POSITION_ERRORS
from elastocal.errors import InputError, PlanFileError
from elastocal.io.compliance_units import unit_of
from elastocal.io.files import finite, read_text, write_text
from elastocal.io.joint_values import configuration
from elastocal.load_case import LoadCases
from elastocal.planning import Plan
from elastocal.robot import Robot
from elastocal.study import Study

LARGEST = 1e9
"""Numbers beyond this are mistakes in any unit of these files."""


@dataclass(frozen=True)
class Proposal:
    """A plan as somebody claims it, not yet believed.

    Attributes:
        name: Name of the file.
        load_cases: S load cases.
        repeats: (S,) how often each is measured.
        claims: What the file says of itself: rho0 [m], lower_bound [m], efficiency,
            standard_error {joint: rad/(N·m)}; whatever is there.
        study_hash: Hash of the study it was made from, empty if not said.
        criterion: Criterion it was made for, empty if not said.
        seed: Seed of the search, None if not said.
        robot_hash: Hash of the robot file it was made with, empty if not said.
    """

    name: str
    load_cases: LoadCases
    repeats: IntArray
    claims: dict[str, Any] = field(default_factory=dict)
    study_hash: str = ""
    criterion: str = ""
    seed: int | None = None
    robot_hash: str = ""


def study_hash(study: Study) -> str:
    """SHA-256 of the study file's text."""
    return hashlib.sha256(study.text.encode()).hexdigest()


def write_plan(plan: Plan, path: str | Path) -> None:
    """Write plan.json."""
    document = finite(plan_document(plan))
    write_text(Path(path), json.dumps(document, indent=2, ensure_ascii=False) + "\n")


def plan_document(plan: Plan) -> dict[str, Any]:
    """The content of plan.json: degrees, millimetres, newtons."""
    study, worth = plan.study, plan.assessment
    robot, times = study.robot, plan.schedule
    cases = []
    for i, case in enumerate(_cases(robot, plan.load_cases)):
        near = worth.nearest[i]
        scale, unit = {"rad": (180.0 / np.pi, "deg"), "m": (1e3, "mm")}.get(
            near.unit, (1.0, near.unit)
        )
        cases.append(
            case
            | {
                "repeats": int(plan.repeats[i]),
                "done_after_min": float(times.ends[i]) / 60.0,
                "nearest_constraint": {
                    "name": near.name,
                    "margin": scale * near.margin,
                    "unit": unit,
                },
            }
        )
    springs = study.springs
    errors = zip(springs.names, springs.prismatic, worth.standard_error, strict=True)
    return {
        "elastocal": 1,
        "kind": "plan",
        "made_by": f"elastocal {__version__}",
        "study": _origin(study),
        "criterion": plan.criterion,
        "seed": plan.seed,
        "experiments": plan.count,
        "free_joints": list(plan.free_joints),
        "load_cases": cases,
        "schedule": {
            "hours": times.hours,
            **{f"{what.replace(' ', '_')}_min": value for what, value in times.minutes.items()},
        },
        "rho0_mm": 1e3 * worth.rho0,
        "rho0_each_mm": {
            pose.name: 1e3 * rho
            for pose, rho in zip(study.test_poses, worth.rho0_each, strict=True)
        },
        "standard_error": {
            name: {"value": float(error), "unit": unit_of("compliance", bool(slides))}
            for name, slides, error in errors
        },
        "criteria": _criteria(worth.criteria),
        "certificate": _certificate(robot, plan.certificate),
    }


def _origin(study: Study) -> dict[str, str]:
    """The study that a plan is made from, and the robot file it names."""
    origin = {"name": study.name, "sha256": study_hash(study), "text": study.text}
    return origin | ({"robot_sha256": study.robot.sha256} if study.robot.sha256 else {})


def _criteria(values: dict[str, float]) -> dict[str, float]:
    return {
        f"{k}_mm" if k in POSITION_ERRORS else k: 1e3 * v if k in POSITION_ERRORS else v
        for k, v in values.items()
    }


def _certificate(robot: Robot, certificate: Certificate) -> dict[str, Any]:
    if certificate.kind == "none":
        return {
            "kind": "none",
            "criterion": certificate.criterion,
            "why": "this criterion is not concave: no bound is known",
        }
    assert certificate.peak is not None
    assert certificate.support is not None
    assert certificate.weights is not None
    key = {
        "test-pose": "rho0_lower_bound_mm",
        "worst": "worst_lower_bound_mm",
        "G": "G_lower_bound_mm",
    }.get(certificate.criterion)
    # The other criteria are compared by efficiency: their losses 1/√φ have units of their own.
    bound = {key: 1e3 * certificate.lower_bound} if key else {}
    return {
        "kind": certificate.kind,
        "criterion": certificate.criterion,
        **bound,
        "efficiency": certificate.efficiency,
        "fresh_starts": certificate.fresh_starts,
        "attained": certificate.attained,
        "floored": certificate.floored,
        "peak": next(_cases(robot, certificate.peak)) | {"ratio": certificate.peak_ratio},
        "continuous_design": [
            case | {"weight": float(weight)}
            for case, weight in zip(
                _cases(robot, certificate.support), certificate.weights, strict=True
            )
        ],
    }


def _cases(robot: Robot, cases: LoadCases) -> Iterator[dict[str, Any]]:
    for q, wrench in zip(cases.q, cases.wrench, strict=True):
        entry: dict[str, Any] = {"q_deg": {}}
        for joint, value in zip(robot.joints, q, strict=True):
            if joint.prismatic:
                entry.setdefault("q_mm", {})[joint.name] = 1e3 * float(value)
            else:
                entry["q_deg"][joint.name] = float(np.degrees(value))
        entry["force_N"] = [float(v) for v in wrench[:3]]
        entry["torque_Nm"] = [float(v) for v in wrench[3:]]
        yield entry


def write_run_sheet(plan: Plan, path: str | Path) -> None:
    """Write plan.csv: one row per configuration, in order of execution."""
    robot = plan.study.robot
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*_columns(robot), "repeats", "nearest constraint"])
    for i in range(len(plan.load_cases)):
        scale = robot.shown_scale
        joints = [f"{value:.4f}" for value in scale * plan.load_cases.q[i]]
        loads = [f"{value + 0.0:.9g}" for value in plan.load_cases.wrench[i]]
        near = plan.assessment.nearest[i].name
        writer.writerow([i + 1, *joints, *loads, int(plan.repeats[i]), near])
    write_text(Path(path), out.getvalue())


def _columns(robot: Robot) -> list[str]:
    joints = [f"{j.name} [{'mm' if j.prismatic else 'deg'}]" for j in robot.joints]
    forces = [f"F{axis} [N]" for axis in "xyz"] + [f"T{axis} [N.m]" for axis in "xyz"]
    return ["configuration", *joints, *forces]


def read_proposal(path: str | Path, study: Study) -> Proposal:
    """A plan file, JSON or CSV by its ending.

    Raises:
        PlanFileError: not a plan, or not for this robot; names row, column or key.
    """
    path = Path(path)
    text = read_text(path)
    if path.suffix.lower() == ".csv":
        return _read_csv(text, path, study.robot)
    return _read_json(text, path, study.robot)


def document_of(text: str, path: Path) -> Any:
    """The content of a plan.json.

    Raises:
        PlanFileError: not JSON, not a plan, or of another version.
    """
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise PlanFileError(
            f"{path}, line {error.lineno}, column {error.colno}: not valid JSON: {error.msg}"
        ) from None
    except RecursionError:
        raise PlanFileError(f"{path}: nested too deeply") from None
    except ValueError as error:
        raise PlanFileError(f"{path}: not valid JSON: {error}") from None
    if not isinstance(document, dict) or document.get("kind") != "plan":
        raise PlanFileError(f'{path}: not a plan file; expected JSON with "kind": "plan"')
    if document.get("elastocal") != 1:
        raise PlanFileError(
            f"{path}: format version {document.get('elastocal')!r} is not known; "
            "this program reads 1"
        )
    return document


def _read_json(text: str, path: Path, robot: Robot) -> Proposal:
    document = document_of(text, path)
    entries = document.get("load_cases")
    if not isinstance(entries, list) or not entries:
        raise PlanFileError(f"{path}: load_cases must be a list with at least one load case")
    q = np.zeros((len(entries), len(robot.joints)))
    wrench = np.zeros((len(entries), 6))
    repeats = np.zeros(len(entries), dtype=np.int64)
    for i, entry in enumerate(entries):
        where = f"{path}, load case {i + 1}"
        if not isinstance(entry, dict):
            raise PlanFileError(f"{where}: expected a section of keys")
        q[i] = _joints(entry, robot, where)
        wrench[i, :3] = _vector(entry.get("force_N"), f"{where}: force_N")
        wrench[i, 3:] = _vector(entry.get("torque_Nm", [0, 0, 0]), f"{where}: torque_Nm")
        repeats[i] = _repeats(entry.get("repeats"), where)
    claims: dict[str, Any] = {}
    if "rho0_mm" in document:
        claims["rho0"] = _finite(document["rho0_mm"], f"{path}: rho0_mm") / 1e3
    if "experiments" in document:
        claims["experiments"] = _finite(document["experiments"], f"{path}: experiments")
    certificate = document.get("certificate", {})
    if isinstance(certificate, dict):
        if "rho0_lower_bound_mm" in certificate:
            bound = _finite(certificate["rho0_lower_bound_mm"], f"{path}: rho0_lower_bound_mm")
            claims["lower_bound"] = bound / 1e3
        if "efficiency" in certificate:
            claims["efficiency"] = _finite(certificate["efficiency"], f"{path}: efficiency")
    errors = document.get("standard_error", {})
    if isinstance(errors, dict):
        claims["standard_error"] = {
            str(name): _finite(entry.get("value"), f"{path}: standard_error of {name}")
            for name, entry in errors.items()
            if isinstance(entry, dict)
        }
    study = document.get("study", {})
    origin = study if isinstance(study, dict) else {}
    seed = document.get("seed")
    return Proposal(
        path.name,
        LoadCases(q, wrench),
        repeats,
        claims,
        str(origin.get("sha256", "")),
        str(document.get("criterion", "")),
        seed if isinstance(seed, int) else None,
        str(origin.get("robot_sha256", "")),
    )


def _joints(entry: dict[str, Any], robot: Robot, where: str) -> Array:
    values = {}
    for key in ("q_deg", "q_mm"):
        section = entry.get(key, {})
        if not isinstance(section, dict):
            raise PlanFileError(f"{where}: {key} must give values by joint name")
        values[key] = {k: _finite(v, f"{where}: {key} of {k}") for k, v in section.items()}
    try:
        return configuration(robot, values["q_deg"], values["q_mm"])
    except InputError as error:
        raise PlanFileError(f"{where}: {error}") from None


def _finite(value: Any, where: str) -> float:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not number or not abs(value) < LARGEST:
        raise PlanFileError(f"{where}: expected a finite number, found {str(value)[:40]}")
    return float(value)


def _vector(value: Any, where: str) -> list[float]:
    if not isinstance(value, list) or len(value) != 3:
        raise PlanFileError(f"{where}: expected three numbers [x, y, z], found {value!r}")
    return [_finite(entry, where) for entry in value]


def _repeats(value: Any, where: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 1_000_000:
        raise PlanFileError(f"{where}: repeats must be a whole number from 1, found {value!r}")
    return value


def _read_csv(text: str, path: Path, robot: Robot) -> Proposal:
    try:
        lines = list(enumerate(csv.reader(io.StringIO(text, newline=None)), 1))
    except csv.Error as error:
        raise PlanFileError(f"{path}: not a table of comma-separated values: {error}") from None
    rows = [(number, row) for number, row in lines if any(cell.strip() for cell in row)]
    if len(rows) < 2:
        raise PlanFileError(f"{path}: expected a header and at least one configuration")
    header = [cell.strip() for cell in rows[0][1]]
    wanted = [*_columns(robot)[1:], "repeats"]
    optional = {f"T{axis} [N.m]" for axis in "xyz"}
    for column in wanted:
        if column not in header and column not in optional:
            bare = column.split(" [")[0]
            near = [cell for cell in header if cell.split(" [")[0] == bare]
            hint = f", found {near[0]!r}" if near else ""
            raise PlanFileError(f"{path}, line {rows[0][0]}: column {column!r} is missing{hint}")
    table = np.zeros((len(rows) - 1, len(wanted)))
    for i, (number, row) in enumerate(rows[1:]):
        if len(row) != len(header):
            raise PlanFileError(
                f"{path}, line {number}: {len(row)} cells where the header has {len(header)}"
            )
        for j, column in enumerate(wanted):
            if column in header:
                cell = row[header.index(column)].strip()
                where = f"{path}, line {number}, column {column!r}"
                table[i, j] = _cell(cell, where)
    n = len(robot.joints)
    scale = np.where(robot.prismatic, 1e-3, np.pi / 180.0)
    repeats = table[:, -1]
    for i, (number, _) in enumerate(rows[1:]):
        if repeats[i] != round(repeats[i]) or not 1 <= repeats[i] <= 1_000_000:
            raise PlanFileError(
                f"{path}, line {number}: repeats must be a whole number from 1, "
                f"found {repeats[i]:g}"
            )
    cases = LoadCases(table[:, :n] * scale, table[:, n : n + 6])
    return Proposal(path.name, cases, repeats.astype(np.int64))


def _cell(cell: str, where: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        raise PlanFileError(f"{where}: expected a number, found {cell!r}") from None
    if not abs(value) < LARGEST:
        raise PlanFileError(f"{where}: expected a finite number, found {cell[:40]!r}")
    return value
