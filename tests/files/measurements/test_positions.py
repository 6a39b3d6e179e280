"""Absolute readings, as trackers and controllers write them: read as they are meant."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.orientations import CONVENTIONS
from elastocal.files.measurements.positions_file import read_positions
from elastocal.measuring.positions import Positions
from elastocal.robot.controller_axes import coupling
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.study.absolute import AbsoluteStudy
from tests.files.absolute_campaign import HEADER, JOINTS, rows, study, table, truth

TRUTH = truth(5)
PLAIN = table(HEADER, rows(TRUTH))


def read(
    files: dict[str, str] | str, folder: Path, mapping: str = "", what: AbsoluteStudy | None = None
) -> Positions:
    files = {"m.csv": files} if isinstance(files, str) else files
    for name, text in files.items():
        (folder / name).write_text(text, "utf-8")
    (folder / "mapping.yaml").write_text(mapping, "utf-8")
    paths = [folder / name for name in files]
    return read_positions(paths, what or study(), folder / "mapping.yaml" if mapping else None)


def test_a_plain_file(tmp_path: Path) -> None:
    found = read(PLAIN, tmp_path)
    assert found.names == tuple("12345")
    assert (len(found), found.stations, found.mountings) == (10, ("",), ("",))
    np.testing.assert_allclose(found.cases.q, TRUTH.q, atol=1e-11)
    np.testing.assert_allclose(found.value, TRUTH.points.reshape(-1, 3), atol=1e-9)
    np.testing.assert_allclose(found.covariance[0], 3e-5**2 * np.eye(3))
    assert not found.cases.wrench.any()
    assert np.isnan(found.time).all()
    assert found.foot is None
    assert not found.torque.size
    assert found.remarks == ()
    assert found.doubts == ()
    assert len(found.sha256) == 64


# A tracker's probe, and the controller: semicolons, decimal commas, radians, spread of each axis.
PROBE = """\
elastocal: 1
positions: absolute
columns:
  q [rad]: [j1, j2, j3, j4, j5, j6]
  x y z [mm]: [meas_x, meas_y, meas_z]
  ux uy uz [mm]: [std_x, std_y, std_z]
  rx ry rz [deg]: [meas_rx, meas_ry, meas_rz]
orientation: euler-xyz
"""
_PROBE_HEADER = ["Goal", *(f"j{i}" for i in range(1, 7))]
_PROBE_HEADER += [f"{what}_{a}" for what in ("meas", "std") for a in "xyz"]
_PROBE_HEADER += ["meas_rx", "meas_ry", "meas_rz"]


def probe_file(convention: str = "XYZ") -> str:
    angles = Rotation.from_matrix(TRUTH.turns).as_euler(convention, degrees=True)
    if len({*convention.lower()}) == 3:  # each angle stands under its own axis
        angles = angles[:, [convention.lower().index(axis) for axis in "xyz"]]
    cells = [
        ["ok", *(f"{v:.10f}" for v in q), *(f"{1e3 * v:.6f}" for v in p[0]), "0.01", "0.02",
         "0.03", *(f"{v:.10f}" for v in a)]
        for q, p, a in zip(TRUTH.q, TRUTH.points, angles, strict=True)
    ]  # fmt: skip
    return table(_PROBE_HEADER, cells, ";").replace(".", ",")


def test_a_probe_by_a_mapping_of_ten_lines(tmp_path: Path) -> None:
    found = read(probe_file(), tmp_path, PROBE, study(probe=True, markers=1))
    assert len(PROBE.splitlines()) <= 10
    assert (len(found), len(found.cases)) == (10, 5)
    place, turned = found.value[~found.rotations], found.value[found.rotations]
    np.testing.assert_allclose(place, TRUTH.points[:, 0], atol=1e-9)
    np.testing.assert_allclose(from_rotation_vectors(turned), TRUTH.turns, atol=1e-9)
    assert found.own_uncertainty
    np.testing.assert_allclose(found.covariance[0], np.diag([1e-10, 4e-10, 9e-10]))
    np.testing.assert_allclose(found.covariance[1], 1e-8 * np.eye(3))
    assert found.marker.tolist() == [0, 1] * 5
    assert found.case.tolist() == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]


def test_orientations_nobody_uses_are_said(tmp_path: Path) -> None:
    found = read(probe_file(), tmp_path, PROBE, study(markers=1))
    assert len(found) == 5
    assert [doubt.code for doubt in found.doubts] == ["rotations-not-used", "columns-not-used"]


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_angles_by_every_convention(convention: str, tmp_path: Path) -> None:
    """Against another program's angles; capitals are about axes that turn along."""
    theirs = {"rpy": "ZYX"}.get(convention, convention.removeprefix("euler-").upper())
    text = probe_file("XYZ" if convention == "rotation-vector" else theirs)
    if convention == "rotation-vector":
        vectors = Rotation.from_matrix(TRUTH.turns).as_rotvec(degrees=True)
        lines = text.replace(",", ".").splitlines()
        cut = [line.rsplit(";", 3)[0] for line in lines]
        ends = [lines[0].rsplit(";", 3)[1:], *[[f"{v:.10f}" for v in row] for row in vectors]]
        text = "\n".join(";".join([a, *b]) for a, b in zip(cut, ends, strict=True)) + "\n"
    mapping = PROBE.replace("euler-xyz", convention)
    found = read(text, tmp_path, mapping, study(probe=True, markers=1))
    turned = from_rotation_vectors(found.value[found.rotations])
    np.testing.assert_allclose(turned, TRUTH.turns, atol=1e-8)


def test_a_quaternion_in_a_plain_file(tmp_path: Path) -> None:
    quaternions = Rotation.from_matrix(TRUTH.turns).as_quat(scalar_first=True)
    cells = [
        [*row, *(f"{-v:.10f}" for v in q)]
        for row, q in zip(rows(TRUTH, markers=1), quaternions, strict=True)
    ]
    cells[2][-4:] = ["", "", "", ""]  # not read there
    text = table([*HEADER, "qw", "qx", "qy", "qz"], cells)
    found = read(text, tmp_path, what=study(probe=True, markers=1))
    turned = from_rotation_vectors(found.value[found.rotations])
    np.testing.assert_allclose(turned, TRUTH.turns[[0, 1, 3, 4]], atol=1e-9)
    assert len(found) == 9


def test_stations_mountings_payloads_and_times(tmp_path: Path) -> None:
    more = [
        ["A", "", "2026-11-28T14:00:05"],
        ["A", "plates", "28.11.2026 14:00:15"],
        ["B", "none", "28.11.2026 14:01:05,5"],
        ["B", "plates", "2026-11-28 14:02:05"],
        ["B", "-", "2026-11-28T14:03:05"],
    ]
    cells = [[*row, *more[int(row[0]) - 1]] for row in rows(TRUTH)]
    text = table([*HEADER, "series", "payload", "time"], cells, ";")
    found = read(text, tmp_path)
    assert (found.stations, found.mountings) == (("A", "B"), ("A", "B"))
    assert found.station.tolist() == [0] * 4 + [1] * 6
    assert found.mounting.tolist() == [0, 0, 1, 1, 1]
    assert (found.payload.tolist(), found.payloads) == ([-1, 0, -1, 0, -1], ("plates",))
    np.testing.assert_allclose(found.time[::2], [0, 10, 60.5, 120, 180])
    usual = replace(study(), payload="plates")
    assert read(text, tmp_path, what=usual).payload.tolist() == [0, 0, -1, 0, -1]
    assert read(PLAIN, tmp_path, what=usual).payload.tolist() == [0] * 5
    mounted = table([*HEADER, "series", "mounting"], [[*r, "A", f"m{r[0]}"] for r in rows(TRUTH)])
    found = read(mounted, tmp_path)
    assert (len(found.mountings), found.stations) == (5, ("A",))


def test_two_series_that_both_count_from_one(tmp_path: Path) -> None:
    other = truth(5, seed=2)
    files = {
        "a.csv": table([*HEADER, "series"], [[*row, "A"] for row in rows(TRUTH)]),
        "b.csv": table([*HEADER, "series"], [[*row, "B"] for row in rows(other)]),
    }
    found = read(files, tmp_path)
    assert found.names[:2] == ("A/1", "A/2")
    assert found.names[5] == "B/1"
    np.testing.assert_allclose(found.cases.q, np.concatenate([TRUTH.q, other.q]), atol=1e-11)


def test_rows_without_names_are_poses_of_their_own(tmp_path: Path) -> None:
    cells = [row[2:] for row in rows(TRUTH, markers=1)]
    found = read(table(HEADER[2:], cells), tmp_path, what=study(markers=1))
    assert found.names == tuple("12345")


def test_numbers_of_time_have_a_unit(tmp_path: Path) -> None:
    cells = [[*row, f"{3 + 0.5 * i}"] for i, row in enumerate(rows(TRUTH))]
    found = read(table([*HEADER, "time [min]"], cells), tmp_path)
    np.testing.assert_allclose(found.time, 30.0 * np.arange(10))


FOOT = """\
elastocal: 1
foot: [F1, F2]
columns:
  experiment: Pose
  marker: Target
  q [deg]: [A1, A2, A3, A4, A5, A6]
  x y z [mm]: [X, Y, Z]
"""
FOOT_HEADER = ["Pose", "Target", *JOINTS, "X", "Y", "Z"]


def foot_rows() -> list[list[str]]:
    cells = rows(TRUTH)
    for at, name in ((10, "F2"), (4, "F1"), (0, "F1")):
        cells.insert(at, ["", name, *[""] * 6, "1000.0", f"{at}", "-500.0"])
    return cells


def test_reflectors_on_the_foot(tmp_path: Path) -> None:
    found = read(table(FOOT_HEADER, foot_rows()), tmp_path, FOOT)
    assert len(found) == 10
    np.testing.assert_allclose(found.value, TRUTH.points.reshape(-1, 3), atol=1e-9)
    foot = found.foot
    assert foot is not None
    assert (foot.names, foot.reflector.tolist()) == (("F1", "F2"), [0, 0, 1])
    assert foot.order.tolist() == [0, 4, 10]
    np.testing.assert_allclose(foot.position[:, 1], [0.0, 0.004, 0.010])
    np.testing.assert_allclose(foot.covariance[0], 3e-5**2 * np.eye(3))


def test_the_clock_says_when_the_foot_was_read(tmp_path: Path) -> None:
    """The rows of the foot are in a file of their own."""
    cells = [[*row, f"{i}"] for i, row in enumerate(rows(TRUTH))]
    apart = [
        ["", "F1", *[""] * 6, "1", "2", "3", "0.5"],
        ["", "F2", *[""] * 6, "1", "2", "3", "99"],
    ]
    mapping = f"{FOOT}  time [s]: T\n"
    files = {"arm.csv": table([*FOOT_HEADER, "T"], cells),
             "foot.csv": table([*FOOT_HEADER, "T"], apart)}  # fmt: skip
    found = read(files, tmp_path, mapping)
    assert found.foot is not None
    assert found.foot.order.tolist() == [1, 10]
    np.testing.assert_allclose(found.foot.time, [0.5, 99])


def test_joint_torques_forces_and_hanging_masses(tmp_path: Path) -> None:
    header = [*HEADER, *(f"torque {j} [N.m]" for j in JOINTS)]
    cells = [[*row, *(f"{100 * i + int(row[0])}" for i in range(6))] for row in rows(TRUTH)]
    found = read(table(header, cells), tmp_path)
    np.testing.assert_allclose(found.torque[:, 1], [101, 102, 103, 104, 105])
    forces = table(
        [*HEADER, "Fx [N]", "Fy [N]", "Fz [N]"], [[*r, "0", "0", "-9"] for r in rows(TRUTH)]
    )
    np.testing.assert_allclose(read(forces, tmp_path).cases.wrench, [[0, 0, -9, 0, 0, 0]] * 5)
    masses = table([*HEADER, "hanging mass [kg]"], [[*r, r[0]] for r in rows(TRUTH)])
    found = read(masses, tmp_path)
    np.testing.assert_allclose(found.cases.wrench[:, 2], -9.80665 * np.arange(1, 6))


def test_joints_as_the_controller_shows_them(tmp_path: Path) -> None:
    table_ = coupling(study().robot, signs={"A1": -1}, offsets={"A2": -0.5})
    what = replace(study(), controller=table_)
    plain = read(PLAIN, tmp_path, what=what)
    assert any("joints: controller" in remark for remark in plain.remarks)
    mapping = FOOT.replace("foot: [F1, F2]", "joints: controller")
    found = read(table(FOOT_HEADER, rows(TRUTH)), tmp_path, mapping, what)
    np.testing.assert_allclose(found.cases.q, table_.to_model(TRUTH.q), atol=1e-11)


def test_repeated_and_invalid_readings(tmp_path: Path) -> None:
    cells = [[*row, "1"] for row in rows(TRUTH)]
    cells.append([*cells[0]])  # a copy
    cells.append([*cells[1][:-2], f"{float(cells[1][-2]) + 0.01:.6f}", "1"])  # read again
    cells.append(["1", "M1", *["no"] * 9, "0"])
    cells.append(["2", "M1", *cells[0][2:8], *cells[0][8:]])  # the beam broke
    cells[-1][2:8] = cells[2][2:8]
    found = read(table([*HEADER, "valid"], cells), tmp_path)
    assert len(found) == 12
    text = " ".join(found.remarks)
    assert "1 row marked as invalid" in text
    assert "1 reading repeated exactly" in text
    assert "was the beam broken" in text


def test_whole_turns_are_inside_the_limits(tmp_path: Path) -> None:
    cells = rows(TRUTH)
    for row in cells[:2]:
        row[2] = f"{float(row[2]) + 360:.10f}"
    found = read(table(HEADER, cells), tmp_path)
    np.testing.assert_allclose(found.cases.q, TRUTH.q, atol=1e-11)
    assert any("whole turn" in remark for remark in found.remarks)


WIDE = """\
elastocal: 1
columns: {experiment: Pose, "q [deg]": [A1, A2, A3, A4, A5, A6]}
markers:
  M1: {"x y z [mm]": [X1, Y1, Z1], "u [mm]": U1}
  M2: {"x y z [mm]": [X2, Y2, Z2], "u [mm]": U2}
"""


def test_columns_for_every_reflector_of_which_some_are_not_seen(tmp_path: Path) -> None:
    cells = [
        [a[0], *a[2:], "0.01", *b[8:], "0.02"]
        for a, b in zip(rows(TRUTH)[::2], rows(TRUTH)[1::2], strict=True)
    ]
    cells[1][7:11] = [""] * 4
    cells[3][11:] = ["", "", "", "0.02"]
    header = ["Pose", *JOINTS, "X1", "Y1", "Z1", "U1", "X2", "Y2", "Z2", "U2"]
    found = read(table(header, cells), tmp_path, WIDE)
    assert found.case.tolist() == [0, 0, 1, 2, 2, 3, 4, 4]
    assert found.marker.tolist() == [0, 1, 1, 0, 1, 0, 0, 1]
    np.testing.assert_allclose(found.value, TRUTH.points[found.case, found.marker], atol=1e-9)
    np.testing.assert_allclose(found.covariance[2], 4e-10 * np.eye(3))
    cells[2][8] = ""
    with pytest.raises(MeasurementFileError, match=r"line 4, column 'Y1 / Y2': the cell is empty"):
        read(table(header, cells), tmp_path, WIDE)


def test_series_and_payloads_that_no_column_says(tmp_path: Path) -> None:
    mapping = FOOT.replace("foot: [F1, F2]", "constants: {series: [A, B]}").rstrip()
    mapping += "\n  payload: Load\nwords: {payload: {'0': none, '120': plates}}\n"
    header = [*FOOT_HEADER, "Load"]
    files = {
        "a.csv": table(header, [[*row, "0"] for row in rows(TRUTH)]),
        "b.csv": table(header, [[*row, "120"] for row in rows(truth(5, seed=2))]),
    }
    found = read(files, tmp_path, mapping)
    assert found.names == tuple(f"{name}/{i}" for name in "AB" for i in range(1, 6))
    assert found.stations == ("A", "B")
    assert found.payload.tolist() == [-1] * 5 + [0] * 5


def test_joints_and_payloads_of_a_plan(tmp_path: Path) -> None:
    """A weight that the plan has there or not is the payload with this weight."""
    header = ["configuration", *(f"{j} [deg]" for j in JOINTS), "Fx [N]", "Fy [N]", "Fz [N]"]
    planned = [
        [f"C{i}", *(f"{v:.9f}" for v in np.degrees(q)), "0", "0", f"{-1176.798 * (i % 2)}", "1"]
        for i, q in enumerate(TRUTH.q)
    ]
    (tmp_path / "plan.csv").write_text(table([*header, "repeats"], planned))
    cells = [[*row[:2], *row[8:]] for row in rows(TRUTH)]
    (tmp_path / "m.csv").write_text(table(["experiment", "marker", *HEADER[8:]], cells))
    found = read_positions(tmp_path / "m.csv", study(), plan=tmp_path / "plan.csv")
    np.testing.assert_allclose(found.cases.q, TRUTH.q, atol=1e-10)
    assert found.payload.tolist() == [-1, 0, -1, 0, -1]
    assert not found.cases.wrench.any()
    with pytest.raises(MeasurementFileError, match="column 'A1 \\[deg\\]' is missing"):
        read_positions(tmp_path / "m.csv", study())
