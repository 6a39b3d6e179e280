"""Unloaded markers beside the arm: the frame by best fit, and the mistakes that spoil it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from elastocal.arrays import Array
from elastocal.errors import Doubt, MeasurementFileError
from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.identification.identify import identify
from elastocal.measuring.measurements import Measurements
from elastocal.wording import worded
from tests.files.campaign import study
from tests.files.exports import INSPECTOR, RPY, TEXT, TRUTH, TURN, Exported, exported, inspector

NO_FRAME = INSPECTOR.replace("frame: {rpy_deg: [-0.7, 1.3, 137.2]}\n", "")
BEST = f"{NO_FRAME}frame: best-fit\n"
CAMPAIGN = exported(noise=1e-5)
Files = dict[str, str]


def read(
    folder: Path, mapping: str = BEST, found: Exported = CAMPAIGN, files: Files | None = None
) -> Measurements:
    files = files or inspector(found)
    for name, text in files.items():
        (folder / name).write_text(text)
    (folder / "mapping.yaml").write_text(mapping)
    return read_measurements([folder / n for n in files], found.study, folder / "mapping.yaml")


def about_arm(data: Measurements) -> list[Doubt]:
    return [doubt for doubt in data.doubts if doubt.code in ("unlike-arm", "readings-turned")]


def test_the_right_frame_is_compared_and_nothing_is_odd(tmp_path: Path) -> None:
    data = read(tmp_path, INSPECTOR)
    assert data.placement is not None
    # The robot is off by .4 mm times a sine along each axis.
    assert data.placement.rms == pytest.approx(4e-4 * np.sqrt(1.5), rel=0.1)
    assert data.placement.apart == pytest.approx(np.linalg.norm([2.5, -3.1, 0.64]), rel=1e-3)
    assert about_arm(data) == []


def test_the_frame_by_best_fit(tmp_path: Path) -> None:
    data = read(tmp_path)
    assert data.placement is not None
    assert data.placement.chosen
    off = Rotation.from_matrix(data.placement.fits[0].rotation @ TURN.T).magnitude()
    assert off < 5.0 * data.placement.turn_error
    assert data.placement.turn_error < np.radians(0.02)
    errors = data.deflection - CAMPAIGN.deflection.reshape(-1, 3)
    assert np.sqrt(np.mean(errors**2)) < 2.0 * 1e-5
    assert any("best fit of 36 unloaded positions" in remark for remark in data.remarks)
    assert about_arm(data) == []
    fit = identify(CAMPAIGN.study.arm, data)
    np.testing.assert_allclose(fit.model.compliance, TRUTH, rtol=0.05)


def test_uncertainties_are_turned_along(tmp_path: Path) -> None:
    mapping = BEST.replace("[4, 5, 6]}", "[4, 5, 6]}", 1)
    mapping += 'constants: {"ux [mm]": 0.01, "uy [mm]": 0.02, "uz [mm]": 0.03}\n'
    data = read(tmp_path, mapping)
    assert data.placement is not None
    turn = data.placement.fits[0].rotation
    own = 2.0 * np.diag([1e-10, 4e-10, 9e-10])
    np.testing.assert_allclose(data.covariance[5], turn @ own @ turn.T, rtol=1e-9, atol=1e-22)


def test_a_forgotten_frame(tmp_path: Path) -> None:
    data = read(tmp_path, NO_FRAME)
    (doubt,) = about_arm(data)
    assert doubt.code == "readings-turned"
    assert doubt.numbers["turn"] == pytest.approx(np.radians(137.2), abs=0.01)
    said = worded(doubt)
    assert "unloaded markers are 0.48 mm (RMS) from where joints and tool put them, after" in said
    assert "turned by 137.2°" in said
    assert "frame: best-fit" in said


def test_a_frame_by_hand(tmp_path: Path) -> None:
    data = read(tmp_path, f"{NO_FRAME}frame: {{rpy_deg: [0, 0, 135]}}\n")
    (doubt,) = about_arm(data)
    apart = Rotation.from_matrix(TURN) * Rotation.from_euler("z", -135, degrees=True)
    assert doubt.numbers["turn"] == pytest.approx(apart.magnitude(), abs=1e-3)
    close = f"{NO_FRAME}frame: {{rpy_deg: [{RPY[0]}, {RPY[1]}, {RPY[2] + 0.2}]}}\n"
    assert about_arm(read(tmp_path, close)) == []  # as much as the zero of a joint may do


def test_two_stations_have_a_frame_each(tmp_path: Path) -> None:
    other = Rotation.from_euler("xyz", [10, 20, -70], degrees=True).as_matrix()
    second = exported(noise=1e-5, seed=5, turn=other)
    files = {"a.txt": inspector(CAMPAIGN)["points.txt"], "b.txt": inspector(second)["points.txt"]}
    joints = inspector(CAMPAIGN)["joints.csv"] + inspector(second)["joints.csv"].split("\n", 1)[1]
    for name in ("A", "B"):
        letter = name.lower()
        files[f"{letter}.txt"] = files[f"{letter}.txt"].replace("KR270,", f"{name},")
    head, *lines = joints.splitlines()
    rows = [f"{'A' if i < 12 else 'B'},{line}" for i, line in enumerate(lines)]
    files["joints.csv"] = "\n".join([f"Day,{head}", *rows]) + "\n"
    entry = """  - header: false
    columns: {series: 1, marker: 3, "x y z [mm]": [4, 5, 6]}
    patterns: {2: 'Pose(?P<experiment>\\d+)_(?P<state>UL|L)'}
"""
    mapping = f"""\
elastocal: 1
files:
{entry}{entry}  - join: [series, experiment]
    columns: {{series: Day, "q [deg]": [A1, A2, A3, A4, A5, A6], "hanging mass [kg]": Load kg}}
    patterns: {{Pose: 'Pose(?P<experiment>\\d+)'}}
words: {{state: {{UL: unloaded, L: loaded}}}}
frame: best-fit
"""
    data = read(tmp_path, mapping, CAMPAIGN, files)
    assert data.placement is not None
    assert len(data.placement.fits) == 2
    assert (data.names[0], data.names[12]) == ("A/01", "B/01")
    wanted = np.concatenate([c.deflection.reshape(-1, 3) for c in (CAMPAIGN, second)])
    assert np.sqrt(np.mean((data.deflection - wanted) ** 2)) < 2.0 * 1e-5


def joints(change: Callable[[Array], Array]) -> Callable[[Files], Files]:
    """Files with other joint values [deg]."""

    def changed(files: Files) -> Files:
        head, *lines = files["joints.csv"].splitlines()
        rows = [line.split(",") for line in lines]
        q = change(np.array([[float(v) for v in row[1:7]] for row in rows]))
        out = [",".join([r[0], *(f"{v:.5f}" for v in row), r[7]])
               for r, row in zip(rows, q, strict=True)]  # fmt: skip
        return {**files, "joints.csv": "\n".join([head, *out]) + "\n"}

    return changed


def points(change: Callable[[str], str]) -> Callable[[Files], Files]:
    """Files with other lines of points."""
    return lambda files: {
        **files,
        "points.txt": "\n".join(map(change, files["points.txt"].splitlines())) + "\n",
    }


def swapped(line: str) -> str:
    return line.replace(",M1,", ",M,").replace(",M2,", ",M1,").replace(",M,", ",M2,")


def in_metres(line: str) -> str:
    cells = line.split(",")
    if line.startswith("//"):
        return line
    return ",".join([*cells[:3], *(f"{float(v) / 1e3:.7f}" for v in cells[3:6]), cells[6]])


E = np.eye(6)
MISTAKES: dict[str, tuple[Callable[[Files], Files], str]] = {
    **{
        f"sign of A{i + 1}": (
            joints(lambda q, i=i: q * (1 - 2 * E[i])),
            f"A{i + 1} counts the other way",
        )  # type: ignore[misc]
        for i in range(6)
    },
    **{
        f"zero of A{i + 1}": (joints(lambda q, i=i: q + 2 * E[i]), f"all values of A{i + 1} were 2")  # type: ignore[misc]
        for i in range(1, 6)
    },
    "a small zero": (joints(lambda q: q - 0.3 * E[1]), "all values of A2 were 0.3"),
    "a quarter": (joints(lambda q: q + 90 * E[2]), "all values of A3 were 90° smaller"),
    "three signs": (joints(lambda q: q * [1, -1, -1, 1, -1, 1]), "A2, A3, A5 count the other way"),
    "radians": (joints(np.radians), "the joint values were radians and not degrees"),
    "exchanged": (points(swapped), "the markers M1, M2 have each other's names"),
    "metres": (points(in_metres), "are they metres, and not millimetres?"),
    "one experiment": (
        points(lambda line: swapped(line) if "Pose04_" in line else line),
        "if experiment 04 were left out",
    ),
    "a coupling": (joints(lambda q: q + q[:, 1:2] * E[2]), "A3 is coupled to A2"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_by_their_name(name: str, tmp_path: Path) -> None:
    change, expected = MISTAKES[name]
    data = read(tmp_path, NO_FRAME, CAMPAIGN, change(inspector(CAMPAIGN)))
    found = about_arm(data)
    assert expected in worded(found[0]), worded(found[0])
    assert found[0].numbers["mended"] < 1e-3
    if found[0].numbers["rms"] > 2e-2:  # no frame is taken from an arm that is elsewhere
        with pytest.raises(MeasurementFileError, match="expected at most 20 mm") as refused:
            read(tmp_path, BEST, CAMPAIGN, change(inspector(CAMPAIGN)))
        assert expected in str(refused.value)


@pytest.mark.parametrize("by", [1e-3, 3e-3, 2e-2])
def test_a_bumped_tracker(by: float, tmp_path: Path) -> None:
    moved = (np.arange(12) >= 6)[:, None, None] * by * np.array([1.0, -0.5, 0.3])
    bumped = replace(CAMPAIGN, unloaded=CAMPAIGN.unloaded + moved, loaded=CAMPAIGN.loaded + moved)
    (doubt,) = about_arm(read(tmp_path, BEST, bumped))
    assert doubt.because == ("bumped",)
    assert doubt.about == ("07",)
    assert "was it bumped?" in worded(doubt)


def test_markers_elsewhere_on_the_tool(tmp_path: Path) -> None:
    other = replace(CAMPAIGN, study=study(TEXT.replace("M2: [500, 150", "M2: [500, 170")))
    (doubt,) = about_arm(read(tmp_path, BEST, other))
    assert (doubt.because, doubt.about) == (("markers",), ("M2",))
    assert doubt.numbers["by"] == pytest.approx(0.02, abs=1e-3)


def test_an_arm_that_nothing_explains(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    strange = replace(CAMPAIGN, unloaded=CAMPAIGN.unloaded + rng.normal(0, 0.05, (12, 3, 3)))
    data = read(tmp_path, NO_FRAME, strange)
    (doubt,) = about_arm(data)
    assert doubt.because == ()
    assert "compare lengths and tool of the model" in worded(doubt)


def test_no_best_fit_of_too_little(tmp_path: Path) -> None:
    files = inspector(CAMPAIGN)
    kept = [n for n in files["points.txt"].splitlines() if "Pose01" in n and ",M3," not in n]
    few = {**files, "points.txt": "\n".join(kept) + "\n"}
    with pytest.raises(MeasurementFileError, match="best-fit: a best fit needs three points that"):
        read(tmp_path, BEST, CAMPAIGN, few)
    data = read(tmp_path, NO_FRAME, CAMPAIGN, few)
    assert data.placement is None
    deflections = {"points.txt": files["points.txt"], "joints.csv": files["joints.csv"]}
    mapping = BEST.replace("x y z [mm]", "dx dy dz [mm]").replace("_(?P<state>UL|L)", "_L?U?L?")
    mapping = mapping.replace("words: {state: {UL: unloaded, L: loaded}}\n", "")
    unloaded = [line for line in deflections["points.txt"].splitlines() if "_L," in line]
    deflections["points.txt"] = "\n".join(unloaded) + "\n"
    with pytest.raises(MeasurementFileError, match="needs positions x, y, z of the unloaded arm"):
        read(tmp_path, mapping, CAMPAIGN, deflections)
