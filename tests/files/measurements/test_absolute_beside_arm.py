"""Absolute readings beside the arm as drawn: base and reflectors are free, mistakes are named."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from elastocal.arrays import Array
from elastocal.errors import Doubt
from elastocal.measuring.positions import Positions
from elastocal.robot.controller_axes import coupling
from elastocal.study.absolute import AbsoluteStudy
from elastocal.wording import worded
from tests.files.absolute_campaign import HEADER, Truth, rows, study, table, truth
from tests.files.measurements.test_positions import read

TRUTH = truth(30)
NOISE = 3e-4 * np.random.default_rng(0).normal(size=TRUTH.points.shape)
E = np.eye(6)


def moved(what: AbsoluteStudy) -> AbsoluteStudy:
    """A study whose reflectors are some centimetres from where they are."""
    markers = what.tool.markers + np.array([0.05, -0.04, 0.03])
    return replace(what, tool=replace(what.tool, markers=markers))


def found(folder: Path, changed: Truth, what: AbsoluteStudy | None = None) -> Positions:
    there = replace(changed, points=changed.points + NOISE)
    return read(table(HEADER, rows(there)), folder, what=moved(what or study()))


def about_arm(positions: Positions) -> list[Doubt]:
    return [d for d in positions.doubts if d.code in ("unlike-arm", "probe-turned")]


def test_the_arm_with_free_base_and_reflectors(tmp_path: Path) -> None:
    positions = found(tmp_path, TRUTH)
    assert positions.apart == pytest.approx(3e-4 * np.sqrt(3.0), rel=0.1)
    assert about_arm(positions) == []
    few = truth(4)
    assert np.isnan(read(table(HEADER, rows(few)), tmp_path).apart)


def joints(change: Callable[[Array], Array]) -> Truth:
    return replace(TRUTH, q=change(TRUTH.q))


MISTAKES: dict[str, tuple[Truth, str]] = {
    **{
        f"sign of A{i + 1}": (joints(lambda q, i=i: q * (1 - 2 * E[i])), f"if A{i + 1} counts")  # type: ignore[misc]
        for i in range(6)
    },
    "zero of A2": (joints(lambda q: q + 0.05 * E[1]), "all values of A2 were 2.9° smaller"),
    "zero of A5": (joints(lambda q: q - 0.2 * E[4]), "all values of A5 were 11° larger"),
    "a quarter": (joints(lambda q: q + 0.5 * np.pi * E[2]), "all values of A3 were 90° smaller"),
    "two signs": (joints(lambda q: q * [1, -1, 1, -1, 1, 1]), "A2, A4 count the other way"),
    "radians": (joints(np.radians), "were radians and not degrees"),
    "metres": (replace(TRUTH, points=TRUTH.points / 1e3), "are they metres, and not millimetres?"),
    "mirrored": (replace(TRUTH, points=TRUTH.points[:, :, [1, 0, 2]]), "they were mirrored"),
    "exchanged": (replace(TRUTH, points=TRUTH.points[:, ::-1]), ""),
    "one pose": (
        replace(TRUTH, points=np.where(np.arange(30)[:, None, None] == 17, 1.0, TRUTH.points)),
        "experiment 18 were left out",
    ),
    "bumped": (
        replace(TRUTH, points=TRUTH.points + 3e-3 * (np.arange(30) >= 20)[:, None, None]),
        "stood elsewhere from experiment 21 on",
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_by_their_name(name: str, tmp_path: Path) -> None:
    changed, expected = MISTAKES[name]
    scale = 1e-3 if name == "metres" else 1.0
    there = replace(changed, points=changed.points + scale * NOISE)
    positions = read(table(HEADER, rows(there)), tmp_path, what=moved(study()))
    doubts = about_arm(positions)
    if not expected:  # with free reflectors either name is as good
        assert doubts == []
        return
    assert expected in worded(doubts[0]), worded(doubts[0])
    assert len(doubts) == 1


@pytest.mark.parametrize("name", ["sign of A4", "zero of A5", "radians", "mirrored"])
def test_mistakes_of_an_arm_that_sags(name: str, tmp_path: Path) -> None:
    """What is left is the sag, more than any arm is off by its geometry."""
    sag = 0.008 * np.sin(3.0 * TRUTH.q[:, 1])[:, None, None] * np.array([0.0, 0.0, 1.0])
    changed, expected = MISTAKES[name]
    positions = found(tmp_path, replace(changed, points=changed.points + sag))
    (doubt,) = about_arm(positions)
    assert doubt.numbers["mended"] > 5e-3
    assert expected in worded(doubt)


def test_joint_values_of_the_controller(tmp_path: Path) -> None:
    table_ = coupling(study().robot, signs={"A2": -1, "A5": -1}, offsets={"A3": 0.4})
    what = replace(study(), controller=table_)
    (doubt,) = about_arm(found(tmp_path, joints(table_.to_controller), what))
    assert "those that the controller shows ('joints: controller')" in worded(doubt)


def test_nothing_explains_another_arm(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    other = replace(TRUTH, points=TRUTH.points + rng.normal(0.0, 0.05, TRUTH.points.shape))
    (doubt,) = about_arm(found(tmp_path, other))
    assert doubt.because == ()
    assert "positions are" in worded(doubt)
    assert "as drawn" in worded(doubt)


PROBE = """\
elastocal: 1
columns:
  q [deg]: [A1, A2, A3, A4, A5, A6]
  x y z [mm]: [x, y, z]
  rx ry rz [deg]: [rx, ry, rz]
orientation: euler-xyz
"""


@pytest.mark.parametrize(
    ("change", "mapping", "expected"),
    [
        (lambda q: q, "euler-xyz", ""),
        (lambda q: q, "rpy", "0.15° if 'orientation' were euler-xyz"),
        (lambda q: q, "rotation-vector", "if 'orientation' were euler-xyz"),
        (lambda q: q * (1 - 2 * E[5]), "euler-xyz", "if A6 counts the other way"),
    ],
)
def test_orientations(
    change: Callable[[Array], Array], mapping: str, expected: str, tmp_path: Path
) -> None:
    """The reflector is on the axis of A6, so positions do not tell its sign."""
    what = study(probe=True, markers=1)
    axis = what.robot.joints[5].axis * 0.2
    flange = Rotation.from_matrix(TRUTH.turns)
    at = TRUTH.points[:, 0] + flange.apply(axis - what.tool.markers[0])
    noise = Rotation.from_rotvec(1e-3 * np.random.default_rng(2).normal(size=(30, 3)))
    angles = (noise * flange).as_euler("XYZ", degrees=True)
    cells = [
        [f"{v:.9f}" for v in (*np.degrees(q), *(1e3 * p), *a)]
        for q, p, a in zip(change(TRUTH.q), at, angles, strict=True)
    ]
    header = [*(f"A{i}" for i in range(1, 7)), "x", "y", "z", "rx", "ry", "rz"]
    mapping = PROBE.replace("euler-xyz", mapping)
    doubts = about_arm(read(table(header, cells), tmp_path, mapping, what))
    assert len(doubts) == bool(expected)
    assert not expected or expected in worded(doubts[0]), worded(doubts[0])


def test_orientations_the_other_way_round(tmp_path: Path) -> None:
    quaternions = Rotation.from_matrix(TRUTH.turns).inv().as_quat(scalar_first=True)
    cells = [
        [*row, *(f"{v:.9f}" for v in q)]
        for row, q in zip(rows(TRUTH, markers=1), quaternions, strict=True)
    ]
    text = table([*HEADER, "qw", "qx", "qy", "qz"], cells)
    (doubt,) = about_arm(read(text, tmp_path, what=study(probe=True, markers=1)))
    assert "if the orientations are those of the tracker in the probe" in worded(doubt)
