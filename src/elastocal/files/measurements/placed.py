"""Readings of unloaded markers beside the arm: the frame by best fit, and what does not belong."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.errors import Doubt, InputError, MeasurementFileError
from elastocal.files.measurements.experiments import Grouping
from elastocal.files.measurements.mapping import FieldMapping
from elastocal.files.measurements.pose_rows import numbered
from elastocal.files.measurements.readings import Readings
from elastocal.files.measurements.table import Table
from elastocal.measuring.misplacement import misplaced
from elastocal.measuring.placement import Placement, Unloaded, place, placeable
from elastocal.study.study import Study
from elastocal.wording.placements import by_best_fit, unlike_arm

_ABSURD = 2e-2
"""Root mean square distance from the arm beyond which no frame is taken from it [m]."""


@dataclass(frozen=True)
class Placed:
    """How readings stand in the base frame.

    Attributes:
        turns: (S, 3, 3) rotations from the frames of the stations to the base.
        station: (R,) station of each reading.
        placement: How unloaded markers fit to the arm; None if no positions are known.
        remarks: What was found by best fit.
        doubts: What does not belong to the arm.
    """

    turns: Array
    station: IntArray
    placement: Placement | None = None
    remarks: tuple[str, ...] = ()
    doubts: tuple[Doubt, ...] = ()


def placed(
    table: Table,
    readings: Readings,
    grouping: Grouping,
    study: Study,
    mapping: FieldMapping | None,
) -> Placed:
    """The readings in the base frame, and beside the arm.

    Raises:
        MeasurementFileError: a best fit is asked for that cannot be, or that is absurd.
    """
    turn = mapping.rotation if mapping and mapping.rotation is not None else np.eye(3)
    wanted = mapping is not None and mapping.best_fit
    where = "" if mapping is None else f"{mapping.path}: frame: best-fit"
    count = len(readings.case)
    if not len(readings.unloaded_at):
        if wanted:
            raise MeasurementFileError(
                f"{where} needs positions x, y, z of the unloaded arm, and here are deflections"
            )
        return Placed(turn[None], np.zeros(count, dtype=np.int64))
    station, names = numbered(table, "station", "series")
    station = station[readings.row]
    tool = study.experiments.tool
    unloaded = Unloaded(
        study.robot,
        tool.markers,
        grouping.cases.q,
        readings.case,
        readings.marker,
        readings.unloaded_at @ turn.T,
        station,
    )
    turns = np.broadcast_to(turn, (len(names), 3, 3))
    if not wanted and not placeable(unloaded):
        return Placed(turns, station)
    try:
        found = place(unloaded)
    except InputError as error:
        raise MeasurementFileError(f"{where}: {error}") from None
    doubts = misplaced(unloaded, found, grouping.names, tool.marker_names, study.coupling)
    if wanted:
        doubts = tuple(doubt for doubt in doubts if doubt.code != "readings-turned")
    else:
        return Placed(turns, station, found, (), doubts)
    if found.rms > _ABSURD:
        wrong = "; ".join(unlike_arm(doubt) for doubt in doubts)
        raise MeasurementFileError(
            f"{where}: {wrong}; expected at most {1e3 * _ABSURD:g} mm, or the frame would be "
            "wrong, too"
        ).with_doubts(*doubts)
    largest = float(np.linalg.norm(readings.deflection, axis=1).max(initial=0.0))
    turns = np.stack([fit.rotation for fit in found.fits])
    said = (by_best_fit(found.rms, found.turn_error, found.count, largest),)
    return Placed(turns, station, replace(found, chosen=True), said, doubts)
