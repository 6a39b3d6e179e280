"""Robots drawn by chance: sizes as their priors, no spring that pushes, what is given stays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.deflections import loaded_deflection
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.tensors import against_the_load
from elastocal.elastic.true_loads import TrueLoads
from elastocal.measuring.instrument import Isotropic
from elastocal.simulation.true_robot import sizes, true_robot
from elastocal.simulation.virtual_campaign import Reality, simulate
from elastocal.study.study import Study
from tests.kr270 import FOLDER, kr270_truth, published_cases

TEXT = (FOLDER / "study.yaml").read_text("utf-8") + "nuisance: typical\n"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    path = tmp_path_factory.mktemp("true") / "study.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return ec.read_study(path)


def test_sizes_are_the_root_mean_squares_of_the_priors(study: Study) -> None:
    nuisance = study.nuisance
    assert nuisance is not None
    shifted = replace(nuisance, mean=0.8 * nuisance.deviation, deviation=0.6 * nuisance.deviation)
    for told in (nuisance, shifted):
        drawn = np.array([sizes(told, np.random.default_rng(i)) for i in range(1500)])
        usual = np.sqrt(np.mean(drawn**2, axis=0)) / nuisance.deviation
        np.testing.assert_allclose(usual[~nuisance.signed], 1.0, atol=0.09)
        assert (drawn[:, ~nuisance.signed] >= 0.0).all()
        assert 0.4 < usual[nuisance.signed].min() <= usual[nuisance.signed].max() < 0.55


def test_no_direction_pushes(study: Study) -> None:
    truth = kr270_truth(study)
    for seed in range(30):
        true = true_robot(study, truth, np.random.default_rng(seed))
        assert true.drawn
        assert against_the_load(true.model.springs, true.model.compliance) == ()
        np.testing.assert_allclose(true.model.of(truth.names), truth.compliance)


def test_what_is_given_is_not_drawn_again(study: Study) -> None:
    first = true_robot(study, kr270_truth(study), np.random.default_rng(0))
    again = true_robot(study, first.model, np.random.default_rng(1), first.loads)
    assert not again.drawn
    assert again.model is first.model
    assert again.loads is first.loads
    plain = true_robot(ec.with_nuisance(study, None), first.model, np.random.default_rng(1))
    assert plain.loads is None
    assert not plain.drawn


def test_the_process_force_is_as_wrong_as_its_cell(study: Study) -> None:
    assert study.nuisance is not None
    gains = {}
    for cell in ("same", "exact", "other"):
        errors = replace(study.nuisance.errors, common_tilt=0.01, process_force=cell)
        told = ec.with_nuisance(study, replace(study.nuisance, errors=errors))
        true = true_robot(told, kr270_truth(study), np.random.default_rng(3))
        assert true.loads is not None
        gains[cell] = true.process_gain / true.loads.gain
        assert true.loads.turn.all()
    assert gains["same"] == 1.0
    assert gains["exact"] == 0.0
    assert gains["other"] not in (0.0, 1.0)


def readings(study: Study, errors: CaseErrors, loads: TrueLoads | None = None) -> np.ndarray:
    """(3, 4, 3) readings of three load cases, four times each, by a perfect instrument [m]."""
    exact = replace(study, instrument=Isotropic(1e-15))
    made = simulate(
        exact,
        kr270_truth(study),
        published_cases(3),
        np.full(3, 4),
        np.random.default_rng(5),
        reality=Reality(loads=loads, errors=errors),
    )
    return made.deflection.reshape(3, 4, 3)


@pytest.mark.parametrize("name", ["friction", "discrepancy", "discrepancy_length"])
def test_repeats_share_what_their_load_case_has(study: Study, name: str) -> None:
    plain = readings(study, CaseErrors())
    off = readings(study, CaseErrors(**{name: 1e-4 if "length" in name else 0.08})) - plain
    assert np.abs(off - off[:, :1]).max() < 1e-12
    assert (np.linalg.norm(off[:, 0], axis=1) > 1e-6).all()


@pytest.mark.parametrize("name", ["gain", "tilt", "repeatability"])
def test_each_experiment_has_its_own(study: Study, name: str) -> None:
    plain = readings(study, CaseErrors())
    off = readings(study, CaseErrors(**{name: 1e-4 if name == "repeatability" else 0.01})) - plain
    assert (np.linalg.norm(off[:, 1:] - off[:, :1], axis=2) > 1e-6).all()


def test_all_loads_are_wrong_together_at_the_equilibrium(study: Study) -> None:
    truth, cases = kr270_truth(study), published_cases(3)
    arm = replace(study.arm, springs=truth.springs)
    found = readings(study, CaseErrors(), TrueLoads(gain=0.02, turn=np.array([0.0, 0.01, 0.0])))
    turned = 1.02 * cases.wrench
    c, s = np.cos(0.01), np.sin(0.01)
    turned[:, [0, 2]] = turned[:, [0, 2]] @ np.array([[c, -s], [s, c]])
    expected = loaded_deflection(arm, truth.compliance, LoadCases(cases.q, turned))
    np.testing.assert_allclose(found[:, 0], expected, atol=1e-12)


def test_friction_is_of_the_joints_alone_and_as_large_as_is_said(study: Study) -> None:
    """Over many load cases the deflection of a joint is off by the share that is said."""
    truth = kr270_truth(study)
    cases = LoadCases(np.repeat(published_cases(3).q[:1], 400, axis=0), np.zeros((400, 6)))
    wrench = np.tile(published_cases(3).wrench[:1], (400, 1))
    wrench[:, 2] -= 1e-3 * np.arange(400)  # each a load case of its own
    only = replace(truth, compliance=truth.compliance * (np.arange(6) == 1))
    made = simulate(
        replace(study, instrument=Isotropic(1e-15)),
        only,
        LoadCases(cases.q, wrench),
        np.ones(400, dtype=int),
        np.random.default_rng(0),
        reality=Reality(errors=CaseErrors(friction=0.08)),
    )
    size = np.linalg.norm(made.deflection, axis=1)
    assert size.std() / size.mean() == pytest.approx(0.08, rel=0.1)
