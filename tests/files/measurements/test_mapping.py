"""Mapping files: foreign headers read as they are meant; bad mappings refused with their line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.measuring.measurements import Measurements
from tests.files.campaign import STUDY_TEXT, study
from tests.files.measurements.test_bad_measurements import GOOD, sentence_of
from tests.test_examples import ROOT

# In the manner of a tracker's export: cp1252, two spaces, time stamps with an apostrophe.
TRACKER = """\
Export 3 of job 17
X  [mm],Y  [mm],Z  [mm],U(95)  [mm],U(95) X  [mm],U(95) Y  [mm],U(95) Z  [mm],Image RMS  [µm],\
Target,Temperature  [C],Time Stamp,Delete
2000.0,-1000.0,1500.0,0.09,0.04,0.06,0.08,1.2,P1,21.4,'11.10.2022 15:06:48.043,
2000.1,-1000.1,1500.1,0.09,0.04,0.06,0.08,1.3,P2,21.4,'11.10.2022 15:06:58.120,
1.0,2.0,3.0,0.09,0.04,0.06,0.08,9.9,P2,21.4,'11.10.2022 15:07:02.300,1
2000.2,-1000.3,1497.0,0.09,0.04,0.06,0.08,1.2,P1,21.4,'11.10.2022 15:09:48.043,
2000.4,-1000.4,1497.0,0.09,0.04,0.06,0.08,1.1,P2,21.5,'11.10.2022 15:09:59.871,
"""
JOINTS = """\
pose;case;J1;J2;J3;J4;J5;J6;E1
1;before;10;-60;80;30;40;50;0
1;before;10;-60;80;30;40;50;0
1;before;10;-60;80;30;40;50;0
1;after;10;-60;80;30;40;50;0
1;after;10;-60;80;30;40;50;0
"""
MAPPING = """\
elastocal: 1
columns:
  experiment: pose
  state: case
  A1 [deg]: J1
  A2 [deg]: J2
  A3 [deg]: J3
  A4 [deg]: J4
  A5 [deg]: J5
  A6 [deg]: J6
  marker: Target
  x [mm]: X
  y [mm]: Y  [mm]
  z [mm]: Z [mm]
  U95x [mm]: U(95) X
  U95y [mm]: U(95) Y
  U95z [mm]: U(95) Z
  delete: Delete
constants: {"Fx [N]": 0, "Fy [N]": 0, "Fz [N]": 0}
words:
  marker: {P1: M1, P2: M2}
  state: {before: unloaded, after: loaded}
"""
LOADS = "case_,Fz [N]\n" + "a,0\n" * 3 + "b,-2500\n" * 2


def read(
    mapping: str, files: dict[str, bytes], folder: Path, text: str = STUDY_TEXT
) -> Measurements:
    for name, data in files.items():
        (folder / name).write_bytes(data)
    (folder / "mapping.yaml").write_text(mapping, "utf-8")
    return read_measurements([folder / n for n in files], study(text), folder / "mapping.yaml")


def skipped(text: str) -> str:
    """The tracker's export without the line above its header."""
    return text.split("\n", 1)[1]


TWO = {"tracker.csv": skipped(TRACKER).encode("cp1252"), "joints.csv": JOINTS.encode()}
THREE = {**TWO, "loads.csv": LOADS.encode()}
LOADED = MAPPING.replace(', "Fz [N]": 0', "").replace("  delete", "  Fz [N]: Fz\n  delete")


def test_a_tracker_export_with_joints_and_loads_beside_it(tmp_path: Path) -> None:
    found = read(LOADED, THREE, tmp_path)
    assert found.names == ("1",)
    assert found.own_uncertainty
    np.testing.assert_allclose(np.degrees(found.cases.q), [[10, -60, 80, 30, 40, 50]])
    np.testing.assert_array_equal(found.cases.wrench, [[0, 0, -2500, 0, 0, 0]])
    expected = [[2e-4, -3e-4, -3e-3], [3e-4, -3e-4, -3.1e-3]]
    np.testing.assert_allclose(found.deflection, expected, rtol=1e-8)
    variance = 2 * (np.array([0.02, 0.03, 0.04]) / 1e3) ** 2
    np.testing.assert_allclose(found.covariance, [np.diag(variance)] * 2)
    assert any("1 row marked" in remark for remark in found.remarks)


def test_lines_before_the_header_are_skipped(tmp_path: Path) -> None:
    joints = "\n".join(["joints of job 17", *JOINTS.splitlines()]) + "\n"
    files = {
        "tracker.csv": TRACKER.encode("cp1252"),
        "joints.csv": joints.encode(),
        "loads.csv": b"loads\n" + LOADS.encode(),
    }
    found = read(LOADED.replace("columns:", "skip_lines: 1\ncolumns:", 1), files, tmp_path)
    assert len(found) == 2


@pytest.mark.parametrize(
    "frame", ["{rpy_deg: [0, 0, 90]}", "{matrix: [[0, -1, 0], [1, 0, 0], [0, 0, 1]]}"]
)
def test_readings_in_the_frame_of_the_tracker_are_turned(tmp_path: Path, frame: str) -> None:
    straight = read(LOADED, THREE, tmp_path)
    turned = read(f"{LOADED}frame: {frame}\n", THREE, tmp_path)
    x, y, z = straight.deflection.T
    np.testing.assert_allclose(turned.deflection, np.stack([-y, x, z], axis=1), atol=1e-15)
    variance = straight.covariance[0].diagonal()[[1, 0, 2]]
    np.testing.assert_allclose(turned.covariance[0], np.diag(variance), atol=1e-22)
    np.testing.assert_array_equal(turned.cases.wrench, straight.cases.wrench)


def test_roll_pitch_yaw_are_about_fixed_axes(tmp_path: Path) -> None:
    """Roll first: x to x, y to z; then yaw. Against the product written out."""
    turned = read(f"{LOADED}frame: {{rpy_deg: [90, 0, 90]}}\n", THREE, tmp_path)
    x, y, z = read(LOADED, THREE, tmp_path).deflection.T
    np.testing.assert_allclose(turned.deflection, np.stack([z, x, y], axis=1), atol=1e-15)


def test_joints_as_the_controller_shows_them(tmp_path: Path) -> None:
    text = STUDY_TEXT + "controller: {signs: {A1: -1}, offsets_deg: {A2: -90}}\n"
    found = read(f"{LOADED}joints: controller\n", THREE, tmp_path, text)
    np.testing.assert_allclose(np.degrees(found.cases.q), [[-10, 30, 80, 30, 40, 50]])
    plain = read(LOADED, THREE, tmp_path, text)
    np.testing.assert_allclose(np.degrees(plain.cases.q), [[10, -60, 80, 30, 40, 50]])
    assert any("not of its controller" in remark for remark in plain.remarks)
    assert not any("not of its controller" in remark for remark in found.remarks)


WIDE = """\
1 10 -60  80 30 40 50 -2500 0.1 0.2 -3.1 0.4 0.5 -3.6
2 20 -70  90 35 45 55 -2500 0.2 0.2 -3.3 0.5 0.5 -3.8

3 30 -80  95 31 41 51 -2500 0.3 0.2 -3.5 0.6 0.5 -3.9
"""
NUMBERED = """\
elastocal: 1
header: false
delimiter: space
columns: {experiment: 1, "A1 [deg]": 2, "A2 [deg]": 3, "A3 [deg]": 4, "A4 [deg]": 5, "A5 [deg]": 6,
          "A6 [deg]": 7, "Fz [N]": 8}
markers:
  M1: {"dx [mm]": 9, "dy [mm]": 10, "dz [mm]": 11}
  M2: {"dx [mm]": 12, "dy [mm]": 13, "dz [mm]": 14}
constants: {"Fx [N]": 0, "Fy [N]": 0, "u [mm]": 0.03}
"""


def test_a_matrix_without_header_and_a_column_for_each_marker(tmp_path: Path) -> None:
    found = read(NUMBERED, {"points.txt": WIDE.encode()}, tmp_path)
    assert found.names == ("1", "2", "3")
    np.testing.assert_array_equal(found.marker, [0, 1] * 3)
    np.testing.assert_array_equal(found.case, [0, 0, 1, 1, 2, 2])
    np.testing.assert_allclose(found.deflection[3], [5e-4, 5e-4, -3.8e-3])
    np.testing.assert_allclose(found.covariance, [(3e-5) ** 2 * np.eye(3)] * 6)
    bad = WIDE.replace("-3.8", "none")
    sentence = sentence_of(lambda: read(NUMBERED, {"points.txt": bad.encode()}, tmp_path))
    assert "line 2, column '14'" in sentence


def test_one_file_for_each_state(tmp_path: Path) -> None:
    head = "id,m," + ",".join(f"j{i}" for i in range(1, 7)) + ",X,Y,Z\n"
    files = {
        "before.csv": f"{head}7,M1,10,-60,80,30,40,50,2.0,-1.0,1.5\n".encode(),
        "after.csv": f"{head}7,M1,10,-60,80,30,40,50,2.0002,-1.0,1.497\n".encode(),
    }
    columns = "".join(f"  A{i} [deg]: j{i}\n" for i in range(1, 7))
    mapping = (
        f"elastocal: 1\ncolumns:\n  experiment: id\n  marker: m\n{columns}"
        "  x [m]: X\n  y [m]: Y\n  z [m]: Z\n"
        "constants:\n  state: [unloaded, loaded]\n  Fx [N]: 0\n  Fy [N]: 0\n"
        "  Fz [kgf]: [0, -250]\n"
    )
    found = read(mapping, files, tmp_path)
    np.testing.assert_allclose(found.deflection, [[2e-4, 0, -3e-3]], atol=1e-12)
    np.testing.assert_allclose(found.cases.wrench[0, 2], -250 * 9.80665)


def test_decimal_sign_and_delimiter_by_word(tmp_path: Path) -> None:
    text = GOOD.replace(",", ";").replace(".", ",")
    mapping = "elastocal: 1\ndelimiter: semicolon\ndecimal: comma\nencoding: utf-8\ncolumns:\n"
    names = ["experiment", "marker", *(f"A{i}" for i in range(1, 7)), "Fx", "Fy", "Fz"]
    mapping += "".join(f"  {name}: {name}\n" for name in [*names, "dx", "dy", "dz", "u"])
    found = read(mapping, {"m.csv": text.encode()}, tmp_path)
    assert len(found) == 6
    assert found.remarks == found.doubts == ()


# old, new in the mapping; what must be in the sentence
BAD: dict[str, tuple[str, str, list[str]]] = {
    "no version": ("elastocal: 1", "version: 1", ["line 1", "begins with 'elastocal: 1'"]),
    "other version": ("elastocal: 1", "elastocal: 3", ["line 1", "found 3"]),
    "brackets in braces": ('"Fx [N]"', "Fx [N]", ["line 20", "quote keys", '{"x [mm]": X}']),
    "not YAML": ("columns:", "columns: [", ["mapping.yaml", "not valid YAML"]),
    "unknown key": ("words:", "word:", ["line 21", "unknown key 'word'", "'words'"]),
    "no columns": ("columns:", "column_:", ["line 2", "unknown key 'column_'"]),
    "unknown quantity": ("A1 [deg]:", "B1 [deg]:", ["line 5", "no quantity 'B1'", "A1, A2"]),
    "unit of a word": ("state:", "state [N]:", ["line 4", "'state' has no unit"]),
    "unit of another kind": ("A1 [deg]", "A1 [N]", ["line 5", "'N' is not accepted", "force"]),
    "no unit anywhere": ("A1 [deg]", "A1", ["line 5", "'J1' has no unit"]),
    "other unit": ("x [mm]: X", "x [m]: X", ["line 12", "says [m]", "'X [mm]'", "same unit"]),
    "no such column": (
        "A1 [deg]: J1", "A1 [deg]: J9", ["line 5", "no column 'J9'", "joints.csv", "'J1'"]),
    "no such number": (
        "A1 [deg]: J1", "A1 [deg]: {file: 2, column: 99}", ["line 5", "no column 99", "only 9"]),
    "no such file": (
        "A1 [deg]: J1", "A1 [deg]: {file: 9, column: 1}", ["line 5", "no file 9, only 3"]),
    "column that means no": (
        "A1 [deg]: J1", "A1 [deg]: No", ["line 5", "found false; yes, no, on and off"]),
    "column zero": ("A1 [deg]: J1", "A1 [deg]: 0", ["line 5", "columns"]),
    "not a column": (
        "A1 [deg]: J1", "A1 [deg]: [1]", ["line 5: columns.A1 [deg]: expected the name", "[1]"]),
    "not a file": (
        "A1 [deg]: J1", "A1 [deg]: {file: x, column: 1}", ["line 5: columns.A1 [deg].file: "]),
    "empty column": ("A1 [deg]: J1", "A1 [deg]: ' '", ["line 5", "is empty"]),
    "quantity twice": ("A1 [deg]: J1", "a2 [deg]: J1", ["line 6", "'A2' is given twice"]),
    "constant of a column": ('"Fx [N]": 0', '"x [mm]": 0', ["line 20", "'x' is given twice"]),
    "constant without unit": ('"Fx [N]": 0', '"Fx": 0', ["line 20", "'Fx' has no unit"]),
    "constant that is no number": ('"Fx [N]": 0', '"Fx [N]": zero', ["line 20", "'zero'"]),
    "constant beyond all measure": (
        '"Fx [N]": 0', '"Fx [N]": 1.0e+12', ["line 20", "a number below 1e+09, found 1e+12"]),
    "constant that is a flag": ('"Fx [N]": 0', '"Fx [N]": true', ["line 20", "number", "true"]),
    "one constant of several": (
        '"Fx [N]": 0', '"Fx [N]": [0, .inf]', ["line 20: constants.Fx [N], entry 2", "finite"]),
    "constants for no files": (
        '"Fx [N]": 0', '"Fx [N]": [0, 1, 2]', ["line 20", "3 values", "files"]),
    "no constant": ('"Fx [N]": 0', '"Fx [N]": []', ["line 20", "empty list"]),
    "words of a number": ("  marker: {", "  Fx: {", ["line 22", "'Fx' has no words"]),
    "words of no column": (
        "  marker: {", "  valid: {yes: x}\n  marker: {",
        ["line 22", "words of 'valid', for which this mapping names no column"]),
    "words twice": ("P1: M1,", "P1: M1, p1: M2,", ["line 22", "'p1' is 'M2' here and 'M1'"]),
    "half a frame": ("words:", "frame: {}\nwords:", ["line 21", "rpy_deg or matrix"]),
    "no rotation": (
        "words:", "frame: {matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 2]]}\nwords:", ["no rotation"]),
    "no rotation but smaller": (
        "words:", "frame: {matrix: [[0.9, 0, 0], [0, 0.9, 0], [0, 0, 0.9]]}\nwords:",
        ["no rotation"]),
    "reflection": (
        "words:", "frame: {matrix: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}\nwords:", ["a reflection"]),
    "no encoding": ("columns:", "encoding: klingon\ncolumns:", ["line 2", "no encoding 'klingon'"]),
    "encoding of bytes": ("columns:", "encoding: hex\ncolumns:", ["line 2", "no encoding 'hex'"]),
    "wrong encoding": ("columns:", "encoding: ascii\ncolumns:", ["not readable as ascii"]),
    "unknown delimiter": ("columns:", "delimiter: dot\ncolumns:", ["line 2", "'comma'", "'dot'"]),
    "negative lines": ("columns:", "skip_lines: -1\ncolumns:", ["line 2", "skip_lines"]),
    "names without a header": (
        "columns:", "header: false\ncolumns:", ["'header: false'", "numbers", "'pose'"]),
    "marker twice": (
        "words:", "markers: {M1: {'dx [mm]': X}}\nwords:", ["line 11", "'marker' is given twice"]),
    "unknown marker": ("P2: M2", "P2: M7", ["tracker.csv, line 3, column 'Target'", "'M7'"]),
    "unknown state": ("after: loaded", "after: heavy", ["joints.csv, line 5", "'heavy'"]),
    "unknown joints": ("words:", "joints: mine\nwords:", ["joints", "'model' or 'controller'"]),
}  # fmt: skip


@pytest.mark.parametrize(
    "name",
    ["idna", "punycode", "rot13", "rot_13", "hex", "zip", "undefined", "unicode_escape", "utf-9"],
)
def test_what_is_no_encoding_of_text_gets_its_sentence(name: str, tmp_path: Path) -> None:
    mapping = MAPPING.replace("columns:", f"encoding: {name}\ncolumns:", 1)
    sentence = sentence_of(lambda: read(mapping, TWO, tmp_path))
    assert f"line 2: encoding: no encoding {name!r} of text is known; expected" in sentence


@pytest.mark.parametrize("name", ["utf-16-le", "utf-16", "utf-32-be", "utf-8-sig", "gb18030"])
def test_encodings_that_the_mapping_names_are_read(name: str, tmp_path: Path) -> None:
    mapping = MAPPING.replace("columns:", f"encoding: {name}\ncolumns:", 1)
    files = {n: data.decode("cp1252").encode(name) for n, data in TWO.items()}
    found = read(mapping, files, tmp_path)
    np.testing.assert_array_equal(found.deflection, read(MAPPING, TWO, tmp_path).deflection)


@pytest.mark.parametrize("name", BAD)
def test_a_bad_mapping_gets_its_sentence(name: str, tmp_path: Path) -> None:
    old, new, expected = BAD[name]
    assert old in LOADED
    sentence = sentence_of(lambda: read(LOADED.replace(old, new, 1), THREE, tmp_path))
    for part in expected:
        assert part in sentence, sentence


def test_a_marker_without_a_column_that_others_have(tmp_path: Path) -> None:
    mapping = NUMBERED.replace(', "dz [mm]": 14', "")
    sentence = sentence_of(lambda: read(mapping, {"points.txt": WIDE.encode()}, tmp_path))
    assert "marker 'M2' has no column for 'dz'" in sentence


def test_a_name_that_a_file_has_twice(tmp_path: Path) -> None:
    files = THREE | {"tracker.csv": skipped(TRACKER).replace("Y  [mm]", "X [um]").encode("cp1252")}
    sentence = sentence_of(lambda: read(LOADED, files, tmp_path))
    assert "has 2 columns 'X'" in sentence


def test_a_mapping_that_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text(GOOD)
    with pytest.raises(MeasurementFileError, match="no such file"):
        read_measurements(tmp_path / "m.csv", study(), tmp_path / "absent.yaml")


def test_the_example_of_the_documents_is_a_whole_mapping(tmp_path: Path) -> None:
    """Copied as it stands, for a tracker's file and the joints beside it, row by row."""
    formats = (ROOT / "docs" / "file-formats.md").read_text("utf-8")
    section = formats.split("\n## Mapping files\n")[1]
    example = section.split("```yaml\n")[1].split("```")[0]
    points = "Point ID,Load,X  [mm],Y,Z,Weight\n7,before,1000,5,2000,0\n"
    points += "7,after,1000.2,5.1,1997,250\n"
    joints = "J1;J2;J3;J4;J5;J6\n" + "10;-60;80;30;40;50\n" * 2
    one = STUDY_TEXT.replace(", M2: [500, 150, -300]", "")
    files = {"points.csv": points.encode(), "joints.csv": joints.encode()}
    found = read(example, files, tmp_path, one)
    assert (found.names, found.own_uncertainty) == (("7",), True)
    np.testing.assert_allclose(found.deflection, [[2e-4, 1e-4, -3e-3]], atol=1e-12)
    np.testing.assert_allclose(found.cases.wrench[0], [0, 0, -250 * 9.80665, 0, 0, 0])
    np.testing.assert_allclose(np.degrees(found.cases.q[0]), [10, -60, 80, 30, 40, 50])


@pytest.mark.parametrize(
    ("mapped", "header"),
    [
        ("u [um]: U", "U [\u00b5m]"),
        ("u [um]: U", "U [\u03bcm]"),
        ("u [\u00b5m]: U", "U [um]"),
        ("u [\u03bcm]: U", "U [\u00b5m]"),
        ("u [um]: U [um]", "U  [\u03bcm]"),
        ("u [\u03bcm]: U [\u00b5m]", "U [um]"),
        ('"u [um]": U', "U"),
        ("u: U [um]", "U [\u00b5m]"),
        ("u [um]: Uncert. f\u00fcr x", "Uncert. fu\u0308r x [um]"),
    ],
)
def test_a_unit_is_the_same_in_any_spelling(mapped: str, header: str, tmp_path: Path) -> None:
    names = ["experiment", "marker", *(f"A{i}" for i in range(1, 7)), "Fx", "Fy", "Fz"]
    columns = "".join(f"  {name}: {name}\n" for name in [*names, "dx", "dy", "dz"])
    text = GOOD.replace("u [mm]", header).replace(",0.02\n", ",20\n")
    mapping = f"elastocal: 1\ncolumns:\n{columns}  {mapped}\n"
    found = read(mapping, {"m.csv": text.encode()}, tmp_path)
    np.testing.assert_allclose(found.covariance[0], (2e-5) ** 2 * np.eye(3), rtol=1e-12)
    assert found.doubts == ()
