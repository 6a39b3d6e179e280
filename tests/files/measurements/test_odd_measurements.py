"""Odd measurement files: some are read as they are meant, some are read and remarked upon."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from elastocal.errors import Doubt, MeasurementFileError
from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.files.measurements.suspicious import kept_aside
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.measuring.measurements import Measurements
from elastocal.robot.posture import forward_kinematics
from tests.files.campaign import STUDY_TEXT, study
from tests.files.measurements.test_bad_measurements import FIRST, GOOD, HEAD, ROWS, STATES, edited

SEMICOLONS = GOOD.replace(",", ";").replace(".", ",")


def read(data: bytes | str, folder: Path, text: str = STUDY_TEXT) -> Measurements:
    path = folder / "m.csv"
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    return read_measurements(path, study(text))


# the good file in other clothes: nothing changes, nothing is remarked
SAME: dict[str, bytes] = {
    "as it is": GOOD.encode(),
    "byte order mark": GOOD.encode("utf-8-sig"),
    "UTF-16": GOOD.encode("utf-16"),
    "UTF-16 big endian": b"\xfe\xff" + GOOD.encode("utf-16-be"),
    "Windows line ends": GOOD.replace("\n", "\r\n").encode(),
    "old Macintosh line ends": GOOD.replace("\n", "\r").encode(),
    "semicolons and decimal commas": SEMICOLONS.encode(),
    "semicolons and decimal points": GOOD.replace(",", ";").encode(),
    "tabs": GOOD.replace(",", "\t").encode(),
    "bars": GOOD.replace(",", "|").encode(),
    "all cells in quotes": "\n".join(
        ",".join(f'"{cell}"' for cell in line.split(",")) for line in GOOD.splitlines()
    ).encode()
    + b"\n",
    "blank lines": GOOD.replace("\n", "\n\n").encode(),
    "rows of delimiters": (GOOD + "," * 14 + "\n").encode(),
    "comments": GOOD.replace("\n", '\n# said the operator, "twice"\n').encode(),
    "trailing delimiters": GOOD.replace("\n", ",\n").encode(),
    "trailing delimiters below": (HEAD + ROWS.replace("\n", ",,,\n")).encode(),
    "spaces around cells": GOOD.replace(",", " , ").encode(),
    "double spaces in headers": GOOD.replace(" [", "   [").encode(),
    "no space in headers": GOOD.replace(" [", "[").encode(),
    "leading apostrophes": GOOD.replace(",", ",'").encode(),
    "micrometres, cp1252": GOOD.replace("u [mm]", "u [µm]")
    .replace(",0.02\n", ",20\n")
    .encode("cp1252"),
    "micrometres, Greek letter": GOOD.replace("u [mm]", "u [μm]")
    .replace(",0.02\n", ",20\n")
    .encode(),
    "expanded uncertainty": GOOD.replace("u [mm]", "U95 [mm]")
    .replace(",0.02\n", ",.04\n")
    .encode(),
    "kilonewtons": GOOD.replace("Fz [N]", "Fz [kN]").replace("-2500", "-2.5").encode(),
    "lower case": GOOD.replace("A1 [", "a1 [").replace("Fz [", "fz [").encode(),
    "extra columns": "\n".join(
        f"temperature,{line},operator" if i == 0 else f'21;5,{line},"Müller, Jörg"'
        for i, line in enumerate(GOOD.splitlines())
    ).encode()
    + b"\n",
    "other columns without unit": GOOD.replace("u [mm]\n", "u [mm],x,y,z\n")
    .replace(",0.02\n", ",0.02,1,2,3\n")
    .encode(),
    "version line": b"# elastocal measurements, version 1\n" + GOOD.encode(),
    "exponents and signs": GOOD.replace("-2500", "-2.5e+3").replace(",0.1,", ",+1E-1,").encode(),
    "minus of typographers": GOOD.replace("-", "−").encode(),
}


@pytest.mark.parametrize("name", SAME)
def test_clothes_make_no_difference(name: str, tmp_path: Path) -> None:
    right = read(GOOD, tmp_path)
    found = read(SAME[name], tmp_path)
    assert found.remarks == right.remarks == ()
    assert {doubt.code for doubt in found.doubts} <= {"columns-not-used"}  # said, no more
    assert right.doubts == ()
    assert found.names == right.names == ("1", "2", "3")
    assert found.own_uncertainty
    np.testing.assert_array_equal(found.marker, right.marker)
    np.testing.assert_allclose(found.cases.q, right.cases.q, rtol=1e-14)
    np.testing.assert_allclose(found.cases.wrench, right.cases.wrench, rtol=1e-14)
    np.testing.assert_allclose(found.deflection, right.deflection, rtol=1e-14)
    np.testing.assert_allclose(found.covariance, right.covariance, rtol=1e-14)
    np.testing.assert_allclose(right.covariance[0], (2e-5) ** 2 * np.eye(3), rtol=1e-14)
    np.testing.assert_allclose(right.deflection[1], [1e-4, 3e-4, -3.2e-3], rtol=1e-14)
    np.testing.assert_allclose(np.degrees(right.cases.q[1]), [20, -70, 90, 35, 45, 55])


def radians(text: str) -> str:
    for i in range(1, 7):
        text = text.replace(f"A{i} [deg]", f"A{i} [rad]")
    return text


EACH = ("1", "2", "3")

# what is in the file; what is odd in it
ODD: dict[str, tuple[str, Doubt]] = {
    "degrees under a radian header": (
        radians(GOOD), Doubt("degrees-for-radians", (), (), {"largest": 95.0})),
    "radians under a degree header": (
        HEAD + "1,M1,0.1,-1,1.4,0.5,0.7,0.9,0,0,-2500,0.1,0.2,-3.1,0.02\n",
        Doubt("radians-for-degrees", (), (), {"largest": np.radians(1.4)})),
    "beyond the limits": (
        GOOD.replace(",-60,", ",-160,"),
        Doubt("beyond-joint-limits", ("1",), ("A2",),
              {"lower": np.radians(-140), "upper": 0.0,
               "least": np.radians(-160), "most": np.radians(-160)}, "rad")),
    "unknown uncertainty": (
        GOOD.replace("u [mm]", "U(95) [mm]"),
        Doubt("looks-used", ("U(95) [mm]",), ("an uncertainty",))),
    "moments by another name": (
        GOOD.replace("u [mm]", "Mz [N.m]"), Doubt("looks-used", ("Mz [N.m]",), ("a torque",))),
    "what means nothing": (
        GOOD.replace("u [mm]", "spindle [rpm]"), Doubt("columns-not-used", ("spindle [rpm]",))),
    "rotations nobody measures": (
        GOOD.replace("u [mm]", "drx [mrad]"), Doubt("rotations-not-used", ("drx [mrad]",))),
    "deflections of metres": (
        GOOD.replace("-3.1", "-3100"),
        Doubt("large-deflection", ("1",), (), {"least": 3.1, "most": 3.1})),
    "metres under millimetres": (
        GOOD.replace(",0.", ",0.000").replace(",-3.", ",-0.003").replace(",0.00002\n", ",0.02\n"),
        Doubt("only-noise", (), (), {"deflection": 3.62e-6, "noise": np.sqrt(3.0) * 2e-5})),
    "zero loads": (GOOD.replace("-2500", "0"), Doubt("no-load", EACH)),
    "half the load": (
        GOOD.replace("-2500", "-1250"),
        Doubt("other-force", EACH, (), {"least": 1250.0, "most": 1250.0, "planned": 2500.0})),
    "other direction": (
        GOOD.replace("0,0,-2500", "2500,0,0"),
        Doubt("other-direction", EACH, ("1",), {"x": 1.0, "y": 0.0, "z": 0.0})),
    "against the force": (
        GOOD.replace(",-3.", ",3."), Doubt("against-force", (), (), {"against": 6, "clear": 6})),
    "one marker missing": (
        GOOD.replace("3,M2,30,-80,95,31,41,51,0,0,-2500,0.3,0.3,-3.6,0.02\n", ""),
        Doubt("fewer-readings", ("3",), (), {"least": 1, "most": 1, "others": 2})),
    "marker never measured": (HEAD + FIRST, Doubt("marker-not-measured", ("M2",))),
    "experiments missing": (
        HEAD + FIRST, Doubt("unfinished", (), (), {"experiments": 1, "planned": 3})),
    "exactly zero": (GOOD.replace("0.1,0.2,-3.1", "0,0,0"), Doubt("zero-deflection", ("1",))),
    "stuck force sensor": (
        HEAD + "".join(
            f"{i},M{m},{i},-60,80,30,40,50,0,0,{-2500 - min(i, 6) * 0.7:.1f},"
            f"0.1,0.{m},-3.{i}{m},0.02\n"
            for i in range(1, 10) for m in (1, 2)), Doubt("stuck-sensor")),
}  # fmt: skip


@pytest.mark.parametrize("name", ODD)
def test_what_is_odd_is_known_by_its_code(name: str, tmp_path: Path) -> None:
    data, expected = ODD[name]
    found = {doubt.code: doubt for doubt in read(data, tmp_path).doubts}[expected.code]
    assert (found.about, found.because, found.unit) == (
        expected.about, expected.because, expected.unit)  # fmt: skip
    assert found.numbers == pytest.approx(dict(expected.numbers), rel=1e-2)


# what is in the file; what one of the remarks says
READ: dict[str, tuple[bytes | str, list[str]]] = {
    "repeated row": (GOOD + FIRST, ["1 row repeated exactly, first at", "line 8", "counted once"]),
    "beam break": (
        GOOD.replace("0.1,0.3,-3.2", "0.1,0.2,-3.1"), ["1 row repeat", "line 3", "beam broken"]),
    "no line end": (GOOD[:-1], ["line 7", "no line end", "complete?"]),
    "joints that scatter": (
        GOOD.replace("1,M2,10,", "1,M2,10.004,"), ["within experiments by up to 0.004 °", "means"]),
    "forces that scatter": (
        GOOD.replace("-2500,0.1,0.3", "-2504,0.1,0.3"), ["forces differ", "by up to 4 N", "means"]),
    "marked rows": (
        STATES + "2,M1,unloaded,a,b,,0,0,50,0,0,0,1,2,3,no\n",
        ["1 row marked as invalid or deleted left out"]),
    "counterpart marked": (
        edited("1500.1,1\n", "1500.1,0\n", STATES),
        ["1 readings are left out", "counterpart is marked invalid", "line 5"]),
    "rest of a sensor": (
        STATES.replace(",0,0,0,", ",0,0,-3,"), ["unloaded rows are not zero (up to 3 N)"]),
    "row commented out": (
        GOOD.replace("2,M1,", "#REF!,M1,"), ["line 4", "begins with #", "left out", "(1 such"]),
    "no UTF-8": (
        GOOD.replace("3,M", "Höhe,M").encode("cp1252"), ["read as Windows-1252", "ö"]),
}  # fmt: skip


@pytest.mark.parametrize("name", READ)
def test_what_the_reader_makes_of_it_is_said(name: str, tmp_path: Path) -> None:
    data, expected = READ[name]
    found = read(data, tmp_path)
    assert any(all(part in remark for part in expected) for remark in found.remarks), found.remarks
    assert not any("\n" in remark for remark in found.remarks)


def without_own_noise(text: str) -> str:
    return text.replace(",0.02\n", ",0.03\n")  # that of the instrument


DIFFERENCES = HEAD + (
    "1,M1,10,-60,80,30,40,50,0,0,-2500,0.2,0.2,-3,0.03\n"
    "1,M2,10,-60,80,30,40,50,0,0,-2500,0.2,0.2,-3,0.03\n"
)
# the clean twins of odd files that are not in plain form themselves
TWINS = {
    "repeated row": GOOD,
    "joints that scatter": GOOD.replace("1,M1,10,", "1,M1,10.002,"),
    "forces that scatter": GOOD.replace("-2500,0.1,0.2", "-2502,0.1,0.2"),
    "row commented out": GOOD.replace("2,M1,20,-70,90,35,45,55,0,0,-2500,0.2,0.2,-3.3,0.02\n", ""),
    "unknown uncertainty": without_own_noise(GOOD),
    "moments by another name": without_own_noise(GOOD),
    "what means nothing": without_own_noise(GOOD),
    "rotations nobody measures": without_own_noise(GOOD),
    "no UTF-8": GOOD.replace("3,M", "Höhe,M"),
    "marked rows": DIFFERENCES,
    "counterpart marked": DIFFERENCES.partition("1,M2,10")[0],
    "rest of a sensor": DIFFERENCES.replace("-2500", "-2497"),
}


def check_against(text: str, found: Measurements) -> None:
    """The readings of a plain table, each number converted here and now."""
    rows = list(csv.DictReader(text.splitlines()))
    names = list(dict.fromkeys(row["experiment"] for row in rows))
    first = [next(row for row in rows if row["experiment"] == name) for name in names]
    unit = 1.0 if "A1 [rad]" in rows[0] else np.pi / 180.0
    q = [[unit * float(v) for k, v in row.items() if k[0] == "A"] for row in first]
    force = [[float(row[f"F{axis} [N]"]) for axis in "xyz"] for row in first]
    moved = [[1e-3 * float(row[f"d{axis} [mm]"]) for axis in "xyz"] for row in rows]
    noise = np.array([1e-3 * float(row["u [mm]"]) for row in rows])
    assert found.names == tuple(names)
    np.testing.assert_array_equal(found.case, [names.index(row["experiment"]) for row in rows])
    np.testing.assert_array_equal(found.marker, [int(row["marker"][1]) - 1 for row in rows])
    np.testing.assert_allclose(found.cases.q, q, rtol=1e-12)
    np.testing.assert_allclose(found.cases.wrench[:, :3], force, rtol=1e-12)
    assert not found.cases.wrench[:, 3:].any()
    np.testing.assert_allclose(found.deflection, moved, rtol=1e-9)
    np.testing.assert_allclose(found.covariance, noise[:, None, None] ** 2 * np.eye(3), rtol=1e-9)


@pytest.mark.parametrize("name", ["plain", *ODD])
def test_what_is_odd_is_read_as_its_clean_twin(name: str, tmp_path: Path) -> None:
    """Remarks leave the numbers as they are; repeats count once, and scatter is averaged."""
    data = GOOD if name == "plain" else ODD[name][0]
    plain = data.decode() if isinstance(data, bytes) and name not in TWINS else data
    check_against(TWINS.get(name, str(plain)), read(data, tmp_path))


def test_readings_kept_aside_need_not_be_as_many_as_planned(tmp_path: Path) -> None:
    """That one experiment of three is there is no matter then; all else is said as before."""
    found = read(HEAD + FIRST, tmp_path)
    codes = [doubt.code for doubt in found.doubts]
    assert "unfinished" in codes
    aside = kept_aside(found)
    assert [doubt.code for doubt in aside.doubts] == [c for c in codes if c != "unfinished"]
    assert len(aside.doubts) == len(codes) - 1 > 0
    np.testing.assert_array_equal(aside.deflection, found.deflection)


def test_torques_that_are_planned_and_not_measured(tmp_path: Path) -> None:
    text = STUDY_TEXT.replace("count: 3", "torque_Nm: [0, 0, 10], count: 3")
    assert Doubt("no-torques", (), (), {"planned": 10.0}) in read(GOOD, tmp_path, text).doubts


def test_loaded_minus_unloaded(tmp_path: Path) -> None:
    """With the noise of the instrument, which is that of one difference."""
    found = read(STATES, tmp_path)
    assert not found.own_uncertainty
    np.testing.assert_allclose(found.deflection, [[2e-4, 2e-4, -3e-3]] * 2, rtol=1e-9)
    np.testing.assert_allclose(found.covariance, [(3e-5) ** 2 * np.eye(3)] * 2)
    np.testing.assert_array_equal(found.cases.wrench, [[0, 0, -2500, 0, 0, 0]])


def test_the_rest_of_a_sensor_is_taken_off(tmp_path: Path) -> None:
    """-1000 N loaded and -3 N unloaded act as -997 N; so do torques; compliances by hand."""
    turned = STATES.partition("\n")[2].replace("1,M", "2,M").replace("-60,80,30", "-80,95,60")
    text = (STATES + turned).replace("Fz [N]", "Fz [N],Tx [N.m],Ty [N.m],Tz [N.m]")
    text = text.replace("0,0,-2500,", "0,0,-1000,120,0,0,")
    rest = read(text.replace(",0,0,0,", ",0,0,-3,2,0,0,"), tmp_path)
    np.testing.assert_array_equal(rest.cases.wrench, [[0, 0, -997, 118, 0, 0]] * 2)
    by_hand = text.replace("-1000,120", "-997,118").replace(",50,0,0,0,", ",50,0,0,0,0,0,0,")
    fits = [identify(study().arm, m, Fit(model="linear")) for m in (rest, read(by_hand, tmp_path))]
    np.testing.assert_allclose(fits[0].model.compliance, fits[1].model.compliance, rtol=1e-12)


@pytest.mark.parametrize("swap", [False, True])
def test_covariances_are_judged_by_both_uncertainties(tmp_path: Path, swap: bool) -> None:
    """ux 100 µm, uy 1 µm: 0.9 of their product is possible, 1.1 is not."""
    u = [1.0, 100.0] if swap else [100.0, 1.0]
    head = HEAD.replace("u [mm]", "ux [um],uy [um],uz [um],cxy [um2],cxz [um2],cyz [um2]")
    for share in (0.9, -0.9, 1.1):
        own = f",{u[0]},{u[1]},10,{share * 100.0:.0f},0,0\n"
        text = head + ROWS.replace(",0.02\n", own)
        if abs(share) > 1.0:
            with pytest.raises(MeasurementFileError, match="must be positive definite"):
                read(text, tmp_path)
            continue
        expected = np.diag([u[0] ** 2, u[1] ** 2, 100.0])
        expected[0, 1] = expected[1, 0] = share * 100.0
        np.testing.assert_allclose(read(text, tmp_path).covariance[2], 1e-12 * expected)


def test_uncertainties_of_both_states_add(tmp_path: Path) -> None:
    text = STATES.replace("valid", "u [mm]").replace(",1\n", ",0.03\n")
    text = text.replace("1500.0,0.03", "1500.0,0.04")
    found = read(text, tmp_path)
    assert found.own_uncertainty
    np.testing.assert_allclose(found.covariance[0], (5e-5) ** 2 * np.eye(3))
    np.testing.assert_allclose(found.covariance[1], 2 * (3e-5) ** 2 * np.eye(3))


@pytest.mark.parametrize("own", [True, False])
def test_several_unloaded_readings_are_averaged(tmp_path: Path, own: bool) -> None:
    again = "1,M1,unloaded,10,-60,80,30,40,50,0,0,0,1000.2,2000.0,1500.0,1\n"
    text = STATES + again
    if own:
        text = text.replace("valid", "u [mm]").replace(",1\n", ",0.04\n")
    found = read(text, tmp_path)
    np.testing.assert_allclose(found.deflection[0], [1e-4, 2e-4, -3e-3], rtol=1e-8)
    variance = 1.5 * 4e-5**2 if own else 0.75 * 3e-5**2
    np.testing.assert_allclose(found.covariance[0], variance * np.eye(3))


def test_a_tracker_sees_each_marker_with_its_own_noise(tmp_path: Path) -> None:
    tracker = "{tracker: {position_mm: [4000, 1000, 500], along_um: 5, across_um: 15}}"
    text = STUDY_TEXT.replace("{sigma_mm: 0.03}", tracker)
    found = read(GOOD.replace("u [mm]", "unused"), tmp_path, text)
    what = study(text)
    for reading, (case, marker) in enumerate(zip(found.case, found.marker, strict=True)):
        pose = forward_kinematics(what.robot, found.cases.q[case : case + 1])[0]
        point = pose[:3, :3] @ found.tool.markers[marker] + pose[:3, 3]
        expected = what.instrument.covariance(point[None])[0]
        np.testing.assert_allclose(found.covariance[reading], expected, rtol=1e-9)


def test_a_hanging_mass_pulls_down(tmp_path: Path) -> None:
    rows = GOOD.replace("Fx [N],Fy [N],Fz [N]", "hanging mass [kg]").replace("0,0,-2500", "255")
    found = read(rows, tmp_path)
    np.testing.assert_allclose(found.cases.wrench[:, 2], -255 * 9.80665)
    assert not found.cases.wrench[:, [0, 1, 3, 4, 5]].any()
    heavier = read(rows, tmp_path, STUDY_TEXT + "gravity_m_s2: [0, 0, -9.81]\n")
    np.testing.assert_allclose(heavier.cases.wrench[:, 2], -255 * 9.81)


def test_three_files_row_by_row(tmp_path: Path) -> None:
    """As they often are: joints, forces, deflections, matched by nothing but their order."""
    one = STUDY_TEXT.replace(", M2: [500, 150, -300]", "")
    whole = [line.split(",") for line in GOOD.splitlines()]
    rows = [whole[0], *whole[1::2]]
    parts = {"joints": range(2, 8), "forces": range(8, 11), "deflections": range(11, 14)}
    paths = []
    for name, used in parts.items():
        paths.append(tmp_path / f"{name}.csv")
        paths[-1].write_text("".join(",".join(row[i] for i in used) + "\n" for row in rows))
    found = read_measurements(paths, study(one))
    right = read(GOOD, tmp_path)
    assert found.names == ("1", "2", "3")
    np.testing.assert_array_equal(found.cases.q, right.cases.q)
    np.testing.assert_array_equal(found.deflection, right.deflection[::2])
    assert found.source == ", ".join(map(str, paths))
    assert len(found.sha256) == 64


def test_files_of_two_days_are_one_campaign(tmp_path: Path) -> None:
    cut = GOOD.index("3,M1")
    monday, tuesday = tmp_path / "monday.csv", tmp_path / "tuesday.csv"
    monday.write_text(GOOD[:cut])
    tuesday.write_text(HEAD + GOOD[cut:])
    found, right = read_measurements([monday, tuesday], study()), read(GOOD, tmp_path)
    assert found.names == right.names
    np.testing.assert_array_equal(found.deflection, right.deflection)
    np.testing.assert_array_equal(found.case, right.case)
