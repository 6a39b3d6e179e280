"""Calibration files: read again they predict the same, and a wrong entry is named."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import elastocal as ec
from elastocal.calibration.arm_model import State
from elastocal.calibration.calibrate import calibrate
from elastocal.calibration.calibrated_robot import CalibratedRobot, put_away
from elastocal.calibration.parameters import parameters_of
from elastocal.calibration.prediction import predicted
from elastocal.elastic.springs import joint_springs
from elastocal.elastic.unknowns import each_spring
from elastocal.errors import ModelFileError
from elastocal.files.models import calibration_file
from elastocal.files.models.calibration_file import read_calibration
from elastocal.files.models.calibration_kind import is_calibration
from elastocal.files.models.calibration_writing import calibration_document, write_calibration
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot
from elastocal.robot.geometry import geometric_errors
from tests.calibration.random_calibrated import (
    TOOL,
    calibrated_as,
    plain_positions,
    random_calibrated,
)
from tests.calibration.random_campaign import random_model, random_state
from tests.files.damage import damaged
from tests.robot.sources.test_mimic_on_chain import read as level_arm

chains = st.tuples(st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=1, max_size=7))
KR270 = ec.load_robot("kuka-kr270")


def again(calibrated: CalibratedRobot, folder: Path, robot: Robot) -> CalibratedRobot:
    path = folder / "calibration.json"
    write_calibration(calibrated, path)
    return read_calibration(path, robot)


def apart(one: CalibratedRobot, other: CalibratedRobot, positions: Positions) -> float:
    """Largest difference of what two calibrated robots predict [m, rad], or of its rows."""
    a, b = (predicted(c.model, positions, c.parameters, c.state) for c in (one, other))
    return float(max(np.abs(a.error - b.error).max(), np.abs(a.rows - b.rows).max()))


@settings(max_examples=10, deadline=None)
@given(chains)
def test_read_again_it_predicts_the_same(
    tmp_path_factory: pytest.TempPathFactory, chain: tuple[int, list[bool]]
) -> None:
    rng = np.random.default_rng(chain[0])
    calibrated, positions = random_calibrated(rng, chain[1])
    found = again(calibrated, tmp_path_factory.mktemp("model"), calibrated.model.robot)
    assert apart(calibrated, found, positions) < 1e-9
    assert np.array_equal(found.covariance, calibrated.covariance)
    assert np.array_equal(found.seen, calibrated.seen)
    assert np.array_equal(found.open, calibrated.open)
    assert found.parameters.names == calibrated.parameters.names
    assert found.parameters.block == calibrated.parameters.block
    assert found.parameters.turns == calibrated.parameters.turns
    assert np.array_equal(found.parameters.held, calibrated.parameters.held)
    assert (found.told, found.dof, found.origin) == (
        calibrated.told,
        calibrated.dof,
        calibrated.origin,
    )
    for one, other in zip(found.noise, calibrated.noise, strict=True):
        assert one.instrument == pytest.approx(other.instrument)
        assert one.model == pytest.approx(other.model)
        assert one.turned == pytest.approx(other.turned)
    assert np.allclose(found.compliances.covariance, calibrated.compliances.covariance, rtol=1e-12)


@pytest.mark.parametrize("robot", [KR270, level_arm()], ids=["kr270", "followers on the chain"])
def test_robots_of_files_too(robot: Robot, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    calibrated = calibrated_as(rng, robot)
    positions = plain_positions(rng, calibrated.model, 20)
    assert apart(calibrated, again(calibrated, tmp_path, robot), positions) < 1e-9


def test_another_robot_is_refused(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    calibrated = calibrated_as(rng, KR270)
    with pytest.raises(ModelFileError, match="not of 'three-link'"):
        again(calibrated, tmp_path, ec.load_robot("three-link"))
    with pytest.raises(ModelFileError, match=r"line \d+: geometry_sha256: .* drawn elsewhere"):
        again(calibrated, tmp_path, calibrated.robot)


def test_what_is_no_calibration(tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    path.write_text('{"elastocal": 1, "kind": "model", "compliance": {}}', "utf-8")
    assert not is_calibration(path)
    with pytest.raises(ModelFileError, match="this is a model file, expected a calibration"):
        read_calibration(path, KR270)
    path.write_text("[]", "utf-8")
    assert not is_calibration(path)
    with pytest.raises(ModelFileError, match="expected a calibration"):
        read_calibration(path, KR270)


ODD = (None, "x", "2", 1, 1e29, True, [], {})
FREE = (
    "made_by",
    "source",
    "provenance",
    "dof",
    "noise",
    "fit",
    "told",
    "open",
    "rests_on_prior",
    "held",
)
"""What may be otherwise without another prediction."""


@pytest.fixture(scope="module")
def document() -> Any:
    rng = np.random.default_rng(5)
    calibrated, _ = random_calibrated(rng, [False, True])
    return json.loads(json.dumps(calibration_document(calibrated)))


@pytest.fixture(scope="module")
def two_links() -> Robot:
    return random_calibrated(np.random.default_rng(5), [False, True])[0].model.robot


def what_is_said(path: Path, robot: Robot) -> str:
    try:
        read_calibration(path, robot)
    except ModelFileError as error:
        return str(error)
    return ""


def test_every_node_is_what_it_was_or_named(
    document: Any, two_links: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(calibration_file, "_SMALL_ENOUGH_TO_LOCATE", 0)  # lines take time
    path, said = tmp_path / "calibration.json", set()
    path.write_text(json.dumps(document), "utf-8")
    read_calibration(path, two_links)
    for place, what, changed in damaged(document, ODD):
        path.write_text(json.dumps(changed), "utf-8")
        told = f"{place} = {what!r}"
        if wrong := what_is_said(path, two_links):
            said.add(wrong)
            assert wrong.startswith(f"{path}"), told
            assert "\n" not in wrong, told
            continue
        number = isinstance(what, (int, float)) and not isinstance(what, bool)
        assert place[0] in FREE or number or place[-1] in OPTIONAL, told
    assert len(said) > 200


OPTIONAL = (
    "station", "mounting", "springs", "type", "name", "payloads", "fitted", "rotation",
    "markers_mm", "order", 0, -1,
)  # fmt: skip


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("covariance", "order", 0), "zero J1", "order must name"),
        (("geometry", "zero J1", "unit"), "m", "zero J1: expected rad, found m"),
        (("geometry", "zero J1", "standard_error"), 1.0, "contradicts the standard errors"),
        (("compliance", "J1", "unit"), "m/N", r"expected rad/\(N·m\) as unit"),
        (("compliance", "J1", "springs"), {"J9": 1.0}, "no joint or spring 'J9'"),
        (("payloads", "open", "fitted"), False, "is not fitted, against the errors"),
        (("bases", 0, "quaternion_wxyz"), [1.0, 1.0, 0.0, 0.0], "a quaternion of length 1"),
        (("bases", 1, "station"), "near", "two bases are called 'near'"),
        (("rests_on_prior",), ["zero J7"], "there is no unknown 'zero J7'"),
        (("noise",), [], "one entry for each of the bases"),
        (("mountings", 0, "markers_mm"), {"X": [0, 0, 0]}, "the tool has no reflector 'X'"),
        (("tool", "rotation"), False, "no probe that reads rotations"),
        (("elastocal",), 2, "format version 2 is not known"),
    ],
)  # fmt: skip
def test_sentences(
    place: tuple[Any, ...], value: Any, message: str, document: Any, two_links: Robot,
    tmp_path: Path,
) -> None:  # fmt: skip
    changed = json.loads(json.dumps(document))
    inner = changed
    for part in place[:-1]:
        inner = inner[part]
    inner[place[-1]] = value
    path = tmp_path / "calibration.json"
    path.write_text(json.dumps(changed, indent=1), "utf-8")
    with pytest.raises(ModelFileError, match=message):
        read_calibration(path, two_links)


def test_a_fit_is_put_away_whole(tmp_path: Path) -> None:
    """A small campaign, fitted, written and read: predictions, and what is known of them."""
    rng = np.random.default_rng(6)
    model = random_model(rng, [False, False, False])
    plain = model.__class__(
        model.robot, TOOL, geometric_errors(model.robot), each_spring(joint_springs(model.robot)),
        np.array([0.0, 0.0, -9.81]),
    )  # fmt: skip
    truth = random_state(rng, random_model(np.random.default_rng(6), [False, False, False]), 1e-3)
    state = State(
        truth.base[:1], TOOL.markers[None], np.eye(3)[None],
        1e-3 * rng.normal(size=len(plain.errors)), np.full(3, 1e-4),
    )  # fmt: skip
    positions = plain_positions(rng, plain, 40)
    seen = predicted(plain, positions, parameters_of(plain, positions), state)
    value = positions.value - seen.error + 1e-5 * rng.normal(size=seen.error.shape)
    covariance = np.tile(1e-10 * np.eye(3), (len(value), 1, 1))
    positions = replace(positions, value=value, covariance=covariance, source="m.csv", sha256="ab")
    fit = calibrate(plain, positions, parameters_of(plain, positions))
    calibrated = put_away(fit, "cell", "cd")
    found = again(calibrated, tmp_path, plain.robot)
    assert apart(calibrated, found, positions) < 1e-9
    there = predicted(found.model, positions, found.parameters, found.state)
    assert np.abs(there.error - fit.error).max() < 1e-9
    assert np.sqrt((there.error**2).sum(axis=1).mean()) == pytest.approx(found.fitted, rel=1e-9)
    assert found.origin == calibrated.origin
    assert np.array_equal(found.standard_error, calibrated.standard_error)
