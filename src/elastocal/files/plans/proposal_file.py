"""Plans as they are read back: believed only after they have been judged."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError, PlanFileError
from elastocal.files.compliance_units import factor_to_si
from elastocal.files.plans.certificate_section import CertifiedDesign, certified_design
from elastocal.files.plans.covariance_section import claimed_covariance
from elastocal.files.plans.document import document_of
from elastocal.files.plans.done_section import read_done
from elastocal.files.plans.known_section import read_known
from elastocal.files.plans.load_case_entries import (
    columns,
    finite_at,
    load_cases_hash,
    read_load_cases,
)
from elastocal.files.plans.plan_schema import PlannedCasesFile, check_kinds
from elastocal.files.plans.promise_section import claimed_promise
from elastocal.files.plans.proved_section import claimed_proof
from elastocal.files.plans.robust_section import claimed_standing
from elastocal.files.plans.via_points import VIA, read_via, split_via
from elastocal.files.tables.csv_table import FORCES, PLAIN, TORQUES, is_table, read_table
from elastocal.files.tables.units import UNITS, split_header
from elastocal.files.texts import read_text
from elastocal.planning.certificate import Certificate
from elastocal.planning.remaining import knowing
from elastocal.robot.chain import Robot
from elastocal.robot.joint_kinds import KINDS
from elastocal.study.before import Done
from elastocal.study.criteria import CRITERIA, RENAMED, RHO0
from elastocal.study.known import Known
from elastocal.study.study import Study, with_load_cases
from elastocal.study.two_steps import with_known

_TORQUES = ("Tx", "Ty", "Tz")


@dataclass(frozen=True)
class Proposal:
    """A plan as somebody claims it, not yet believed.

    Attributes:
        name: Name of the file.
        load_cases: S load cases.
        repeats: (S,) how often each is measured.
        claims: What the file says of itself: rho0 [m], lower_bound [m], efficiency,
            standard_error {joint: rad/(N·m)}, criteria {name: SI}; whatever is there. What it
            claims to be proved, a `Proved`; None if that is nothing.
        study_hash: Hash of the study it was made from, empty if not said.
        criterion: Criterion it was made for, by the name it has today; empty if not said.
        named: What the file calls that criterion.
        seed: Seed of the search, None if not said.
        robot_hash: Hash of the robot file it was made with, empty if not said.
        path_hashes: Hashes of the path files of its study, by name; empty if not said.
        done: What was measured before it, None if nothing.
        via: Configurations passed on the way, see `motion.Vias`; empty if there are none.
        free_joints: Joints whose values do not matter, empty if not said.
        turns_with_load: Joint that may turn together with the load, empty if not said.
        known: What it knew of further springs, None if nothing.
        prior_hash: Hash of the plan that was carried out before it, empty if not said.
        edited: Whether its load cases are others than when it was written.
        certified: The continuous design its certificate rests on, None if there is none.
    """

    name: str
    load_cases: LoadCases
    repeats: IntArray
    claims: dict[str, Any] = field(default_factory=dict)
    study_hash: str = ""
    criterion: str = ""
    seed: int | None = None
    robot_hash: str = ""
    done: Done | None = None
    via: tuple[Array, ...] = ()
    free_joints: tuple[str, ...] = ()
    named: str = ""
    path_hashes: dict[str, str] = field(default_factory=dict)
    turns_with_load: str = ""
    known: Known | None = None
    prior_hash: str = ""
    edited: bool = False
    certified: CertifiedDesign | None = None

    @property
    def count(self) -> int:
        """Number of experiments m."""
        return int(self.repeats.sum())


def read_proposal(path: str | Path, study: Study) -> Proposal:
    """A plan file: JSON, or a table of load cases in any form that measurement files may have.

    Raises:
        PlanFileError: not a plan, or not for this robot; names row, column or key.
    """
    return proposal_at(Path(path), study.robot)


def proposal_at(path: Path, robot: Robot) -> Proposal:
    """The plan in a file, for a robot; as `read_proposal`."""
    if is_table(path):
        return _read_csv(path, robot)
    return proposal_in(document_of(read_text(path), path), path, robot)


def study_for(proposal: Proposal, study: Study) -> Study:
    """The study as a plan was made for it: its count, its criterion, what was known before."""
    study = replace(study, criterion=proposal.criterion or study.criterion)
    if proposal.known is not None and study.known is None:
        study = with_known(study, proposal.known)
    if proposal.done is not None:
        study = knowing(study, proposal.done)
    return with_load_cases(study, proposal.repeats)


PROMISE_BOUND = "promise_lower_bound_mm"
"""Key of the bound on what plans promise."""


def bound_key(certificate: Certificate) -> str:
    """Key of the bound on a position error, or on a promise."""
    return PROMISE_BOUND if certificate.promise else _key_of(certificate.criterion)


def _key_of(criterion: str) -> str:
    """Key of the bound on a position error; on ρ0 if nothing is said of the criterion."""
    return f"{CRITERIA.get(criterion, RHO0).key}_lower_bound_mm"


def proposal_in(document: dict[str, Any], path: Path, robot: Robot) -> Proposal:
    """The plan in the document of a plan.json.

    Raises:
        PlanFileError: a section is wrong, or not for this robot; names the key.
    """
    entries = document.get("load_cases")
    if not isinstance(entries, list) or not entries:
        raise PlanFileError(f"{path}: load_cases must be a list with at least one load case")
    cases = read_load_cases(entries, robot, str(path))
    counts = [entry.get("repeats") for entry in entries]
    repeats = np.array([_repeats(n, f"{path}, load case {i + 1}") for i, n in enumerate(counts)])
    check_kinds({"load_cases": entries}, path, PlannedCasesFile)
    certificate = _section(document, "certificate")
    certified = certified_design(certificate, robot, f"{path}: certificate")
    named = document.get("criterion") or ""
    criterion = _name_today(named, document)
    if criterion and criterion not in CRITERIA:
        raise PlanFileError(
            f"{path}: criterion: expected one of {', '.join(CRITERIA)}, found {named!r}"
        )
    claims: dict[str, Any] = {
        name: finite_at(section[key], f"{path}: {key}") / unit
        for name, section, key, unit in (
            ("rho0", document, "rho0_mm", 1e3),
            ("experiments", document, "experiments", 1.0),
            ("lower_bound", certificate, _key_of(criterion), 1e3),
            ("lower_bound", certificate, PROMISE_BOUND, 1e3),
            ("lower_bound", certificate, f"{named}_lower_bound_mm", 1e3),
            ("efficiency", certificate, "efficiency", 1.0),
        )
        if key in section
    }
    claims["standard_error"] = {
        name: _claimed_error(name, entry, robot, f"{path}: standard_error of {name}")
        for name, entry in _section(document, "standard_error").items()
    }
    claims["rho0_each"] = {
        name: finite_at(value, f"{path}: rho0_each_mm of {name}") / 1e3
        for name, value in _section(document, "rho0_each_mm").items()
        if value is not None  # null: infinite
    }
    claims["worst_point"] = {
        name: finite_at(entry["worst_mm"], f"{path}: worst_mm of {name}") / 1e3
        for name, entry in _section(document, "paths").items()
        if entry.get("worst_mm") is not None
    }
    if "covariance" in document:
        claims["covariance"] = claimed_covariance(document["covariance"], f"{path}: covariance")
    claims |= _claimed_promise(_section(document, "promise"), robot, f"{path}: promise")
    claims["as_good"] = claimed_standing(document.get("robust"), f"{path}: robust")
    if certificate.get("kind"):
        claims["kind"] = certificate["kind"]
    if certificate.get("criterion"):
        claims["certified"] = _name_today(certificate["criterion"], document)
    claims["proved"] = claimed_proof(certificate, f"{path}: certificate")
    claims["unchecked"] = _unchecked(document, certificate)
    claims["criteria"] = _claimed_criteria(_section(document, "criteria"), path)
    origin = _section(document, "study")
    claims["stopped_after"] = _section(document, "searches").get("stopped_after")
    via = read_via(document.get("via", []), robot, len(cases), str(path))
    digest = document.get("load_cases_sha256")
    return Proposal(
        path.name,
        cases,
        repeats,
        claims,
        origin.get("sha256", ""),
        criterion,
        document.get("seed"),
        origin.get("robot_sha256", ""),
        read_done(document["after"], robot, f"{path}: after") if "after" in document else None,
        via,
        _free(document.get("free_joints") or [], robot, path),
        named,
        _section(origin, "paths_sha256"),
        "".join(name for name in robot.joint_names if name == document.get("turns_with_load")),
        read_known(document["known"], robot, f"{path}: known") if "known" in document else None,
        origin.get("prior_sha256", ""),
        bool(digest) and digest != load_cases_hash(entries, document.get("via", [])),
        certified,
    )


_UNCHECKED = ("after", "blind", "mends", "robust", "schedule", "searches")
_SEARCHED = (
    *("fresh_starts", "attained", "narrow_starts", "narrow_attained", "rarest", "missed"),
    *("floored", "peak", "continuous_design"),
)
_SAID = ("done_after_min", "nearest_constraint")


def _unchecked(document: dict[str, Any], certificate: dict[str, Any]) -> tuple[str, ...]:
    """What a plan says that nobody can recompute from the study, or that nothing follows from."""
    cases = document["load_cases"]
    return (
        *(key for key in _UNCHECKED if key in document),
        *(key for key in _SAID if any(key in case for case in cases)),
        *(f"{key} of the certificate" for key in _SEARCHED if key in certificate),
    )


def _name_today(named: str, document: dict[str, Any]) -> str:
    """The criterion of a plan: a name that meant a length when it was written is another now."""
    old = f"{named}_mm" in _section(document, "criteria")
    old = old or f"{named}_lower_bound_mm" in _section(document, "certificate")
    return RENAMED[named] if old and named in RENAMED else named


def _claimed_criteria(section: dict[str, Any], path: Path) -> dict[str, float]:
    """Values of criteria in SI; lengths have their unit in the key, also under an old name."""
    claimed = {}
    for key, value in section.items():
        bare = key.removesuffix("_mm")
        name = RENAMED.get(bare, bare) if bare != key else key
        known = name in CRITERIA and CRITERIA[name].is_position_error == (bare != key)
        if known and value is not None:  # null: infinite
            scale = 1e3 if bare != key else 1.0
            claimed[name] = finite_at(value, f"{path}: criteria, {key}") / scale
    return claimed


def _claimed_promise(section: dict[str, Any], robot: Robot, where: str) -> dict[str, Any]:
    """What a plan claims of its promise, and of the nuisance behind it."""
    errors = _section(section, "standard_error").items()
    nuisance = _section(section, "nuisance").items()
    return {
        "promise": claimed_promise(section, where),
        "promise_each": {
            name: finite_at(value, f"{where}: rho0_each_mm of {name}") / 1e3
            for name, value in _section(section, "rho0_each_mm").items()
            if value is not None  # null: infinite
        },
        "promise_error": {
            name: _claimed_error(name, entry, robot, f"{where}: standard_error of {name}")
            for name, entry in errors
            if entry.get("value") is not None
        },
        "nuisance": {
            name: finite_at(entry["standard_uncertainty"], f"{where}: nuisance, {name}")
            for name, entry in nuisance
            if entry.get("standard_uncertainty") is not None
        },
        "errors": _section(section, "errors"),
    }


def _claimed_error(name: str, entry: dict[str, Any], robot: Robot, where: str) -> float:
    """A standard error in SI, whatever the unit it is given in."""
    kinds = [joint.kind for joint in robot.joints if joint.name == name] or list(KINDS)
    value, unit = finite_at(entry.get("value"), where), entry.get("unit", kinds[0].compliance)
    if unit in [kind.unit for kind in KINDS]:  # of a displacement that no load makes
        return value
    for kind in kinds[::-1]:
        try:
            return value * factor_to_si(unit, kind.compliance)
        except InputError as error:
            wrong = error
    raise PlanFileError(f"{where}: {wrong}")


def _section(document: dict[str, Any], key: str) -> dict[str, Any]:
    """A section, empty if it is not there."""
    return document.get(key) or {}


def _free(names: list[str], robot: Robot, path: Path) -> tuple[str, ...]:
    """Names of joints, in the order of the chain."""
    try:
        return tuple(robot.joint_names[i] for i in sorted(robot.index(names)))
    except InputError as error:
        raise PlanFileError(f"{path}: free_joints: {error}") from None


def _repeats(value: Any, where: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 1_000_000:
        raise PlanFileError(f"{where}: repeats must be a whole number from 1, found {value!r}")
    return value


def _read_csv(path: Path, robot: Robot) -> Proposal:
    table = read_table(path, PlanFileError, shows_units=True)
    for column in (*columns(robot)[1:], "repeats"):
        name = split_header(column)[0]
        if name not in table.names and name not in _TORQUES:
            raise PlanFileError(f"{path}, line {table.header_line}: column {column!r} is missing")
    units = [(joint.name, UNITS[joint.kind.quantity]) for joint in robot.joints]
    q = np.hstack([table.numbers([name], unit) for name, unit in units])
    wrench = np.zeros((len(q), 6))
    wrench[:, :3] = table.numbers(["Fx", "Fy", "Fz"], FORCES)
    for i, name in enumerate(_TORQUES, 3):
        if name in table.names:
            wrench[:, i] = table.numbers([name], TORQUES)[:, 0]
    names = table.text("configuration") if "configuration" in table.names else [""] * len(q)
    stops = np.array([name.lower() != VIA for name in names])
    repeats = table.numbers(["repeats"], PLAIN)[:, 0]
    for (line, _), count, stop in zip(table.rows, repeats, stops, strict=True):
        if stop and not (count == round(count) and 1 <= count <= 1_000_000):
            raise PlanFileError(
                f"{path}, line {line}: repeats must be a whole number from 1, found {count:g}"
            )
    if not stops.any():
        raise PlanFileError(f"{path}: expected at least one configuration that is measured")
    cases = LoadCases(q[stops], wrench[stops])
    via = split_via(q[~stops], np.cumsum(stops)[~stops], len(cases))
    return Proposal(path.name, cases, repeats[stops].astype(np.int64), via=via)
