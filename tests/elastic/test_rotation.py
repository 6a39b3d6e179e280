"""The rotation of the flange under load: MuJoCo, rigid bodies, differences, limits."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.deflections import deflection_and_gradient, loaded_deflection, markers_at
from elastocal.elastic.equilibrium import equilibrium
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import deflection, regressor
from elastocal.elastic.springs import joint_springs
from elastocal.errors import InputError
from elastocal.robot.chain import Tool
from elastocal.robot.rotations import turned_slope
from elastocal.robot.shapes import BodyMass
from tests.arms import random_chain, random_tool
from tests.elastic.test_equilibrium import GENTLE, chains, random_arm, random_cases
from tests.kr270 import kr270_study, kr270_truth, published_cases
from tests.settling import Settling

reproducible = settings(max_examples=20)


def reading_rotations(arm: ElasticArm) -> ElasticArm:
    """The same arm whose tool asks for the rotation too."""
    return replace(arm, tool=replace(arm.tool, rotation=True))


def kabsch(before: Array, after: Array) -> Array:
    """Rotation vector that takes points (K, 3) to where they are after, but for a shift."""
    turn, _ = Rotation.align_vectors(after - after.mean(axis=0), before - before.mean(axis=0))
    return turn.as_rotvec()


@pytest.mark.parametrize("heavy", [False, True], ids=["weightless links", "heavy links"])
def test_the_kr270_turns_as_in_mujoco(
    heavy: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of four markers in MuJoCo the rotation is that of a rigid body."""
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its log into the folder it is run in
    study = kr270_study()
    truth, robot = kr270_truth(study), study.robot
    if heavy:
        rng = np.random.default_rng(0)
        masses = (
            BodyMass(b, 300.0 * rng.uniform(0.2, 1.0), rng.normal(size=3) * 0.3)
            for b in range(1, 7)
        )
        robot = replace(robot, masses=tuple(masses))
    points = np.array([[0.6, 0.0, -0.5], [0.2, 0.9, 0.0], [0.1, -0.7, 0.3], [0.0, 0.1, 0.8]])
    tool = Tool("four", study.experiments.tool.load_point, points, tuple("ABCD"), rotation=True)
    arm = ElasticArm(robot, truth.springs, tool, np.array([0.0, 0.0, -9.81]) * heavy)
    cases = published_cases(3)
    ours = loaded_deflection(arm, truth.compliance, cases)[:, -3:]
    assert np.linalg.norm(ours, axis=1).min() > 4e-3
    linear = deflection(arm, truth.compliance, cases)[:, -3:]
    for i, q in enumerate(cases.q):
        theirs = Settling(arm, truth.compliance, q)
        idle, bent = (theirs.markers(w).reshape(-1, 3) for w in (np.zeros(6), cases.wrench[i]))
        found = kabsch(idle, bent)
        assert ours[i] == pytest.approx(found, abs=1e-11)
        assert np.linalg.norm(linear[i] - found) > 1e-6  # the linear model would not pass


@reproducible
@given(chains)
def test_the_flange_turns_as_its_points_do(chain: tuple[int, list[bool]]) -> None:
    """However large: the rotation of a rigid body through five of its points."""
    rng = np.random.default_rng(chain[0])
    arm = random_arm(rng, chain[1])
    arm = reading_rotations(replace(arm, tool=random_tool(rng, 5)))
    compliance = GENTLE * rng.uniform(0.5, 1.0, len(arm.springs))
    cases = random_cases(rng, arm, 2)
    found = loaded_deflection(arm, compliance, cases)
    whole = loaded_deflection(
        replace(arm, tool=replace(arm.tool, rotation=False)), compliance, cases
    )
    assert np.array_equal(found[:, :-3], whole)
    states = [
        equilibrium(arm, compliance, LoadCases(cases.q, w)).displacement
        for w in (0.0 * cases.wrench, cases.wrench)
    ]
    idle, bent = (markers_at(arm, cases.q, s).reshape(2, -1, 3) for s in states)
    for i in range(2):
        assert found[i, -3:] == pytest.approx(kabsch(idle[i], bent[i]), abs=1e-10)


@settings(max_examples=8)
@given(chains)
def test_the_gradient_of_the_rotation(chain: tuple[int, list[bool]]) -> None:
    """In the compliances, with weights that bend the idle arm too: central differences."""
    rng = np.random.default_rng(chain[0])
    arm = reading_rotations(random_arm(rng, chain[1]))
    p = len(arm.springs)
    compliance = GENTLE * rng.uniform(0.5, 1.0, p)
    cases = random_cases(rng, arm, 2)
    value, gradient = deflection_and_gradient(arm, compliance, cases)
    np.testing.assert_allclose(value, loaded_deflection(arm, compliance, cases), atol=1e-14)
    for j in range(p):
        h = np.zeros(p)
        h[j] = 1e-5
        ahead, behind = (loaded_deflection(arm, compliance + s, cases) for s in (h, -h))
        np.testing.assert_allclose(gradient[:, :, j], (ahead - behind) / 2e-5, atol=1e-5)


@reproducible
@given(chains)
def test_small_loads_turn_as_the_linear_model_says(chain: tuple[int, list[bool]]) -> None:
    """The difference to the rotation rows falls as the square of the load."""
    rng = np.random.default_rng(chain[0])
    arm = reading_rotations(random_arm(rng, chain[1], heavy=False))
    compliance = GENTLE * rng.uniform(0.5, 1.0, len(arm.springs))
    cases = random_cases(rng, arm, 2)
    off = []
    for load in (1e-2, 1e-3):
        small = LoadCases(cases.q, load * cases.wrench)
        linear = regressor(arm, small) @ compliance
        bent = loaded_deflection(arm, compliance, small)
        off.append(np.abs(bent - linear)[:, -3:].max())
    assert off[1] <= 0.011 * off[0] + 1e-14
    assert off[0] <= 1e-2


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.floats(-9.0, 0.49))
def test_slopes_of_a_turn_before_and_behind(seed: int, power: float) -> None:
    """log(exp(dw) exp(v)) and log(exp(v) exp(dw)), for angles from nothing up to 3 rad."""
    rng = np.random.default_rng(seed)
    v, w = rng.normal(size=(2, 3))
    v *= 10.0**power / np.linalg.norm(v)
    turn, step = Rotation.from_rotvec(v), 1e-5
    left, right = (
        [order(Rotation.from_rotvec(s * step * w)).as_rotvec() for s in (1.0, -1.0)]
        for order in (lambda r: r * turn, lambda r: turn * r)
    )
    slope = turned_slope(v[None])[0]
    assert slope @ w == pytest.approx((left[0] - left[1]) / (2.0 * step), abs=1e-7)
    assert slope.T @ w == pytest.approx((right[0] - right[1]) / (2.0 * step), abs=1e-7)


def test_series_and_closed_form_of_the_slope_meet() -> None:
    v = np.outer([1e-2 * (1.0 - 1e-12), 1e-2], [0.6, 0.0, 0.8])
    below, above = turned_slope(v)
    np.testing.assert_allclose(below, above, atol=2e-14)


def test_rows_of_a_tool_that_asks_for_the_rotation() -> None:
    """The same as those asked for by name; without either there are none."""
    rng = np.random.default_rng(3)
    robot = random_chain(rng, [False, True, False])
    arm = ElasticArm(robot, joint_springs(robot), random_tool(rng, 2))
    cases = random_cases(rng, arm, 4)
    asked = regressor(reading_rotations(arm), cases)
    assert np.array_equal(asked, regressor(arm, cases, rotation=True))
    assert np.array_equal(asked[:, :-3], regressor(arm, cases))
    assert reading_rotations(arm).tool.targets == ("M1", "M2", "rotation")
    assert arm.tool.targets == ("M1", "M2")
    assert not reading_rotations(arm).tool.at_tcp.rotation


def test_a_marker_called_as_the_rotation_is() -> None:
    with pytest.raises(InputError, match="a marker is called 'rotation'"):
        Tool("t", np.zeros(3), np.zeros((1, 3)), ("rotation",), rotation=True)
    assert Tool("t", np.zeros(3), np.zeros((1, 3)), ("rotation",)).targets == ("rotation",)
