"""Whatever the bytes: measurements or one clean sentence, never a traceback, never a hang."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from elastocal.errors import InputError, MeasurementFileError
from elastocal.files.measurements import fast
from elastocal.files.measurements.cells import read_cells
from elastocal.files.measurements.columns import columns_by_name
from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.files.tables.decoding import FileText
from elastocal.files.tables.layout import Style, layout
from elastocal.measuring.measurements import Measurements
from tests.files.campaign import study
from tests.files.measurements.test_bad_measurements import GOOD, HEAD, ROWS, STATES
from tests.files.measurements.test_mapping import LOADED, THREE

QUIET = settings(
    max_examples=300,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
STUDY = study()
PIECES = st.sampled_from(
    [
        *(
            b"",
            b",",
            b";",
            b"\t",
            b"\n",
            b"\r",
            b'"',
            b"'",
            b"#",
            b"\x00",
            b"\xff\xfe",
            b"\xb5",
            b"[",
        ),
        *(
            b"]",
            b"nan",
            b"1e999",
            b"-0",
            b"9" * 400,
            b"_",
            b"\xe2\x88\x92",
            b" ",
            b"[deg]",
            b"state",
        ),
        *(b"x [mm]", b"A1 [rad]", b"U95 [um]", b"hanging mass [kg]", b"loaded", b"valid"),
        *(b"," * 30, b"\n" * 5),
    ]
)


def outcome(
    data: bytes | Sequence[bytes], folder: Path, mapping: str | None = None
) -> Measurements | str:
    """Measurements, or the sentence on what is wrong; anything else fails the test."""
    paths = []
    for i, part in enumerate([data] if isinstance(data, bytes) else data):
        paths.append(folder / f"{i}.csv")
        paths[-1].write_bytes(part)
    where = None
    if mapping is not None:
        where = folder / "mapping.yaml"
        where.write_text(mapping, "utf-8")
    try:
        found = read_measurements(paths, STUDY, where)
    except InputError as error:
        sentence = str(error)
        assert sentence
        assert "\n" not in sentence
        return sentence
    assert np.isfinite(found.deflection).all()
    assert (np.linalg.eigvalsh(found.covariance)[:, 0] > 0.0).all()
    return found


@given(data=st.binary(max_size=400))
@QUIET
def test_any_bytes(data: bytes, tmp_path: Path) -> None:
    assert isinstance(outcome(data, tmp_path), str)


@given(text=st.text(max_size=300))
@QUIET
def test_any_text_under_a_good_header(text: str, tmp_path: Path) -> None:
    outcome(HEAD.encode() + text.encode("utf-8", "surrogatepass"), tmp_path)


@st.composite
def spoilt(draw: st.DrawFn, sources: Sequence[str] = (GOOD, STATES)) -> bytes:
    """A good file with some pieces cut out, put in, or doubled."""
    data = draw(st.sampled_from([source.encode() for source in sources]))
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(data)))
        end = min(len(data), start + draw(st.sampled_from([0, 0, 1, 3, 10, 80])))
        twice = data[start:end] if draw(st.booleans()) else b""
        data = data[:start] + draw(PIECES) + 2 * twice + data[end:]
    return data


@given(data=spoilt())
@QUIET
def test_spoilt_files(data: bytes, tmp_path: Path) -> None:
    outcome(data, tmp_path)


@example(data=b"elastocal: 1\nwords:\n  state: {b\n\n\n\noaded, after: loaded}\n")
@given(data=spoilt([LOADED]))
@QUIET
def test_spoilt_mappings(data: bytes, tmp_path: Path) -> None:
    outcome(list(THREE.values()), tmp_path, data.decode("latin-1"))


@given(files=st.lists(spoilt(), min_size=2, max_size=3))
@QUIET
def test_spoilt_files_side_by_side(files: list[bytes], tmp_path: Path) -> None:
    outcome(files, tmp_path)


@given(cells=st.lists(PIECES | st.binary(max_size=6), min_size=15, max_size=15))
@QUIET
def test_any_cells(cells: list[bytes], tmp_path: Path) -> None:
    outcome(GOOD.encode() + b",".join(cells) + b"\n", tmp_path)


@pytest.mark.parametrize("end", range(1, len(GOOD), 7))
def test_files_cut_off_anywhere(tmp_path: Path, end: int) -> None:
    """As a crash leaves them: refused, or remarked upon where the cut hides between two cells."""
    found = outcome(GOOD[:end].encode(), tmp_path)
    if isinstance(found, Measurements):
        whole = GOOD[:end].endswith("\n")
        assert whole or any("no line end" in remark for remark in found.remarks)


@pytest.mark.parametrize(
    "data",
    [
        b'"' * 200_000,
        b"a," * 200_000,
        b"\n" * 500_000 + GOOD.encode(),
        HEAD.encode() + b"," * 300_000,
        HEAD.encode() + b'"' + b"1,2\n" * 100_000,
        GOOD.encode() + b"#" * 500_000,
        HEAD.encode() + b"1" * 300_000,
    ],
    ids=["quotes", "columns", "blank lines", "commas", "open quote", "comment", "digits"],
)
def test_monsters(data: bytes, tmp_path: Path) -> None:
    outcome(data, tmp_path)


@given(
    order=st.permutations(range(15)),
    delimiter=st.sampled_from(",;\t|"),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252"]),
    joints=st.sampled_from(["deg", "rad", "°"]),
    lengths=st.sampled_from(["mm", "m", "um", "µm", "in"]),
    forces=st.sampled_from(["N", "kN", "daN", "kgf", "lbf"]),
)
@settings(max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_order_units_and_encoding_make_no_difference(
    order: list[int],
    delimiter: str,
    encoding: str,
    joints: str,
    lengths: str,
    forces: str,
    tmp_path: Path,
) -> None:
    factors = {"deg": 1.0, "°": 1.0, "rad": np.pi / 180, "mm": 1.0, "m": 1e-3, "um": 1e3}
    factors |= {"µm": 1e3, "in": 1 / 25.4, "N": 1.0, "kN": 1e-3, "daN": 0.1}
    factors |= {"kgf": 1 / 9.80665, "lbf": 1 / (9.80665 * 0.45359237)}
    units = [None, None, *[joints] * 6, *[forces] * 3, *[lengths] * 4]
    rows = [line.split(",") for line in GOOD.splitlines()]
    out = [
        [
            cell.split(" [")[0] + (f" [{u}]" if u else "")
            for cell, u in zip(rows[0], units, strict=True)
        ]
    ]
    out += [
        [repr(float(c) * factors[u]) if u else c for c, u in zip(row, units, strict=True)]
        for row in rows[1:]
    ]
    text = "".join(delimiter.join(row[i] for i in order) + "\n" for row in out)
    found = outcome(text.encode(encoding), tmp_path)
    right = outcome(GOOD.encode(), tmp_path)
    assert isinstance(found, Measurements)
    assert isinstance(right, Measurements)
    np.testing.assert_allclose(found.cases.q, right.cases.q, rtol=1e-12)
    np.testing.assert_allclose(found.cases.wrench, right.cases.wrench, rtol=1e-12)
    np.testing.assert_allclose(found.deflection, right.deflection, rtol=1e-12)
    np.testing.assert_allclose(found.covariance, right.covariance, rtol=1e-12, atol=1e-24)
    assert found.remarks == right.remarks == ()
    assert found.doubts == right.doubts == ()


class TestFast:
    """The reader of large plain tables gives what the careful one gives, or nothing."""

    @staticmethod
    def both(text: str, monkeypatch: pytest.MonkeyPatch) -> tuple[object, object]:
        results = []
        for least in (0, 10**9):
            monkeypatch.setattr(fast, "LEAST", least)
            try:
                table = layout(FileText(Path("m.csv"), text, "", MeasurementFileError), Style())
                columns = columns_by_name(table.header, STUDY.robot, "m.csv, line 1")
                cells = read_cells(table, columns)
                results.append(
                    (
                        cells.lines.tolist(),
                        {key: values.tolist() for key, values in cells.numbers.items()},
                        {
                            key: [words.names[i] for i in words.codes]
                            for key, words in cells.words.items()
                        },
                    )
                )
            except InputError as error:
                results.append(str(error))
        return results[0], results[1]

    def check(self, text: str) -> object:
        """What both give, the same."""
        with pytest.MonkeyPatch.context() as monkeypatch:
            quick, careful = self.both(text, monkeypatch)
        assert quick == careful
        return quick

    @pytest.mark.parametrize(
        "text",
        [GOOD, GOOD.replace(",", ";").replace(".", ","), GOOD.replace("\n", "\n\n"), STATES],
        ids=["good", "decimal commas", "blank lines", "states"],
    )
    def test_plain_tables_are_read_by_it(self, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(fast, "LEAST", 0)
        table = layout(FileText(Path("m.csv"), text, "", MeasurementFileError), Style())
        columns = columns_by_name(table.header, STUDY.robot, "")
        assert fast.plain_columns(table, columns, "," if ";" in text else ".") is not None
        quick, careful = self.both(text, monkeypatch)
        assert not isinstance(quick, str)
        assert quick == careful

    @given(data=spoilt())
    @QUIET
    def test_spoilt_files_have_the_same_outcome(self, data: bytes) -> None:
        text = data.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n")
        self.check(text)

    @given(
        values=st.lists(
            st.floats(-1e8, 1e8, allow_nan=False, allow_infinity=False), min_size=1, max_size=20
        )
    )
    @settings(max_examples=100)
    def test_every_number_to_the_last_bit(self, values: list[float]) -> None:
        row = ROWS.splitlines()[0].rsplit(",", 4)[0]
        text = HEAD + "".join(f"{row},{v!r},{v:.6f},{v:.3e},1\n" for v in values)
        assert not isinstance(self.check(text), str)

    @pytest.mark.parametrize("block", [1, 100, 1000])
    def test_blocks_of_any_size_give_the_same(
        self, block: int, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(fast, "_BLOCK", block)
        quick, careful = self.both(GOOD.replace("\n", "\n\n") * 1 + ROWS, monkeypatch)
        assert not isinstance(quick, str)
        assert quick == careful

    @given(
        cells=st.lists(
            st.from_regex(r" ?[-+]?([0-9]{0,17}\.?[0-9]{0,17})([eE][-+]?[0-9])?", fullmatch=True),
            min_size=1,
            max_size=20,
        )
    )
    @settings(max_examples=60)
    def test_every_way_to_write_a_number(self, cells: list[str]) -> None:
        row = ROWS.splitlines()[0].rsplit(",", 4)[0]
        text = HEAD + "".join(f"{row},{cell},1,1,1\n" for cell in cells)
        self.check(text)

    @given(names=st.lists(st.text("ab'1é ", max_size=12), min_size=1, max_size=30))
    @settings(max_examples=100)
    def test_names_of_any_length(self, names: list[str]) -> None:
        rest = ROWS.splitlines()[0].split(",", 1)[1]
        text = HEAD + "".join(f"{name},{rest}\n" for name in names)
        self.check(text)
