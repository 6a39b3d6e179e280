"""Study files of absolute readings: those whose `identify` names a block, as base or geometry."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from elastocal.elastic.springs import VirtualJoints, joint_springs, merged, subset
from elastocal.errors import InputError, StudyError
from elastocal.files.problems import first_problem
from elastocal.files.sections import Section, SectionError, fresh
from elastocal.files.study.instrument import InstrumentFile, instrument_of
from elastocal.files.study.nuisance import KnownJoints, NuisanceFile, nuisance_of
from elastocal.files.study.robot import ControllerFile, RobotFile, coupling_of, robot_of
from elastocal.files.study.springs import SpringFile, extra_springs
from elastocal.files.study.study_file import BLOCKS, check_version, names_blocks, parse_study
from elastocal.files.study.tools import ToolFile, find_tool, tool_of
from elastocal.files.texts import read_text
from elastocal.files.values import (
    Either,
    MillimetreVector,
    Name,
    NonNegative,
    PositiveMillimetres,
    Vector,
)
from elastocal.files.yaml_lines import LocatedError, at, parse
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.geometry import GROUPS
from elastocal.robot.payloads import Payload
from elastocal.study.absolute import AbsoluteStudy
from elastocal.study.study import Study, springs_of

_LARGEST = 1_000_000  # bytes; a study file is a page of text
_DOWN = [0.0, 0.0, -9.80665]
_OPEN_MASS, _OPEN_CENTER = 10.0, 0.3  # kg, m: a payload of which next to nothing is known


class PayloadFile(Section):
    """A mass fixed to the flange."""

    mass_kg: NonNegative
    center_mm: MillimetreVector = fresh(lambda: [0.0, 0.0, 0.0])
    mass_error_kg: NonNegative = 0.0
    center_error_mm: NonNegative = 0.0


class AbsoluteExperimentsFile(Section):
    """What is read, and what hangs on the flange meanwhile."""

    tool: Name | None = None
    payload: Name | None = None


class AbsoluteStudyFile(Section):
    """A whole study file; the keys of every section stand beside what is made of it."""

    elastocal: Literal[1]
    name: Name | None = None
    robot: RobotFile
    identify: list[Name]
    springs: dict[Name, SpringFile] | None = None
    tools: dict[Name, ToolFile] = fresh(dict)
    payloads: dict[Name, PayloadFile] = fresh(dict)
    experiments: AbsoluteExperimentsFile = fresh(dict)
    instrument: InstrumentFile
    nuisance: Either[Literal["none", "typical"], NuisanceFile] | None = None
    geometry_prior_mm: PositiveMillimetres | None = None
    gravity_m_s2: Vector | None = None
    controller: ControllerFile = fresh(dict)


def read_any_study(path: str | Path) -> Study | AbsoluteStudy:
    """The study in a file, of deflections or of absolute readings.

    Raises:
        StudyError: the file is wrong; the message names line, key, what was found and expected.
    """
    text = read_text(Path(path), largest=_LARGEST)
    document = parse(text, Path(path))
    value = document.value
    if not (isinstance(value, dict) and names_blocks(value)):
        return parse_study(text, Path(path))
    try:
        check_version(document)
        try:
            file = AbsoluteStudyFile.of(value)
        except SectionError as error:
            raise StudyError(first_problem(document, error, AbsoluteStudyFile)) from None
        return _study(file, Path(path), text)
    except LocatedError as error:
        raise StudyError(f"{document.where(error.path)}: {error}") from None


def is_absolute(path: str | Path) -> bool:
    """Whether a study file is of absolute readings; what is wrong with it is said by its reader."""
    try:
        value = parse(read_text(Path(path), largest=_LARGEST), Path(path)).value
    except InputError:
        return False
    return isinstance(value, dict) and names_blocks(value)


def read_absolute_study(path: str | Path) -> AbsoluteStudy:
    """The study of absolute readings in a file.

    Raises:
        StudyError: the file is wrong, or of deflections.
    """
    study = read_any_study(path)
    if not isinstance(study, AbsoluteStudy):
        raise StudyError(f"{path}: identify names no block, so this is a study of deflections")
    return study


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
    with at("experiments"):
        payload = file.experiments.payload or ""
        if payload and payload not in file.payloads:
            known = ", ".join(file.payloads) or "none"
            raise LocatedError(
                ("payload",), f"payload {payload!r} is not defined; defined are: {known}"
            )
    with at("controller"):
        controller = coupling_of(robot, file.controller)
    with at("instrument"):
        instrument = instrument_of(file.instrument)
    with at("nuisance"):
        told = KnownJoints(file.robot if isinstance(file.robot, str) else "")
        nuisance = nuisance_of(file.nuisance, robot, told, springs)
    study = AbsoluteStudy(
        robot=robot,
        tool=tool,
        instrument=instrument,
        springs=springs,
        blocks=blocks,
        gravity=np.array(file.gravity_m_s2 or _DOWN),
        payloads=tuple(payloads),
        payload=payload,
        nuisance=nuisance,
        controller=controller,
        name=file.name or path.stem,
        text=text,
    )
    if file.geometry_prior_mm is None:
        return study
    return replace(study, geometry_prior=file.geometry_prior_mm)


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
