"""Study files of absolute readings: those whose `identify` names a block, as base or geometry."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from elastocal.elastic.allowed_loads import FixedVector, Load, ThereOrNot
from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged, subset
from elastocal.elastic.typical import ERRORS
from elastocal.errors import InputError, StudyError
from elastocal.files.problems import first_problem
from elastocal.files.sections import Section, SectionError, fresh
from elastocal.files.study.constraints import ConstraintsFile, constraints_of, limits_of
from elastocal.files.study.instrument import InstrumentFile, instrument_of
from elastocal.files.study.joint_values import configuration
from elastocal.files.study.kinds import BLOCKS, LARGEST, check_version, names_blocks
from elastocal.files.study.nuisance import KnownJoints, NuisanceFile, nuisance_of
from elastocal.files.study.obstacles import Cell, clearances_of
from elastocal.files.study.pace import CampaignFile, MotionFile, pace_of
from elastocal.files.study.robot import (
    ControllerFile,
    RobotFile,
    UrdfRobotFile,
    coupling_of,
    robot_of,
)
from elastocal.files.study.springs import SpringFile, extra_springs
from elastocal.files.study.tools import ToolFile, find_tool, tool_of
from elastocal.files.study.view import view_of
from elastocal.files.texts import read_text
from elastocal.files.values import (
    Count,
    Degrees,
    Either,
    ListOrByName,
    Millimetres,
    MillimetreVector,
    Name,
    NonNegative,
    PositiveMillimetres,
    Vector,
)
from elastocal.files.yaml_lines import Located, LocatedError, at, parse
from elastocal.measuring.single_readings import of_readings
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.compensators import Compensator, turning_joint
from elastocal.robot.geometry import GROUPS
from elastocal.robot.payloads import Payload
from elastocal.study.absolute import AbsoluteStudy
from elastocal.study.absolute_plan import absolute_pose, payloads_of, planned_unknowns
from elastocal.study.study import Experiments, Study, springs_of

_DOWN = [0.0, 0.0, -9.80665]
_OPEN_MASS, _OPEN_CENTER = 10.0, 0.3  # kg, m: a payload of which next to nothing is known


class PayloadFile(Section):
    """A mass fixed to the flange."""

    mass_kg: NonNegative
    center_mm: MillimetreVector = fresh(lambda: [0.0, 0.0, 0.0])
    mass_error_kg: NonNegative = 0.0
    center_error_mm: NonNegative = 0.0


class CompensatorFile(Section):
    """A spring that holds part of the weight at a joint, as it is drawn."""

    joint: Name
    crank_mm: PositiveMillimetres
    reach_mm: PositiveMillimetres
    angle_deg: Degrees = 0.0
    rest_mm: NonNegative = 0.0


class AbsoluteExperimentsFile(Section):
    """What is read, and what hangs on the flange meanwhile."""

    tool: Name | None = None
    payload: Name | list[Name] | None = None
    count: Count | None = None
    max_configurations: Count | None = None


class AbsoluteTestPoseFile(Section):
    """A pose of the task, and what acts on the tool there besides weights."""

    name: Name | None = None
    q_deg: ListOrByName[Degrees] | None = None
    q_mm: dict[Name, Millimetres] | None = None
    force_N: Vector | None = None
    torque_Nm: Vector | None = None
    weight: NonNegative = 1.0


class AbsoluteStudyFile(Section):
    """A whole study file; the keys of every section stand beside what is made of it."""

    elastocal: Literal[1]
    name: Name | None = None
    robot: RobotFile
    identify: list[Name]
    springs: dict[Name, SpringFile] | None = None
    tools: dict[Name, ToolFile] = fresh(dict)
    payloads: dict[Name, PayloadFile] = fresh(dict)
    compensators: dict[Name, CompensatorFile] = fresh(dict)
    experiments: AbsoluteExperimentsFile = fresh(dict)
    instrument: InstrumentFile
    nuisance: Either[Literal["none", "typical"], NuisanceFile] | None = None
    geometry_prior_mm: PositiveMillimetres | None = None
    gravity_m_s2: Vector | None = None
    controller: ControllerFile = fresh(dict)
    test_poses: list[AbsoluteTestPoseFile] = fresh(list)
    constraints: ConstraintsFile = fresh(dict)
    motion: MotionFile | None = None
    campaign: CampaignFile | None = None


def is_absolute(path: str | Path) -> bool:
    """Whether a study file is of absolute readings; what is wrong with it is said by its reader."""
    try:
        value = parse(read_text(Path(path), largest=LARGEST), Path(path)).value
    except InputError:
        return False
    return isinstance(value, dict) and names_blocks(value)


def says_what_to_plan(path: str | Path) -> bool:
    """Whether a study file of absolute readings says where accuracy is judged, or how often."""
    value = parse(read_text(Path(path), largest=LARGEST), Path(path)).value
    wanted = value.get("experiments") if isinstance(value, dict) else None
    return "test_poses" in value or (isinstance(wanted, dict) and "count" in wanted)


def read_absolute_study(path: str | Path) -> AbsoluteStudy:
    """The study of absolute readings in a file.

    Raises:
        StudyError: the file is wrong, or of deflections; the message names line and key.
    """
    text = read_text(Path(path), largest=LARGEST)
    document = parse(text, Path(path))
    if not (isinstance(document.value, dict) and names_blocks(document.value)):
        raise StudyError(f"{path}: identify names no block, so this is a study of deflections")
    with _located(document):
        return _study(_validated(document), Path(path), text)


def planned_study(document: Located, path: Path, text: str) -> Study:
    """The study to plan that is in a document of absolute readings.

    Raises:
        StudyError: the file is wrong, or says not what is to be planned.
    """
    with _located(document):
        file = _validated(document)
        return _to_plan(file, _study(file, path, text), path)


def files_named(document: Located, path: Path) -> list[Path]:
    """The files that a document of absolute readings names, beside its file `path`."""
    with _located(document):
        file = _validated(document)
    names = [obstacle.mesh for obstacle in file.constraints.obstacles or ()]
    if isinstance(file.robot, UrdfRobotFile):
        names.append(file.robot.urdf)
    return [path.parent / name for name in names if name is not None]


@contextmanager
def _located(document: Located) -> Iterator[None]:
    """Within it, errors get the place in the document."""
    try:
        yield
    except LocatedError as error:
        raise StudyError(f"{document.where(error.path)}: {error}") from None


def _validated(document: Located) -> AbsoluteStudyFile:
    check_version(document)
    try:
        return AbsoluteStudyFile.of(document.value)
    except SectionError as error:
        raise StudyError(first_problem(document, error, AbsoluteStudyFile)) from None


def _study(file: AbsoluteStudyFile, path: Path, text: str) -> AbsoluteStudy:
    """The study of a validated file; every error knows its place in it."""
    with at("robot"):
        robot = robot_of(file.robot, path)
    with at():
        extra = extra_springs(file.springs or {}, robot)
    with at("identify"):
        blocks, springs = _sought(file.identify, robot, extra)
    tool = _tool(file, robot)
    payloads = []
    for name, entry in file.payloads.items():
        with at("payloads", name):
            payloads.append(_payload(name, entry, sought="payload" in blocks))
    compensators = []
    for name, one in file.compensators.items():
        with at("compensators", name):
            joint = turning_joint(robot, one.joint)
            rest = one.rest_mm / 1e3
            compensators.append(
                Compensator(name, joint, one.crank_mm, one.reach_mm, one.angle_deg, rest)
            )
    with at("identify"):
        if "compensator" in blocks and not compensators:
            raise InputError("identify names 'compensator', but none is given in compensators")
        if compensators and "compensator" not in blocks:
            raise InputError(
                "compensators are given, so identify must name 'compensator': nobody knows their "
                "stiffness"
            )
    with at("experiments"):
        hung = _hung(file)
        payload = "" if len(hung) != 1 or hung[0] == "none" else hung[0]
    with at("controller"):
        controller = coupling_of(robot, file.controller)
    with at("instrument"):
        instrument = instrument_of(file.instrument)
    with at("nuisance"):
        told = KnownJoints(file.robot if isinstance(file.robot, str) else "")
        nuisance = _without_errors(nuisance_of(file.nuisance, robot, told, springs))
    study = AbsoluteStudy(
        robot=robot,
        tool=tool,
        instrument=instrument,
        springs=springs,
        blocks=blocks,
        gravity=np.array(file.gravity_m_s2 or _DOWN),
        payloads=tuple(payloads),
        payload=payload,
        compensators=tuple(compensators),
        nuisance=nuisance,
        controller=controller,
        name=file.name or path.stem,
        text=text,
    )
    if file.geometry_prior_mm is None:
        return study
    return replace(study, geometry_prior=file.geometry_prior_mm)


def _without_errors(nuisance: Nuisance | None) -> Nuisance | None:
    """What the fit finds of the nuisance; errors of load cases are in the noise that it finds.

    Raises:
        InputError: the study gives such errors.
    """
    if nuisance is None:
        return None
    if nuisance.errors not in (CaseErrors(), ERRORS):
        raise InputError(
            "friction, discrepancy, repeatability and errors of loads are not for absolute "
            "readings, whose fit finds what the model leaves as noise; leave them out"
        )
    return replace(nuisance, errors=CaseErrors()) if len(nuisance.unknowns) else None


def _hung(file: AbsoluteStudyFile) -> list[str]:
    """Names of what hangs on the flange, in turn if there are several."""
    given = file.experiments.payload
    names = [given] if isinstance(given, str) else given or []
    for name in names:
        if name != "none" and name not in file.payloads:
            known = ", ".join(file.payloads) or "none"
            raise LocatedError(
                ("payload",), f"payload {name!r} is not defined; defined are: {known}"
            )
    return names


def _to_plan(file: AbsoluteStudyFile, study: AbsoluteStudy, path: Path) -> Study:
    """The study of experiments to plan."""
    wanted = file.experiments
    if wanted.count is None:
        raise LocatedError(("experiments",), "to plan, key 'count' is missing: the number of poses")
    if not file.test_poses:
        raise LocatedError((), "to plan, key 'test_poses' is missing: where accuracy is judged")
    robot, tool, rules = study.robot, study.tool, file.constraints
    with at("constraints"):
        limits = limits_of(robot, rules)
    with at("experiments"):
        payload, weight = payloads_of(study, _hung(file))
    if weight.any():  # it acts where its centre is
        chosen = next(p for p in study.payloads if p.name in _hung(file))
        tool = replace(tool, load_point=chosen.center)
    with at("identify"):
        unknowns = planned_unknowns(replace(study, tool=tool), limits, weight, payload)
    poses = []
    for i, pose in enumerate(file.test_poses):
        with at("test_poses", i):
            q = configuration(robot, pose)
            wrench = np.append(pose.force_N or [0.0] * 3, pose.torque_Nm or [0.0] * 3)
            case, name = LoadCases(q[None], wrench[None]), pose.name or f"test pose {i + 1}"
            of = study, unknowns, payload, case
            poses.append(absolute_pose(*of, name=name, weight=pose.weight))
    force: Load = ThereOrNot(weight) if weight.any() else FixedVector(np.zeros(3))
    with at("constraints"):
        constraints = constraints_of(rules, tool)
        cell = Cell(robot, tool, limits, study.gravity, path.parent)
        constraints += clearances_of(rules.obstacles, rules.collision, rules.floor, cell)
    reflectors = file.tools.get(tool.name)
    constraints += view_of(robot, tool, reflectors, file.instrument.tracker, constraints)
    count, most = wanted.count, wanted.max_configurations
    with at("experiments"):
        experiments = Experiments(tool, force, count, most, weighs=True, payload=payload)
    pace = pace_of(file.motion, file.campaign, robot, limits)
    with at("constraints"):
        return Study(
            robot=robot,
            springs=unknowns.columns,
            test_poses=tuple(poses),
            experiments=experiments,
            instrument=of_readings(study.instrument),
            pace=pace,
            gravity=study.gravity,
            constraints=constraints,
            limits=limits,
            prior=unknowns.prior,
            nuisance=unknowns.nuisance,
            controller=study.controller,
            name=study.name,
            text=study.text,
        )


def _sought(
    names: list[str], robot: Robot, extra: dict[str, VirtualJoints]
) -> tuple[tuple[str, ...], VirtualJoints]:
    """What is sought: blocks, with `geometry` as its groups, and springs."""
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"identify lists {twice!r} twice")
    both = [name for name in names if name in BLOCKS and name in (*robot.joint_names, *extra)]
    if both:
        raise InputError(
            f"{both[0]!r} is a block of unknowns and the name of a joint or spring; rename that"
        )
    blocks = [name for name in names if name in BLOCKS and name != "geometry"]
    if "geometry" in names:
        blocks += [group for group in GROUPS if group not in blocks]
    joints = [name for name in names if name not in BLOCKS and name not in extra]
    unknown = [name for name in joints if name not in robot.joint_names]
    if unknown:
        raise InputError(
            f"{unknown[0]!r} is no block, joint or spring; expected some of {', '.join(BLOCKS)}, "
            f"{', '.join((*robot.joint_names, *extra))}"
        )
    found = _none(robot)
    if joints:
        found = merged(found, springs_of(robot, joints))
    for name in names:
        if name in extra:
            found = merged(found, extra[name])
    return tuple(blocks), found


def _none(robot: Robot) -> VirtualJoints:
    """No springs."""
    return subset(joint_springs(robot), ())


def _tool(file: AbsoluteStudyFile, robot: Robot) -> Tool:
    """The tool with its reflectors; if none is named, one reflector somewhere on the flange."""
    tools = dict(robot.tools)
    for name, entry in file.tools.items():
        with at("tools", name):
            tools[name] = tool_of(name, entry)
    if file.experiments.tool is not None:
        with at("experiments"):
            tool = find_tool(tools, file.experiments.tool)
    elif len(file.tools) == 1:
        tool = tools[next(iter(file.tools))]
    elif file.tools:
        raise LocatedError(
            ("experiments",), f"say which tool is read: tool is one of {', '.join(file.tools)}"
        )
    else:
        tool = Tool("reflector", np.zeros(3), np.zeros((1, 3)), ("reflector",))
    return replace(tool, rotation=file.instrument.measures == "pose")


def _payload(name: str, entry: PayloadFile, *, sought: bool) -> Payload:
    """A payload; one that is sought without an uncertainty is hardly known."""
    mass, center = entry.mass_error_kg, entry.center_error_mm / 1e3
    if sought and not mass and not center:
        mass, center = _OPEN_MASS, _OPEN_CENTER
    return Payload(name, entry.mass_kg, np.array(entry.center_mm), mass, center)
