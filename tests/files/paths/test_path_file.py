"""Path files: every way to write one, every way to get it wrong, and any bytes at all."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import elastocal as ec
from elastocal.arrays import Array
from elastocal.errors import ElastocalError, PathFileError
from elastocal.files.paths.path_file import ToolPath, read_path
from elastocal.robot.chain import transform
from tests.test_examples import ROOT, quietly

KUKA = ec.load_robot("kuka-kr270")
MILLING = KUKA.tools["milling"]
THREE = ec.load_robot("three-link")
TIP = THREE.tools["tip"]
DEGREES = np.array([0.0, -56.9, 89.3, 45.1, 76.0, 57.2])
START = np.radians(DEGREES)
Q = np.radians(DEGREES + np.array([[0.0] * 6, [1, 0.5, -1, 2, 0, 3], [2, 1, -2, 4, 0, 6]]))
WRENCH = np.array([[0, 280, -180, 0, 0, 0], [10, 270, -180, 1, 2, 3], [20, 260, -190, 2, 4, 6.0]])
POSES = ec.forward_kinematics(KUKA, Q) @ transform(None, MILLING.tcp)
TURNS = Rotation.from_matrix(POSES[:, :3, :3])
JOINTS = [f"A{i} [deg]" for i in range(1, 7)]
LOADS = ["Fx [N]", "Fy [N]", "Fz [N]", "Tx [N.m]", "Ty [N.m]", "Tz [N.m]"]


def text(header: list[str], *columns: Array, separator: str = ",", decimal: str = ".") -> str:
    rows = [[f"{v:.12g}".replace(".", decimal) for v in row] for row in np.hstack(columns)]
    return "\n".join(separator.join(row) for row in [header, *rows]) + "\n"


def read(folder: Path, content: str | bytes, **others: Array) -> ToolPath:
    path = folder / "path.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
    return read_path(path, KUKA, MILLING, START, others.get("wrench"))


BY_JOINTS = text(JOINTS + LOADS, np.degrees(Q), WRENCH)
XYZ = ["x [mm]", "y [mm]", "z [mm]"]
PLACES = 1e3 * POSES[:, :3, 3]
QUATERNION = text(
    [*XYZ, "qw", "qx", "qy", "qz", *LOADS],
    PLACES,
    np.roll(TURNS.as_quat(), 1, axis=1),
    WRENCH,
)
ABC = text(
    [*XYZ, "A [deg]", "B [deg]", "C [deg]", *LOADS], PLACES, TURNS.as_euler("ZYX", True), WRENCH
)


@pytest.mark.parametrize(
    "content",
    [
        BY_JOINTS,
        "﻿" + BY_JOINTS.replace("\n", "\r\n"),
        BY_JOINTS.replace("\n", "\n\n"),
        text(JOINTS + LOADS, np.degrees(Q), WRENCH, separator=";", decimal=","),
        text(JOINTS + LOADS, np.degrees(Q), WRENCH, separator="\t"),
        text((JOINTS + LOADS)[::-1], np.hstack([np.degrees(Q), WRENCH])[:, ::-1]),
        text([f"A{i} [rad]" for i in range(1, 7)] + LOADS, Q, WRENCH),
        text(JOINTS + [c.replace("[N]", "[kN]") for c in LOADS[:3]] + LOADS[3:], np.degrees(Q),
             WRENCH * [1e-3, 1e-3, 1e-3, 1, 1, 1]),
        QUATERNION,
        ABC,
        text([*XYZ, "rx [rad]", "ry [rad]", "rz [rad]", *LOADS], PLACES, TURNS.as_rotvec(), WRENCH),
        text(["x [m]", "y [m]", "z [m]", "qx", "qy", "qz", "qw", *LOADS], 1e-3 * PLACES,
             TURNS.as_quat(), WRENCH),
    ],
)  # fmt: skip
def test_the_same_path_in_every_form(tmp_path: Path, content: str) -> None:
    found = read(tmp_path, content)
    np.testing.assert_allclose(found.cases.q, Q, atol=1e-9)
    np.testing.assert_allclose(found.cases.wrench, WRENCH, atol=1e-9)
    assert found.names == ("1", "2", "3")
    assert found.remarks == ()


def test_loads_in_the_axes_of_the_flange_are_turned_to_the_base(tmp_path: Path) -> None:
    rotation = POSES[:, :3, :3]
    own = np.hstack(
        [np.einsum("nji,nj->ni", rotation, part) for part in (WRENCH[:, :3], WRENCH[:, 3:])]
    )
    header = JOINTS + [c.replace(" [", " tool [") for c in LOADS]
    found = read(tmp_path, text(header, np.degrees(Q), own))
    np.testing.assert_allclose(found.cases.wrench, WRENCH, atol=1e-8)


def test_a_constant_load_from_elsewhere(tmp_path: Path) -> None:
    wrench = np.array([1.0, 2, 3, 4, 5, 6])
    found = read(tmp_path, text(JOINTS, np.degrees(Q)), wrench=wrench)
    np.testing.assert_array_equal(found.cases.wrench, [wrench] * 3)


def test_names_lines_and_columns_that_are_not_read(tmp_path: Path) -> None:
    lines = BY_JOINTS.splitlines()
    content = "\n".join(
        ["point,feed [mm/s]," + lines[0], "", *(f"p{i},7,{row}" for i, row in enumerate(lines[1:]))]
    )
    found = read(tmp_path, content + "\n")
    assert found.names == ("p0", "p1", "p2")
    assert found.lines == (3, 4, 5)
    assert found.remarks == ("columns not read: feed",)


def test_jumps_are_reported_with_their_lines(tmp_path: Path) -> None:
    q = np.radians(DEGREES) + np.linspace(0, 0.01, 20)[:, None]
    q[12:, 3] += np.radians(170.0)
    wrench = np.tile(WRENCH[0], (20, 1))
    found = read(tmp_path, text(JOINTS + LOADS, np.degrees(q), wrench))
    assert len(found.remarks) == 1
    assert found.remarks[0].startswith("1 jump between consecutive points")
    assert "from line 13 to line 14, where A4 moves by 170" in found.remarks[0]


def test_a_path_without_jumps_stays_on_its_branch(tmp_path: Path) -> None:
    example = read_path(ROOT / "examples" / "kr270" / "path.csv", KUKA, MILLING, START)
    steps = np.abs(np.diff(example.cases.q, axis=0))
    assert np.degrees(steps).max() < 3.0
    assert example.remarks == ()
    assert example.form is not None
    assert example.form.name == "A, B, C"


def test_three_joints_take_positions_alone(tmp_path: Path) -> None:
    q = np.radians([[10.0, 40.0, -60.0], [11.0, 41.0, -62.0]])
    places = ec.forward_kinematics(THREE, q)[:, :3, 3]
    content = text([*XYZ, "Fx [N]", "Fy [N]", "Fz [N]"], 1e3 * places, WRENCH[:2, :3])
    path = tmp_path / "path.csv"
    path.write_text(content, encoding="utf-8")
    found = read_path(path, THREE, TIP, q[0] + 0.1)
    np.testing.assert_allclose(found.cases.q, q, atol=1e-8)
    turned = content.replace("Fx [N],Fy [N],Fz [N]", "A [deg],B [deg],C [deg]")
    path.write_text(turned, encoding="utf-8")
    with pytest.raises(PathFileError, match="3 joints cannot take any orientation"):
        read_path(path, THREE, TIP, q[0])


def edit(content: str, line: int, column: int, cell: str) -> str:
    rows = [row.split(",") for row in content.splitlines()]
    rows[line - 1][column] = cell
    return "\n".join(",".join(row) for row in rows) + "\n"


def without(content: str, *names: str) -> str:
    rows = [row.split(",") for row in content.splitlines()]
    keep = [i for i, name in enumerate(rows[0]) if name.split(" [")[0] not in names]
    return "\n".join(",".join(row[i] for i in keep) for row in rows) + "\n"


BAD = {
    "empty": ("", "the file is empty"),
    "header alone": (BY_JOINTS.splitlines()[0] + "\n", "no row of data below it"),
    "numbers alone": ("1,2,3\n4,5,6\n", "line 1: numbers where the names"),
    "short row": (BY_JOINTS + "1,2\n", "line 5: 2 cells where the header has 12"),
    "no number": (edit(BY_JOINTS, 3, 1, "left"), "line 3, column 'A2': expected a number"),
    "nan": (edit(BY_JOINTS, 3, 1, "nan"), "line 3, column 'A2': expected a finite number"),
    "infinite": (edit(BY_JOINTS, 2, 6, "1e999"), "line 2, column 'Fx': expected a finite"),
    "huge": (edit(BY_JOINTS, 2, 6, "-1e9"), "'Fx': expected a finite number, found '-1e9'; none"),
    "no cell": (edit(BY_JOINTS, 4, 0, ""), "line 4, column 'A1': the cell is empty"),
    "no unit": (edit(BY_JOINTS, 1, 0, "A1"), "column 'A1': expected one of the units deg"),
    "length": (edit(BY_JOINTS, 1, 0, "A1 [mm]"), "expected one of the units deg.*found \\[mm\\]"),
    "force in kg": (edit(BY_JOINTS, 1, 6, "Fx [kg]"), "'Fx': expected one of the units N, kN"),
    "joint missing": (without(BY_JOINTS, "A4"), "line 1: the column of joint 'A4' is missing"),
    "twice": (edit(BY_JOINTS, 1, 1, "A1 [deg]"), "line 1: column 'A1' is there twice"),
    "Fy missing": (without(BY_JOINTS, "Fy"), "column 'Fy' is missing beside 'Fx'"),
    "no load": (text(JOINTS, np.degrees(Q)), "no load; expected columns Fx"),
    "two frames": (
        edit(edit(edit(BY_JOINTS, 1, 9, "Tx tool [N.m]"), 1, 10, "Ty tool [N.m]"), 1, 11,
             "Tz tool [N.m]"),
        "in the base frame and in that of the tool",
    ),
    "outside limits": (edit(BY_JOINTS, 3, 1, "5"), "line 3, column 'A2': 5° is outside the limits"),
    "joints and places": (
        text(JOINTS + XYZ + LOADS, np.degrees(Q), PLACES, WRENCH),
        "joint values and tool positions .column 'x'. are both given",
    ),
    "nothing": (text(LOADS, WRENCH), "expected the joints A1, A2"),
    "no orientation": (without(ABC, "A", "B", "C"), "the orientation is missing; expected qw"),
    "half of it": (without(ABC, "B"), "column 'B' of the A, B, C is missing"),
    "two of them": (
        text([*XYZ, "qw", "qx", "qy", "qz", "A [deg]", "B [deg]", "C [deg]", *LOADS], PLACES,
             np.roll(TURNS.as_quat(), 1, axis=1), TURNS.as_euler("ZYX", True), WRENCH),
        "given twice, as quaternion and as A, B, C",
    ),
    "long quaternion": (edit(QUATERNION, 3, 3, "0.9"), "line 3, column 'qw': a quaternion must"),
    "quaternion with unit": (edit(QUATERNION, 1, 3, "qw [deg]"), "'qw': expected no unit"),
    "out of reach": (
        edit(QUATERNION, 3, 0, "9000"),
        "line 3: no configuration within the joint limits has the TCP there, the nearest",
    ),
    "first out of reach": (edit(QUATERNION, 2, 0, "9000"), "near it: --start"),
    "in metres": (
        text([*XYZ, "qw", "qx", "qy", "qz", *LOADS], PLACES / 1e3,
             np.roll(TURNS.as_quat(), 1, axis=1), WRENCH),
        "line 2: no configuration",
    ),
    "corrected": (
        BY_JOINTS.replace("Tx [N.m]", "deflection dx [mm]"), "this is a corrected path already"
    ),
    "mixed decimals": (
        text(JOINTS + LOADS, np.degrees(Q), WRENCH, separator=";", decimal=",").replace(
            "89,3", "89.3"
        ),
        "expected a number with a decimal comma",
    ),
    "excel": (b"PK\x03\x04 and so on", "Excel workbook"),
}  # fmt: skip


@pytest.mark.parametrize("what", BAD)
def test_what_is_wrong_is_said_in_one_sentence(tmp_path: Path, what: str) -> None:
    content, sentence = BAD[what]
    with pytest.raises(PathFileError, match=sentence) as found:
        read(tmp_path, content)
    assert str(found.value).startswith(str(tmp_path / "path.csv"))
    assert "\n" not in str(found.value)


def test_a_load_may_not_come_from_two_places(tmp_path: Path) -> None:
    with pytest.raises(PathFileError, match="one for all points is given too"):
        read(tmp_path, BY_JOINTS, wrench=np.ones(6))


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(PathFileError, match="no such file"):
        read_path(tmp_path / "none.csv", KUKA, MILLING, START)


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.one_of(
        st.binary(max_size=200),
        st.text(max_size=200).map(str.encode),
        st.tuples(st.integers(0, len(BY_JOINTS)), st.text(max_size=6)).map(
            lambda cut: (BY_JOINTS[: cut[0]] + cut[1] + BY_JOINTS[cut[0] :]).encode()
        ),
    )
)
def test_any_bytes_give_a_path_or_a_sentence(tmp_path: Path, content: bytes) -> None:
    sentence = ""
    try:
        assert np.isfinite(read(tmp_path, content).cases.q).all()
    except ElastocalError as error:
        sentence = str(error)
    assert "\n" not in sentence


def test_the_example_path_is_what_its_script_makes() -> None:
    script = ROOT / "examples" / "kr270" / "make_path.py"
    made = subprocess.run(
        [sys.executable, str(script)], env=quietly(), capture_output=True, encoding="utf-8"
    )
    assert made.returncode == 0, made.stderr
    assert made.stdout == (ROOT / "examples" / "kr270" / "path.csv").read_text("utf-8")
