"""A study that knows what moves readings and tools besides."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.elastic.compliance_model import rows_of
from elastocal.elastic.effects import effects_of
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.springs import VirtualJoints
from elastocal.elastic.typical import typical_sizes
from elastocal.elastic.unknowns import Unknowns, each_spring, joined
from elastocal.errors import InputError
from elastocal.files.study.study_file import read_study
from elastocal.robot.sources import USUAL
from elastocal.study.before import Earlier
from elastocal.study.criteria import CRITERIA
from elastocal.study.experiment_space import LoadCaseEvaluation
from elastocal.study.known import Known
from elastocal.study.study import Study, TestPose
from elastocal.study.test_path import test_path
from elastocal.study.two_steps import with_known, with_nuisance
from tests.kr270 import FOLDER, kr270_study, published_cases

REPEATS = np.array([2, 7, 3])


def foot_and_forearm() -> Nuisance:
    """A foot that turns alike about x and y; a forearm that bends by a tensor, given by hand."""
    z45 = np.sqrt(0.5)
    springs = VirtualJoints(
        ("x", "y", "0", "45", "90"),
        np.array([0, 0, 3, 3, 3]),
        np.array([[1, 0, 0], [0, 1, 0], [1, 0, 0], [z45, z45, 0], [0, 1, 0]], dtype=float),
        np.zeros((5, 3)),
        np.zeros(5, dtype=bool),
    )
    make = np.zeros((5, 4))
    make[:2, 0] = make[2, 1] = make[4, 2] = 1.0
    make[[2, 3, 4], 3] = [-1.0, 2.0, -1.0]
    return Nuisance(
        Unknowns(("foot", "n1", "n2", "n12"), springs, make),
        np.zeros(4),
        1e-7 * np.array([1.0, 3.0, 3.0, 3.0 / np.sqrt(2.0)]),
        np.array([False, False, False, True]),
        ("by hand",) * 4,
        np.ones(6),
    )


def by_hand(study: Study, nuisance: Nuisance) -> float:
    """rho0 from regressors of single springs, by numpy."""
    (pose,) = study.test_poses
    assert pose.case is not None
    assert pose.tool is not None
    scale = 1e-7
    unknowns = nuisance.unknowns
    arms = [replace(study.arm, springs=s) for s in (study.springs, unknowns.springs)]
    makes = [np.eye(5), unknowns.make]
    tool = pose.tool.at_tcp
    rows, rows0 = (
        np.concatenate(
            [ec.regressor(replace(a, tool=t), cases) @ m for a, m in zip(arms, makes, strict=True)],
            axis=2,
        )
        * scale
        for t, cases in ((study.arm.tool, published_cases(3)), (tool, pose.case))
    )
    information = np.einsum("n,nri,nrj->ij", REPEATS / study.sigma**2, rows, rows)
    information[5:, 5:] += np.diag((nuisance.deviation / scale) ** -2)
    a0 = rows0[0]
    return float(np.sqrt(np.trace(a0 @ np.linalg.inv(information) @ a0.T)))


def test_rho0_counts_what_springs_besides_leave() -> None:
    plain, nuisance = kr270_study(), foot_and_forearm()
    study = with_nuisance(plain, nuisance)
    assert study.fitted.names == (*plain.springs.names, *nuisance.names)
    assert study.wanted == [0, 1, 2, 3, 4]
    worth = ec.assess(study, published_cases(3), REPEATS)
    assert worth.rho0 == pytest.approx(by_hand(plain, nuisance), rel=1e-8)
    assert len(worth.standard_error) == 5
    assert worth.covariance.shape == (9, 9)
    without = ec.assess(plain, published_cases(3), REPEATS)
    assert worth.rho0 > 2.0 * without.rho0
    assert with_nuisance(plain, None) is plain
    again = ec.assess(with_nuisance(study, None), published_cases(3), REPEATS)
    assert again.rho0 == without.rho0


def test_a_path_of_one_point_is_a_pose() -> None:
    study = kr270_study()
    (pose,) = study.test_poses
    assert pose.cases is not None
    assert pose.tool is not None
    path = test_path(replace(study.arm, tool=pose.tool), pose.cases, 1.0, "path")
    seen = [
        ec.assess(with_nuisance(s, foot_and_forearm()), published_cases(3), REPEATS).rho0
        for s in (study, replace(study, test_poses=(path,)))
    ]
    assert seen[1] == pytest.approx(seen[0], rel=1e-9)


def test_with_what_an_earlier_campaign_knows_in_either_order() -> None:
    study, nuisance = kr270_study(), foot_and_forearm()
    a1 = ec.joint_springs(study.robot, ["A1"])
    known = Known(ec.ComplianceModel(a1, np.zeros(1), np.array([[1e-16]])), planned=True)
    one = with_nuisance(with_known(study, known), nuisance)
    other = with_known(with_nuisance(study, nuisance), known)
    assert one.fitted.names == other.fitted.names == ("A1", *study.springs.names, *nuisance.names)
    np.testing.assert_array_equal(one.prior, other.prior)
    np.testing.assert_array_equal(one.test_poses[0].regressor, other.test_poses[0].regressor)


def test_a_mixed_fit_before_is_the_prior_of_both() -> None:
    """What a fit of the joints and of the nuisance says of them together is information at once."""
    study, nuisance = kr270_study(), foot_and_forearm()
    unknowns = joined(each_spring(study.springs), nuisance.unknowns)
    root = 1e-7 * (np.eye(9) + 0.3 * np.random.default_rng(1).normal(size=(9, 9)))
    whole = root @ root.T
    covariance = unknowns.make @ whole @ unknowns.make.T
    model = ec.ComplianceModel(unknowns.springs, np.zeros(10), covariance)
    rows = rows_of(model, study.springs.names, study.springs.names)
    after = replace(study, prior=rows.T @ rows, earlier=Earlier(model))
    found = with_nuisance(after, nuisance)
    np.testing.assert_allclose(1e-14 * found.prior, np.linalg.inv(1e14 * whole), rtol=1e-7)
    again = with_nuisance(found, replace(nuisance, mean=np.ones(4)))
    np.testing.assert_allclose(again.prior, found.prior, rtol=1e-9)
    np.testing.assert_allclose(with_nuisance(found, None).prior, after.prior, rtol=1e-9)


def test_a_matrix_has_no_columns_for_it() -> None:
    study = replace(kr270_study(), test_poses=(TestPose("matrix", np.ones((3, 5))),))
    with pytest.raises(InputError, match="matrix of 5 columns"):
        with_nuisance(study, foot_and_forearm())


def test_a_name_that_is_taken() -> None:
    study, nuisance = kr270_study(), foot_and_forearm()
    unknowns = replace(nuisance.unknowns, names=("A2", "n1", "n2", "n12"))
    with pytest.raises(InputError, match="'A2' is the name of something that is nuisance"):
        with_nuisance(study, replace(nuisance, unknowns=unknowns))


def test_criteria_of_compliances_look_at_those_to_identify() -> None:
    """What is known nearly exactly changes none of them; what is not makes all worse."""
    plain, nuisance = kr270_study(), foot_and_forearm()
    exact = replace(nuisance, deviation=1e-6 * nuisance.deviation)
    base, same, worse = (
        ec.assess(study, published_cases(3), REPEATS).criteria
        for study in (plain, with_nuisance(plain, exact), with_nuisance(plain, nuisance))
    )
    assert same == pytest.approx(base, rel=1e-4)
    for name, value in worse.items():
        better = CRITERIA[name].larger_is_better
        assert value < 0.99 * base[name] if better else value > 1.01 * base[name], name


@pytest.mark.parametrize("angle", [0.3, 1.2])
def test_rho0_does_not_depend_on_the_axes_of_a_tensor(angle: float) -> None:
    nuisance, s = foot_and_forearm(), np.sin(angle)
    springs = nuisance.unknowns.springs
    turn = np.array([[np.cos(angle), s, 0], [-s, np.cos(angle), 0], [0, 0, 1]])
    turned = replace(nuisance.unknowns, springs=replace(springs, axis=springs.axis @ turn))
    one, other = (
        ec.assess(with_nuisance(kr270_study(), n), published_cases(3), REPEATS).rho0
        for n in (nuisance, replace(nuisance, unknowns=turned))
    )
    assert other == pytest.approx(one, rel=1e-8)


def test_the_core_makes_the_same_rows_of_the_preset() -> None:
    study = read_study(FOLDER / "study.yaml")
    sizes = typical_sizes(study.robot, np.array(USUAL["kuka-kr270"]))
    effects = effects_of(study.robot, sizes)
    u = len(effects.deviation)
    told = Nuisance(
        effects.unknowns, np.zeros(u), effects.deviation, effects.signed, effects.source, np.ones(6)
    )
    space = with_nuisance(study, told).space
    x = space.sample(37, np.random.default_rng(0))
    expected = LoadCaseEvaluation(space, x, None)
    bars = (
        np.random.default_rng(1).normal(size=expected.blocks.shape) / np.abs(expected.blocks).max()
    )
    found, none = space.evaluate(x), np.zeros_like(expected.margins)
    size = np.abs(expected.blocks).max()
    np.testing.assert_allclose(found.blocks, expected.blocks, rtol=0, atol=1e-12 * size)
    pulled = expected.pull(bars, none)
    atol = 1e-11 * np.abs(pulled).max()
    np.testing.assert_allclose(found.pull(bars, none), pulled, rtol=0, atol=atol)
