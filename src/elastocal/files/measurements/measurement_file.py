"""Measurement files: from tables of the field to `Measurements`, and the canonical CSV.

In: one file, or several with the same columns, or several matched row by row. Out: deflections
in the base frame, SI units, each with its covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from elastocal.arrays import Array, BoolArray, unset
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.columns import (
    AXES,
    DEFLECTIONS,
    FORCES,
    MASS,
    POSITION,
    ROTATION,
    TORQUES,
    missing,
)
from elastocal.files.measurements.experiments import grouped
from elastocal.files.measurements.gathered import OpenFiles, opened, rows_of, used_alone
from elastocal.files.measurements.placed import placed
from elastocal.files.measurements.pose_rows import told_apart
from elastocal.files.measurements.readings import Readings, deflections, differences, markers
from elastocal.files.measurements.selection import chosen_word, usable
from elastocal.files.measurements.suspicious import doubts, unused
from elastocal.files.measurements.table import Table, kept
from elastocal.files.measurements.turns import within_limits
from elastocal.files.measurements.uncertainty import kind_of_uncertainty, matrices
from elastocal.files.measurements.writing import write_measurements
from elastocal.files.tables.units import split_header
from elastocal.measuring.measurements import Measurements
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.posture import Posture
from elastocal.study.study import Study

__all__ = ["read_measurements", "write_measurements"]

_READ = frozenset((*AXES, *DEFLECTIONS, *ROTATION.values))
_TURNS = frozenset(ROTATION.columns)
_CHUNK = 50_000  # experiments; bounds the memory for body frames


def read_measurements(
    path: str | Path | Sequence[str | Path],
    study: Study,
    mapping: str | Path | None = None,
    plan: str | Path | None = None,
) -> Measurements:
    """The measurements in a file, or in several.

    Files with the same columns are read one below the other; files with different columns, such
    as joints, forces and deflections, side by side, row by row.

    Args:
        path: File or files.
        study: The campaign: robot, calibration tool, instrument.
        mapping: Mapping file that says what foreign columns mean.
        plan: Plan whose joints and loads the experiments have by their numbers.

    Raises:
        MeasurementFileError: a file is wrong; the message names file, line and column.
    """
    turns = study.experiments.tool.rotation
    files, turned = _of_use(opened(path, study.robot, mapping, plan, rotation=turns), turns=turns)
    _check_columns(files, study)
    table, left = rows_of(files)
    shown = _measurements(table, study, files)
    found = within_limits(shown, study.robot)
    return replace(
        found,
        source=files.source,
        sha256=files.sha256,
        readings=files.with_readings(_READ),
        remarks=(*files.remarks, *left, *found.remarks),
        doubts=(
            *unused(files.free, turned, chosen=files.mapping is not None),
            *found.doubts,
            *doubts(found, study, files.units(), shown.cases.q),
        ),
    )


def _of_use(files: OpenFiles, *, turns: bool) -> tuple[OpenFiles, set[str]]:
    """The columns that this study reads; of the headers that it does not, those of rotations.

    Where rotations are measured, a row may lack the rotation, or have it alone.
    """
    turned = {c.header for some in files.columns for c in some.values() if c.meaning.key in _TURNS}
    may_lack = (*POSITION.columns, *_TURNS) if turns else ()
    files = used_alone(files, may_lack, () if turns else _TURNS)
    return files, {n for n in files.free if n in turned or split_header(n)[0] in _TURNS}


def _check_columns(files: OpenFiles, study: Study) -> None:
    """Refuse what lacks a column, before any row is read."""
    found, where = files.keys, files.header
    if files.mapping is not None and files.mapping.absolute:
        raise MeasurementFileError(
            f"{files.mapping.path}: 'positions: absolute' is for studies of absolute readings, but "
            "this one is of deflections; it needs 'state', which tells loaded from unloaded"
        )
    if files.mapping is not None and (files.mapping.foot or files.mapping.orientation):
        key = "foot" if files.mapping.foot else "orientation"
        raise MeasurementFileError(
            f"{files.mapping.path}: {key!r} is for studies of absolute readings, but this one is "
            "of deflections"
        )
    for twice, why in (
        ((MASS, *FORCES), "a hanging mass and a force exclude each other"),
        (
            ("state", *DEFLECTIONS, *ROTATION.values),
            "a deflection has no state, it is loaded minus unloaded",
        ),
    ):
        also = [key for key in twice[1:] if key in found]
        if twice[0] in found and also:
            raise MeasurementFileError(f"{where}: columns {twice[0]!r} and {also[0]!r}: {why}")
    robot, many = study.robot, len(study.experiments.tool.markers) > 1

    wanted = [] if files.several and not many else ["experiment"]
    wanted += ["marker"] * many + [f"q:{joint.name}" for joint in robot.joints]
    wanted += [MASS] if MASS in found else FORCES
    wanted += TORQUES if found & set(TORQUES) else ()
    turned = found & set(ROTATION.values)
    wanted += ROTATION.values if turned else ()
    if "state" in found:
        wanted += AXES
    elif found & set(DEFLECTIONS) or not turned:
        wanted += DEFLECTIONS
    problem = missing(wanted, found, files.free, robot)
    if problem:
        if "state" not in found and found >= set(AXES) and not found & set(DEFLECTIONS):
            problem = (
                "column 'state' is missing; positions x, y, z need it to tell loaded from unloaded"
            )
        raise MeasurementFileError(f"{where}: {problem}")
    for of in (POSITION, ROTATION):
        kind_of_uncertainty(found, where, of)


def _measurements(table: Table, study: Study, files: OpenFiles) -> Measurements:
    """Measurements without their source."""
    mapping = files.mapping
    tool = study.experiments.tool
    table = told_apart(table, ("series", "station"))
    keep = usable(table)
    left_out = kept(table, ~keep)
    table = kept(table, keep) if not keep.all() else table
    loaded = chosen_word(table, "state", _STATES) if "state" in table.words else None
    marker = markers(table, tool)
    grouping = grouped(table, study.robot, loaded, study.gravity, _preloaded(table))
    if files.controller:
        grouping = replace(grouping, cases=_from_controller(grouping.cases, study))
    if loaded is None:
        readings = deflections(table, grouping, marker, tool)
    else:
        readings = differences(table, grouping, marker, tool, loaded, _names_of(left_out, tool))
    said = list(grouping.remarks)
    if files.controller is False and not study.coupling.is_identity:
        said.append(
            "joint values are taken as those of the model, not of its controller; a mapping with "
            "'joints: controller' says otherwise"
        )
    if left_out.rows:
        said.append(
            f"{left_out.rows} row{'s' if left_out.rows > 1 else ''} marked as invalid or deleted "
            "left out"
        )
    there = placed(table, readings, grouping, study, mapping)
    turns = there.turns[there.station] if len(there.turns) > 1 else there.turns
    covariance, common = _covariance(study, grouping.cases, readings, turns)
    return Measurements(
        tool,
        grouping.cases,
        grouping.names,
        readings.case,
        readings.marker,
        _turned(readings.deflection, turns),
        covariance,
        own_uncertainty=readings.six is not None,
        remarks=(*said, *readings.remarks, *there.remarks),
        doubts=there.doubts,
        placement=there.placement,
        unloaded_of=readings.unloaded,
        common=common,
    )


def _turned(vectors: Array, turns: Array) -> Array:
    """(R, 3) vectors (R, 3) by one rotation (1, 3, 3) or by those of each (R, 3, 3)."""
    if len(turns) == 1:
        return np.asarray(vectors @ turns[0].T)
    return np.asarray(np.einsum("rij,rj->ri", turns, vectors))


def _covariance(
    study: Study, cases: LoadCases, readings: Readings, turns: Array
) -> tuple[Array, Array]:
    """(R, 3, 3) covariances in the base frame: of the readings, or of the instrument for others.

    And (R, 3, e) what readings of one experiment share, where the instrument says; it is in both.
    """
    if readings.six is not None:
        own = turns @ matrices(readings.six) @ turns.transpose(0, 2, 1)
        given = np.isfinite(readings.six).all(axis=1)
        if given.all():
            return np.asarray(own), unset()
    tool, instrument = study.experiments.tool, study.instrument.single
    covariance = np.zeros((len(readings.case), 3, 3))
    turned = readings.marker == len(tool.markers)
    if not turned.all():
        if instrument.alike_everywhere:
            covariance[~turned] = instrument.covariance(np.zeros((1, 3)))
        else:
            points = _points(study.robot, tool, cases, readings)[~turned]
            covariance[~turned] = instrument.covariance(points)
    if turned.any():
        assert instrument.sigma_rotation is not None
        covariance[turned] = instrument.sigma_rotation**2 * np.eye(3)
    covariance *= readings.weight[:, None, None]
    common = unset()
    if instrument is not study.instrument:
        posture = Posture(study.robot, cases.q)
        points = np.stack([posture.point(marker).T for marker in tool.markers], axis=1)
        common = study.instrument.common(points)[readings.case, readings.marker]
        common = common * np.sqrt(readings.weight)[:, None, None]
        if readings.six is not None:
            common[given] = 0.0
        covariance += common @ common.transpose(0, 2, 1)
    if readings.six is not None:
        covariance[given] = own[given]
    return covariance, common


def _from_controller(cases: LoadCases, study: Study) -> LoadCases:
    """Load cases with the joint values of the model for those that the controller shows."""
    return replace(cases, q=study.coupling.to_model(cases.q))


_STATES = {"loaded": True, "unloaded": False, "preloaded": False}


def _preloaded(table: Table) -> BoolArray:
    """(R,) whether a row was read under the first of two loads."""
    words = table.words.get("state")
    if words is None:
        return np.zeros(table.rows, dtype=bool)
    return np.array([name.lower() == "preloaded" for name in words.names], dtype=bool)[words.codes]


def _names_of(table: Table, tool: Tool) -> set[tuple[str, str]]:
    """(experiment, marker) of every row."""
    found = []
    for key, default in (("experiment", ""), ("marker", tool.marker_names[0])):
        words = table.words.get(key)
        column = [default] * table.rows if words is None else [words.names[c] for c in words.codes]
        found.append(column)
    return set(zip(*found, strict=True))


def _points(robot: Robot, tool: Tool, cases: LoadCases, readings: Readings) -> Array:
    """(R, 3) where each marker was, unloaded [m]."""
    points = np.empty((len(readings.case), 3))
    for start in range(0, len(cases), _CHUNK):
        rows = np.flatnonzero((readings.case >= start) & (readings.case < start + _CHUNK))
        posture = Posture(robot, cases.q[start : start + _CHUNK])
        for k in range(len(tool.markers)):
            mine = rows[readings.marker[rows] == k]
            points[mine] = posture.point(tool.markers[k])[:, readings.case[mine] - start].T
    return points
