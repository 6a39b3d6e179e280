"""Study files: from YAML in degrees and millimetres to a `Study` in SI units."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from elastocal.elastic.springs import VirtualJoints, merged, subset
from elastocal.errors import InputError, StudyError
from elastocal.files.problems import first_problem
from elastocal.files.sections import Section, SectionError, fresh
from elastocal.files.study.absolute_file import files_named, planned_study
from elastocal.files.study.constraints import ConstraintsFile, constraints_of, limits_of
from elastocal.files.study.experiments import ExperimentsFile, experiments_of
from elastocal.files.study.instrument import InstrumentFile, instrument_of
from elastocal.files.study.kinds import LARGEST, check_version, names_blocks
from elastocal.files.study.nuisance import KnownJoints, NuisanceFile, nuisance_of
from elastocal.files.study.obstacles import Cell, clearances_of
from elastocal.files.study.pace import CampaignFile, MotionFile, pace_of
from elastocal.files.study.prior import PriorFile, with_prior
from elastocal.files.study.robot import (
    CheckPoseFile,
    ControllerFile,
    RobotFile,
    UrdfRobotFile,
    coupling_of,
    known_pose_of,
    robot_of,
)
from elastocal.files.study.springs import SpringFile, extra_springs
from elastocal.files.study.test_poses import Surroundings, TestPoseFile, test_pose_of
from elastocal.files.study.tools import ToolFile, tool_of
from elastocal.files.study.view import view_of
from elastocal.files.texts import read_text
from elastocal.files.values import Either, FileName, Name, Vector
from elastocal.files.yaml_lines import Located, LocatedError, at, parse
from elastocal.robot.chain import Robot
from elastocal.robot.joint_room import outside
from elastocal.robot.pose_check import refuse_too_few
from elastocal.study.criteria import CRITERIA, RHO0
from elastocal.study.known import Known
from elastocal.study.study import Study, TestPose, check_weights, springs_of
from elastocal.study.test_path import TestPath
from elastocal.study.two_steps import with_known, with_nuisance

if TYPE_CHECKING:
    from elastocal.files.study.known import KnownOf


class StudyFile(Section):
    """A whole study file; the keys of every section stand beside what is made of it."""

    elastocal: Literal[1]
    name: Name | None = None
    robot: RobotFile
    identify: list[Name] | None = None
    springs: dict[Name, SpringFile] | None = None
    tools: dict[Name, ToolFile] = fresh(dict)
    test_poses: list[TestPoseFile]
    experiments: ExperimentsFile
    instrument: InstrumentFile
    constraints: ConstraintsFile = fresh(dict)
    criterion: Name = "test-pose"
    prior: PriorFile | None = None
    known: FileName | None = None
    nuisance: Either[Literal["none", "typical"], NuisanceFile] | None = None
    motion: MotionFile | None = None
    campaign: CampaignFile | None = None
    gravity_m_s2: Vector | None = None
    controller: ControllerFile = fresh(dict)
    check_poses: list[CheckPoseFile] = fresh(list)


def read_study(path: str | Path, known: KnownOf | None = None) -> Study:
    """The study in a file.

    Args:
        path: The file.
        known: What is known of further springs, in place of what the file says.

    Raises:
        StudyError: the file is wrong; the message names line, key, what was found and expected.
    """
    return parse_study(read_text(Path(path), largest=LARGEST), Path(path), known)


def parse_study(text: str, path: Path, known: KnownOf | None = None) -> Study:
    """The study in a text; `path` is for messages and for files named in the study."""
    document = parse(text, path)
    if isinstance(document.value, dict) and names_blocks(document.value):
        return planned_study(document, path, text)
    try:
        return _study(_validated(document), path, text, known)
    except LocatedError as error:
        raise StudyError(f"{document.where(error.path)}: {error}") from None


def named_files(text: str, path: Path) -> list[Path]:
    """The files that the study in a text names; they are beside its file `path`."""
    document = parse(text, path)
    if isinstance(document.value, dict) and names_blocks(document.value):
        return files_named(document, path)
    file = _validated(document)
    names = [
        file.robot.urdf if isinstance(file.robot, UrdfRobotFile) else None,
        file.known,
        *(() if file.prior is None else (file.prior.plan, file.prior.model)),
        *(pose.path for pose in file.test_poses),
        *(obstacle.mesh for obstacle in file.constraints.obstacles or ()),
    ]
    return [path.parent / name for name in names if name is not None]


def _validated(document: Located) -> StudyFile:
    """The document as a `StudyFile`."""
    value = document.value
    if not isinstance(value, dict):
        raise LocatedError((), f"expected keys such as 'robot:', found {type(value).__name__}")
    check_version(document)
    try:
        return StudyFile.of(value)
    except SectionError as error:
        raise StudyError(first_problem(document, error, StudyFile)) from None


def _study(file: StudyFile, path: Path, text: str, given: KnownOf | None) -> Study:
    """The study of a validated file; every error knows its place in it."""
    with at("robot"):
        robot = robot_of(file.robot, path)
    with at():
        extra = extra_springs(file.springs or {}, robot)
    with at("identify"):
        springs = _springs(robot, file.identify, extra)
    with at("known") if given is None else nullcontext():
        before = _known(robot, file, path) if given is None else given(robot)
    tools = dict(robot.tools)
    for name, entry in file.tools.items():
        with at("tools", name):
            tools[name] = tool_of(name, entry)
    probed = file.experiments.tool
    if file.instrument.measures == "pose" and probed in tools:
        with at("tools", probed):
            tools[probed] = replace(tools[probed], rotation=True)
    poses: list[TestPose | TestPath] = []
    for i, pose in enumerate(file.test_poses):
        with at("test_poses", i):
            among = Surroundings(robot, _fitted(springs, before), tools, path.parent, tuple(poses))
            poses.append(test_pose_of(pose, among))
    _check_names(poses)
    with at("experiments"):
        experiments = experiments_of(file.experiments, tools)
    tool = experiments.tool
    with at("constraints"):
        limits = limits_of(robot, file.constraints)
    _check_limits(robot, poses)
    if file.criterion not in CRITERIA:
        raise LocatedError(
            ("criterion",),
            f"criterion {file.criterion!r} is not known; expected one of {', '.join(CRITERIA)}",
        )
    if experiments.robust is not None and file.criterion != RHO0.name:
        raise LocatedError(
            ("experiments", "robust"),
            f"robust speaks of ρ0: the criterion must be {RHO0.name}, found {file.criterion!r}",
        )
    _check_involved(springs, _fitted(springs, before), poses)
    with at("controller"):
        controller = coupling_of(robot, file.controller)
    shown_poses = []
    for i, shown in enumerate(file.check_poses):
        with at("check_poses", i):
            shown_poses.append(known_pose_of(robot, tools, shown, i))
    if shown_poses:
        with at("check_poses"):
            refuse_too_few(tuple(shown_poses))
    with at("instrument"):
        instrument = instrument_of(file.instrument)
    gravity = np.array(file.gravity_m_s2 or [0.0, 0.0, 0.0])
    with at("constraints"):
        rules = file.constraints
        constraints = constraints_of(rules, tool)
        cell = Cell(robot, tool, limits, gravity, path.parent)
        constraints += clearances_of(rules.obstacles, rules.collision, rules.floor, cell)
    reflectors = file.tools.get(tool.name)
    constraints += view_of(robot, tool, reflectors, file.instrument.tracker, constraints)
    pace = pace_of(file.motion, file.campaign, robot, limits)
    with at("constraints"):
        study = Study(
            robot=robot,
            springs=springs,
            test_poses=tuple(poses),
            experiments=experiments,
            instrument=instrument,
            pace=pace,
            gravity=gravity,
            constraints=constraints,
            limits=limits,
            controller=controller,
            known_poses=tuple(shown_poses),
            criterion=file.criterion,
            name=file.name or path.stem,
            text=text,
        )
    if file.prior is not None:
        with at("prior"):
            study = with_prior(study, file.prior, path.parent)
    with at("known") if given is None else nullcontext():
        study = with_known(study, before)
    with at("nuisance"):
        told = _told(file, study)
        return with_nuisance(study, nuisance_of(file.nuisance, robot, told, _bent(study)))


def _bent(study: Study) -> VirtualJoints:
    """All springs that the study identifies, or knows."""
    if study.known is None:
        return study.springs
    return merged(study.springs, study.known.model.springs)


def _told(file: StudyFile, study: Study) -> KnownJoints:
    """What the study names that says how soft the joints are."""
    earlier = () if study.earlier is None else (study.earlier.model,)
    known = () if study.known is None or file.known is None else (study.known.model,)
    return KnownJoints(file.robot if isinstance(file.robot, str) else "", (*known, *earlier))


def _known(robot: Robot, file: StudyFile, path: Path) -> Known | None:
    """What the file of the key `known` knows."""
    if file.known is None:
        return None
    from elastocal.files.study.known import known_at

    return known_at(path.parent / file.known, robot, parse_study, file.known)


def _fitted(springs: VirtualJoints, known: Known | None) -> VirtualJoints:
    """The springs that a study with these to identify will fit."""
    if known is None:
        return springs
    others = [name for name in known.uncertain.names if name not in springs.names]
    return merged(springs, subset(known.uncertain, others))


def _check_names(poses: list[TestPose | TestPath]) -> None:
    with at("test_poses"):
        if not poses:
            raise InputError("test_poses is empty; give at least one test pose")
        names = [pose.name for pose in poses]
        for i, name in enumerate(names):
            if name in names[:i]:
                raise LocatedError((i,), f"two test poses are called {name!r}")
        check_weights([pose.weight for pose in poses])


def _check_limits(robot: Robot, poses: list[TestPose | TestPath]) -> None:
    for i, pose in enumerate(poses):
        q = () if pose.case is None else zip(robot.joints, pose.case.q[0], strict=True)
        for joint, value in q:
            if wrong := outside(joint, value):
                raise LocatedError(("test_poses", i), f"test pose {pose.name!r} has {wrong}")


def _check_involved(
    springs: VirtualJoints, fitted: VirtualJoints, poses: list[TestPose | TestPath]
) -> None:
    wanted = [fitted.names.index(name) for name in springs.names]
    if not any(np.any(pose.regressor[:, wanted]) for pose in poses if pose.weight):
        raise LocatedError(
            ("test_poses",),
            "no test pose involves any of the compliances "
            f"{', '.join(springs.names)}: their deflections are zero there",
        )


def _springs(
    robot: Robot, names: list[str] | None, extra: dict[str, VirtualJoints]
) -> VirtualJoints:
    """Springs to identify: those named, or all."""
    if names is None:
        names = [*robot.joint_names, *extra]
    in_joints = [name for name in names if name not in extra]
    found = springs_of(robot, in_joints) if in_joints or not names else None
    for name in dict.fromkeys(n for n in names if n in extra):
        found = extra[name] if found is None else merged(found, extra[name])
    if found is None:
        raise InputError("identify lists no springs; name at least one")
    return found
