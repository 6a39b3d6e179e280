"""Joint values that wrap: whole turns are where the arm is, no other place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.files.study.study_file import parse_study
from elastocal.measuring.measurements import Measurements
from elastocal.robot.posture import forward_kinematics

STUDY = """\
elastocal: 1
robot:
  convention: classic
  dh:
    - {joint: rail, type: prismatic, limits_mm: [0, 3000]}
    - {joint: J1, alpha_deg: 90, d_mm: 500, limits_deg: [-180, 180]}
    - {joint: J2, a_mm: 700, limits_deg: [-90, 90]}
    - {joint: J3, a_mm: 600}
tools: {t: {load_point_mm: [100, 0, 0], markers_mm: {M1: [100, 0, 0], M2: [0, 50, 0]}}}
test_poses:
  - {tool: t, q_mm: {rail: 500}, q_deg: {J1: 0, J2: 30, J3: 20}, force_N: [0, 0, -100]}
experiments: {tool: t, force_N: [0, 0, -500], count: 2}
instrument: {sigma_mm: 0.03}
"""
HEAD = "experiment,marker,rail [mm],J1 [deg],J2 [deg],J3 [deg],Fx [N],Fy [N],Fz [N],"
TAIL = "0,0,-500,0.1,0.1,-1\n"


def read(folder: Path, *joints: str, study: str = STUDY, head: str = HEAD) -> Measurements:
    """Two markers of one experiment for each two rows of joint values."""
    rows = [f"{1 + i // 2},M{1 + i % 2},{row},{TAIL}" for i, row in enumerate(joints)]
    path = folder / "m.csv"
    path.write_text(f"{head}dx [mm],dy [mm],dz [mm]\n{''.join(rows)}")
    return read_measurements(path, parse_study(study, folder / "study.yaml"))


@pytest.mark.parametrize(
    ("one", "other", "mean"),
    [
        ("100,0.004,10,20", "100,359.997,10,20", (0.0005, 10, 20)),
        ("100,359.997,10,20", "100,0.004,10,20", (0.0005, 10, 20)),
        ("100,179.998,10,20", "100,-179.998,10,20", (180.0, 10, 20)),
        ("100,0,10,719.996", "100,0,10,-0.002", (0, 10, 719.997)),
        ("100,0,10,-180.002", "100,0,10,179.996", (0, 10, -180.003)),
        ("100,0,10,20", "100,0.0,10.0,20.0", (0, 10, 20)),
    ],
)
def test_rows_of_one_experiment_are_averaged_on_the_circle(
    one: str, other: str, mean: tuple[float, ...], tmp_path: Path
) -> None:
    found = read(tmp_path, one, other)
    np.testing.assert_allclose(np.degrees(found.cases.q[0, 1:]), mean, atol=1e-9)
    assert found.cases.q[0, 0] == 0.1
    said = [remark for remark in found.remarks if "their means are used" in remark]
    assert len(said) == (one != "100,0,10,20")
    assert all("0.00" in remark for remark in said)


def test_a_rail_does_not_turn(tmp_path: Path) -> None:
    turn = 2e3 * np.pi
    with pytest.raises(MeasurementFileError, match=r"line 3, column 'rail \[mm\]'"):
        read(tmp_path, "0,0,10,20", f"{turn:.9f},0,10,20")
    found = read(tmp_path, *[f"{turn:.9f},0,10,20"] * 2)
    assert [doubt.code for doubt in found.doubts] == ["beyond-joint-limits", "unfinished"]


def test_what_is_no_whole_turn_apart_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MeasurementFileError, match=r"has 359\.9 ° here and 0\.5 ° in line 2"):
        read(tmp_path, "0,0.5,10,20", "0,359.9,10,20")


# what the file says; what it is taken as; limits that are then broken
LIMITS: dict[str, tuple[str, float, int]] = {
    "a turn above": ("359.9,10,20", -0.1, 0),
    "a turn below": ("-359.9,10,20", 0.1, 0),
    "at the limit": ("540,10,20", 180.0, 0),
    "inside": ("180,10,20", 180.0, 0),
    "a little outside": ("180.5,10,20", -179.5, 0),
    "two turns above": ("719.9,10,20", 719.9, 1),
}


@pytest.mark.parametrize("name", LIMITS)
def test_a_whole_turn_outside_the_limits_is_inside(name: str, tmp_path: Path) -> None:
    shown, taken, broken = LIMITS[name]
    found = read(tmp_path, *[f"0,{shown}"] * 2)
    np.testing.assert_allclose(np.degrees(found.cases.q[0, 1]), taken, atol=1e-9)
    doubts = [doubt.code for doubt in found.doubts if doubt.code != "unfinished"]
    assert doubts == ["beyond-joint-limits"] * broken
    told = [remark for remark in found.remarks if "a whole turn" in remark]
    moved = taken != float(shown.split(",")[0])
    assert told == [
        f"experiment 1: J1 is shown a whole turn outside its limits and taken as inside, "
        f"{float(shown.split(',')[0]):g}° as {taken:g}°"
    ] * int(moved)


def test_outside_by_less_than_a_turn_stays_outside(tmp_path: Path) -> None:
    """J2 is limited to ±90°: 100° is no place inside, whatever is added."""
    found = read(tmp_path, *["0,0,100,20"] * 2)
    assert np.degrees(found.cases.q[0, 2]) == pytest.approx(100.0)
    assert [doubt.code for doubt in found.doubts] == ["beyond-joint-limits", "unfinished"]


def test_the_arm_is_where_it_was(tmp_path: Path) -> None:
    robot = parse_study(STUDY, tmp_path / "study.yaml").robot
    shown = read(tmp_path, *["100,359.9,280,740"] * 2)
    plain = read(tmp_path, *["100,-0.1,-80,20"] * 2)
    np.testing.assert_allclose(
        forward_kinematics(robot, shown.cases.q), forward_kinematics(robot, plain.cases.q),
        atol=1e-12,
    )  # fmt: skip
    assert np.degrees(shown.cases.q[0, 3]) == pytest.approx(740.0)  # turns without end


def test_degrees_under_radians_are_still_noticed(tmp_path: Path) -> None:
    """Each of these values is within a turn of the limits when it is taken for radians."""
    head = HEAD.replace("[deg]", "[rad]")
    found = read(tmp_path, *["0,8,7.5,9"] * 2, head=head)
    assert "degrees-for-radians" in [doubt.code for doubt in found.doubts]


def test_readings_about_a_full_turn_in_radians_are_no_degrees(tmp_path: Path) -> None:
    found = read(tmp_path, "0,0,0,6.28313", "0,0,0,0.0001", head=HEAD.replace("[deg]", "[rad]"))
    assert "degrees-for-radians" not in [doubt.code for doubt in found.doubts]
    assert np.degrees(found.cases.q[0, 3]) == pytest.approx(360.0, abs=2e-3)


def test_values_of_the_controller_wrap_too(tmp_path: Path) -> None:
    study = STUDY + "controller: {signs: {J1: -1}, offsets_deg: {J2: 90}}\n"
    rows = ["1,M1,0,359.996,460,20," + TAIL, "1,M2,0,-0.002,99.998,20," + TAIL]
    (tmp_path / "m.csv").write_text(f"{HEAD}dx [mm],dy [mm],dz [mm]\n{''.join(rows)}")
    names = [cell.split(" [")[0] for cell in HEAD.split(",")[:-1]]
    columns = "".join(f"  {name}: {name}\n" for name in [*names, "dx", "dy", "dz"])
    (tmp_path / "map.yaml").write_text(f"elastocal: 1\njoints: controller\ncolumns:\n{columns}")
    found = read_measurements(
        tmp_path / "m.csv", parse_study(study, tmp_path / "study.yaml"), tmp_path / "map.yaml"
    )
    np.testing.assert_allclose(np.degrees(found.cases.q[0, 1:]), [0.003, 9.999, 20], atol=1e-9)
