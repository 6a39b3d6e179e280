"""Replanning: the rest of a campaign that was broken off."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import elastocal as ec
from elastocal.cli import app
from elastocal.constraints import Distinct
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.files.measurements.measurement_file import write_measurements
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.planning.assessment import assess
from elastocal.planning.remaining import done, remaining
from elastocal.study.study import Study
from tests.campaigns import hung, measured
from tests.test_examples import ROOT

LIGHT = ec.Effort(batch=32, generations=3, patience=1, islands=1)


@pytest.fixture(scope="module")
def study() -> Study:
    return ec.read_study(ROOT / "examples" / "kr270" / "study.yaml")


@pytest.fixture(scope="module")
def campaign(study: Study) -> ec.Plan:
    wide = replace(study, experiments=replace(study.experiments, max_configurations=None))
    return ec.plan(wide, seed=0, effort=LIGHT)


def broken_off(study: Study, campaign: ec.Plan, count: int) -> ec.Measurements:
    """The first experiments of a campaign."""
    every = np.repeat(np.arange(len(campaign.repeats)), campaign.repeats)[:count]
    cases = LoadCases(campaign.load_cases.q[every], campaign.load_cases.wrench[every])
    return measured(study.arm, cases, rng=np.random.default_rng(1))


def test_what_was_measured_is_known(study: Study, campaign: ec.Plan) -> None:
    data = broken_off(study, campaign, 5)
    before = done(study, data)
    rest = remaining(study, before)
    assert rest.experiments.count == 7
    fit = identify(study.arm, broken_off(study, campaign, 12), Fit(model="linear"))
    whole = done(study, fit.measurements)
    np.testing.assert_allclose(np.linalg.inv(whole.information), fit.model.covariance, rtol=1e-6)


def test_the_rest_is_nearly_as_good_as_the_whole(study: Study, campaign: ec.Plan) -> None:
    """Five of twelve done: with the best seven more, nearly the accuracy of the best twelve."""
    before = done(study, broken_off(study, campaign, 5))
    rest = ec.plan(remaining(study, before), seed=0, effort=LIGHT)
    assert rest.count == 7
    assert rest.assessment.rho0 < 1.03 * campaign.assessment.rho0
    assert rest.certificate.efficiency > 0.97
    together = assess(
        study,
        LoadCases(
            np.concatenate([before.cases.q, rest.load_cases.q]),
            np.concatenate([before.cases.wrench, rest.load_cases.wrench]),
        ),
        np.append(_counts(study, campaign, before), rest.repeats),
    )
    assert together.rho0 == pytest.approx(rest.assessment.rho0, rel=1e-9)


def _counts(study: Study, campaign: ec.Plan, before: ec.Done) -> np.ndarray:
    q = broken_off(study, campaign, 5).cases.q
    return np.array([int(np.isclose(q, one).all(axis=1).sum()) for one in before.cases.q])


def test_measured_configurations_are_not_asked_for_again(study: Study, campaign: ec.Plan) -> None:
    """Not even with the first joint, which changes nothing, turned elsewhere."""
    before = done(study, broken_off(study, campaign, 5))
    rest = ec.plan(remaining(study, before), seed=0, effort=LIGHT)
    matter = np.array([0, 1, 1, 1, 1, 1.0])
    difference = rest.load_cases.q[:, None] - before.cases.q
    difference -= 2.0 * np.pi * np.round(difference / (2.0 * np.pi))
    apart = np.linalg.norm(difference * matter, axis=2)
    assert apart.min() >= np.radians(0.999)
    assert not rest.assessment.violations


def test_where_a_campaign_has_been_there_is_no_room(study: Study) -> None:
    """Without planning: the constraints of the rest, at a configuration that was measured."""
    cases = hung(3, seed=3)
    rest = remaining(study, done(study, measured(study.arm, cases)))
    apart = [c for c in rest.constraints if isinstance(c, Distinct)]
    assert len(apart) == 3
    turns = np.zeros((5, 6))
    turns[1, 0], turns[2, 2], turns[3, 2], turns[4, 5] = 40.0, 1.5, -0.4, 360.0 - 2.0
    room = apart[1].margin(study.robot, cases.q[1] + np.radians(turns))
    np.testing.assert_allclose(np.degrees(room), [-1.0, -1.0, 0.5, -0.6, 1.0], atol=1e-9)


def test_configurations_that_differ_by_rounding_are_one(study: Study) -> None:
    """A controller shows the same place with other last digits."""
    cases = hung(2, seed=3)
    noise = 1e-11 * np.random.default_rng(0).normal(size=(4, 6))
    again = LoadCases(np.round(np.tile(cases.q, (2, 1)), 6) + noise, np.tile(cases.wrench, (2, 1)))
    before = done(study, measured(study.arm, again))
    assert before.experiments == 4
    np.testing.assert_allclose(before.cases.q, again.q[:2], atol=1e-9)


@pytest.mark.parametrize(
    ("most", "before", "left"), [(3, 5, 3), (3, 10, 2), (3, 11, 1), (None, 5, None)]
)
def test_the_rest_has_as_many_configurations_as_allowed(
    study: Study, most: int | None, before: int, left: int | None
) -> None:
    allowed = replace(study, experiments=replace(study.experiments, max_configurations=most))
    rest = remaining(allowed, done(allowed, measured(study.arm, hung(before, seed=3))))
    assert rest.experiments.count == 12 - before
    assert rest.experiments.max_configurations == left


def test_a_campaign_that_is_done_has_no_rest(study: Study, campaign: ec.Plan) -> None:
    with pytest.raises(InputError, match="has 12 experiments, and 12 are wanted in all"):
        remaining(study, done(study, broken_off(study, campaign, 12)))


def test_the_command_plans_judges_and_reports_the_rest(
    study: Study, campaign: ec.Plan, tmp_path: Path
) -> None:
    path = tmp_path / "study.yaml"
    path.write_text(study.text, encoding="utf-8")
    data = tmp_path / "first.csv"
    write_measurements(broken_off(study, campaign, 5), study.robot, data)
    out = tmp_path / "rest.json"
    run = CliRunner().invoke
    made = run(app, ["plan", str(path), "--after", str(data), "-o", str(out)])
    assert made.exit_code == 0, made.output
    assert "5 experiments of" in made.output
    judged = run(app, ["evaluate", str(path), str(out), "--random", "0"])
    assert judged.exit_code == 0, judged.output
    assert "counts the information of 5 experiments" in judged.output
    assert "that is not checked" not in judged.output
    document = json.loads(out.read_text("utf-8"))
    rows = np.array(document["after"]["information_N2m2"])
    document["after"]["information_N2m2"] = (100.0 * rows).tolist()
    better = tmp_path / "better.json"
    better.write_text(json.dumps(document), encoding="utf-8")
    caught = run(app, ["evaluate", str(path), str(better), "--random", "0"])
    assert caught.exit_code == 2
    assert "information_N2m2 is not what" in " ".join(caught.output.split())
    data.rename(tmp_path / "elsewhere.csv")
    trusted = run(app, ["evaluate", str(path), str(out), "--random", "0"])
    assert "that is not checked" in " ".join(trusted.output.split())
    (tmp_path / "elsewhere.csv").rename(data)
    page = tmp_path / "rest.html"
    shown = run(app, ["report", str(out), "--quick", "-o", str(page)])
    assert shown.exit_code == 0, shown.output
    text = out.read_text("utf-8")
    more = ["plan", str(path), "--after", str(data), "-o", str(out)]
    few = run(app, [*more, "--count", "5"])
    assert few.exit_code == 2
    assert "and 5 are wanted in all; ask for more than 5 with --count" in " ".join(
        few.output.split()
    )
    two = run(app, [*more, "--count", "7", "--json"])
    assert json.loads(two.stdout)["experiments"] == 2
    out.write_text(text.replace('"information_N2m2": [', '"information_N2m2": [[1],'), "utf-8")
    spoilt = run(app, ["evaluate", str(path), str(out)])
    assert spoilt.exit_code == 2
    assert "after: information_N2m2 must be as many rows as columns" in spoilt.output
