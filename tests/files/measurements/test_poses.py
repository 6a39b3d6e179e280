"""Files with rotations: read as written, units and signs looked at, parts that are missing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.measurement_file import read_measurements, write_measurements
from elastocal.measuring.instrument import Isotropic, PoseProbe
from elastocal.measuring.measurements import Measurements
from elastocal.simulation.virtual_campaign import simulate
from elastocal.study.study import Study
from elastocal.wording import worded
from tests.kr270 import kr270_study, kr270_truth, published_cases

SIGMA, TURN = 3e-5, 5e-5
JOINTS = ",".join(f"A{i} [deg]" for i in range(1, 7))
HEAD = f"experiment,marker,{JOINTS},Fx [N],Fy [N],Fz [N],dx [mm],dy [mm],dz [mm]"
AT = "M1,0,-60,80,30,40,50,0,0,-2500"
GOOD = f"""{HEAD},drx [mrad],dry [mrad],drz [mrad]
1,{AT},0.1,0.2,-3.1,4.1,-2.2,0.3
2,{AT},0.1,0.3,-3.2,4.2,-2.1,0.4
"""


@cache
def study(markers: int = 1) -> Study:
    one = kr270_study()
    tool = one.experiments.tool
    points = tool.markers[0] + 0.1 * np.arange(markers)[:, None]
    names = tuple(f"M{i + 1}" for i in range(markers))
    tool = replace(tool, markers=points, marker_names=names)
    return replace(
        one,
        instrument=PoseProbe(Isotropic(SIGMA), TURN),
        experiments=replace(one.experiments, tool=tool, count=2),
    )


def read(text: str, folder: Path, of: Study | None = None, mapping: str = "") -> Measurements:
    (folder / "m.csv").write_text(text)
    if mapping:
        (folder / "map.yaml").write_text(mapping)
    return read_measurements(
        folder / "m.csv", of or study(), folder / "map.yaml" if mapping else None
    )


def simulated(of: Study) -> Measurements:
    rng, repeats = np.random.default_rng(3), np.array([2, 1, 1])
    return simulate(of, kr270_truth(of), published_cases(3), repeats, rng)


def codes(found: Measurements) -> set[str]:
    return {doubt.code for doubt in found.doubts}


def test_positions_and_rotations_of_a_row(tmp_path: Path) -> None:
    found = read(GOOD, tmp_path)
    assert found.case.tolist() == [0, 0, 1, 1]
    assert found.rotations.tolist() == [False, True, False, True]
    np.testing.assert_allclose(found.deflection[1], [4.1e-3, -2.2e-3, 3e-4])
    np.testing.assert_allclose(found.covariance[1], TURN**2 * np.eye(3))
    np.testing.assert_allclose(found.covariance[0], SIGMA**2 * np.eye(3))
    assert not found.own_uncertainty


@pytest.mark.parametrize("markers", [1, 3])
def test_a_written_campaign_is_read_as_it_was(markers: int, tmp_path: Path) -> None:
    of = study(markers)
    made = simulated(of)
    write_measurements(made, of.robot, tmp_path / "m.csv")
    found = read_measurements(tmp_path / "m.csv", of)
    assert found.names == made.names
    assert np.array_equal(found.case, made.case)
    assert np.array_equal(found.marker, made.marker)
    np.testing.assert_allclose(found.deflection, made.deflection, rtol=1e-9, atol=1e-14)
    np.testing.assert_allclose(found.covariance, made.covariance, rtol=1e-12)
    rows = (tmp_path / "m.csv").read_text().splitlines()[2:]
    assert len(rows) == 4 * markers
    assert sum(row.endswith(",,,") for row in rows) == 4 * (markers - 1)


def test_own_uncertainties_are_written_and_read(tmp_path: Path) -> None:
    """Full covariances of both kinds, then of three axes, then one number."""
    rng, made = np.random.default_rng(0), simulated(study())
    root = rng.normal(size=(len(made), 3, 3)) * 1e-5
    full = root @ root.transpose(0, 2, 1) + 1e-10 * np.eye(3)
    axes = np.einsum("rii->ri", full)[:, :, None] * np.eye(3)
    for covariance in (full, axes, axes[:, :1, :1] * np.eye(3)):
        given = replace(made, covariance=covariance, own_uncertainty=True)
        write_measurements(given, study().robot, tmp_path / "m.csv")
        found = read_measurements(tmp_path / "m.csv", study())
        assert found.own_uncertainty
        np.testing.assert_allclose(found.covariance, covariance, rtol=1e-8)


def test_uncertainties_of_positions_alone(tmp_path: Path) -> None:
    """The rotation has then that of the instrument."""
    text = GOOD.replace("dz [mm],", "dz [mm],u [mm],").replace("-3.1,", "-3.1,0.01,")
    found = read(text.replace("-3.2,", "-3.2,0.02,"), tmp_path)
    np.testing.assert_allclose(
        found.deviation, [[1e-5] * 3, [TURN] * 3, [2e-5] * 3, [TURN] * 3], rtol=1e-12
    )


def test_where_a_part_was_not_read(tmp_path: Path) -> None:
    """Positions without rotation, rotation without positions; neither is refused."""
    text = GOOD.replace(",4.1,-2.2,0.3", ",,,").replace(",0.1,0.3,-3.2", ",,,")
    found = read(text, tmp_path)
    assert found.case.tolist() == [0, 1]
    assert found.rotations.tolist() == [False, True]
    assert found.deflection[1] == pytest.approx([4.2e-3, -2.1e-3, 4e-4])
    write_measurements(found, study().robot, tmp_path / "again.csv")
    again = read_measurements(tmp_path / "again.csv", study())
    assert np.array_equal(again.deflection, found.deflection)
    assert np.array_equal(again.marker, found.marker)


@pytest.mark.parametrize("lacking", ["rotation", "position"])
def test_columns_that_are_not_there_at_all(lacking: str, tmp_path: Path) -> None:
    """A campaign of one part is one, and what the study wanted besides is said."""
    keep = slice(0, 14) if lacking == "rotation" else [*range(11), 14, 15, 16]
    rows = [np.array(row.split(","))[keep] for row in GOOD.splitlines()]
    found = read("\n".join(",".join(row) for row in rows) + "\n", tmp_path)
    assert found.rotations.tolist() == [lacking == "position"] * 2
    missing = next(d for d in found.doubts if d.code == "marker-not-measured")
    said = worded(missing)
    assert ("rotation of the flange" in said) == (lacking == "rotation")


def test_one_rotation_for_all_markers(tmp_path: Path) -> None:
    """In one row of the experiment, or in each with the same values."""
    row = f"1,{AT},0.1,0.2,-3.1,"
    second = row.replace("M1", "M2").replace("0.1,0.2", "0.3,0.4")
    head = GOOD.splitlines()[0] + "\n"
    once = read(f"{head}{row},,\n{second}4.1,-2.2,0.3\n", tmp_path, study(2))
    twice = read(f"{head}{row}4.1,-2.2,0.3\n{second}4.1,-2.2,0.3\n", tmp_path, study(2))
    for found in (once, twice):
        assert found.marker.tolist() == [0, 1, 2]
        assert found.deflection[2] == pytest.approx([4.1e-3, -2.2e-3, 3e-4])
    assert any("a rotation that another row has" in remark for remark in twice.remarks)
    with pytest.raises(MeasurementFileError, match=r"line 3.*its rotation was given in line 2"):
        read(f"{head}{row}4.1,-2.2,0.3\n{second}4.1,-2.2,0.4\n", tmp_path, study(2))


def with_column(text: str, header: str, *cells: str) -> str:
    """The file with a further column at the end."""
    rows = zip(text.splitlines(), (header, *cells), strict=True)
    return "".join(f"{row},{cell}\n" for row, cell in rows)


REFUSED: dict[str, tuple[Callable[[str], str], str]] = {
    "a part of a rotation": (
        lambda t: t.replace("4.1,-2.2,0.3", "4.1,,0.3"),
        r"line 2, column 'dry \[mrad\]': the cell is empty; expected a number, or all three",
    ),
    "a part of a position": (
        lambda t: t.replace("0.1,0.2,-3.1", "0.1,0.2,"),
        r"line 2, column 'dz \[mm\]': the cell is empty; expected a number, or all three",
    ),
    "nothing": (
        lambda t: t.replace("0.1,0.2,-3.1,4.1,-2.2,0.3", ",,,,,"),
        "line 2: the row has neither a deflection nor a rotation",
    ),
    "no unit": (
        lambda t: t.replace("drx [mrad]", "drx"),
        r"column 'drx' has no unit; expected it in brackets, such as 'drx \[mrad\]'",
    ),
    "a length": (
        lambda t: t.replace("drx [mrad]", "drx [mm]"),
        "unit 'mm' is not accepted for 'drx'; that is a unit of length",
    ),
    "one column missing": (
        lambda t: t.replace("drz [mrad]", "phi [mrad]"),
        r"column 'drz \[mrad\]' is missing",
    ),
    "words": (lambda t: t.replace("4.1,", "much,"), "expected a number, found 'much'"),
    "an uncertainty for the unread": (
        lambda t: with_column(t, "ur [mrad]", "", "0.1"),
        r"line 2, column 'ur \[mrad\]': an uncertainty must be positive, the cell is empty",
    ),
    "expanded or standard": (
        lambda t: with_column(t, "UR [mrad]", "1", "1"),
        r"column 'UR \[mrad\]' is ambiguous; write 'ur \[mrad\]' for standard or 'U95r \[mrad\]'",
    ),
    "states": (
        lambda t: t.replace("marker,", "marker,state,").replace("M1,", "M1,loaded,"),
        "columns 'state' and 'dx': a deflection has no state",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(name: str, tmp_path: Path) -> None:
    change, message = REFUSED[name]
    with pytest.raises(MeasurementFileError, match=message):
        read(change(GOOD), tmp_path)


def test_a_study_of_positions_does_without_rotations_and_says_so(tmp_path: Path) -> None:
    positions = replace(study(), instrument=Isotropic(SIGMA))
    found = read(GOOD, tmp_path, positions)
    assert not found.rotations.any()
    doubt = next(d for d in found.doubts if d.code == "rotations-not-used")
    assert doubt.about == ("drx [mrad]", "dry [mrad]", "drz [mrad]")
    assert "`measures: pose`" in worded(doubt)
    # Without a unit, or with empty cells, too: nobody looks at them.
    bare = GOOD.replace("drx [mrad]", "drx").replace("4.1,-2.2,0.3", ",,")
    assert "drx" in next(d for d in read(bare, tmp_path, positions).doubts).about


def test_a_mapping_of_rotations(tmp_path: Path) -> None:
    """Their columns, unit and frame; of no use where positions alone are measured."""
    names = {f"A{i} [deg]": f"A{i} [deg]" for i in range(1, 7)}
    names |= {"dx [mm]": "dx", "dy [mm]": "dy", "dz [mm]": "dz", "experiment": "experiment"}
    names |= {f"dr{a} [deg]": f"w{a}" for a in "xyz"}
    text = "elastocal: 1\ncolumns:\n" + "".join(f'  "{k}": "{v}"\n' for k, v in names.items())
    text += 'constants: {"Fx [N]": 0, "Fy [N]": 0, "Fz [N]": -2500, marker: M1}\n'
    text += "frame: {rpy_deg: [0, 0, 90]}\n"
    data = GOOD.replace("drx [mrad]", "wx").replace("dry [mrad]", "wy").replace("drz [mrad]", "wz")
    found = read(data, tmp_path, mapping=text)
    np.testing.assert_allclose(
        found.deflection[1], np.radians([2.2, 4.1, 0.3]), rtol=1e-12, atol=1e-15
    )
    plain = read(data, tmp_path, replace(study(), instrument=Isotropic(SIGMA)), text)
    assert not plain.rotations.any()
    assert {"rotations-not-used", "columns-not-used"} <= codes(plain)


def test_rotations_in_another_unit_are_noticed(tmp_path: Path) -> None:
    """Degrees under a header of milliradians, and the reverse, and radians; and the sign."""
    made = simulated(study())

    def written(factor: float, header: str = "mrad") -> Measurements:
        values = np.array(made.deflection)
        values[made.rotations] *= factor
        write_measurements(replace(made, deflection=values), study().robot, tmp_path / "m.csv")
        text = (tmp_path / "m.csv").read_text().replace("mrad", header)
        return read(text, tmp_path)

    assert not codes(written(1.0)) & {"rotation-unit", "rotation-sign"}
    degrees = np.degrees(1e-3)  # of a milliradian
    for factor, header, meant in (
        (degrees, "mrad", "deg"),
        (1.0, "deg", "mrad"),
        (1e-3, "mrad", "rad"),
        (1e3, "mrad", "urad"),
    ):
        found = written(factor, header)
        doubt = next(d for d in found.doubts if d.code == "rotation-unit")
        assert (doubt.about, doubt.because) == ((meant,), (header,))
        assert f"{meant} read as {header}" in worded(doubt)
    backwards = written(-1.0)
    assert "rotation-sign" in codes(backwards)
    assert "rotation-unit" not in codes(backwards)
    both = written(-degrees)
    assert {"rotation-sign", "rotation-unit"} <= codes(both)


def test_rotations_that_look_odd_by_themselves(tmp_path: Path) -> None:
    large = read(GOOD.replace("mrad", "rad"), tmp_path)
    doubt = next(d for d in large.doubts if d.code == "large-deflection")
    assert (doubt.about, doubt.unit) == (("1", "2"), "rad")
    assert "milliradians or degrees" in worded(doubt)
    still = GOOD.replace("4.1,-2.2,0.3", "0,0,0")
    doubt = next(d for d in read(still, tmp_path).doubts if d.code == "zero-deflection")
    assert worded(doubt) == "experiment 1: the rotation is exactly zero"
    quiet = still.replace("4.2,-2.1,0.4", "0.01,0.02,0")
    doubt = next(d for d in read(quiet, tmp_path).doubts if d.code == "only-noise")
    assert "no rotation is above three times its noise" in worded(doubt)
    assert "mrad" in worded(doubt)
