"""Odd and wrong files of absolute readings: read as they are meant, or refused with a sentence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from elastocal.errors import InputError
from elastocal.files.measurements.positions_file import read_positions
from elastocal.measuring.positions import Positions
from elastocal.study.absolute import AbsoluteStudy
from tests.files.absolute_campaign import HEADER, JOINTS, rows, study, table, truth
from tests.files.measurements.test_bad_measurements import sentence_of
from tests.files.measurements.test_measurement_fuzz import PIECES
from tests.files.measurements.test_positions import (
    FOOT,
    FOOT_HEADER,
    PROBE,
    foot_rows,
    probe_file,
    read,
)

TRUTH = truth(5)
PLAIN = table(HEADER, rows(TRUTH))
CELLS = rows(TRUTH)
SERIES = table(
    [*HEADER, "series", "payload", "time"],
    [[*row, "A", "plates", f"2026-11-28T14:00:{i:02d}"] for i, row in enumerate(CELLS)],
)
FEET = table(FOOT_HEADER, foot_rows())
TURNED = table([*HEADER, "qw", "qx", "qy", "qz"], [[*row, "1", "0", "0", "0"] for row in CELLS])
TORQUES = table(
    [*HEADER, *(f"torque {j} [N.m]" for j in JOINTS)], [[*row, *"123456"] for row in CELLS]
)
NOISY = table(
    [*HEADER, "ux [mm]", "uy [mm]", "uz [mm]"], [[*row, "0.01", "0.02", "0.03"] for row in CELLS]
)
X = CELLS[2][8]
FILES = {"plain": PLAIN, "series": SERIES, "feet": FEET, "turned": TURNED, "torques": TORQUES,
         "noisy": NOISY, "probe": probe_file()}  # fmt: skip
MAPPINGS = {"feet": FOOT, "probe": PROBE}


def of(kind: str) -> AbsoluteStudy:
    probe = kind in ("probe", "turned")
    return study(probe=probe, markers=1 if kind == "probe" else 2)


# which file, what is replaced in it, by what; in "mapping:…" the mapping; what the sentence says
BAD: dict[str, tuple[str, str, str, list[str]]] = {
    "no joints": ("plain", "A3 [deg]", "Q3 [deg]", ["line 1", "column 'A3 [deg]' is missing"]),
    "no z": ("plain", "z [mm]", "height [mm]", ["column 'z [mm]' is missing"]),
    "no marker": ("plain", "marker", "reflector", ["column 'marker' is missing"]),
    "joints without unit": ("plain", "A1 [deg]", "A1", ["column 'A1' has no unit"]),
    "positions in kilograms": ("plain", "x [mm]", "x [kg]", ["'kg' is not accepted for 'x'"]),
    "deflections": ("plain", "x [mm]", "dx [mm]", ["column 'x [mm]' is missing, found 'dx [mm]'"]),
    "mapped as deflections": (
        "mapping:feet", "x y z", "dx dy dz", ["'dx' is that of a deflection", "needs positions"]),
    "x twice": ("plain", "y [mm]", "x [mm]", ["column 'x [mm]' appears twice"]),
    "a capital U": ("noisy", "ux [mm],uy [mm],uz [mm]", "U [mm],a,b", ["'U [mm]' is ambiguous"]),
    "two uncertainties": ("noisy", "ux [mm],uy [mm],uz [mm]", "u [mm],U95 [mm],a", ["both give"]),
    "an uncertainty of zero": ("noisy", ",0.01,", ",0,", ["line 2", "must be positive"]),
    "an uncertainty too few": ("noisy", "uy [mm]", "b", ["column 'uy [mm]' is missing beside"]),
    "an empty x": ("plain", f",{X},", ",,", ["line 4, column 'x [mm]'", "the cell is empty"]),
    "a word for x": ("plain", f",{X},", ",lost,", ["line 4", "expected a number, found 'lost'"]),
    "no number for x": ("plain", f",{X},", ",nan,", ["line 4", "expected a finite number"]),
    "a beam to the moon": ("plain", f",{X},", ",4e12,", ["none here is 1e+09 or more"]),
    "a decimal comma": ("plain", f",{X},", ',"1,5",', ["line 4", "one decimal sign for all"]),
    "an unknown reflector": ("plain", "1,M1", "1,M7", ["no marker 'M7'", "M1, M2"]),
    "an empty pose": ("plain", "\n2,M1", "\n,M1", ["line 4, column 'experiment'", "is empty"]),
    "joints that differ": (
        "plain", f"\n2,M1,{CELLS[2][2]}", f"\n2,M1,{float(CELLS[2][2]) + 1}",
        ["line 5, column 'A1 [deg]'", "expected one configuration"]),
    "half a row": ("plain", f",{X},", ",", ["line 4: 10 cells where the header has 11"]),
    "half a file": ("plain", PLAIN[-30:], "", ["only half written"]),
    "nothing below": ("plain", PLAIN[len(PLAIN.split("\n")[0]):], "\n", ["no row of data below"]),
    "no header": ("plain", PLAIN.split("\n")[0] + "\n", "", ["column 'marker' is missing"]),
    "an unknown payload": ("series", ",plates,", ",bricks,", ["no payload 'bricks'", "plates"]),
    "no time": (
        "series", "2026-11-28T14:00:03", "yesterday", ["line 5, column 'time'", "'yesterday'"]),
    "a time of the day": ("series", "2026-11-28T14:00:03", "14:00:03", ["expected a time such as"]),
    "an American date": (
        "series", "2026-11-28T14:00:03", "11/28/2026 14:00", ["'11/28/2026 14:00'"]),
    "a zone now and then": ("series", "14:00:03", "14:00:03Z", ["with a time zone, or none"]),
    "a 31st of February": (
        "series", "2026-11-28T14:00:03", "31.02.2026 14:00", ["expected a time"]),
    "no quaternion": ("turned", ",1,0,0,0", ",1,1,0,0", ["line 2", "length 1, found 1.41421"]),
    "half a quaternion": ("turned", ",1,0,0,0", ",1,,0,0", ["column 'qx'", "the cell is empty"]),
    "three of four": ("turned", "qz", "qq", ["column 'qz' is missing"]),
    "angles and a quaternion": ("turned", "qw", "rx [deg]", ["both say how the probe is turned"]),
    "a unit of a quaternion": ("turned", "qw", "qw [deg]", ["a number without unit"]),
    "five torques": ("torques", "torque A4 [N.m]", "other", ["'torque A4 [N.m]' is missing"]),
    "an empty torque": ("torques", ",1,2,3,", ",1,,3,", ["column 'torque A2 [N.m]'", "empty"]),
    "torques in newtons": ("torques", "torque A4 [N.m]", "torque A4 [N]", ["'N' is not accepted"]),
    "a foot without x": ("feet", "1000.0,4,", ",4,", ["line 7", "the cell is empty"]),
    "an arm without joints": (
        "feet", f"2,M1,{CELLS[2][2]}", "2,M1,", ["column 'A1'", "the cell is empty"]),
    "a pose without name among feet": ("feet", "\n2,M1", "\n,M1", ["column 'Pose'", "is empty"]),
    "no foot": ("mapping:feet", "[F1, F2]", "[F1, F3]", ["no row has the reflector 'F3'", "'F2'"]),
    "all on the foot": ("mapping:feet", "[F1, F2]", "[F1, F2, M1, M2]", ["all rows are of"]),
    "angles of nobody": ("mapping:probe", "orientation: euler-xyz\n", "", ["need 'orientation'"]),
    "unknown angles": ("mapping:probe", "euler-xyz", "euler-xxy", ["'rotation-vector', 'rpy'"]),
    "half an orientation": ("probe", ";".join(probe_file().split("\n")[2].split(";")[-2:]),
                            ";" + probe_file().split("\n")[2].split(";")[-1],
                            ["line 3, column 'meas_ry'", "the cell is empty", "or all of rx"]),
    "two decimal signs": ("probe", "0,01;", "0.01;", ["one decimal sign for all"]),
    "a workbook": ("plain", PLAIN[:4], "PK\x03\x04", ["Excel workbook"]),
    "a picture": ("plain", "1,M1", "\x00\x01", ["does not occur in text"]),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_gets_its_sentence(name: str, tmp_path: Path) -> None:
    where, old, new, expected = BAD[name]
    kind = where.removeprefix("mapping:")
    text, mapping = FILES[kind], MAPPINGS.get(kind, "")
    assert old in (mapping if where != kind else text)
    if where != kind:
        mapping = mapping.replace(old, new, 1)
    else:
        text = text.replace(old, new, 1)
    sentence = sentence_of(lambda: read(text, tmp_path, mapping, of(kind)))
    for part in expected:
        assert part in sentence, sentence


def test_there_are_enough_of_them() -> None:
    assert len(BAD) >= 40


def quoted(text: str) -> str:
    lines = [",".join(f'"{cell}"' for cell in line.split(",")) for line in text.splitlines()]
    return "\n".join(lines) + "\n"


SAME: dict[str, Callable[[str], str]] = {
    "byte order mark": lambda text: "\ufeff" + text,
    "Windows line ends": lambda text: text.replace("\n", "\r\n"),
    "Excel's first line": lambda text: "sep=;\n" + text.replace(",", ";"),
    "decimal commas": lambda text: text.replace(",", ";").replace(".", ","),
    "comments": lambda text: "// by the tracker\n# by hand\n" + text.replace("\n2,", "\n //x\n2,"),
    "quotes": quoted,
    "blank lines": lambda text: text.replace("\n", "\n\n"),
    "rows of delimiters": lambda text: text + "," * 10 + "\n",
    "apostrophes": lambda text: text.replace(",", ",'"),
    "minus of typographers": lambda text: text.replace("-", "−"),
    "further columns": lambda text: "\n".join(f"{line},21.5" for line in text.splitlines()) + "\n",
    "other spellings": lambda text: text.replace("[deg]", "[°]").replace(" [mm]", "[mm]"),
    "capitals": lambda text: text.replace("experiment", "Experiment").replace("x [", "X ["),
}


@pytest.mark.parametrize("name", SAME)
def test_the_same_in_other_clothes(name: str, tmp_path: Path) -> None:
    found = read(SAME[name](PLAIN), tmp_path)
    np.testing.assert_allclose(found.value, TRUTH.points.reshape(-1, 3), atol=1e-9)
    np.testing.assert_allclose(found.cases.q, TRUTH.q, atol=1e-11)
    assert found.remarks == ()


def test_metres_radians_and_other_units(tmp_path: Path) -> None:
    cells = [
        [
            r[0],
            r[1],
            *(f"{v:.12f}" for v in TRUTH.q[int(r[0]) - 1]),
            *(f"{float(v) / 1e3:.9f}" for v in r[8:]),
        ]
        for r in CELLS
    ]
    header = [h.replace("[deg]", "[rad]").replace("[mm]", "[m]") for h in HEADER]
    found = read(table(header, cells), tmp_path)
    np.testing.assert_allclose(found.value, TRUTH.points.reshape(-1, 3), atol=1e-9)
    wrong = read(
        table(
            HEADER, [[*r[:2], *(f"{v:.9f}" for v in TRUTH.q[int(r[0]) - 1]), *r[8:]] for r in CELLS]
        ),
        tmp_path,
    )
    assert "radians-for-degrees" in [doubt.code for doubt in wrong.doubts]


def test_a_pose_with_and_without_payload_is_two(tmp_path: Path) -> None:
    text = SERIES.replace("A,plates,2026-11-28T14:00:01", "A,none,2026-11-28T14:00:01")
    found = read(text, tmp_path)
    assert found.names[:2] == ("plates/1", "none/1")
    assert found.payload[:3].tolist() == [0, -1, 0]


def test_loaded_and_unloaded_are_poses_of_their_own(tmp_path: Path) -> None:
    """A constant load is that of the loaded rows."""
    cells = [[*row, state] for state in ("unloaded", "loaded") for row in CELLS]
    mapping = FOOT.replace("foot: [F1, F2]", 'constants: {"hanging mass [kg]": 100}')
    mapping += "  state: S\n"
    found = read(table([*FOOT_HEADER, "S"], cells), tmp_path, mapping)
    assert (found.names[0], found.names[5]) == ("unloaded/1", "loaded/1")
    np.testing.assert_allclose(found.cases.wrench[:, 2], [0.0] * 5 + [-980.665] * 5)


def test_an_instrument_without_orientations(tmp_path: Path) -> None:
    """A probe's tool, and an instrument that says nothing of them."""
    what = replace(study(probe=True), instrument=study().instrument)
    with pytest.raises(InputError, match="says nothing of orientations"):
        read(TURNED, tmp_path, what=what)
    own = TURNED.replace("qw,", "ur [mrad],qw,").replace(",1,0,0,0", ",0.1,1,0,0,0")
    found = read(own, tmp_path, what=what)
    np.testing.assert_allclose(found.covariance[found.rotations], [1e-8 * np.eye(3)] * 5)
    assert "10 readings repeated" not in " ".join(found.remarks)


def outcome(folder: Path, what: AbsoluteStudy, mapping: Path | None) -> Positions | None:
    """Readings, or nothing if there is a sentence on what is wrong; anything else fails."""
    try:
        return read_positions(folder / "m.csv", what, mapping)
    except InputError as error:
        sentence = str(error)
    assert sentence
    assert "\n" not in sentence
    return None


@st.composite
def spoilt(draw: st.DrawFn) -> tuple[str, bytes]:
    """A good file with some pieces cut out, put in, or doubled."""
    kind = draw(st.sampled_from(sorted(FILES)))
    data = FILES[kind].encode()
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(data)))
        end = min(len(data), start + draw(st.sampled_from([0, 0, 1, 3, 10, 80])))
        twice = data[start:end] if draw(st.booleans()) else b""
        data = data[:start] + draw(PIECES) + 2 * twice + data[end:]
    return kind, data


@given(spoilt=spoilt())
@settings(
    max_examples=300,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_spoilt_files(spoilt: tuple[str, bytes], tmp_path: Path) -> None:
    kind, data = spoilt
    (tmp_path / "m.csv").write_bytes(data)
    mapping = None
    if kind in MAPPINGS:
        mapping = tmp_path / "mapping.yaml"
        mapping.write_text(MAPPINGS[kind], "utf-8")
    if found := outcome(tmp_path, of(kind), mapping):
        assert np.isfinite(found.value).all()
        assert (np.linalg.eigvalsh(found.covariance)[:, 0] > 0.0).all()


@given(cut=st.integers(0, len(PROBE)), put=PIECES)
@settings(
    max_examples=200,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_spoilt_mappings(cut: int, put: bytes, tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text(FILES["probe"])
    text = PROBE.encode()
    (tmp_path / "mapping.yaml").write_bytes(text[:cut] + put + text[cut + 3 :])
    outcome(tmp_path, of("probe"), tmp_path / "mapping.yaml")
