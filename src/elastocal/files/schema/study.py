"""The whole study file, and what is said of one that is wrong."""

from __future__ import annotations

import difflib
import re
from typing import Any, Literal

from pydantic import Field, ValidationError

from elastocal.errors import StudyError
from elastocal.files.schema.campaign import CampaignFile, MotionFile
from elastocal.files.schema.constraints import (
    BoxFile,
    CollisionFile,
    ConstraintsFile,
    CylinderFile,
    ElevationFile,
    ObstacleFile,
    TiltFile,
    WorkspaceFile,
)
from elastocal.files.schema.experiments import (
    ConeFile,
    ExperimentsFile,
    InstrumentFile,
    PriorFile,
    TestPoseFile,
    TrackerFile,
)
from elastocal.files.schema.robot import (
    CheckPoseFile,
    ControllerFile,
    DHRobotFile,
    DHRowFile,
    RobotFile,
    SpringFile,
    ToolFile,
    UrdfRobotFile,
)
from elastocal.files.schema.values import Name, Section, Vector
from elastocal.files.yaml_lines import Located, Path_


class StudyFile(Section):
    """A whole study file."""

    elastocal: Literal[1]
    name: Name | None = None
    robot: RobotFile
    identify: list[Name] | None = None
    springs: dict[Name, SpringFile] | None = None
    tools: dict[Name, ToolFile] = Field(default_factory=dict)
    test_poses: list[TestPoseFile]
    experiments: ExperimentsFile
    instrument: InstrumentFile
    constraints: ConstraintsFile = Field(default_factory=ConstraintsFile)
    criterion: Name = "test-pose"
    prior: PriorFile | None = None
    motion: MotionFile | None = None
    campaign: CampaignFile | None = None
    gravity_m_s2: Vector | None = None
    controller: ControllerFile = Field(default_factory=ControllerFile)
    check_poses: list[CheckPoseFile] = Field(default_factory=list)


def validate(document: Located) -> StudyFile:
    """The document as a `StudyFile`.

    Raises:
        StudyError: the first thing that is wrong, with its line.
    """
    if not isinstance(document.value, dict):
        raise StudyError(
            f"{document.where(())}: expected keys such as 'robot:', found "
            f"{type(document.value).__name__}"
        )
    _check_version(document)
    try:
        return StudyFile.model_validate(document.value)
    except ValidationError as error:
        raise StudyError(first_problem(document, error, _MODELS)) from None


def first_problem(
    document: Located, error: ValidationError, models: dict[str, type[Section]]
) -> str:
    """A sentence on the first thing that is wrong, with its line.

    Args:
        document: The file.
        error: What pydantic says of it.
        models: Sections of such a file by their key; "" for the whole file.
    """
    entries: list[dict[str, Any]] = [dict(entry) for entry in error.errors()]
    # A misspelt key is also reported as missing: one mistake, one message.
    spoilt = {e["loc"][:-1] for e in entries if e["type"] == "extra_forbidden"}
    entries = [e for e in entries if e["type"] != "missing" or e["loc"][:-1] not in spoilt]
    problems = sorted(_describe(document, entry, models) for entry in entries)
    more = len({line for (line, _), _ in problems}) - 1
    rest = f" (and {more} more line{'s' if more > 1 else ''} to mend)" if more > 0 else ""
    return problems[0][1] + rest


def _check_version(document: Located) -> None:
    if "elastocal" not in document.value:
        raise StudyError(
            f"{document.file}: key 'elastocal' is missing; a study file begins with "
            "'elastocal: 1', the version of its format"
        )
    if document.value["elastocal"] != 1:
        raise StudyError(
            f"{document.where(('elastocal',))}: format version "
            f"{document.value['elastocal']!r} is not known; this program reads 1"
        )


def _describe(
    document: Located, error: dict[str, Any], models: dict[str, type[Section]]
) -> tuple[tuple[int, int], str]:
    """((line, -depth), sentence) for one pydantic error."""
    path = _real_path(document.value, error["loc"])
    where = document.where(path)
    line = int(where.rsplit(" ", 1)[1])
    name = _spell(path)
    kind = error["type"]
    if kind == "extra_forbidden":
        sentence = f"{where}: unknown key {path[-1]!r}{_suggestion(document.value, path, models)}"
    elif kind == "missing":
        parent = _spell(path[:-1])
        sentence = f"{where}: key {path[-1]!r} is missing" + (f" in {parent}" if parent else "")
    elif kind == "literal_error":
        sentence = f"{where}: {name}: expected {error['ctx']['expected']}, found {error['input']!r}"
    elif kind == "value_error":
        sentence = f"{where}: {name}: {error['ctx']['error']}"
    else:
        found = error["input"]
        shown = repr(found) if isinstance(found, (str, int, float)) else type(found).__name__
        expected = {
            "model_type": "a section of keys",
            "dict_type": "a section of keys",
            "list_type": "a list",
        }.get(kind, error["msg"].removeprefix("Input should be "))
        if found is None:
            shown = "nothing"
        sentence = f"{where}: {name}: expected {expected}, found {shown}"
    # A missing key has no line of its own, so it comes last; on one line the deepest comes first.
    return (line + (1_000_000 if kind == "missing" else 0), -len(path)), sentence


def _spell(path: Path_) -> str:
    """'test_poses.q_deg, entry 2' for a path; entries of lists counted from 1, the last only."""
    words = ".".join(" ".join(part.split()) for part in path if isinstance(part, str))
    last = path[-1] if path else ""
    return f"{words}, entry {last + 1}" if isinstance(last, int) else words


def _real_path(value: Any, location: tuple[str | int, ...]) -> Path_:
    """The part of a pydantic location that names keys of the file, not branches of types."""
    path: list[str | int] = []
    for i, part in enumerate(location):
        last = i == len(location) - 1
        if isinstance(value, dict) and part in value:
            value = value[str(part)]
        elif isinstance(value, list) and isinstance(part, int) and part < len(value):
            value = value[part]
        elif not (last and isinstance(value, dict)) or part == "[key]":
            continue
        path.append(part)
    return tuple(path)


_MODELS: dict[str, type[Section]] = {
    "": StudyFile,
    "robot": DHRobotFile,
    "tools": ToolFile,
    "springs": SpringFile,
    "test_poses": TestPoseFile,
    "experiments": ExperimentsFile,
    "instrument": InstrumentFile,
    "tracker": TrackerFile,
    "constraints": ConstraintsFile,
    "workspace": WorkspaceFile,
    "elevation": ElevationFile,
    "tilt": TiltFile,
    "obstacles": ObstacleFile,
    "cylinder_mm": CylinderFile,
    "capsule_mm": CylinderFile,
    "collision": CollisionFile,
    "prior": PriorFile,
    "controller": ControllerFile,
    "check_poses": CheckPoseFile,
    "motion": MotionFile,
    "campaign": CampaignFile,
    "dh": DHRowFile,
    "box_mm": BoxFile,
    "direction": ConeFile,
    "torque_direction": ConeFile,
}


def _suggestion(root: Any, path: Path_, models: dict[str, type[Section]]) -> str:
    """What the unknown key at the end of `path` was probably meant to be."""
    words = [part for part in path[:-1] if isinstance(part, str) and part in models]
    model = models[words[-1] if words else ""]
    if model is DHRobotFile and "urdf" in root["robot"]:
        model = UrdfRobotFile
    allowed = list(model.model_fields)
    key = str(path[-1])
    stem = re.sub(
        r"_(deg_s|rad_s|mm_s|m_s|m|mm|cm|um|inch|in|rad|deg|N|kN|kg|Nm|lbf|min|s|h)$", "", key
    )
    with_unit = [
        name
        for name in allowed
        if re.sub(r"_(deg_s|mm_s|mm|deg|N|Nm|Nm2|min|s)$", "", name) == stem
    ]
    if with_unit and with_unit[0] != key:
        reason = "the key has no unit" if stem == key else "this unit is not accepted here"
        return f": {reason}, write {with_unit[0]!r}"
    close = difflib.get_close_matches(key, allowed, 1)
    if close:
        return f"; did you mean {close[0]!r}?"
    return f"; expected one of {', '.join(allowed)}"
