"""Columns for plans against the rows of predictions, and their gradients against differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.calibration.columns import unknown_columns
from elastocal.calibration.parameters import parameters_of
from elastocal.calibration.prediction import predicted
from elastocal.elastic.allowed_loads import FixedVector, ThereOrNot
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.measuring.instrument import Isotropic
from elastocal.study.experiment_space import LoadCaseEvaluation, LoadCaseSpace
from tests.calibration.random_campaign import random_model, random_positions, random_state

LIMITS = np.tile([[-3.0], [3.0]], 8)


@pytest.mark.parametrize("seed", range(6))
def test_columns_are_the_rows_of_predictions_at_the_arm_as_drawn(seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = random_model(rng, [bool(s) for s in rng.random(5) < 0.3])
    positions, state = random_positions(rng, model, 8), random_state(rng, model, 0.0)
    one = np.zeros(8)
    state = replace(state, base=np.tile(np.eye(4), (2, 1, 1)))
    markers = np.tile(np.asarray(model.tool.markers), (2, 1, 1))
    state = replace(state, markers=markers, compliance=np.zeros(len(model.compliances)))
    positions = replace(positions, mounting=one, payload=one, station=np.zeros(len(positions)))
    parameters = parameters_of(model, positions)
    rows = predicted(model, positions, parameters, state).rows
    unknowns = unknown_columns(model, LIMITS)
    arm = ElasticArm(
        model.robot, unknowns.springs, model.tool, model.gravity, model.payloads[0], weighs=True
    )
    cases = LoadCases(positions.cases.q, positions.cases.wrench)
    found = unknowns.columns(regressor(arm, cases)).reshape(len(cases), -1, 3, len(unknowns))
    given = len(unknowns) - len(model.compliances)
    names = [name.replace(" of near", "").replace(" of first", "") for name in parameters.names]
    for u, name in enumerate(unknowns.names):
        own = rows[..., names.index(name)].reshape(len(cases), -1, 3)
        places = ~positions.rotations.reshape(len(cases), -1)[0]
        size = 1.0 + np.abs(own).max()
        share = unknowns.springs.by[unknowns.springs.names.index(name)] if u < given else None
        if share is not None:
            found[..., u] *= share.largest
        assert np.abs(found[..., u][:, places] - own[:, places]).max() < 1e-10 * size, name


@pytest.mark.parametrize("seed", range(4))
def test_gradients_of_columns_are_differences(seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = random_model(rng, [bool(s) for s in rng.random(4) < 0.3])
    unknowns = unknown_columns(model, LIMITS)
    tool = replace(model.tool, rotation=False)
    arm = ElasticArm(
        model.robot, unknowns.springs, tool, model.gravity, model.payloads[0], weighs=True
    )
    n = len(model.robot.joints)
    space = LoadCaseSpace(
        arm,
        ThereOrNot(rng.normal(size=3)),
        FixedVector(np.zeros(3)),
        [],
        Isotropic(1.0),
        np.array([np.full(n, -3.0), np.full(n, 3.0)]),
        unknowns,
    )
    assert space.lower[-1] == 0.0
    x = space.sample(5, rng)
    x[:, -1] = rng.uniform(0.1, 0.9, 5)  # as searches that stir may have it
    wrench = space.load_cases(x).wrench
    assert np.array_equal(wrench[:, :3], np.where(x[:, -1:] > 0.5, space.force.value, 0.0))
    here = LoadCaseEvaluation(space, x)
    bar = rng.normal(size=here.blocks.shape)
    gradient = here.pull(bar, np.zeros((5, 0)))
    assert not gradient[:, n].any()  # whether the load is there is not moved
    for j in range(n):
        step = np.zeros(n + 1)
        step[j] = 1e-6
        ends = [
            (LoadCaseEvaluation(space, x + way * step).blocks * bar).sum((1, 2)) for way in (1, -1)
        ]
        assert gradient[:, j] == pytest.approx((ends[0] - ends[1]) / 2e-6, rel=2e-6, abs=2e-6)
