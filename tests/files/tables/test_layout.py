"""Tables as spreadsheets leave them: measurements, plans and paths are read by one reader."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.files.paths.path_file import read_path
from elastocal.files.plans.proposal_file import read_proposal
from tests.files.campaign import study
from tests.files.measurements.test_bad_measurements import GOOD, ROWS, STATES

STUDY = study()
HEAD, *LINES = GOOD.splitlines()
JOINTS = [cell for cell in HEAD.split(",") if cell.startswith("A")]
LOADS = ["Fx [N]", "Fy [N]", "Fz [N]"]
CELLS = [line.split(",")[2:11] for line in LINES[::2]]
PLAN = "\n".join(
    [
        ",".join(["configuration", *JOINTS, *LOADS, "Tx [N.m]", "repeats", "nearest constraint"]),
        *(",".join([str(i + 1), *row, "1.5", "2", "A2 <= 0°"]) for i, row in enumerate(CELLS)),
    ]
)
PATH = "\n".join([",".join([*JOINTS, *LOADS]), *map(",".join, CELLS)])

Reader = Callable[[Path], LoadCases]


def of_measurements(path: Path) -> LoadCases:
    return read_measurements(path, STUDY).cases


def of_a_plan(path: Path) -> LoadCases:
    found = read_proposal(path, STUDY)
    assert (found.repeats >= 1).all()
    return found.load_cases


def of_a_path(path: Path) -> LoadCases:
    return read_path(path, STUDY.robot, STUDY.robot.tools["milling"], np.zeros(6)).cases


KINDS: dict[str, tuple[str, Reader]] = {
    "measurements": (GOOD, of_measurements),
    "states": (STATES, of_measurements),
    "plan": (PLAN + "\n", of_a_plan),
    "path": (PATH + "\n", of_a_path),
}


def german(text: str) -> str:
    """As a German spreadsheet saves it: decimal commas, and semicolons between cells."""
    return text.replace(",", ";").replace(".", ",").replace("[N,m]", "[N.m]")


def quoted(text: str, mark: str = ",") -> str:
    return "\n".join(
        mark.join(f'"{cell}"' if cell else "" for cell in line.split(mark))
        for line in text.split("\n")
    )


CLOTHES: dict[str, Callable[[str], bytes]] = {
    "sep=,": lambda t: b"sep=,\n" + t.encode(),
    "SEP=;": lambda t: b"SEP=;\r\n" + german(t).replace("\n", "\r\n").encode(),
    "Sep=;, quoted, with delimiters behind it": lambda t: b'"Sep=;";;;;\n' + german(t).encode(),
    "sep = |": lambda t: b"sep = |\n" + t.replace(",", "|").encode(),
    "a tab": lambda t: b"sep=\t\n" + t.replace(",", "\t").encode(),
    "a tab by letters": lambda t: b"sep=\\t\n" + t.replace(",", "\t").encode(),
    "sep=; behind a mark": lambda t: b"\xef\xbb\xbfsep=;\n" + german(t).encode(),
    "a mark behind sep=;": lambda t: b"sep=;\n\xef\xbb\xbf" + quoted(german(t), ";").encode(),
    "sep=; below a comment": lambda t: b"# of the cell\n\nsep=;\n" + german(t).encode(),
    "sep=; in UTF-16": lambda t: ("sep=;\n" + german(t)).encode("utf-16"),
    "two marks": lambda t: b"\xef\xbb\xbf\xef\xbb\xbf" + t.encode(),
    "a mark taken for letters": lambda t: "\ufeffï»¿".encode() + t.encode(),
    "two marks of UTF-16": lambda t: ("\ufeff" + t).encode("utf-16"),
    "a mark before a quote": lambda t: b"\xef\xbb\xbf\xef\xbb\xbf" + quoted(t).encode(),
    "semicolons, cp1252, empty columns": lambda t: (
        german(t).replace("\n", ";;;\r\n").encode("cp1252")
    ),
    "tabs and decimal commas": lambda t: german(t).replace(";", "\t").encode("utf-16"),
    "quotes around decimal commas": lambda t: quoted(german(t), ";").replace(";", ",").encode(),
    "degree signs": lambda t: t.replace("[deg]", "[°]").encode("cp1252"),
    "twins of units": lambda t: (
        t.replace("[N.m]", "[N m]").replace("[deg]", "[ º ]").encode()
    ),
}  # fmt: skip


@pytest.mark.parametrize("clothes", CLOTHES)
@pytest.mark.parametrize("kind", KINDS)
def test_every_table_is_read_in_all_clothes(kind: str, clothes: str, tmp_path: Path) -> None:
    text, read = KINDS[kind]
    (tmp_path / "plain.csv").write_text(text, "utf-8")
    (tmp_path / "other.csv").write_bytes(CLOTHES[clothes](text))
    plain, other = read(tmp_path / "plain.csv"), read(tmp_path / "other.csv")
    np.testing.assert_allclose(other.q, plain.q, rtol=1e-14)
    np.testing.assert_allclose(other.wrench, plain.wrench, rtol=1e-14)


@pytest.mark.parametrize("ending", [".txt", ".tsv", ".CSV"])
def test_plans_are_tables_by_their_ending(ending: str, tmp_path: Path) -> None:
    (tmp_path / f"plan{ending}").write_bytes(PLAN.replace(",", "\t").encode("utf-16"))
    assert len(of_a_plan(tmp_path / f"plan{ending}")) == 3


def test_units_of_plans_are_converted(tmp_path: Path) -> None:
    text = PLAN.replace("Fz [N]", "Fz [kN]").replace("-2500", "-2.5").replace("[N.m]", "[Nmm]")
    (tmp_path / "plan.csv").write_text(text)
    found = of_a_plan(tmp_path / "plan.csv")
    np.testing.assert_allclose(found.wrench, [[0, 0, -2500, 1.5e-3, 0, 0]] * 3, rtol=1e-14)


# what is in the file; what must be in the sentence
BAD = {
    "sep=^": (b"sep=^\n" + GOOD.encode(), ["line 1", "'^' as this line says", "semicolons, tabs"]),
    "another delimiter": (
        b"sep=;\n" + GOOD.encode(), ["line 2", "one cell", "by semicolons alone"]),
    "spaces": (
        GOOD.replace(" [", "_[").replace(",", " ").encode(), ["line 1", "one cell", "commas"]),
    "a line is a cell": (
        "".join(f'"{line}"\n' for line in GOOD.splitlines()).encode(), ["line 1", "one cell"]),
    "only sep=;": (b"sep=;\n", ["no table in it"]),
    "only sep=; and a header": (b"sep=,\n" + HEAD.encode(), ["a header, but no row"]),
    "a row that is too long": (
        b"sep=,\n" + HEAD.encode() + b"\n" + ROWS.encode() + b"4,M1" + b",0" * 14 + b"\n",
        ["line 9", "16 cells where the header has 15"]),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
@pytest.mark.parametrize("kind", KINDS)
def test_the_delimiter_that_is_found_is_named(kind: str, name: str, tmp_path: Path) -> None:
    data, expected = BAD[name]
    (tmp_path / "m.csv").write_bytes(data)
    with pytest.raises(InputError) as caught:
        KINDS[kind][1](tmp_path / "m.csv")
    sentence = str(caught.value)
    assert "\n" not in sentence
    for part in expected:
        assert part in sentence, sentence


def test_a_mapping_and_the_file_may_not_differ_on_the_delimiter(tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text("sep=;\n" + german(GOOD))
    names = [cell.split(" [")[0] for cell in HEAD.split(",")]
    columns = "columns:\n" + "".join(f"  {name}: {name}\n" for name in names)
    mapping = tmp_path / "mapping.yaml"
    for said in ("", "delimiter: semicolon\n", "skip_lines: 1\n"):
        mapping.write_text(f"elastocal: 1\n{said}{columns}")
        assert len(read_measurements(tmp_path / "m.csv", STUDY, mapping)) == 6
    mapping.write_text(f"elastocal: 1\ndelimiter: tab\n{columns}")
    with pytest.raises(InputError, match=r"line 1: cells .* semicolons .* says tab"):
        read_measurements(tmp_path / "m.csv", STUDY, mapping)


@pytest.mark.parametrize("digits", ["\uff16\uff17", "\u0663", "\uff11.5", "-\u0663", "\xb2"])
def test_digits_of_other_scripts_are_no_numbers(digits: str, tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_text(PATH.replace("-2500", digits), encoding="utf-8")
    with pytest.raises(InputError, match=f"column 'Fz': expected a number, found '{digits}'"):
        of_a_path(tmp_path / "path.csv")


def test_thousands_in_quotes_are_no_decimals(tmp_path: Path) -> None:
    """Between commas 1,200 in quotes may be either, so it is refused; 0,200 is no thousand."""
    (tmp_path / "path.csv").write_text(PATH.replace("-2500", '"-2,500"'))
    with pytest.raises(InputError, match="column 'Fz': expected a number without thousands"):
        of_a_path(tmp_path / "path.csv")
    (tmp_path / "path.csv").write_text(PATH.replace("-2500", '"-2500,5"'))
    np.testing.assert_array_equal(of_a_path(tmp_path / "path.csv").wrench[:, 2], [-2500.5] * 3)
    (tmp_path / "path.csv").write_text(PATH.replace("-2500", '"-0,200"'))
    np.testing.assert_array_equal(of_a_path(tmp_path / "path.csv").wrench[:, 2], [-0.2] * 3)


# what is in the cell of a table with decimal points, with semicolons; what is read, None: refused
NUMBERS: dict[str, float | None] = {
    "-12.5": -12.5,
    " -12.5 ": -12.5,
    "'-12.5": -12.5,
    "\u221212.5": -12.5,
    "\u201312.5": -12.5,
    "-1.25E+01": -12.5,
    "-1.25e1": -12.5,
    "-1.25D+01": -12.5,
    "-.125d2": -12.5,
    "-12.50000000000000000000": -12.5,
    "+3": 3.0,
    "5.": 5.0,
    "1e400": None,
    "1,234.5": None,
    "1'234.5": None,
    "1\u2019234.5": None,
    "1\u00a0234.5": None,
    "1\u202f234.5": None,
    "1.234.567": None,
    "12.5 N": None,
    "12.5%": None,
    "0x10": None,
    "1_000": None,
    "12.5.1": None,
    "--5": None,
    "nan": None,
    "#DIV/0!": None,
    "#N/A": None,
    "1.25D": None,
    "D+01": None,
    "01.02.2024": None,
    "12:30": None,
    "": None,
}


@pytest.mark.parametrize("kind", ["measurements", "plan", "path"])
@pytest.mark.parametrize("cell", NUMBERS)
def test_numbers_as_programs_write_them(kind: str, cell: str, tmp_path: Path) -> None:
    text, read = KINDS[kind]
    lines = text.replace(",", ";").splitlines()
    column = lines[0].split(";").index("A4 [deg]")
    for i in range(1, len(lines)):
        cells = lines[i].split(";")
        lines[i] = ";".join([*cells[:column], cell, *cells[column + 1 :]])
    (tmp_path / "m.csv").write_text("\n".join(lines) + "\n", "utf-8")
    value = NUMBERS[cell]
    if value is not None:
        np.testing.assert_array_equal(read(tmp_path / "m.csv").q[:, 3], [np.radians(value)] * 3)
        return
    with pytest.raises(InputError) as caught:
        read(tmp_path / "m.csv")
    assert "line 2, column 'A4" in str(caught.value)
    assert ("thousands" in str(caught.value)) == ("234" in cell), str(caught.value)


PIECES = [
    *(b",", b";", b"\t", b"\n", b"\r", b'"', b"'", b"#", b"\x00", b"\xff\xfe", b"\xef\xbb\xbf"),
    *(b"sep=;\n", b"sep=", b"[", b"]", b"nan", b"1e999", b"1e300", b"-0", b"9" * 400, b"_", b"D+9"),
    *(b"\xe2\x88\x92", b"\xb5", b" ", b"[deg]", b"[rad]", b"via", b"repeats", b"1e8", b"," * 30),
    *(b"point", b"x [mm]", b"Fx tool [N]", b"hanging mass [kg]", b"state", b"\xed\xa0\x80", b"0"),
]


@st.composite
def spoilt(draw: st.DrawFn, text: str) -> bytes:
    """A good file with pieces cut out, put in, or cells exchanged."""
    data = draw(st.sampled_from([text, german(text)])).encode()
    for _ in range(draw(st.integers(1, 3))):
        start = draw(st.integers(0, len(data)))
        end = min(len(data), start + draw(st.sampled_from([0, 1, 4, 20])))
        data = data[:start] + draw(st.sampled_from(PIECES) | st.binary(max_size=3)) + data[end:]
    return data


@pytest.mark.parametrize("kind", KINDS)
def test_any_table_is_read_or_refused_in_one_sentence(kind: str, tmp_path: Path) -> None:
    text, read = KINDS[kind]
    path = tmp_path / "m.csv"

    @settings(max_examples=200, suppress_health_check=[HealthCheck.too_slow], deadline=None)
    @given(spoilt(text))
    def run(data: bytes) -> None:
        path.write_bytes(data)
        said = "read"
        try:
            found = read(path)
            assert np.isfinite(np.hstack([found.q, found.wrench])).all()
        except InputError as error:
            said = str(error)
        assert said
        assert "\n" not in said

    run()
