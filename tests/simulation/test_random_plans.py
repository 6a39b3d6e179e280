"""Random plans beside others in virtual campaigns: drawn, judged and shown as they are."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from elastocal import Contents, html
from elastocal.arrays import Array
from elastocal.errors import IdentifiabilityError
from elastocal.identification.fit import Fit
from elastocal.planning.trade_off import random_plans
from elastocal.report.charts.histograms import histogram_chart
from elastocal.report.sections.monte_carlo import campaigns_picture
from elastocal.simulation.campaigns import MonteCarlo
from elastocal.simulation.monte_carlo import campaigns
from elastocal.simulation.prediction import predicted_total
from elastocal.simulation.virtual_campaign import Reality
from elastocal.study.experiment_space import LoadCaseSpace
from elastocal.study.study import with_count
from tests.cli.test_commands import run
from tests.kr270 import FOLDER, kr270_study, kr270_truth, published_plans

STUDY = kr270_study()
TRUTH = kr270_truth(STUDY)
PLANS = {"two": published_plans()["2 configurations"]}
LINEAR = {"how": Fit(model="linear"), "reality": Reality(linear=True)}


@cache
def found(number: int = 100, random: int = 40) -> MonteCarlo:
    return campaigns(STUDY, TRUTH, PLANS, number, seed=2, random=random, **LINEAR)  # type: ignore[arg-type]


def test_together_they_have_as_many_campaigns_as_a_plan() -> None:
    random = found().random
    assert random is not None
    assert random.name == "40 random plans"
    assert (random.experiments, random.drawn, random.total.shape) == (12, 40, (40, 3))
    few = found(10, 20).random
    assert few is not None
    assert few.total.shape == (20, 2)


def test_they_are_worth_what_random_plans_are() -> None:
    random = found(200, 200).random
    assert random is not None
    others = random_plans(with_count(STUDY, 12), 2000, seed=3)
    for share in (0.1, 0.5, 0.9):
        here, there = (np.quantile(rho0, share) for rho0 in (random.rho0_each, others))
        assert here == pytest.approx(there, rel=0.1)
    assert random.rms == pytest.approx(random.rho0, rel=0.1)  # 400 campaigns
    assert random.rho0 == pytest.approx(np.sqrt(np.mean(random.rho0_each**2)))
    assert len(np.unique(random.rho0_each)) == 200


def test_each_has_campaigns_of_its_own_noise() -> None:
    """Errors over predicted ones of two plans have nothing to do with each other."""
    random = found(3000, 60).random
    assert random is not None
    relative = random.total / random.rho0_each[:, None]
    together = np.corrcoef(relative)[np.triu_indices(60, 1)]
    assert abs(together.mean()) < 0.02  # 1770 pairs of 50 campaigns: 0.0034 by chance


def test_nothing_else_changes() -> None:
    alone = campaigns(STUDY, TRUTH, PLANS, 100, seed=2, **LINEAR)  # type: ignore[arg-type]
    assert alone.random is None
    np.testing.assert_array_equal(alone.plans[0].total, found().plans[0].total)
    again = campaigns(STUDY, TRUTH, PLANS, 100, seed=2, random=40, **LINEAR).random  # type: ignore[arg-type]
    assert again is not None
    assert found().random is not None
    np.testing.assert_array_equal(again.total, found().random.total)  # type: ignore[union-attr]


def test_those_that_identify_nothing_are_left_out_and_counted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two configurations to draw from: half of the plans of two have one of them twice."""
    cases, _ = PLANS["two"]

    def sample(space: LoadCaseSpace, count: int, rng: np.random.Generator) -> Array:
        return space.points(cases)[rng.integers(0, kinds, count)]

    monkeypatch.setattr(LoadCaseSpace, "sample", sample)
    once = {"once": (cases, np.ones(2, dtype=int))}
    kinds = 2
    random = campaigns(STUDY, TRUTH, once, 20, random=30, **LINEAR).random  # type: ignore[arg-type]
    assert random is not None
    assert random.drawn == 30
    assert 5 < len(random.total) < 25
    whole = campaigns(STUDY, TRUTH, once, 20, **LINEAR).plans[0]  # type: ignore[arg-type]
    np.testing.assert_allclose(random.rho0_each, whole.rho0, rtol=1e-9)
    kinds = 1
    with pytest.raises(IdentifiabilityError, match="none of 3 random plans of 2 experiments"):
        campaigns(STUDY, TRUTH, once, 20, random=3, **LINEAR)  # type: ignore[arg-type]


def test_the_page_shows_them() -> None:
    page = html(Contents(monte_carlo=found()))
    assert page.count("40 random plans") >= 3  # two charts and the table
    assert "3 campaigns of each.</" in page
    some = replace(found().random, drawn=44)  # type: ignore[type-var]
    assert "4 more did not tell the compliances apart" in html(
        Contents(monte_carlo=replace(found(), random=some))
    )
    without = html(Contents(monte_carlo=replace(found(), random=None)))
    assert "random" not in without.split('id="monte-carlo"')[1].split("</section>")[0].replace(
        'class="random"', ""
    )


@pytest.mark.parametrize("width", [860.0, 350.0])
def test_a_histogram_counts_every_campaign(width: float) -> None:
    """Heights of bars over the highest of them are shares of all 120 campaigns."""
    random, plan = found().random, found().plans[0]
    assert random is not None
    chart = str(histogram_chart([plan], [predicted_total(plan)], width, random))
    signs, lanes = 1, 1
    assert chart.count('class="curve density"') == signs + lanes  # none for the random plans
    bars = re.findall(r'<rect x="[^"]*" y="([^"]*)" width="[^"]*" height="([^"]*)"', chart)
    tops, heights = np.array(bars[signs:], float).T
    last = np.isclose(tops + heights, (tops + heights).max(), atol=0.05)
    counts = heights[last] / heights[last].min()
    assert counts == pytest.approx(counts.round(), abs=0.05)
    assert counts.round().sum() == 120  # the smallest bar is one campaign


def test_a_picture_stands_alone() -> None:
    picture = campaigns_picture(found())
    assert picture.startswith('<svg xmlns="http://www.w3.org/2000/svg" viewBox="-10 -10 ')
    assert "var(--" not in picture
    assert "http" not in picture.replace("http://www.w3.org/2000/svg", "")
    assert picture.count("<svg") == picture.count("</svg>") == 1


def test_by_command(tmp_path: Path) -> None:
    plan, truth = FOLDER / "published" / "m3-times-4.csv", FOLDER / "truth.json"
    ask = ("simulate", FOLDER / "study.yaml", plan, "--truth", truth)
    out, picture = tmp_path / "c.json", tmp_path / "errors.svg"
    many = ("--campaigns", 40, "--random", 10, "--picture", picture, "-o", out)
    done = run(*ask, *many)
    assert done.exit_code == 0, done.stderr
    said = " ".join(done.stdout.split())
    assert "10 random plans: random configurations that the study allows, 4 campaigns" in said
    assert f"{picture.name}" in said
    assert "10 random plans" in picture.read_text("utf-8")
    for words, message in (
        (("--random", 5, "-o", tmp_path / "m.csv"), "--random and --picture need --campaigns"),
        (("--picture", picture, "-o", tmp_path / "m.csv"), "--random and --picture need"),
        (("--campaigns", 5, "--picture", tmp_path / "e.png", "-o", out), "ends in .svg"),
        (("--campaigns", 5, "--picture", tmp_path / "no" / "e.svg", "-o", out), "does not exist"),
    ):
        refused = run(*ask, *words)
        assert refused.exit_code == 2
        assert message in refused.stderr
