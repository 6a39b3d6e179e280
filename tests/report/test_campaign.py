"""The report of a campaign: every stage that exists, what is weak, safe whatever it is named."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser

import numpy as np
import pytest

from elastocal import report
from elastocal.compensation.compensate import compensate
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt, InputError
from elastocal.identification.doubts import doubts
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.validation import leave_one_out, summary, validate
from elastocal.measuring.measurements import chosen
from elastocal.report.charts.axes import shortened
from elastocal.report.charts.correlation import _colour
from elastocal.report.charts.strips import Strips
from elastocal.report.contents import Contents
from elastocal.report.intervals import decimals_of
from elastocal.simulation.virtual_campaign import Outliers, Reality, simulate
from elastocal.study.at_test_poses import at_test_poses
from elastocal.wording import worded
from elastocal.wording.numbers import length
from elastocal.wording.stiffness import ranged
from tests.report.examples import (
    HOSTILE,
    PLANS,
    campaign_page,
    compensated,
    identified,
    judged,
    measured,
    simulated,
    three_link_plan,
    truth_of,
    validated,
    visible,
    without_plotly,
)

STAGES = (
    "identification",
    "residuals",
    "influence",
    "correlation",
    "validation",
    "path",
    "remaining",
    "corrections",
    "monte-carlo",
    "coverage",
)


@cache
def page_of(name: str) -> str:
    return without_plotly(campaign_page(name))


def ids(page: str) -> list[str]:
    return re.findall(r'<(?:section|header)[^>]* id="([\w-]+)"', page)


@pytest.mark.parametrize("name", PLANS)
class TestEveryRobot:
    def test_stages_come_in_the_order_of_the_work(self, name: str) -> None:
        found = ids(page_of(name))
        assert found[:2] == ["state", "verdict"]
        assert tuple(found[-11:]) == (*STAGES, "provenance")
        assert found.index("run-sheet") < found.index("identification")

    def test_links_lead_somewhere(self, name: str) -> None:
        page = page_of(name)
        targets = set(re.findall(r'href="#([\w-]+)"', page))
        assert {*STAGES, "verdict", "provenance"} <= targets
        assert targets <= set(re.findall(r' id="([\w-]+)"', page))

    def test_nothing_is_fetched(self, name: str) -> None:
        page = page_of(name)
        assert not re.findall(r"""(?:src|href)\s*=\s*["']?\s*(?:https?:|//)""", page)
        assert not re.findall(r"@import|url\((?!#)", page)

    def test_elements_are_closed(self, name: str) -> None:
        open_elements: list[str] = []

        class Checker(HTMLParser):
            def handle_starttag(self, tag: str, attrs: object) -> None:
                if tag not in {"meta", "link", "input", "img"}:
                    open_elements.append(tag)

            def handle_endtag(self, tag: str) -> None:
                assert open_elements.pop() == tag

        Checker().feed(page_of(name))
        assert open_elements == []

    def test_every_scene_has_its_data(self, name: str) -> None:
        page = page_of(name)
        wanted = re.findall(r'data-scene="([\w-]+)"', page)
        assert wanted == ["robot-scene", "residuals-scene", "path-scene"]
        assert [i for i in wanted if f'type="application/json" id="{i}"' not in page] == []

    def test_compliances_are_shown_with_error_and_unit(self, name: str) -> None:
        found, words = identified(name), visible(page_of(name))
        for k, error in zip(found.compliance, found.standard_error, strict=True):
            decimals = decimals_of(1e9 * error)
            assert f"{1e9 * k:.{decimals}f}" in words
        for slides, unit in ((False, "nrad/(N·m)"), (True, "nm/N")):
            if (found.model.springs.prismatic == slides).any():
                assert unit in words


def test_remarks_are_on_top_and_in_their_section() -> None:
    plan, data = PLANS["kuka-kr270"](), measured("kuka-kr270")
    found = identify(plan.study.arm, replace(data, covariance=data.covariance / 9.0))
    assert doubts(found)
    page = report.html(Contents(plan, identification=found))
    top = page.split("<nav")[0]
    own = page.split('id="identification"')[1].split("</section>")[0]
    for sentence in map(worded, doubts(found)):
        assert sentence in visible(top)
        assert sentence in visible(own)


def test_no_remarks_is_said() -> None:
    plan = three_link_plan()
    rng = np.random.default_rng(4)
    q = rng.uniform(-1.2, 1.2, (40, 3))
    cases = LoadCases(q, np.tile([300.0, 200.0, -800.0, 0.0, 0.0, 0.0], (40, 1)))
    data = simulate(plan.study, truth_of(plan), cases, np.ones(40, dtype=int), rng)
    found = identify(plan.study.arm, data)
    assert doubts(found) == ()
    assert "Nothing weak was found" in visible(report.html(Contents(plan, identification=found)))
    assert "No weak points" in visible(report.html(Contents(plan, identification=found)))


def test_state_in_plain_words() -> None:
    top = visible(page_of("three-link").split("<nav")[0])
    found = validated("three-link")
    removed = 1.0 - summary(found.after).rms / summary(found.before).rms
    assert f"{100.0 * removed:.0f}" in top
    assert "took no part in the identification" in top
    assert "Noise found: σ =" in top
    left = np.sqrt(np.mean(np.sum(judged("three-link") ** 2, axis=1)))
    assert f"→ {length(float(left))}" in top
    assert "200 virtual campaigns" in top


def test_stiffness_at_the_test_poses_is_shown() -> None:
    found, plan = identified("three-link"), three_link_plan()
    there = at_test_poses(plan.study, found.model, found.width)
    page = report.html(Contents(plan, identification=found, at_test_poses=there))
    own = visible(page.split('id="stiffness"')[1].split("</section>")[0])
    stiff = there[0].cartesian
    assert ranged(stiff.axes[0].compliance, 1e6) in own
    assert ranged(stiff.axes[0].stiffness, 1e-6) in own
    assert f"leaves here after compensation: {length(there[0].rho0)}" in own
    assert stiff.missing == 3  # three joints
    assert "leave 3 of the six ways to move the TCP rigid" in own
    assert 'id="stiffness"' not in report.html(Contents(plan, identification=found))


def test_what_is_missing_is_said() -> None:
    top = visible(report.html(Contents(identification=identified("three-link"))).split("<nav")[0])
    assert "no plan in this report" in top
    assert "not validated yet" in top
    assert "no path compensated yet" in top
    assert "Simulated" not in top


def test_remaining_error_against_what_was_expected() -> None:
    name = "kuka-kr270"
    section = page_of(name).split('id="remaining"')[1].split("</section>")[0]
    words = visible(section)
    sizes = [np.linalg.norm(judged(name, sign), axis=1) for sign in (1.0, -1.0)]
    for size in sizes:
        assert length(float(np.sqrt(np.mean(size**2)))) in words
    assert "negative control" in words
    assert "Do not run" not in words
    below = int((sizes[0] <= 2.0 * compensated(name).rho0).sum())
    assert f"{below} of 30 points of the true robot lie below" in words


def test_control_and_truth_only_if_given() -> None:
    words = visible(report.html(Contents(compensation=compensated("three-link"))))
    assert "negative control" not in words
    assert "true robot" not in words
    assert "its own judge" in words


def test_points_without_solution_raise_an_alarm() -> None:
    done = compensated("three-link")
    converged, q = np.array(done.converged), np.array(done.q)
    converged[4:7], q[4:7] = False, np.nan
    after = np.where(converged[:, None], done.after, np.nan)
    numbers = {"value": 2.0, "limit": 1.0}
    hostile = Doubt("beyond-limit", (HOSTILE,), numbers=numbers, unit="rad")
    doubts = tuple(() if ok else (hostile,) for ok in converged)
    broken = replace(done, converged=converged, q=q, after=after, doubts=doubts)
    page = without_plotly(report.html(Contents(compensation=broken)))
    assert "Do not run the corrected path" in visible(page.split("<nav")[0])
    assert "3 points of 30 cannot be corrected" in visible(page)
    assert "points 5 to 7" in visible(page)
    assert "<img" not in page
    assert "would need 114.5916°, beyond its limit 57.2958°" in visible(page)


def test_linear_rule_shows_what_it_leaves() -> None:
    done = compensated("three-link")
    linear = replace(done, rule="linear", after=0.01 * done.before)
    assert "left by the linear rule" in visible(report.html(Contents(compensation=linear)))


def test_a_single_point_is_a_path_too() -> None:
    done = compensated("gantry")
    one = compensate(done.arm, done.model, LoadCases(done.cases.q[:1], done.cases.wrench[:1]))
    assert 'id="remaining"' in report.html(Contents(compensation=one))


def test_nothing_that_bends() -> None:
    done = compensated("three-link")
    idle = compensate(done.arm, done.model, LoadCases(done.cases.q, 0.0 * done.cases.wrench))
    assert "nothing to compensate" in visible(report.html(Contents(compensation=idle)))


def test_an_exact_model_is_not_taken_for_a_perfect_robot() -> None:
    done = compensated("three-link")
    exact = compensate(done.arm, truth_of(three_link_plan()), done.cases)
    assert "given without uncertainty" in visible(report.html(Contents(compensation=exact)))


def test_virtual_campaigns_against_prediction() -> None:
    found = simulated("three-link")
    words = visible(page_of("three-link").split('id="monte-carlo"')[1])
    for plan in found.plans:
        assert length(plan.rho0) in words
        assert length(plan.rms) in words
    assert "The predicted errors are found" in words
    assert "distribution predicted" in visible(
        report.html(Contents(monte_carlo=found))
    )  # also alone


def test_broken_predictions_are_weak_points() -> None:
    found = simulated("three-link")
    wrong = replace(found.plans[0], rho0_each=0.5 * found.plans[0].rho0_each)
    small = replace(wrong, inside=np.zeros_like(wrong.inside))
    words = visible(
        report.html(Contents(monte_carlo=replace(found, plans=(small,)))).split("<nav")[0]
    )
    assert "times the predicted" in words
    assert "do not cover the truth" in words


def test_left_out_in_turn_is_said() -> None:
    page = visible(report.html(Contents(validation=leave_one_out(identified("three-link")))))
    assert "each left out in turn; nothing was kept aside" in page
    assert "weaker test" in page


def test_a_wrong_model_is_not_praised() -> None:
    plan = three_link_plan()
    truth = truth_of(plan)
    wrong = replace(truth, compliance=-truth.compliance)
    page = visible(
        report.html(Contents(validation=validate(plan.study.arm, wrong, measured("three-link"))))
    )
    assert "the error is larger than without it" in page
    assert "larger than noise and uncertain compliances make" in page
    assert "No weak points" not in page


def test_interval_that_contains_zero_is_marked() -> None:
    plan = three_link_plan()
    truth = truth_of(plan)
    stiff = replace(truth, compliance=truth.compliance * [1.0, 1.0, 1e-6])
    data = simulate(
        plan.study, stiff, plan.load_cases, np.array([1, 1, 1]), np.random.default_rng(2)
    )
    found = identify(plan.study.arm, data)
    assert found.interval[2, 0] < 0.0 < found.interval[2, 1]
    page = report.html(Contents(identification=found))
    assert '<tr class="open">' in page
    assert "∞" in visible(page)


def test_outlier_leaves_the_band_and_is_named() -> None:
    plan = three_link_plan()
    rng = np.random.default_rng(7)
    data = simulate(
        plan.study,
        truth_of(plan),
        plan.load_cases,
        np.full(3, 5),
        rng,
        reality=Reality(outliers=Outliers(0.1, 1e-3)),
    )
    found = identify(plan.study.arm, data, Fit(sigma="estimated"))
    page = report.html(Contents(identification=found))
    assert 'class="far"' in page.split('id="residuals"')[1].split("</section>")[0]
    worst = data.names[int(np.nanargmax(found.influence.cook))]
    influence = page.split('id="influence"')[1].split("</section>")[0]
    assert f"<td>{worst}</td>" in influence


def test_hostile_text_is_escaped() -> None:
    plan = three_link_plan()
    data = measured("three-link")
    tool = replace(data.tool, name=HOSTILE, marker_names=tuple(HOSTILE for _ in data.tool.markers))
    names = tuple(f"{HOSTILE}{i}" for i in range(len(data.names)))
    hostile = replace(data, tool=tool, names=names, source=HOSTILE, remarks=(HOSTILE,), sha256="ab")
    springs = plan.study.springs
    named = replace(springs, names=tuple(f"{HOSTILE}{i}" for i in range(len(springs))))
    arm = replace(plan.study.arm, springs=named)
    found = identify(arm, hostile)
    page = report.html(
        Contents(
            plan,
            identification=found,
            references={HOSTILE: found.model},
            validation=leave_one_out(found),
            monte_carlo=replace(
                simulated("three-link"),
                springs=found.identified,
                known=(HOSTILE,),
                plans=(replace(simulated("three-link").plans[0], name=HOSTILE),),
            ),
        )
    )
    page = without_plotly(page)
    assert page.count("<script") == page.count("</script>") == 4
    assert "<img" not in page
    assert page.count("alert(&#39;x&#39;)") > 10


def test_a_long_campaign_stays_a_small_page() -> None:
    plan = three_link_plan()
    rng = np.random.default_rng(3)
    q = rng.uniform(-1.2, 1.2, (3000, 3))
    cases = LoadCases(q, np.tile([300.0, 200.0, -800.0, 0.0, 0.0, 0.0], (3000, 1)))
    data = simulate(plan.study, truth_of(plan), cases, np.ones(3000, dtype=int), rng)
    found = identify(plan.study.arm, data)
    page = without_plotly(
        report.html(Contents(plan, identification=found, validation=leave_one_out(found)))
    )
    assert len(page) < 4_000_000
    assert "2988 further configurations" in visible(page)
    assert re.search(r"2\d{3} further readings, none of them the farthest out", visible(page))


def test_a_single_compliance() -> None:
    plan = three_link_plan()
    arm = replace(plan.study.arm, springs=_first(plan.study.springs))
    found = identify(arm, chosen(measured("three-link"), np.arange(6) < 4))
    assert "nothing to be told apart" in visible(report.html(Contents(identification=found)))


def _first(springs):  # type: ignore[no-untyped-def]
    from elastocal.elastic.springs import subset

    return subset(springs, springs.names[:1])


def test_nothing_to_show_is_refused() -> None:
    with pytest.raises(InputError, match="a report needs"):
        report.html(Contents())


def test_same_values_same_report() -> None:
    found = identified("three-link")
    assert report.html(Contents(identification=found)) == report.html(
        Contents(identification=found)
    )


def test_remarks_say_which_readings_they_are_about() -> None:
    found = validated("three-link")
    doubts = (Doubt("marker-not-measured", ("M9",)),)
    data = replace(found.measurements, remarks=("row 3 is odd",), doubts=doubts)
    odd = replace(found, measurements=data)
    top = visible(report.html(Contents(validation=odd)).split("<nav")[0])
    assert "readings kept aside: row 3 is odd" in top
    assert "readings kept aside: marker 'M9' was never measured" in top


def test_long_names_keep_what_tells_them_apart() -> None:
    names = [f"morning shift, experiment {i}" for i in range(8, 12)]
    assert shortened(names, 9) == ["…8", "…9", "…10", "…11"]
    assert shortened(["a", "b"], 9) == ["a", "b"]
    assert shortened(["a name that is long"], 9) == ["a name t…"]


@pytest.mark.parametrize(
    ("error", "decimals"), [(42.0, 0), (4.2, 1), (0.42, 2), (0.0031, 4), (0.0, 2), (np.nan, 2)]
)
def test_no_more_digits_than_the_error_leaves(error: float, decimals: int) -> None:
    assert decimals_of(error) == decimals


def test_correlations_are_as_dark_for_either_sign() -> None:
    """In grey the size is seen and the number says the sign."""

    def grey(r: float) -> float:
        colour = _colour(r)
        parts = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
        return float(np.dot([0.2126, 0.7152, 0.0722], parts))

    for size in (0.2, 0.5, 0.9, 1.0):
        assert abs(grey(size) - grey(-size)) < 15.0
        assert grey(size) < grey(size - 0.15)


def test_thinned_strips_keep_the_farthest_out() -> None:
    error = np.random.default_rng(0).normal(size=(5000, 3)) * 1e-5
    error[1234] = 1e-3
    strips = Strips(error, np.full((5000, 3), 2e-5), np.arange(5000), [], "")
    assert 1234 in strips.shown
    assert len(strips.shown) <= 900
    assert strips.remark.startswith(str(5000 - len(strips.shown)))
