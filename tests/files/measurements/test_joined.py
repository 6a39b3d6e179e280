"""Files of one campaign joined by a key, rows chosen, names split, and what does not belong."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.patterns import pattern_of
from elastocal.measuring.positions import Positions
from tests.files.absolute_campaign import JOINTS, rows, table, truth
from tests.files.measurements.test_bad_measurements import sentence_of
from tests.files.measurements.test_positions import read

TRUTH = truth(6)
POINTS = table(
    ["Name", "X", "Y", "Z", "mood"],
    [
        [f"P{int(r[0]):02d}-{r[1]}", *r[8:], "good" if i % 4 else "bad"]
        for i, r in enumerate(rows(TRUTH))
    ],
)
POSES = table(["Pose", *JOINTS], [[r[0], *r[2:8]] for r in rows(TRUTH, markers=1)], ";")
LIST = "row;use\n" + "".join(f"{line};{'ab'[line % 2]}\n" for line in range(3, 12))
FILES = {"points.csv": POINTS, "poses.csv": POSES}
JOIN = r"""
elastocal: 1
join: experiment
patterns: {Name: 'P(?P<experiment>\d+)-(?P<marker>M\d)'}
columns:
  x y z [mm]: [X, Y, Z]
  q [deg]: [A1, A2, A3, A4, A5, A6]
  experiment: {file: 2, column: Pose}
"""
LINES = r"""
elastocal: 1
patterns: {Name: 'P(?P<experiment>\d+)-(?P<marker>M\d)'}
columns:
  x y z [mm]: [X, Y, Z]
  q [deg]: [A1, A2, A3, A4, A5, A6]
files: [{}, {join: experiment, columns: {experiment: Pose}}, {join: line, columns: {line: row}}]
keep: {use: [a]}
"""
THREE = {**FILES, "list.csv": LIST}


def test_poses_by_their_key(tmp_path: Path) -> None:
    """01 in one file is 1 in the other."""
    found = read(FILES, tmp_path, JOIN)
    np.testing.assert_allclose(found.cases.q, TRUTH.q, atol=1e-11)
    np.testing.assert_allclose(found.value, TRUTH.points.reshape(-1, 3), atol=1e-9)
    assert found.names == ("01", "02", "03", "04", "05", "06")
    assert found.remarks == ()
    mixed = {
        **FILES,
        "poses.csv": "".join([POSES.splitlines(True)[0], *POSES.splitlines(True)[:0:-1]]),
    }
    np.testing.assert_array_equal(read(mixed, tmp_path, JOIN).cases.q, found.cases.q)


def test_lines_of_a_list(tmp_path: Path) -> None:
    found = read(THREE, tmp_path, LINES)
    lines = [line for line in range(3, 12) if line % 2 == 0]
    every = TRUTH.points.reshape(-1, 3)
    np.testing.assert_allclose(found.value, every[np.array(lines) - 2], atol=1e-9)
    said = " ".join(found.remarks)
    assert "3 of 12 rows left out that list.csv does not list" in said
    assert "5 of 9 rows left out that do not have 'a' in 'use'" in said


def test_rows_chosen_by_a_word_need_no_numbers_elsewhere(tmp_path: Path) -> None:
    """What is not kept may hold anything."""
    spoilt = POINTS.replace(",bad", ";", 1)
    lines = [line.rsplit(",", 2) if line.endswith("bad") else None for line in POINTS.splitlines()]
    spoilt = "\n".join(
        ",".join([parts[0], "none", parts[2]]) if parts else line
        for parts, line in zip(lines, POINTS.splitlines(), strict=True)
    )
    files = {**FILES, "points.csv": spoilt + "\n"}
    found = read(files, tmp_path, f"{JOIN}keep: {{mood: good}}\n")
    assert len(found) == 9
    by_word = read(FILES, tmp_path, f"{JOIN}keep: {{experiment: [2, 3], marker: M2}}\n")
    np.testing.assert_allclose(by_word.value, TRUTH.points[[1, 2], 1], atol=1e-9)


def test_a_key_of_two_words(tmp_path: Path) -> None:
    cells = [[r[0], r[1], *r[2:8]] for r in rows(TRUTH)]
    files = {**FILES, "poses.csv": table(["Pose", "M", *JOINTS], cells)}
    mapping = JOIN.replace("join: experiment", "join: [experiment, marker]")
    mapping += "  marker: {file: 2, column: M}\n"
    np.testing.assert_allclose(read(files, tmp_path, mapping).cases.q, TRUTH.q, atol=1e-11)


def test_poses_in_two_files_that_are_joined_together(tmp_path: Path) -> None:
    head, *lines = POSES.splitlines(True)
    files = {
        "points.csv": POINTS,
        "a.csv": head + "".join(lines[:2]),
        "b.csv": head + "".join(lines[2:]),
    }
    mapping = JOIN.replace("  experiment: {file: 2, column: Pose}\n", "")
    mapping += "files: [{}, {columns: {experiment: Pose}}, {columns: {experiment: Pose}}]\n"
    np.testing.assert_allclose(read(files, tmp_path, mapping).cases.q, TRUTH.q, atol=1e-11)


def test_each_file_has_a_layout_of_its_own(tmp_path: Path) -> None:
    """Excel's first line, comments of several kinds, decimal commas, no header, cp1252."""
    poses = "sep=;\n! größe\n" + POSES.replace(".", ",")
    points = "// points\n  // Name, X\n# of today\n" + "".join(POINTS.splitlines(True)[1:])
    (tmp_path / "poses.csv").write_bytes(poses.encode("cp1252"))
    mapping = r"""
elastocal: 1
files:
  - {header: false, columns: {x y z [mm]: [2, 3, 4]},
     patterns: {1: 'P(?P<experiment>\d+)-(?P<marker>.+)'}}
  - {join: experiment, encoding: cp1252, decimal: comma, comment: "!",
     columns: {experiment: Pose, "q [deg]": [A1, A2, A3, A4, A5, A6]}}
""".replace("x y z [mm]", '"x y z [mm]"')
    (tmp_path / "mapping.yaml").write_text(mapping, "utf-8")
    (tmp_path / "points.csv").write_text(points)
    from elastocal.files.measurements.positions_file import read_positions
    from tests.files.absolute_campaign import study

    paths = [tmp_path / "points.csv", tmp_path / "poses.csv"]
    found = read_positions(paths, study(), tmp_path / "mapping.yaml")
    np.testing.assert_allclose(found.cases.q, TRUTH.q, atol=1e-11)
    assert found.remarks == ()


def test_several_patterns_of_which_one_fits(tmp_path: Path) -> None:
    points = POINTS + "reference F1,1,2,3,good\n"
    mapping = JOIN.replace(
        r"'P(?P<experiment>\d+)-(?P<marker>M\d)'",
        r"['P(?P<experiment>\d+)-(?P<marker>M\d)', 'reference (?P<marker>F\d)']",
    )
    found = read({**FILES, "points.csv": points}, tmp_path, f"{mapping}foot: F1\n")
    assert found.foot is not None
    assert found.foot.order.tolist() == [12]


def sentence(files: dict[str, str], mapping: str, folder: Path) -> str:
    def reading() -> Positions:
        return read(files, folder, mapping)

    return sentence_of(reading)


# what is replaced: file or "mapping", old, new; what must be in the sentence
BAD: dict[str, tuple[str, str, str, list[str]]] = {
    "no partner": (
        "poses.csv",
        "\n4;",
        "\n44;",
        ["points.csv, line 8", "no experiment '4' in", "poses.csv"],
    ),
    "key twice": (
        "poses.csv",
        "\n4;",
        "\n3;",
        ["poses.csv, line 5, column 'Pose'", "'3' was given in line 4"],
    ),
    "name without pattern": (
        "points.csv",
        "P03-M1",
        "Q03-M1",
        ["points.csv, line 6, column 'Name'", "found 'Q03-M1'", "pattern"],
    ),
    "name too long": (
        "points.csv",
        "P03-M1",
        "P" + "0" * 120 + "3-M1",
        ["line 6", "of 125 characters"],
    ),
    "line that is none": (
        "list.csv",
        "row;use\n3;",
        "row;use\n99;",
        ["list.csv, line 2, column 'row'", "no row in line '99'"],
    ),
    "line that is the header": (
        "list.csv",
        "row;use\n3;",
        "row;use\n1;",
        ["no row in line '1'", "the first of the file is 1"],
    ),
    "line twice": ("list.csv", "row;use\n3;b\n", "row;use\n4;x\n", ["'4' was given in"]),
    "keep of nothing": (
        "mapping",
        "{use: [a]}",
        "{use: [a, c]}",
        ["keep: no row has 'c' in 'use'; found"],
    ),
    "keep of no column": ("mapping", "{use: [a]}", "{usage: [a]}", ["no column 'usage'", "'use'"]),
    "keep of a flag": (
        "mapping",
        "{use: [a]}",
        "{use: [yes]}",
        ["line 8: keep.use: ", "in quotes"],
    ),
    "join of no word": (
        "mapping",
        "join: line",
        "join: row",
        ["join: expected order, line, or some of"],
    ),
    "join of the first": (
        "mapping",
        "[{}, {join",
        "[{join: line}, {join",
        ["line 7: join: the first file"],
    ),
    "line and more": (
        "mapping",
        "join: line",
        "join: [line, series]",
        ["'line' says the row alone"],
    ),
    "no key": (
        "mapping",
        "join: experiment, columns: {experiment: Pose}",
        "join: experiment",
        ["poses.csv: no column or pattern gives 'experiment'"],
    ),
    "no line": ("mapping", "{join: line, columns: {line: row}}", "{join: line}", ["gives 'line'"]),
    "files of another number": (
        "mapping",
        ", {join: line, columns: {line: row}}",
        "",
        ["'files' has 2 entries", "3 files are named"],
    ),
    "no expression": (
        "mapping",
        r"P(?P<exp",
        r"P((?P<exp",
        ["line 3: ", "no regular expression", "missing"],
    ),
    "no group": ("mapping", "(?P<marker>M", "(M", ["is missing"]),
    "group that is no word": (
        "mapping",
        "(?P<marker>",
        "(?P<reflector>",
        ["line 3", "a group 'reflector'", "experiment"],
    ),
    "word twice": (
        "mapping",
        "columns:\n",
        "columns:\n  marker: mood\n",
        ["'marker' is given twice"],
    ),
    "endless": (
        "mapping",
        r"(?P<experiment>\d+)",
        r"(?P<experiment>(\d+)+)",
        ["may take for ever"],
    ),
    "pattern of no column": (
        "mapping",
        "{Name:",
        "{Nome:",
        ["line 3: there is no column 'Nome'", "'Name'"],
    ),
    "too few columns": (
        "mapping",
        "[X, Y, Z]",
        "[X, Y]",
        ["expected 3 columns, one for each of x, y, z, found 2"],
    ),
    "list without names": ("mapping", "x y z [mm]", "x y w [mm]", ["no quantity 'w'"]),
    "too few joints": ("mapping", "[A1, A2, A3,", "[A1, A3,", ["expected 6 columns", "A1, A2"]),
    "file in a file": (
        "mapping",
        "{experiment: Pose}",
        "{experiment: {file: 2, column: Pose}}",
        ["'file' belongs to columns of the whole mapping"],
    ),
    "column in both": (
        "mapping",
        "{line: row}",
        "{line: row, marker: use}",
        ["list.csv, line", "column 'use': this is in", "points.csv too, and not alike"],
    ),
    "foot that nobody read": (
        "mapping",
        "keep:",
        "foot: [F9]\nkeep:",
        ["no row has the reflector 'F9'", "'M1'"],
    ),
    "a frame": (
        "mapping",
        "keep:",
        "frame: best-fit\nkeep:",
        ["frame of their tracker", "leave 'frame' out"],
    ),
    "a fixed frame": (
        "mapping",
        "keep:",
        "frame: {rpy_deg: [0, 0, 1]}\nkeep:",
        ["leave 'frame' out"],
    ),
    "another kind": ("mapping", "keep:", "positions: states\nkeep:", ["campaigns of deflections"]),
    "unknown kind": (
        "mapping",
        "keep:",
        "positions: relative\nkeep:",
        ["'absolute' or 'states'", "'relative'"],
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_what_does_not_belong_together(name: str, tmp_path: Path) -> None:
    where, old, new, expected = BAD[name]
    files, mapping = dict(THREE), LINES
    if where == "mapping":
        assert old in mapping
        mapping = mapping.replace(old, new, 1)
    else:
        assert old in files[where]
        files[where] = files[where].replace(old, new, 1)
    said = sentence(files, mapping, tmp_path)
    for part in expected:
        assert part in said, said


@pytest.mark.parametrize(
    "text",
    [
        r"(?P<experiment>(a+)+)b",
        r"(?P<experiment>(a|a)*)b",
        r"(?P<experiment>(a|b){5,})",
        r"(?P<experiment>(?:a?){40})",
        r"(?P<experiment>.*.*.*.*.*.*.*)",
        r"((?P<experiment>a*)x){3}",
        r"(?P<experiment>" + "a?" * 30 + ")",
        r"(?P<experiment>((a)|b)+)",
        r"(?P<experiment>(\w+\s?)*)",
    ],
)
def test_patterns_whose_search_may_not_end(text: str) -> None:
    with pytest.raises(MeasurementFileError, match="may take for ever"):
        pattern_of(text, "here")


@pytest.mark.parametrize(
    "text",
    [
        r"(?P<series>\w+)_(?P<experiment>\d+)_(?P<state>[^_+]+)_(?P<marker>\w+)",
        r"P(?P<experiment>\d{1,3})(?:_(?P<state>UL|L))?",
        r"(?i:pose)\s*(?P<experiment>[a-z*+]{3})",
        r"\(\+\*(?P<experiment>\d+)\)\*",
        r"(?P<marker>(?:AB)+)",
    ],
)
def test_patterns_that_are_plain_enough(text: str) -> None:
    assert pattern_of(text, "here").pattern == text


def test_the_worst_pattern_takes_its_time_and_ends(tmp_path: Path) -> None:
    points = POINTS.replace("P01-M1", "a" * 100)
    mapping = JOIN.replace(
        r"'P(?P<experiment>\d+)-(?P<marker>M\d)'", "'(?P<experiment>a*)a*a*(?P<marker>a*)b'"
    )
    begin = time.perf_counter()
    assert "found 'aaaa" in sentence({**FILES, "points.csv": points}, mapping, tmp_path)
    assert time.perf_counter() - begin < 5.0
