"""Files of absolute readings: from tables of the field to `Positions`.

In: files as those of deflections, with positions x, y, z of reflectors in the frame of the tracker,
joints, and whatever else tells poses, stations and payloads apart. Out: readings in SI units, each
with its covariance, in the frames of their stations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, unset
from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.absolute_doubts import with_arm
from elastocal.files.measurements.columns import (
    ANGLES,
    AXES,
    DEFLECTIONS,
    FORCES,
    MASS,
    PLACE,
    QUATERNION,
    ROTATIONS,
    TORQUES,
    TURN,
    Triple,
    missing,
)
from elastocal.files.measurements.experiments import grouped
from elastocal.files.measurements.gathered import OpenFiles, opened, rows_of, used_alone
from elastocal.files.measurements.mapping import FieldMapping
from elastocal.files.measurements.orientations import LENGTH, VECTOR, from_angles, from_four
from elastocal.files.measurements.pose_rows import (
    carried,
    hung_as_planned,
    numbered,
    on_foot,
    refuse_empty,
    told_apart,
)
from elastocal.files.measurements.readings import markers, repeated, repeats
from elastocal.files.measurements.selection import usable
from elastocal.files.measurements.suspicious import position_doubts, unused
from elastocal.files.measurements.table import Table, kept
from elastocal.files.measurements.times import times
from elastocal.files.measurements.turns import first_rows, within_limits
from elastocal.files.measurements.uncertainty import kind_of_uncertainty, matrices, variances
from elastocal.measuring.positions import FootReadings, Positions
from elastocal.measuring.single_readings import reading_covariance, turn_covariance
from elastocal.study.absolute import AbsoluteStudy

_TURNED = (*TURN.columns, *QUATERNION)


def read_positions(
    path: str | Path | Sequence[str | Path],
    study: AbsoluteStudy,
    mapping: str | Path | None = None,
    plan: str | Path | None = None,
) -> Positions:
    """The absolute readings in a file, or in several.

    Args:
        path: File or files.
        study: Robot, tool and instrument.
        mapping: Mapping file that says what foreign columns mean.
        plan: Plan whose joints and loads the poses have by their numbers.

    Raises:
        MeasurementFileError: a file is wrong; the message names file, line and column.
    """
    files = opened(path, study.robot, mapping, plan, absolute=True)
    turned = {c.header for some in files.columns for k, c in some.items() if k in _TURNED}
    foot = bool(files.mapping and files.mapping.foot)
    wide = bool(files.mapping and files.mapping.markers)
    optional = [key for key in files.keys if _may_lack(key, foot=foot, wide=wide)]
    files = used_alone(files, optional, () if study.tool.rotation else _TURNED)
    _check_columns(files, study)
    table, left = rows_of(files)
    shown, angles = _positions(table, study, files)
    found = within_limits(shown, study.robot)
    free = files.free
    found = replace(
        found,
        source=files.source,
        sha256=files.sha256,
        readings=files.with_readings(AXES),
        remarks=(*files.remarks, *left, *found.remarks),
        doubts=(
            *unused(free, turned & {*free}, chosen=files.mapping is not None),
            *position_doubts(found, study.robot, files.units(), shown.cases.q),
        ),
    )
    return with_arm(found, study, angles, _convention(files.mapping))


def _may_lack(key: str, *, foot: bool, wide: bool) -> bool:
    """Whether a cell may be empty: of an orientation; in rows of the foot, of the arm.

    Where a row has columns for every reflector, also those of one that was not seen.
    """
    return key in _TURNED or (wide if {key} & {*AXES, *PLACE.noise} else foot)


def _check_columns(files: OpenFiles, study: AbsoluteStudy) -> None:
    """Refuse what lacks a column, or has one of another kind of campaign."""
    found, where, robot = files.keys, files.header, study.robot
    if files.mapping is not None and files.mapping.absolute is False:
        raise MeasurementFileError(
            f"{files.mapping.path}: 'positions: states' is for campaigns of deflections, but the "
            "study is one of absolute readings"
        )
    if files.mapping is not None and (files.mapping.best_fit or files.mapping.rotation is not None):
        raise MeasurementFileError(
            f"{files.mapping.path}: frame: absolute readings stay in the frame of their tracker, "
            "which is found with the rest; leave 'frame' out"
        )
    other = [key for key in (*DEFLECTIONS, *ROTATIONS) if key in found]
    if other:
        raise MeasurementFileError(
            f"{where}: column {other[0]!r} is that of a deflection; a study of absolute readings "
            "needs positions x, y, z"
        )
    if MASS in found and found & {*FORCES}:
        raise MeasurementFileError(
            f"{where}: columns {MASS!r} and {min(found & {*FORCES})!r}: a hanging mass and a force "
            "exclude each other"
        )
    wanted = ["marker"] * (len(study.tool.markers) > 1)
    wanted += [f"q:{joint.name}" for joint in robot.joints]
    wanted += AXES
    for group in (FORCES, TORQUES, [f"t:{joint.name}" for joint in robot.joints]):
        wanted += group if found & {*group} else ()
    four = [key for key in QUATERNION if key in found]
    three = [key for key in ANGLES if key in found]
    if four and three:
        raise MeasurementFileError(
            f"{where}: columns {three[0]!r} and {four[0]!r} both say how the probe is turned; keep "
            "three angles or the quaternion"
        )
    wanted += QUATERNION if four else ANGLES if three else ()
    problem = missing(wanted, found, files.free, robot)
    if problem:
        raise MeasurementFileError(f"{where}: {problem}")
    if three and files.mapping is not None and files.mapping.orientation is None:
        raise MeasurementFileError(
            f"{files.mapping.path}: rx, ry and rz need 'orientation', which says what these angles "
            "are: rotation-vector, rpy, euler-xyz, euler-zyx, …"
        )
    for of in (PLACE, TURN):
        kind_of_uncertainty(found, where, of)


def _convention(mapping: FieldMapping | None) -> str:
    """What three angles of a probe are."""
    return (mapping.orientation if mapping else None) or VECTOR


def _positions(table: Table, study: AbsoluteStudy, files: OpenFiles) -> tuple[Positions, Array]:
    """Positions without their source, and the angles of their orientations as they were read."""
    mapping = files.mapping
    keep = usable(table)
    said = []
    if not keep.all():
        count = int((~keep).sum())
        said.append(f"{count} row{'s' if count > 1 else ''} marked as invalid or deleted left out")
        table = kept(table, keep)
    if mapping is not None and mapping.markers:
        unseen = np.asarray(np.isnan(table.vectors(AXES)).all(axis=1))
        if unseen.all():
            raise MeasurementFileError(f"{table.where(0)}: no row has a position")
        table = kept(table, ~unseen)
    still = on_foot(table, mapping.foot if mapping else ())
    time = times(table)
    if np.isfinite(time).any():
        time = time - np.nanmin(time)
    stations, station_names = numbered(table, "station", "series")
    if still.all():
        raise MeasurementFileError(f"{table.where(0)}: all rows are of reflectors of the foot")
    arm = told_apart(kept(table, ~still))
    keys = [f"q:{joint.name}" for joint in study.robot.joints]
    refuse_empty(arm, [*keys, *AXES, *FORCES, *TORQUES, MASS])
    marker = markers(arm, study.tool)
    grouping = grouped(arm, study.robot, None, study.gravity, np.zeros(arm.rows, dtype=bool))
    said += grouping.remarks
    cases = grouping.cases
    if files.controller:
        cases = replace(cases, q=study.coupling.to_model(cases.q))
    elif files.controller is False and not study.coupling.is_identity:
        said.append(
            "joint values are taken as those of the model, not of its controller; a mapping with "
            "'joints: controller' says otherwise"
        )
    first = first_rows(grouping.codes, len(grouping.names))  # of each pose; `told_apart` by both
    payload = carried(arm, study.payloads, study.payload)[first]
    if files.planned is not None and "payload" not in arm.words:
        cases, payload = hung_as_planned(cases, payload, study)
    mounting, mountings = numbered(arm, "mounting", "series")
    value, covariance, row, target, own = _readings(arm, marker, study, mapping)
    station = stations[~still][row]
    case, turn = grouping.codes[row], len(study.tool.markers)
    once, more = _once(arm, case, target, station, value, row, turn)
    of_arm = np.flatnonzero(~still)[row][once]
    positions = Positions(
        study.tool,
        cases,
        grouping.names,
        case[once],
        target[once],
        value[once],
        covariance[once],
        station[once],
        station_names,
        mounting=mounting[first],
        mountings=mountings,
        payload=payload,
        payloads=tuple(payload.name for payload in study.payloads),
        time=time[of_arm],
        torque=_torques(arm, grouping.codes, study),
        foot=_foot(table, still, of_arm, mapping, study, time, stations) if still.any() else None,
        own_uncertainty=own,
        remarks=(*said, *more),
    )
    turned = row[once][target[once] == turn]
    return positions, arm.vectors(ANGLES)[turned] if arm.has(*ANGLES) else np.zeros((0, 3))


def _readings(
    arm: Table, marker: IntArray, study: AbsoluteStudy, mapping: FieldMapping | None
) -> tuple[Array, Array, IntArray, IntArray, bool]:
    """Values, covariances, rows and targets of positions and orientations, in order of the rows."""
    place = arm.vectors(AXES)
    noise = _own(arm, PLACE)
    own = noise is not None
    parts = [(place, reading_covariance(study.instrument, place) if noise is None else noise)]
    rows, targets = [np.arange(arm.rows)], [marker]
    if study.tool.rotation:
        read, turn = _orientations(arm, mapping)
        if read.any():
            noise = _own(kept(arm, read), TURN)
            if noise is None:
                noise = np.broadcast_to(turn_covariance(study.instrument), (len(turn), 3, 3))
            parts.append((turn, noise))
            rows.append(np.flatnonzero(read))
            targets.append(np.full(len(turn), len(study.tool.markers)))
    row = np.concatenate(rows)
    order = np.argsort(row, kind="stable")
    value = np.concatenate([value for value, _ in parts])[order]
    covariance = np.concatenate([noise for _, noise in parts])[order]
    return value, covariance, row[order], np.concatenate(targets)[order], own


def _own(table: Table, of: Triple) -> Array | None:
    """(R, 3, 3) covariances that came with the readings, None if none did."""
    names = kind_of_uncertainty(table.numbers, "", of)
    return matrices(variances(table, names, of)) if names else None


def _orientations(arm: Table, mapping: FieldMapping | None) -> tuple[BoolArray, Array]:
    """(R,) rows with an orientation, and that as axis times angle [rad].

    Raises:
        MeasurementFileError: some of its cells are empty, a quaternion that is not of length 1.
    """
    keys = QUATERNION if arm.has(*QUATERNION) else ANGLES
    if not arm.has(*keys):
        return np.zeros(arm.rows, dtype=bool), np.zeros((0, 3))
    values = arm.vectors(keys)
    empty = np.isnan(values)
    some = np.flatnonzero(empty.any(axis=1) & ~empty.all(axis=1))
    if len(some):
        row = int(some[0])
        raise MeasurementFileError(
            f"{arm.where(row, keys[int(empty[row].argmax())])}: the cell is empty; expected a "
            f"number, or all of {', '.join(keys)} empty where nothing was read"
        )
    read = ~empty[:, 0]
    if keys == ANGLES:
        return read, from_angles(values[read], _convention(mapping))
    length = np.linalg.norm(values[read], axis=1)
    wrong = np.flatnonzero(np.abs(length - 1.0) > LENGTH)
    if len(wrong):
        row = int(np.flatnonzero(read)[wrong[0]])
        raise MeasurementFileError(
            f"{arm.where(row, 'qw')}: a quaternion has length 1, found {length[wrong[0]]:.6g}"
        )
    return read, from_four(values[read])


def _once(
    arm: Table,
    case: IntArray,
    target: IntArray,
    station: IntArray,
    value: Array,
    row: IntArray,
    turn: int,
) -> tuple[BoolArray, list[str]]:
    """(R,) readings that are no copies of one before, and what is said of copies.

    Args: `row` is where each stands, `turn` the target that is an orientation; else as `Positions`.
    """
    keep, said = np.ones(len(row), dtype=bool), list[str]()
    key = (case * (turn + 1) + target) * (int(station.max(initial=0)) + 1) + station
    if len(np.unique(key)) < len(key):
        stuck = np.isin(np.arange(len(row)), repeats(value))  # the beam broke: said below
        _refuse_far_repeats(arm, key, value, row, (target < turn) & ~stuck)
        first = np.unique(np.column_stack([key, value]), axis=0, return_index=True)[1]
        keep[:] = False
        keep[first] = True
    copies = np.flatnonzero(~keep)
    if len(copies):
        said.append(
            f"{len(copies)} reading{'s' if len(copies) > 1 else ''} repeated exactly in the same "
            f"experiment, first at {arm.where(int(row[copies[0]]))}; counted once"
        )
    again = np.setdiff1d(repeats(value), copies)
    return keep, said + repeated(arm, row[again[target[again] < turn]])


def _refuse_far_repeats(
    arm: Table, key: IntArray, value: Array, row: IntArray, points: BoolArray
) -> None:
    """Refuse readings of one reflector in one pose that cannot be of one point."""
    order = np.argsort(key, kind="stable")
    same = (key[order[1:]] == key[order[:-1]]) & points[order[1:]]
    apart = np.linalg.norm(value[order[1:]] - value[order[:-1]], axis=1)
    far = np.flatnonzero(same & (apart > _ONE_POINT))
    if len(far):
        first, again = (int(row[order[far[0] + i]]) for i in (0, 1))
        raise MeasurementFileError(
            f"{arm.where(again, AXES[0])}: this reflector was read in this pose by this station "
            f"before, {1e3 * apart[far[0]]:.4g} mm from here ({arm.line(first, again)}); expected "
            "one point: is it another reflector, or another pose?"
        )


_ONE_POINT = 0.02  # m that repeats of one point may be apart, bumps of a tracker included


def _torques(arm: Table, codes: IntArray, study: AbsoluteStudy) -> Array:
    """(N, n) means of the joint torques of each pose [N·m, N]; none if there are none."""
    keys = [f"t:{joint.name}" for joint in study.robot.joints]
    if not arm.has(*keys):
        return unset()
    refuse_empty(arm, keys)
    size = np.bincount(codes)
    return np.column_stack([np.bincount(codes, arm.numbers[key]) / size for key in keys])


def _foot(
    table: Table,
    still: BoolArray,
    of_arm: IntArray,
    mapping: FieldMapping | None,
    study: AbsoluteStudy,
    time: Array,
    station: IntArray,
) -> FootReadings:
    """Readings of reflectors that stand still, among those of the arm, which have rows `of_arm`."""
    assert mapping is not None
    rows = kept(table, still)
    refuse_empty(rows, AXES)
    words = rows.words["marker"]
    place = np.array([mapping.foot.index(n) if n in mapping.foot else -1 for n in words.names])
    position = rows.vectors(AXES)
    noise = _own(rows, PLACE)
    if np.isfinite(time).all():
        order = np.searchsorted(np.sort(time[of_arm]), time[still])
    else:  # as they are written
        order = np.searchsorted(of_arm, np.flatnonzero(still))
    return FootReadings(
        mapping.foot,
        place[words.codes],
        station[still],
        position,
        reading_covariance(study.instrument, position) if noise is None else noise,
        order,
        time[still],
    )
