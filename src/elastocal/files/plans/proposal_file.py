"""Plans as they are read back: believed only after they have been judged."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import PlanFileError
from elastocal.files.plans.covariance_section import claimed_covariance
from elastocal.files.plans.done_section import read_done
from elastocal.files.plans.known_section import read_known
from elastocal.files.plans.load_case_entries import columns, finite_at, read_load_cases
from elastocal.files.plans.via_points import VIA, read_via, split_via
from elastocal.files.tables.csv_table import FORCES, PLAIN, TORQUES, is_table, read_table
from elastocal.files.tables.units import UNITS, split_header
from elastocal.files.texts import is_version, json_document, read_text, text_hash
from elastocal.names import LONGEST, flaw, shown
from elastocal.planning.remaining import knowing
from elastocal.robot.chain import Robot
from elastocal.study.criteria import CRITERIA, RENAMED, RHO0
from elastocal.study.known import Known
from elastocal.study.study import Done, Study, with_count
from elastocal.study.two_steps import with_known

_LONGEST_TEXT = 10_000  # of a remark
_TORQUES = ("Tx", "Ty", "Tz")


@dataclass(frozen=True)
class Proposal:
    """A plan as somebody claims it, not yet believed.

    Attributes:
        name: Name of the file.
        load_cases: S load cases.
        repeats: (S,) how often each is measured.
        claims: What the file says of itself: rho0 [m], lower_bound [m], efficiency,
            standard_error {joint: rad/(N·m)}, criteria {name: SI}; whatever is there.
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

    @property
    def count(self) -> int:
        """Number of experiments m."""
        return int(self.repeats.sum())


def read_proposal(path: str | Path, study: Study) -> Proposal:
    """A plan file: JSON, or a table of load cases in any form that measurement files may have.

    Raises:
        PlanFileError: not a plan, or not for this robot; names row, column or key.
    """
    path = Path(path)
    if is_table(path):
        return _read_csv(path, study.robot)
    return _read_json(read_text(path), path, study.robot)


def study_for(proposal: Proposal, study: Study) -> Study:
    """The study as a plan was made for it: its count, its criterion, what was known before."""
    study = replace(study, criterion=proposal.criterion or study.criterion)
    if proposal.known is not None and study.known is None:
        study = with_known(study, proposal.known)
    if proposal.done is not None:
        study = knowing(study, proposal.done)
    return with_count(study, proposal.count, study.experiments.max_configurations)


def document_of(text: str, path: Path) -> Any:
    """The content of a plan.json, with the study it was written with.

    Raises:
        PlanFileError: not JSON, not a plan, of another version, or with a text of the study that
            is not the one whose hash stands beside it.
    """
    document = json_document(text, path, PlanFileError)
    if not isinstance(document, dict) or document.get("kind") != "plan":
        raise PlanFileError(f'{path}: not a plan file; expected JSON with "kind": "plan"')
    if not is_version(document.get("elastocal")):
        raise PlanFileError(
            f"{path}: format version {document.get('elastocal')!r} is not known; "
            "this program reads 1"
        )
    _check_texts(document, path)
    _refuse_edited(_section(document, "study"), path)
    return document


def _refuse_edited(origin: dict[str, Any], path: Path) -> None:
    """Refuse a text of the study that was changed inside the plan."""
    text, digest = origin.get("text"), origin.get("sha256")
    if isinstance(text, str) and text and digest is not None and text_hash(text) != digest:
        raise PlanFileError(
            f"{path}: the text of the study in it is not the one its sha256 stands for, so it was "
            "changed after planning; plan again from the study that is meant, or export the run "
            "sheet (CSV) with --study"
        )


def _check_texts(document: Any, path: Path) -> None:
    """Refuse keys that cannot be names, and texts but that of the study with signs unseen."""
    left: list[tuple[str, Any]] = [("", document)]
    while left:
        place, value = left.pop()
        texts, inner, longest = [], [], LONGEST
        if isinstance(value, dict):
            texts = list(value)
            inner = [(f"{place}.{key}", v) for key, v in value.items()]
        elif isinstance(value, list):
            inner = [(place, v) for v in value if isinstance(v, dict | list | str)]
        elif isinstance(value, str) and place != ".study.text":
            texts, longest = [value], _LONGEST_TEXT
        if wrong := next(filter(None, (flaw(text, longest) for text in texts)), ""):
            where = f"{path}, {shown(place[1:])}" if place else str(path)
            raise PlanFileError(f"{where}: {wrong}")
        left += inner[::-1]


def bound_key(criterion: str) -> str:
    """Key of the bound on a position error; on ρ0 if nothing is said of the criterion."""
    return f"{CRITERIA.get(criterion, RHO0).key}_lower_bound_mm"


def _read_json(text: str, path: Path, robot: Robot) -> Proposal:
    document = document_of(text, path)
    entries = document.get("load_cases")
    if not isinstance(entries, list) or not entries:
        raise PlanFileError(f"{path}: load_cases must be a list with at least one load case")
    cases = read_load_cases(entries, robot, str(path))
    counts = [entry.get("repeats") for entry in entries]
    repeats = np.array([_repeats(n, f"{path}, load case {i + 1}") for i, n in enumerate(counts)])
    certificate = _section(document, "certificate")
    named = str(document.get("criterion", ""))
    criterion = _name_today(named, document)
    claims: dict[str, Any] = {
        name: finite_at(section[key], f"{path}: {key}") / unit
        for name, section, key, unit in (
            ("rho0", document, "rho0_mm", 1e3),
            ("experiments", document, "experiments", 1.0),
            ("lower_bound", certificate, bound_key(criterion), 1e3),
            ("lower_bound", certificate, f"{named}_lower_bound_mm", 1e3),
            ("efficiency", certificate, "efficiency", 1.0),
        )
        if key in section
    }
    claims["standard_error"] = {
        str(name): finite_at(entry.get("value"), f"{path}: standard_error of {name}")
        for name, entry in _section(document, "standard_error").items()
        if isinstance(entry, dict)
    }
    claims["rho0_each"] = {
        str(name): finite_at(value, f"{path}: rho0_each_mm of {name}") / 1e3
        for name, value in _section(document, "rho0_each_mm").items()
        if value is not None  # null: infinite
    }
    claims["worst_point"] = {
        str(name): finite_at(entry.get("worst_mm"), f"{path}: worst_mm of {name}") / 1e3
        for name, entry in _section(document, "paths").items()
        if isinstance(entry, dict) and entry.get("worst_mm") is not None
    }
    if "covariance" in document:
        claims["covariance"] = claimed_covariance(document["covariance"], f"{path}: covariance")
    claims["criteria"] = _claimed_criteria(_section(document, "criteria"), path)
    origin = _section(document, "study")
    seed = document.get("seed")
    return Proposal(
        path.name,
        cases,
        repeats,
        claims,
        str(origin.get("sha256", "")),
        criterion,
        seed if isinstance(seed, int) else None,
        str(origin.get("robot_sha256", "")),
        read_done(document["after"], robot, f"{path}: after") if "after" in document else None,
        read_via(document.get("via", []), robot, len(cases), str(path)),
        _free(document.get("free_joints"), robot),
        named,
        {str(k): str(v) for k, v in _section(origin, "paths_sha256").items()},
        "".join(_free([document.get("turns_with_load")], robot)),
        read_known(document["known"], robot, f"{path}: known") if "known" in document else None,
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


def _section(document: dict[str, Any], key: str) -> dict[str, Any]:
    """A section that is read only if it is one."""
    section = document.get(key)
    return section if isinstance(section, dict) else {}


def _free(names: Any, robot: Robot) -> tuple[str, ...]:
    said = names if isinstance(names, list) else []
    return tuple(name for name in robot.joint_names if name in said)


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
