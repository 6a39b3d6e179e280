"""Calibration files: a calibrated robot as JSON, read again so that it predicts the same.

`calibration_writing.py` writes them. What is asked of a file is that it is a calibration of this
robot, complete, and does not contradict itself.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.calibration.arm_model import ArmModel, State
from elastocal.calibration.calibrated_robot import CalibratedRobot, Origin, StationNoise
from elastocal.calibration.parameters import (
    BASE,
    COMPENSATOR,
    COMPLIANCE,
    PAYLOAD,
    PROBE,
    TOOL,
    Parameters,
)
from elastocal.elastic.unknowns import Unknowns
from elastocal.errors import InputError, ModelFileError
from elastocal.files.models.calibration_kind import KIND
from elastocal.files.models.calibration_schema import (
    CalibrationFile,
    FoundPayloadFile,
    GeometryFile,
    ReflectorsFile,
)
from elastocal.files.models.claims import AGREE, ProvenanceFile
from elastocal.files.problems import first_problem
from elastocal.files.sections import SectionError
from elastocal.files.study.springs import extra_springs, in_chain_order
from elastocal.files.texts import is_version, json_document, read_text
from elastocal.files.yaml_lines import Located, LocatedError, at, parse
from elastocal.matrices import is_covariance, is_symmetric
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.compensators import Compensator, turning_joint
from elastocal.robot.geometry import GeometricErrors, geometric_errors, group_of
from elastocal.robot.geometry_hash import geometry_hash
from elastocal.robot.payloads import Payload
from elastocal.robot.rotations import from_quaternions

_SMALL_ENOUGH_TO_LOCATE = 1_000_000  # bytes; a larger file is a program's, and errors go unlined


def read_calibration(path: str | Path, robot: Robot) -> CalibratedRobot:
    """The calibrated robot in a file.

    Args:
        path: The file.
        robot: The robot as drawn, as its study has it.

    Raises:
        ModelFileError: not a calibration, not of this robot, or one that contradicts itself; names
            line and key.
    """
    path = Path(path)
    text = read_text(path)
    document = json_document(text, path, ModelFileError)
    if not isinstance(document, dict) or document.get("kind") != KIND:
        kind = document.get("kind", "without kind") if isinstance(document, dict) else "other"
        raise ModelFileError(f"{path}: this is a {kind!s:.40} file, expected a {KIND}")
    if not is_version(version := document.get("elastocal")):
        raise ModelFileError(
            f"{path}: format version {version!r:.40} is not known; this program reads 1"
        )
    try:
        return _robot_of(CalibrationFile.of(document), robot)
    except SectionError as error:
        message = first_problem(_located(document, text, path), error, CalibrationFile)
    except LocatedError as error:
        message = f"{_located(document, text, path).where(error.path)}: {error}"
    raise ModelFileError(message)


def _located(document: dict[str, Any], text: str, path: Path) -> Located:
    """The document with its lines, if they can be told."""
    try:
        return parse(text if len(text) <= _SMALL_ENOUGH_TO_LOCATE else "", path)
    except InputError:
        return Located(document, {}, path)


def _robot_of(file: CalibrationFile, robot: Robot) -> CalibratedRobot:
    _refuse_another(file, robot)
    with at("tool"):
        tool = _tool(file.tool)
    with at("geometry"):
        errors = _errors(file.geometry, robot)
    compliances = _compliances(file, robot)
    payloads = _payloads(file.payloads)
    compensators = _compensators(file, robot)
    gravity = np.array(file.gravity_m_s2)
    model = ArmModel(robot, tool, errors, compliances, gravity, payloads, compensators)
    state, targets = _state(file, tool)
    parameters = _parameters(file, model, targets)
    covariance = _covariance(file, parameters)
    noise = _noise(file)
    origin = file.provenance or ProvenanceFile()
    study, measured = origin.study, origin.measurements
    return CalibratedRobot(
        model=model,
        state=state,
        parameters=parameters,
        covariance=covariance,
        seen=~_among("rests_on_prior", file.rests_on_prior, parameters.names) & ~parameters.held,
        open=_open(file.open, parameters.names),
        told=file.told,
        dof=np.inf if file.dof is None else file.dof,
        stations=tuple(base.station for base in file.bases),
        mountings=tuple(one.mounting for one in file.mountings),
        noise=noise,
        poses=file.fit.poses,
        readings=file.fit.readings,
        fitted=file.fit.rms_mm / 1e3,
        left_out=file.fit.left_out_mm / 1e3,
        loss=file.fit.loss,
        origin=Origin(
            study.name if study else "",
            study.sha256 if study else "",
            measured.name if measured else "",
            measured.sha256 if measured else "",
            tuple(origin.readings or ()),
        ),
        source=file.source,
    )


def _refuse_another(file: CalibrationFile, robot: Robot) -> None:
    if file.robot != robot.name:
        raise LocatedError(
            ("robot",), f"robot: this is a calibration of {file.robot!r:.80}, not of {robot.name!r}"
        )
    if file.geometry_sha256 != geometry_hash(robot):
        raise LocatedError(
            ("geometry_sha256",),
            "geometry_sha256: this is a calibration of a robot whose joint axes are drawn "
            f"elsewhere than those of {robot.name!r} here; errors count from the drawing, so it "
            "says nothing of this one",
        )


def _tool(file: ReflectorsFile) -> Tool:
    points = np.array([*file.markers_mm.values()]).reshape(-1, 3)
    return Tool(
        file.name,
        np.array(file.load_point_mm) / 1e3,
        points / 1e3,
        tuple(file.markers_mm),
        np.array(file.tcp_mm) / 1e3,
        file.radius_mm / 1e3,
        file.rotation,
    )


def _errors(file: dict[str, GeometryFile], robot: Robot) -> GeometricErrors:
    """The geometric errors that are named, in chain order."""
    whole = geometric_errors(robot)
    if unknown := [name for name in file if name not in whole.names]:
        raise LocatedError(
            (unknown[0],),
            f"robot {robot.name!r} has no geometric error {unknown[0]!r}; there are "
            f"{', '.join(whole.names)}",
        )
    kept = [i for i, name in enumerate(whole.names) if name in file]
    for i in kept:
        name, unit = whole.names[i], whole.kinds[i].unit
        if file[name].unit != unit:
            raise LocatedError((name, "unit"), f"{name}: expected {unit}, found {file[name].unit}")
    names = tuple(whole.names[i] for i in kept)
    if names != tuple(file):
        raise InputError(f"geometric errors must stand in chain order: {', '.join(names)}")
    return GeometricErrors(names, whole.step[kept], whole.body[kept], whole.normals, whole.shifts)


def _compliances(file: CalibrationFile, robot: Robot) -> Unknowns:
    """The compliances that were found, and the springs they make."""
    extra = extra_springs(file.springs, robot)
    shares: list[dict[str, float]] = []
    for name, entry in file.compliance.items():
        own = {name: 1.0} if entry.springs is None else entry.springs
        with at("compliance", name):
            if not any(own.values()):
                raise LocatedError(("springs",), f"{name}: it makes no spring")
            if unknown := [s for s in own if s not in extra and s not in robot.joint_names]:
                known = ", ".join([*robot.joint_names, *extra])
                raise InputError(
                    f"robot {robot.name!r} has no joint or spring {unknown[0]!r}; known are {known}"
                )
        shares.append(own)
    names = dict.fromkeys([*extra, *(s for own in shares for s in own)])
    if not names:
        from elastocal.elastic.springs import joint_springs

        return Unknowns((), joint_springs(robot, []), np.zeros((0, 0)))
    springs = in_chain_order(names, extra, robot)
    place = {name: i for i, name in enumerate(springs.names)}
    make = np.zeros((len(springs), len(shares)))
    for i, own in enumerate(shares):
        for spring, share in own.items():
            make[place[spring], i] = share
    found = Unknowns(tuple(file.compliance), springs, make)
    for name, kind in zip(found.names, found.kinds, strict=True):
        if file.compliance[name].unit != kind.compliance:
            raise LocatedError(
                ("compliance", name, "unit"),
                f"compliance of {name}: expected {kind.compliance} as unit, found "
                f"{file.compliance[name].unit!r:.40}",
            )
    return found


def _payloads(file: dict[str, FoundPayloadFile]) -> tuple[Payload, ...]:
    found = []
    for name, entry in file.items():
        with at("payloads", name):
            was = entry.thought
            center = np.array(was.center_mm) / 1e3
            errors = was.mass_error_kg, was.center_error_mm / 1e3
            found.append(Payload(name, was.mass_kg, center, *errors))
            if entry.fitted is not any(errors):
                word = "is" if entry.fitted else "is not"
                raise LocatedError(
                    ("fitted",), f"payload {name!r} {word} fitted, against the errors it had"
                )
    return tuple(found)


def _state(file: CalibrationFile, tool: Tool) -> tuple[State, IntArray]:
    """What was found, and (M, K + 1) which targets of each mounting were read."""
    _refuse_none(file)
    base = np.tile(np.eye(4), (len(file.bases), 1, 1))
    base[:, :3, :3] = from_quaternions(np.array([b.quaternion_wxyz for b in file.bases]))
    base[:, :3, 3] = np.array([b.origin_mm for b in file.bases]) / 1e3
    count = len(file.mountings)
    markers = np.tile(tool.markers, (count, 1, 1))
    probe = np.tile(np.eye(3), (count, 1, 1))
    targets = np.zeros((count, len(tool.markers) + 1), dtype=np.int64)
    for m, one in enumerate(file.mountings):
        for name, point in one.markers_mm.items():
            if name not in tool.marker_names:
                raise LocatedError(
                    ("mountings", m, "markers_mm", name),
                    f"the tool has no reflector {name!r}; there are "
                    f"{', '.join(tool.marker_names) or 'none'}",
                )
            k = tool.marker_names.index(name)
            markers[m, k], targets[m, k] = np.array(point) / 1e3, 1
        if one.probe_wxyz is not None:
            if not tool.rotation:
                raise LocatedError(
                    ("mountings", m, "probe_wxyz"), "the tool has no probe that reads rotations"
                )
            probe[m], targets[m, -1] = from_quaternions(np.array([one.probe_wxyz]))[0], 1
    payload = [[p.mass_kg, *p.moment_kg_m] for p in file.payloads.values()]
    state = State(
        base,
        markers,
        probe,
        np.array([entry.value for entry in file.geometry.values()]),
        np.array([entry.value for entry in file.compliance.values()]),
        np.array(payload).reshape(-1, 4),
        np.array([one.value for one in file.compensators.values()]),
    )
    return state, targets


def _compensators(file: CalibrationFile, robot: Robot) -> tuple[Compensator, ...]:
    found = []
    for name, one in file.compensators.items():
        with at("compensators", name):
            joint = turning_joint(robot, one.joint)
            lengths = one.crank_mm / 1e3, one.reach_mm / 1e3
            angle = float(np.radians(one.angle_deg))
            found.append(Compensator(name, joint, *lengths, angle, one.rest_mm / 1e3))
    return tuple(found)


def _refuse_none(file: CalibrationFile) -> None:
    for key, names in (
        ("bases", [base.station for base in file.bases]),
        ("mountings", [one.mounting for one in file.mountings]),
    ):
        if not names:
            raise LocatedError((key,), f"{key} is empty; expected at least one")
        if twice := [i for i, name in enumerate(names) if name in names[:i]]:
            raise LocatedError((key, twice[0]), f"two {key} are called {names[twice[0]]!r}")


def _parameters(file: CalibrationFile, model: ArmModel, targets: IntArray) -> Parameters:
    """The unknowns, as the covariance names them."""
    block: list[str] = []
    turns: list[bool] = []
    for _ in file.bases:
        block += 6 * [BASE]
        turns += 3 * [False] + 3 * [True]
    for _, k in np.argwhere(targets).tolist():
        probe = k == targets.shape[1] - 1
        block += 3 * [PROBE if probe else TOOL]
        turns += 3 * [probe]
    block += group_of(model.errors, model.robot)
    turns += [kind.unit == "rad" for kind in model.errors.kinds]
    block += len(model.compliances) * [COMPLIANCE]
    turns += [kind.unit == "rad" for kind in model.compliances.kinds]
    block += len(model.compensators) * [COMPENSATOR]
    turns += len(model.compensators) * [True]
    hung = tuple(i for i, p in enumerate(file.payloads.values()) if p.fitted)
    block += 4 * len(hung) * [PAYLOAD]
    turns += 4 * len(hung) * [False]
    names = tuple(file.covariance.order)
    found = Parameters(
        names,
        tuple(block),
        tuple(turns),
        len(file.bases),
        targets,
        len(model.errors),
        len(model.compliances),
        hung,
        held=_among("held", file.held, names),
        compensators=len(model.compensators),
    )
    held = tuple(f"compensator {one.name}" for one in model.compensators)
    own = (*model.errors.names, *model.compliances.names, *held)
    first = found.arm
    with at("covariance", "order"):
        if len(names) != len(block) or len(set(names)) != len(names):
            raise InputError(
                f"covariance: order must name {len(block)} unknowns once: 6 for each base, 3 for "
                "each reflector and probe, each geometric error, each compliance, and 4 for each "
                f"fitted payload; found {len(names)}"
            )
        if names[first : first + len(own)] != own:
            raise InputError(
                f"covariance: order must have the geometric errors and compliances from place "
                f"{first + 1} on, in their order"
            )
    return found


def _covariance(file: CalibrationFile, parameters: Parameters) -> Array:
    u = len(parameters)
    with at("covariance", "matrix"):
        if [len(row) for row in file.covariance.matrix] != u * [u]:
            raise InputError(f"covariance: matrix must be {u} rows of {u} numbers")
        matrix = np.array(file.covariance.matrix).reshape(u, u)
        if not is_symmetric(matrix):
            raise InputError("covariance: the matrix is not symmetric")
        if not is_covariance(matrix):
            raise InputError("covariance: the matrix has a negative eigenvalue")
        found = np.sqrt(np.maximum(np.diagonal(matrix), 0.0))[parameters.arm :]
        said = [(name, entry.standard_error) for name, entry in file.geometry.items()]
        said += [(name, entry.standard_error) for name, entry in file.compliance.items()]
        said += [(name, entry.standard_error) for name, entry in file.compensators.items()]
        for (name, error), own in zip(said, found.tolist(), strict=False):
            if abs(error - own) > AGREE * own:
                raise InputError(
                    f"covariance: the matrix contradicts the standard errors: that of {name} is "
                    f"{error:.6g} beside it and {own:.6g} in it"
                )
    return np.asarray(0.5 * (matrix + matrix.T))


def _among(key: str, chosen: list[str], names: tuple[str, ...]) -> BoolArray:
    """(U,) which unknowns a list names."""
    for i, name in enumerate(chosen):
        if name not in names:
            raise LocatedError((key, i), f"there is no unknown {name!r}")
    return np.array([name in chosen for name in names], dtype=bool)


def _open(file: list[dict[str, float]], names: tuple[str, ...]) -> Array:
    rows = np.zeros((len(file), len(names)))
    for r, combination in enumerate(file):
        for name, share in combination.items():
            if name not in names:
                raise LocatedError(("open", r, name), f"there is no unknown {name!r}")
            rows[r, names.index(name)] = share
    return rows


def _noise(file: CalibrationFile) -> tuple[StationNoise, ...]:
    if [one.station for one in file.noise] != [base.station for base in file.bases]:
        raise LocatedError(("noise",), "noise: expected one entry for each of the bases, in order")
    return tuple(
        StationNoise(
            one.instrument_mm / 1e3,
            one.model_shared_mm / 1e3,
            one.model_own_mm / 1e3,
            one.model_turned_mrad / 1e3,
        )
        for one in file.noise
    )
