"""Plans for absolute readings of which no compliance rests on one configuration."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elastocal.design.exact import ExactDesign
from elastocal.elastic.load_cases import LoadCases
from elastocal.files.study.study_file import read_study
from elastocal.planning.aim import accuracy
from elastocal.planning.assessment import assess
from elastocal.planning.near import near_configurations
from elastocal.planning.plain_values import Plain
from elastocal.planning.relieved import relieved, rests_on_one
from elastocal.planning.resting import RESTS, resting
from elastocal.study.study import Study
from elastocal.wording import worded
from tests.calibration.test_absolute_plan import STUDY

MANY = 14


@pytest.fixture
def study(tmp_path: Path) -> Study:
    path = tmp_path / "study.yaml"
    path.write_text(STUDY, encoding="utf-8")
    return read_study(path)


def loaded_once(study: Study) -> LoadCases:
    """Poses of which one, the third, has the weight."""
    x = study.space.sample(MANY, np.random.default_rng(5))
    x[:, -1] = 0.0
    x[2, -1] = 1.0
    return study.space.load_cases(x)


def test_standard_errors_without_a_configuration_are_those_of_the_plan_without_it(
    study: Study,
) -> None:
    cases, repeats = loaded_once(study), np.ones(MANY, dtype=np.int64)
    repeats[4] = 2
    found = resting(study, cases, repeats)
    assert found is not None
    names, soft = study.springs.names, ~study.springs.stiff
    before = assess(study, cases, repeats).standard_error
    group = near_configurations(study.robot, cases.q)
    worst: dict[int, np.ndarray] = {}
    for g in range(group.max() + 1):
        stay = group != g
        left = assess(study, cases.chosen(stay), repeats[stay]).standard_error
        worst[int(np.flatnonzero(~stay)[0]) + 1] = left / before
    most = max(worst, key=lambda case: float(worst[case][soft].max()))
    assert found.load_case == most
    large = {n: t for n, t, s in zip(names, worst[most], soft, strict=True) if s and t > RESTS}
    assert found.times == pytest.approx(large, rel=1e-3)


def test_what_rests_on_one_configuration_is_said_with_what_one_more_is_worth(study: Study) -> None:
    cases, repeats = loaded_once(study), np.ones(MANY, dtype=np.int64)
    (doubt,) = rests_on_one(study, cases, repeats)
    said = worded(doubt)
    assert "on configuration 3: without it" in said
    assert "with one more experiment" in said
    assert "min more at the cell" in said
    assert doubt.numbers["more_rho0"] < doubt.numbers["rho0"]
    assert doubt.numbers["more"] < max(doubt.numbers[name] for name in doubt.about)


def test_other_configurations_are_found_of_which_none_carries_a_compliance(study: Study) -> None:
    aim, cases = accuracy(study), loaded_once(study)
    design = ExactDesign(aim.space.points(cases), np.ones(MANY, dtype=np.int64), 0.0)
    plain, rng = Plain(cases, (), ""), np.random.default_rng(0)
    made = relieved(study, aim, aim.space, aim.goal(), design, plain, rng)
    assert made is not None
    better, after = made
    assert better.counts.sum() == MANY
    assert resting(study, after.cases, better.counts) is None
    before = assess(study, cases, design.counts)
    assert assess(study, after.cases, better.counts).rho0 < 1.05 * before.rho0
    assert not assess(study, after.cases, better.counts).violations
    # Where none rests on one, nothing is done.
    design = ExactDesign(better.x, better.counts, 0.0)
    assert relieved(study, aim, aim.space, aim.goal(), design, after, rng) is None
