"""Tables of Denavit and Hartenberg: the same flange as the robot they are of."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import elastocal as ec
from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.robot.chain import Joint, Robot, moved, transform
from elastocal.robot.geometry import geometric_errors, with_errors
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.robot.sinks.dh import DHTable, dh_table, refuse_unlike
from elastocal.robot.sources import DHRow, from_dh
from tests.arms import random_chain
from tests.robot.sinks.drawn import drawn
from tests.robot.sources.oracle import OWN
from tests.robot.sources.test_mimic_on_chain import read as level_arm

UR10 = (  # the maker's table: theta, d, a, alpha
    (0.0, 0.1273, 0.0, 90.0),
    (0.0, 0.0, -0.612, 0.0),
    (0.0, 0.0, -0.5723, 0.0),
    (0.0, 0.163941, 0.0, 90.0),
    (0.0, 0.1157, 0.0, -90.0),
    (0.0, 0.0922, 0.0, 0.0),
)


def ur10() -> Robot:
    rows = [
        DHRow(f"J{i}", np.radians(t), d, a, np.radians(alpha))
        for i, (t, d, a, alpha) in enumerate(UR10, 1)
    ]
    return from_dh("ur10", rows, modified=False)


def plain_flange(robot: Robot, q: Array) -> Array:
    """(4, 4) as a product of all transforms."""
    T = np.eye(4)
    for joint, value in zip(robot.joints, q, strict=True):
        T = T @ joint.T_parent_joint @ moved(joint, value)
    return T @ robot.T_tip_flange


def turned(axis: int, angle: float) -> Array:
    return from_rotation_vectors(np.eye(3)[axis : axis + 1] * angle)[0]


def by_rows(table: DHTable, q: Array) -> Array:
    """(4, 4) the flange by the words of the two conventions, not by our writer."""
    T = np.array(table.T_base_first)
    for row, beta, value in zip(table.rows, table.beta, q, strict=True):
        theta = row.theta + (0.0 if row.prismatic else row.sign * value)
        d = row.d + (row.sign * value if row.prismatic else 0.0)
        about_z = [transform(turned(2, theta)), transform(None, (0, 0, d))]
        about_x = [transform(None, (row.a, 0, 0)), transform(turned(0, row.alpha))]
        about_x.append(transform(turned(1, beta)))
        for part in [*about_x, *about_z] if table.modified else [*about_z, *about_x]:
            T = T @ part
    return T @ table.T_last_flange


def apart(robot: Robot, table: DHTable, rng: np.random.Generator) -> float:
    q = rng.uniform(-2.0, 2.0, (20, len(robot.joints)))
    return max(float(np.abs(by_rows(table, one) - plain_flange(robot, one)).max()) for one in q)


def numbers(table: DHTable) -> list[tuple[float, ...]]:
    return [(np.degrees(r.theta), r.d, r.a, np.degrees(r.alpha)) for r in table.rows]


@settings(max_examples=30, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.booleans(), min_size=1, max_size=7),
    st.booleans(),
)
def test_any_chain(seed: int, slides: list[bool], modified: bool) -> None:
    rng = np.random.default_rng(seed)
    robot = random_chain(rng, slides)
    table = dh_table(robot, modified=modified)
    assert apart(robot, table, rng) < 1e-9


@pytest.mark.parametrize("modified", [False, True])
@pytest.mark.parametrize("path", OWN, ids=lambda path: path.stem)
def test_robots_of_files_as_drawn_and_calibrated(path: Path, modified: bool) -> None:
    rng = np.random.default_rng(1)
    robot = drawn(path)
    errors = geometric_errors(robot)
    for size in (0.0, 1e-6, 1e-4, 1e-3):
        real = with_errors(robot, errors, size * rng.normal(size=len(errors)))
        table = dh_table(real, modified=modified, like=robot)
        assert apart(real, table, rng) < 1e-9
        refuse_unlike(table, real)
        assert all(abs(row.d) < 3.0 for row in table.rows)


def test_a_table_comes_back_as_it_was() -> None:
    table = dh_table(ur10(), modified=False)
    assert table.plain
    assert np.array(numbers(table)) == pytest.approx(np.array(UR10), abs=1e-9)
    assert np.abs(table.T_base_first - np.eye(4)).max() < 1e-12
    assert np.abs(table.T_last_flange - np.eye(4)).max() < 1e-12


def test_errors_in_the_numbers_of_a_table_are_found_in_its_numbers() -> None:
    """Crossing axes: what is put into the rows comes out of them, and no beta with it."""
    rng = np.random.default_rng(2)
    rows = [
        DHRow(f"J{i}", *(v + 1e-3 * rng.normal() for v in (t, d, a, np.radians(alpha))))
        for i, (t, d, a, alpha) in enumerate(
            ((0.1, 0.4, 0.02, 90.0), (-0.2, 0.1, 0.5, -90.0), (0.3, 0.2, 0.1, 60.0)), 1
        )
    ]
    for modified in (False, True):
        robot = from_dh("r", rows, modified=modified)
        table = dh_table(robot, modified=modified)
        assert table.plain
        for row, own in zip(table.rows, rows, strict=True):
            assert (row.theta, row.d, row.a, row.alpha) == pytest.approx(
                (own.theta, own.d, own.a, own.alpha), abs=1e-12
            )


def test_parallel_axes_that_are_not_quite() -> None:
    """The forearm of a UR10 tilts by a milliradian: beta says it, and d stays what it was."""
    robot = ur10()
    errors = geometric_errors(robot)
    values = np.zeros(len(errors))
    values[errors.names.index("beta J2")] = 1e-3
    real = with_errors(robot, errors, values)
    table = dh_table(real, modified=False, like=robot)
    assert not table.plain
    assert abs(table.beta[1]) == pytest.approx(1e-3, abs=1e-9)
    assert table.far[1] > 100.0, "m: where a plain table would put d"
    assert np.array(numbers(table))[:, :3] == pytest.approx(np.array(UR10)[:, :3], abs=1e-3)
    assert apart(real, table, np.random.default_rng(0)) < 1e-12


def test_signs_are_kept() -> None:
    rows = [DHRow("A", 0.2, 0.3, 0.1, 1.0, sign=-1.0), DHRow("B", 0.1, 0.2, 0.3, -1.0, sign=-1.0)]
    table = dh_table(from_dh("r", rows, modified=True), modified=True)
    assert [row.sign for row in table.rows] == [-1.0, -1.0]


def test_the_kr270() -> None:
    robot = ec.load_robot("kuka-kr270")
    for modified in (False, True):
        assert apart(robot, dh_table(robot, modified=modified), np.random.default_rng(0)) < 1e-12


def test_what_has_no_table() -> None:
    with pytest.raises(InputError, match="'level' stands between base and flange and follows"):
        dh_table(level_arm(), modified=False)


def test_a_wrong_table_is_refused() -> None:
    robot = ur10()
    table = dh_table(robot, modified=False)
    wrong = replace(table, rows=(replace(table.rows[0], d=0.2), *table.rows[1:]))
    with pytest.raises(InputError, match="µm off"):
        refuse_unlike(wrong, robot)


def test_axes_on_one_line() -> None:
    z = np.array([0.0, 0.0, 1.0])
    joints = (Joint("A", np.eye(4), z), Joint("B", transform(None, (0, 0, 0.5)), z))
    robot = Robot("r", joints, transform(None, (0.1, 0.2, 0.3)))
    errors = geometric_errors(robot)
    rng = np.random.default_rng(3)
    for size in (0.0, 1e-9, 1e-4):
        real = with_errors(robot, errors, size * rng.normal(size=len(errors)))
        for modified in (False, True):
            assert apart(real, dh_table(real, modified=modified, like=robot), rng) < 1e-9
