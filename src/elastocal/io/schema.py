"""What a study file may contain, key by key.

Units are part of the keys. A key without its unit, or with a typing error, is an error that says
what was probably meant.
"""

from __future__ import annotations

import difflib
import math
import re
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from elastocal.errors import StudyError
from elastocal.io.yaml_lines import Located, Path_


def _number(value: Any) -> float:
    """A finite number. YAML 1.1 reads 1e-8 as text, so such text is accepted."""
    if isinstance(value, str) and re.fullmatch(r"[-+]?\d+(\.\d*)?[eE][-+]?\d+", value):
        value = float(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        hint = ""
        if isinstance(value, str) and re.match(r"[-+]?[\d.]+\s*[A-Za-z°]", value):
            hint = "; the unit belongs in the key, the value is a bare number"
        elif isinstance(value, str) and re.fullmatch(r"[-+]?\d+,\d+", value):
            hint = "; write the decimal point as '.'"
        raise ValueError(f"expected a number, found {value!r}{hint}")
    if not math.isfinite(value if isinstance(value, float) else 0.0):
        raise ValueError(f"expected a finite number, found {value}")
    if not (value == 0 or 1e-30 < abs(value) < 1e30):
        raise ValueError("expected a number of ordinary size, found one beyond 1e30 or 1e-30")
    return float(value)


def _positive(value: Any) -> float:
    number = _number(value)
    if not number > 0.0:
        raise ValueError(f"expected a positive number, found {number:g}")
    return number


def _count(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"expected a whole number, found {value!r}")
    if not 1 <= value <= 1_000_000:
        raise ValueError(f"expected a whole number from 1 to 1000000, found {value}")
    return value


def _numbers(count: int, what: str) -> BeforeValidator:
    def check(value: Any) -> list[float]:
        if not isinstance(value, list):
            raise ValueError(f"expected {what}, found {value!r}")
        if len(value) != count:
            raise ValueError(f"expected {what}, found {len(value)} values")
        return [_number(entry) for entry in value]

    return BeforeValidator(check)


def _text(value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (str, int)):
        raise ValueError(f"expected a name, found {value!r}")
    return str(value)


Number = Annotated[float, BeforeValidator(_number)]
Positive = Annotated[float, BeforeValidator(_positive)]
Count = Annotated[int, BeforeValidator(_count)]
Vector = Annotated[list[float], _numbers(3, "three numbers [x, y, z]")]
Range = Annotated[list[float], _numbers(2, "two numbers [lower, upper]")]
Name = Annotated[str, BeforeValidator(_text)]
Axis = Literal["x", "y", "z"] | Vector


class Section(BaseModel):
    """A mapping of the file; unknown keys are errors."""

    model_config = ConfigDict(extra="forbid")


class DHRowFile(Section):
    """One row of a DH table."""

    joint: Name
    theta_deg: Number = 0.0
    d_mm: Number = 0.0
    a_mm: Number = 0.0
    alpha_deg: Number = 0.0
    type: Literal["revolute", "prismatic"] = "revolute"
    sign: Literal[1, -1] = 1
    limits_deg: Range | None = None
    limits_mm: Range | None = None


class DHRobotFile(Section):
    """A robot given by its table."""

    name: Name = "robot"
    convention: Literal["modified", "classic"]
    dh: list[DHRowFile]


class ToolFile(Section):
    """Points of a tool in the flange frame."""

    tcp_mm: Vector | None = None
    load_point_mm: Vector | None = None
    markers_mm: dict[Name, Vector] | None = None


class TestPoseFile(Section):
    """A test pose: a load case with its tool, or the matrix A0."""

    __test__ = False

    name: Name | None = None
    tool: Name | None = None
    q_deg: dict[Name, Number] | list[Number] | None = None
    q_mm: dict[Name, Number] | None = None
    force_N: Vector | None = None
    torque_Nm: Vector | None = None
    regressor_Nm2: list[list[Number]] | None = None
    weight: Positive = 1.0


class ConeFile(Section):
    """Directions within an angle of an axis."""

    axis: Vector
    half_angle_deg: Positive


Direction = Literal["free"] | ConeFile


class ExperimentsFile(Section):
    """What is done."""

    tool: Name
    force_N: Vector | None = None
    max_force_N: Positive | None = None
    direction: Direction | None = None
    torque_Nm: Vector | None = None
    max_torque_Nm: Positive | None = None
    torque_direction: Direction | None = None
    count: Count
    max_configurations: Count | None = None


class InstrumentFile(Section):
    """How well a coordinate is measured."""

    sigma_mm: Positive


class BoxFile(Section):
    """A box in the base frame."""

    min: Vector
    max: Vector


class WorkspaceFile(Section):
    """Where the points of the tool may be."""

    min_z_mm: Number | None = None
    max_z_mm: Number | None = None
    min_radius_mm: Positive | None = None
    box_mm: BoxFile | None = None


class ElevationFile(Section):
    """Angle of a flange axis over the horizontal."""

    axis: Axis
    max_deg: Positive


class TiltFile(Section):
    """Angle between a flange axis and a direction of the base frame."""

    axis: Axis
    towards: Axis
    max_deg: Positive


class ConstraintsFile(Section):
    """Where the robot may go."""

    joint_limits_deg: dict[Name, Range] | None = None
    joint_limits_mm: dict[Name, Range] | None = None
    joint_margin_deg: Number = 0.0
    joint_margin_mm: Number = 0.0
    workspace: WorkspaceFile | None = None
    elevation: ElevationFile | None = None
    tilt: TiltFile | None = None


class PriorFile(Section):
    """What is known before: one of three ways to say it."""

    plan: Name | None = None
    standard_error_rad_per_Nm: dict[Name, Positive] | None = None
    information_N2m2: list[list[Number]] | None = None


class StudyFile(Section):
    """A whole study file."""

    elastocal: Literal[1]
    name: Name | None = None
    robot: Name | DHRobotFile
    identify: list[Name] | None = None
    tools: dict[Name, ToolFile] = Field(default_factory=dict)
    test_poses: list[TestPoseFile]
    experiments: ExperimentsFile
    instrument: InstrumentFile
    constraints: ConstraintsFile = Field(default_factory=ConstraintsFile)
    criterion: Name = "test-pose"
    prior: PriorFile | None = None


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
        entries: list[dict[str, Any]] = [dict(entry) for entry in error.errors()]
        # A misspelt key is also reported as missing: one mistake, one message.
        spoilt = {e["loc"][:-1] for e in entries if e["type"] == "extra_forbidden"}
        entries = [e for e in entries if e["type"] != "missing" or e["loc"][:-1] not in spoilt]
        problems = sorted(_describe(document, entry) for entry in entries)
        more = len({line for (line, _), _ in problems}) - 1
        rest = f" (and {more} more line{'s' if more > 1 else ''} to mend)" if more > 0 else ""
        raise StudyError(problems[0][1] + rest) from None


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


def _describe(document: Located, error: dict[str, Any]) -> tuple[tuple[int, int], str]:
    """((line, -depth), sentence) for one pydantic error."""
    path = _real_path(document.value, error["loc"])
    where = document.where(path)
    line = int(where.rsplit(" ", 1)[1])
    name = _spell(path)
    kind = error["type"]
    if kind == "extra_forbidden":
        sentence = f"{where}: unknown key {path[-1]!r}{_suggestion(document.value, path)}"
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
    words = ".".join(part for part in path if isinstance(part, str))
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
    "test_poses": TestPoseFile,
    "experiments": ExperimentsFile,
    "instrument": InstrumentFile,
    "constraints": ConstraintsFile,
    "workspace": WorkspaceFile,
    "elevation": ElevationFile,
    "tilt": TiltFile,
    "prior": PriorFile,
    "dh": DHRowFile,
    "box_mm": BoxFile,
    "direction": ConeFile,
    "torque_direction": ConeFile,
}


def _suggestion(root: Any, path: Path_) -> str:
    """What the unknown key at the end of `path` was probably meant to be."""
    words = [part for part in path[:-1] if isinstance(part, str) and part in _MODELS]
    allowed = list(_MODELS[words[-1] if words else ""].model_fields)
    key = str(path[-1])
    stem = re.sub(r"_(m|mm|cm|um|inch|in|rad|deg|N|kN|kg|Nm|lbf)$", "", key)
    with_unit = [name for name in allowed if re.sub(r"_(mm|deg|N|Nm|Nm2)$", "", name) == stem]
    if with_unit and with_unit[0] != key:
        reason = "the key has no unit" if stem == key else "this unit is not accepted here"
        return f": {reason}, write {with_unit[0]!r}"
    close = difflib.get_close_matches(key, allowed, 1)
    if close:
        return f"; did you mean {close[0]!r}?"
    return f"; expected one of {', '.join(allowed)}"
