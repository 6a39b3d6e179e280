"""Bad measurement files: each gets one sentence that names the place, what was found, expected."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.measurement_file import read_measurements
from tests.files.campaign import study

HEAD = (
    "experiment,marker,A1 [deg],A2 [deg],A3 [deg],A4 [deg],A5 [deg],A6 [deg],"
    "Fx [N],Fy [N],Fz [N],dx [mm],dy [mm],dz [mm],u [mm]\n"
)
ROWS = """\
1,M1,10,-60,80,30,40,50,0,0,-2500,0.1,0.2,-3.1,0.02
1,M2,10,-60,80,30,40,50,0,0,-2500,0.1,0.3,-3.2,0.02
2,M1,20,-70,90,35,45,55,0,0,-2500,0.2,0.2,-3.3,0.02
2,M2,20,-70,90,35,45,55,0,0,-2500,0.2,0.3,-3.4,0.02
3,M1,30,-80,95,31,41,51,0,0,-2500,0.3,0.2,-3.5,0.02
3,M2,30,-80,95,31,41,51,0,0,-2500,0.3,0.3,-3.6,0.02
"""
GOOD = HEAD + ROWS
FIRST = "1,M1,10,-60,80,30,40,50,0,0,-2500,0.1,0.2,-3.1,0.02\n"
STATES = """\
experiment,marker,state,A1 [deg],A2 [deg],A3 [deg],A4 [deg],A5 [deg],A6 [deg],Fx [N],Fy [N],\
Fz [N],x [mm],y [mm],z [mm],valid
1,M1,unloaded,10,-60,80,30,40,50,0,0,0,1000.0,2000.0,1500.0,1
1,M2,unloaded,10,-60,80,30,40,50,0,0,0,1000.1,2000.1,1500.1,1
1,M1,loaded,10,-60,80,30,40,50,0,0,-2500,1000.2,2000.2,1497.0,1
1,M2,loaded,10,-60,80,30,40,50,0,0,-2500,1000.3,2000.3,1497.1,1
"""


def edited(old: str, new: str, text: str = GOOD) -> bytes:
    assert text.count(old) >= 1, old
    return text.replace(old, new, 1).encode()


# what is in the file; what must be in the sentence
CASES: dict[str, tuple[bytes, list[str]]] = {
    # the file as such
    "empty": (b"", ["m.csv: the file is empty"]),
    "only white space": (b" \r\n \n", ["the file is empty"]),
    "only comments": (b"# nothing\n# here\n", ["no table", "only comments"]),
    "header only": (HEAD.encode(), ["a header, but no row of data"]),
    "header and blank rows": (HEAD.encode() + b",,,\n\n", ["no row of data"]),
    "binary": (b"\x7fELF\x02\x01\x01" + bytes(9), ["line 1", "0x7f does not occur in text"]),
    "Excel workbook": (b"PK\x03\x04" + bytes(30), ["Excel workbook", "save the sheet as CSV"]),
    "old Excel workbook": (b"\xd0\xcf\x11\xe0\xa1\xb1", ["Excel workbook"]),
    "UTF-16 without its mark": (GOOD.encode("utf-16-le"), ["line 1", "0x00", "byte order mark"]),
    "no known encoding": (GOOD.encode() + b"\x81", ["line 8", "not readable", "UTF-8"]),
    "another version": (
        b"# elastocal measurements, version 2\n" + GOOD.encode(),
        ["line 1", "version '2'", "reads 1"]),
    # the header
    "no header": (ROWS.replace("M", "").encode(), ["line 1", "numbers where the names"]),
    "header commented out": (
        b"# " + GOOD.replace("M", "").encode(), ["line 2", "numbers where", "comments beginning"]),
    "no experiment": (edited("experiment,", "number,"), ["line 1", "'experiment' is missing"]),
    "no marker": (edited("marker,", "SMR,"), ["'marker' is missing"]),
    "no joint": (edited("A3 [deg]", "q3 [deg]"), ["column 'A3 [deg]' is missing"]),
    "joint in round brackets": (
        edited("A3 [deg]", "A3 (deg)"), ["'A3 [deg]' is missing", "found 'A3 (deg)'"]),
    "no force": (edited("Fy [N],", "Gy [N],"), ["column 'Fy [N]' is missing"]),
    "no deflection": (edited("dz [mm]", "z [mm]"), ["column 'dz [mm]' is missing"]),
    "some torques": (edited("u [mm]", "Tx [N.m]"), ["column 'Ty [N.m]' is missing"]),
    "positions without state": (
        edited("dx [mm],dy [mm],dz [mm]", "x [mm],y [mm],z [mm]"),
        ["'state' is missing", "loaded"]),
    "no unit": (edited("Fz [N]", "Fz"), ["line 1", "'Fz' has no unit", "such as 'Fz [N]'"]),
    "empty unit": (edited("dx [mm]", "dx []"), ["'dx []' has no unit", "'dx [mm]'"]),
    "unit of another kind": (
        edited("A1 [deg]", "A1 [mm]"), ["'A1 [mm]'", "unit of length", "deg, rad, mrad"]),
    "unknown unit": (edited("dx [mm]", "dx [mil]"), ["'mil' is not accepted", "mm, m"]),
    "unit in another case": (edited("dx [mm]", "dx [MM]"), ["'MM'", "did you mean mm?"]),
    "mass for a force": (
        edited("Fz [N]", "Fz [kg]"), ["'kg'", "a mass is no force", "hanging mass [kg]"]),
    "column twice": (edited("A2 [deg]", "A1 [deg]"), ["'A1 [deg]' appears twice"]),
    "quantity twice": (edited("A2 [deg]", "A1 [rad]"), ["'A1 [deg]' and 'A1 [rad]'", "'A1'"]),
    "force and hanging mass": (
        edited("u [mm]", "hanging mass [kg]"), ["'hanging mass' and 'Fx'", "exclude each other"]),
    "state of a deflection": (edited("u [mm]", "state"), ["'state' and 'dx'", "has no state"]),
    "two uncertainties": (
        edited(",0.02\n", ",0.02,0.04\n").replace(b"u [mm]", b"u [mm],U95 [mm]"),
        ["'u' and 'U95'"]),
    "uncertainty of one axis": (edited("u [mm]", "ux [mm]"), ["'uy [mm]' is missing"]),
    "capital U": (edited("u [mm]", "U [mm]"), ["'U [mm]' is ambiguous", "U95"]),
    # rows
    "row too short": (edited("-3.1,0.02\n", "-3.1\n"), ["line 2", "14 cells", "header has 15"]),
    "row too long": (edited("-3.1,0.02\n", "-3.1,0.02,7\n"), ["line 2", "16 cells"]),
    "decimal commas between commas": (
        edited("0.1,0.2,-3.1,0.02", "0,1,0,2,-3,1,0,02"), ["line 2", "semicolon or tab"]),
    "half-written last line": (
        GOOD.encode()[:-25], ["line 7", "the last line is only half written", "of 15 cells"]),
    "quote not closed": (edited("1,M1,", '1,"M1,'), ["line 2", "a quote", "not closed"]),
    # cells
    "empty cell": (edited("10,-60", ",-60"), ["line 2, column 'A1 [deg]'", "the cell is empty"]),
    "text for a number": (
        edited("10,-60", "ten,-60"), ["line 2, column 'A1 [deg]'", "a number, found 'ten'"]),
    "unit in the cell": (
        edited("-2500", "-2500 N"), ["column 'Fz [N]'", "'-2500 N'", "unit belongs in the header"]),
    "NaN": (edited("0.1,0.2", "nan,0.2"), ["line 2, column 'dx [mm]'", "finite", "'nan'"]),
    "infinity": (edited("0.1,0.2", "-inf,0.2"), ["line 2, column 'dx [mm]'", "finite"]),
    "spreadsheet error": (edited("0.1,0.2", "#N/A,0.2"), ["column 'dx [mm]'", "found '#N/A'"]),
    "beyond all measure": (edited("0.1,0.2", "1e300,0.2"), ["finite number, found '1e300'"]),
    "thousands separators": (
        edited("-2500", '"-2,500.0"'), ["column 'Fz [N]'", "without thousands separators"]),
    "decimal comma in quotes": (
        edited("0.1,0.2", '"0,1",0.2'),
        ["line 2, column 'dx [mm]': '0,1' here and '0.2' in line 2"]),
    "decimal commas and points": (
        edited("0,3;-3,6;0,02", "0.3;-3,6;0,02", GOOD.replace(",", ";").replace(".", ",")),
        ["line 2, column 'dx [mm]'", "'0,1'", "'0.3' in line 7", "one decimal sign"]),
    "a comma that is in no number": (
        edited("0.1;0.2", "a,b;0.2", GOOD.replace(",", ";")),
        ["line 2, column 'dx [mm]'", "found 'a,b'"]),
    "decimal point far below decimal commas": (
        (HEAD + FIRST * 1100 + FIRST).replace(",", ";").replace(".", ",")[::-1]
        .replace("1,3-", "1.3-", 1)[::-1].encode(),
        ["column 'dz [mm]'", "a decimal comma as in the rows before", "'-3.1'"]),
    "another load in the rows of one experiment": (
        edited("1,M2,10,-60,80,30,40,50,0,0,-2500", "1,M2,10,-60,80,30,40,50,0,0,-2537.5"),
        ["line 3", "'Fz [N]'", "-2537.5 N here and -2500 N in line 2", "one load for each"]),
    "underscore": (edited("-2500", "-2_500"), ["column 'Fz [N]'", "found '-2_500'"]),
    "spoilt by a spreadsheet": (edited("0.1,0.2", "01. Jan,0.2"), ["found '01. Jan'"]),
    "no name": (edited("1,M1", ",M1"), ["line 2, column 'experiment'", "the cell is empty"]),
    "unknown marker": (
        edited("3,M2", "3,M9"), ["line 7, column 'marker'", "no marker 'M9'", "M1, M2"]),
    "zero uncertainty": (
        edited("-3.2,0.02", "-3.2,0"), ["line 3, column 'u [mm]'", "positive, found 0 mm"]),
    "negative uncertainty": (edited("-3.2,0.02", "-3.2,-0.02"), ["line 3", "found -0.02 mm"]),
    "uncertainty of no instrument": (
        edited("-3.2,0.02", "-3.2,1e-300"),
        ["line 3, column 'u [mm]'", "expected 1e-09 to 10000 mm, found 1e-300 mm"]),
    "uncertainty beyond the robot": (
        edited("-3.2,0.02", "-3.2,1e8"), ["line 3", "no instrument", "found 1e+08 mm"]),
    "uncertainty of another unit": (
        edited("u [mm]", "u [m]").replace(b",0.02\n", b",20\n"),
        ["line 2, column 'u [m]'", "no instrument", "found 20000 mm"]),
    "unknown state": (
        edited("1,M2,loaded", "1,M2,halfloaded", STATES),
        ["line 5, column 'state'", "loaded, unloaded", "'halfloaded'"]),
    "unknown mark": (edited("1500.0,1\n", "1500.0,maybe\n", STATES), ["column 'valid'", "'maybe'"]),
    "no row is valid": (
        STATES.replace(",1\n", ",0\n").encode(),
        ["every row is marked as invalid"]),
    # rows that do not fit together
    "loaded without unloaded": (
        edited("1,M2,unloaded", "2,M2,unloaded", STATES),
        ["line 3", "experiment '2', marker 'M2'", "unloaded but none loaded"]),
    "only loaded": (
        STATES.replace("unloaded", "loaded").replace(",0,0,0,", ",0,0,-2500,").encode(),
        ["line 2", "loaded but none unloaded"]),
    "joints differ between markers": (
        edited("1,M2,10,", "1,M2,11,"),
        ["line 3, column 'A1 [deg]'", "experiment '1'", "11 °", "10 ° in line 2"]),
    "joints differ between states": (
        edited("1,M1,loaded,10,-60", "1,M1,loaded,10,-61", STATES), ["line 4, column 'A2 [deg]'"]),
    "force differs between markers": (
        edited("55,0,0,-2500,0.2,0.3", "55,0,0,-2000,0.2,0.3"),
        ["line 5, column 'Fz [N]'", "experiment '2'", "-2000 N", "-2500 N in line 4"]),
    "unloaded under the full load": (
        STATES.replace(",0,0,0,", ",0,0,-2500,").encode(),
        ["line 2, column 'Fz [N]'", "expected zero"]),
    "same marker with another deflection": (
        edited(FIRST, FIRST + FIRST.replace("0.1", "0.4")), ["line 3", "'M1' was given in line 2"]),
    "covariances that cannot be": (
        GOOD.replace("u [mm]", "ux [mm],uy [mm],uz [mm],cxy [mm2],cxz [mm2],cyz [mm2]")
        .replace(",0.02\n", ",0.02,0.02,0.02,0.0005,0,0\n").encode(),
        ["line 2", "positive definite"]),
    "covariances without uncertainties": (edited("u [mm]", "cxy [mm2]"), ["needs all of ux, uy"]),
}  # fmt: skip


def sentence_of(read: Callable[[], object]) -> str:
    with pytest.raises(MeasurementFileError) as caught:
        read()
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert len(sentence) < 500
    return sentence


@pytest.mark.parametrize("name", CASES)
def test_a_bad_file_gets_its_sentence(name: str, tmp_path: Path) -> None:
    data, expected = CASES[name]
    path = tmp_path / "m.csv"
    path.write_bytes(data)
    sentence = sentence_of(lambda: read_measurements(path, study()))
    assert str(path) in sentence
    for part in expected:
        assert part in sentence, sentence


def test_there_are_enough_of_them() -> None:
    assert len(CASES) >= 40


def test_the_good_files_are_good(tmp_path: Path) -> None:
    """The negative control of the whole table: only what was edited is refused."""
    for text, readings in ((GOOD, 6), (STATES, 2)):
        path = tmp_path / "m.csv"
        path.write_text(text)
        assert len(read_measurements(path, study())) == readings


@pytest.mark.parametrize(
    ("name", "expected"),
    [("absent.csv", "no such file"), ("", "cannot be read"), ("null\0.csv", "not a file name")],
)
def test_what_is_no_file_is_refused(tmp_path: Path, name: str, expected: str) -> None:
    assert expected in sentence_of(lambda: read_measurements(tmp_path / name, study()))


def test_a_file_that_is_too_large_is_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("elastocal.files.tables.decoding.LARGEST", 1000)
    path = tmp_path / "m.csv"
    path.write_text(GOOD * 3)
    assert "more than the 1000" in sentence_of(lambda: read_measurements(path, study()))


def test_no_file_at_all() -> None:
    assert "no measurement file" in sentence_of(lambda: read_measurements([], study()))


def columns(*wanted: int) -> str:
    """Some columns of the good file."""
    rows = [line.split(",") for line in GOOD.splitlines()]
    return "".join(",".join(row[i] for i in wanted) + "\n" for row in rows)


# joints; forces; deflections; what must be in the sentence
ROW_BY_ROW: dict[str, tuple[str, str, str, list[str]]] = {
    "row counts": (
        columns(*range(2, 8)), columns(8, 9, 10).removesuffix("0,0,-2500\n"),
        columns(0, 1, 11, 12, 13), ["forces.csv: 5 rows, but 6 in", "joints.csv"]),
    "same column of numbers": (
        columns(*range(2, 9)), columns(8, 9, 10), columns(0, 1, 11, 12, 13),
        ["'Fx [N]' is in", "too"]),
    "other names": (
        columns(0, *range(2, 8)).replace("\n2,", "\n4,", 1), columns(8, 9, 10),
        columns(0, 1, 11, 12, 13), ["deflections.csv, line 4", "'2' is matched with '4'"]),
    "column in no file": (
        columns(*range(2, 8)), columns(8, 9), columns(0, 1, 11, 12, 13), ["'Fz [N]' is missing"]),
    "experiment missing with several markers": (
        columns(*range(2, 8)), columns(8, 9, 10), columns(1, 11, 12, 13),
        ["'experiment' is missing"]),
}  # fmt: skip


@pytest.mark.parametrize("name", ROW_BY_ROW)
def test_files_that_do_not_match_row_by_row(name: str, tmp_path: Path) -> None:
    *texts, expected = ROW_BY_ROW[name]
    paths = [tmp_path / f"{part}.csv" for part in ("joints", "forces", "deflections")]
    for path, text in zip(paths, texts, strict=True):
        assert isinstance(text, str)
        path.write_text(text)
    sentence = sentence_of(lambda: read_measurements(paths, study()))
    for part in expected:
        assert part in sentence, sentence
