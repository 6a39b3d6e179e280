"""What would make a plan promise more: proposals hold what they say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.mends import Mend, mends
from elastocal.planning.quick_choice import chosen
from elastocal.study.study import Study
from elastocal.study.two_steps import with_nuisance
from elastocal.wording.mends import mend_name, minutes_phrase
from tests.kr270 import kr270_study
from tests.planning.test_promise import ALL, PLAN, REPEATS, two_axes_a_joint


@pytest.fixture(scope="module")
def study() -> Study:
    return with_nuisance(kr270_study(), two_axes_a_joint(ALL))


@pytest.fixture(scope="module")
def found(study: Study) -> dict[str, Mend]:
    return {mend.kind: mend for mend in mends(study, PLAN, REPEATS)}


def promised(study: Study, cases: LoadCases, repeats: np.ndarray) -> float:
    worth = ec.assess(study, cases, repeats).promise
    assert worth is not None
    return worth.rho0


def test_each_gains_and_the_best_comes_first(study: Study, found: dict[str, Mend]) -> None:
    now = promised(study, PLAN, REPEATS)
    sizes = [mend.promised for mend in found.values()]
    assert sizes == sorted(sizes)
    assert max(sizes) < 0.95 * now
    assert {"configurations", "second-step", "all"} <= set(found)
    assert found["all"].promised < found["configurations"].promised


def test_what_another_way_beats_in_both_is_left_out(found: dict[str, Mend]) -> None:
    """So each that promises less takes less time."""
    minutes = [mend.minutes for mend in found.values()]
    assert minutes == sorted(set(minutes), reverse=True)


def test_loads_from_the_side_find_the_first_joint(found: dict[str, Mend]) -> None:
    """Another load takes a change of load, 12 minutes, and moves; readings take 2 minutes each."""
    step = found["second-step"]
    assert step.joints == ("A1",)
    assert 12.0 + 4 * 2.0 < step.minutes < 4 * (12.0 + 2.0 + 2.0)
    assert mend_name(step).startswith("4 more readings, pulled from the side")
    assert minutes_phrase(step) == f"{step.minutes:.0f} min more"
    assert minutes_phrase(replace(step, minutes=-3.0)) == "3 min less"


def test_three_markers_are_the_same_load_cases(study: Study, found: dict[str, Mend]) -> None:
    """Wherever the plane of three markers is turned to, it tells about as much."""
    tool = study.experiments.tool
    first = tool.markers[0]
    along = first / np.linalg.norm(first)
    side = np.cross(along, [0.3, -0.5, 0.8])
    side *= 0.3 / np.linalg.norm(side)
    markers = np.array([first, first + side, first + np.cross(along, side)])
    more = replace(tool, markers=markers, marker_names=("M1", "M2", "M3"))
    other = replace(study, experiments=replace(study.experiments, tool=more))
    now, expected = promised(study, PLAN, REPEATS), promised(other, PLAN, REPEATS)
    if "markers" in found:
        assert found["markers"].promised == pytest.approx(expected, rel=0.15)
        assert minutes_phrase(found["markers"]) == "as long"
    else:
        assert expected > 0.9 * now


def test_the_quick_choice_is_better_than_chance(study: Study) -> None:
    rng = np.random.default_rng(1)
    pool = study.space.load_cases(study.space.sample(100, rng))
    repeats = np.array([2, 2, 2, 1, 1])
    quick = promised(study, chosen(study, pool, repeats), repeats)
    drawn = []
    for _ in range(30):
        own = rng.choice(100, 5, replace=False)
        drawn.append(promised(study, LoadCases(pool.q[own], pool.wrench[own]), repeats))
    assert quick < min(drawn)
    beside = chosen(study, pool, np.ones(2, dtype=np.int64), beside=(PLAN, REPEATS))
    both = LoadCases(np.vstack([PLAN.q, beside.q]), np.vstack([PLAN.wrench, beside.wrench]))
    assert promised(study, both, np.append(REPEATS, [1, 1])) < promised(study, PLAN, REPEATS)


def test_nothing_is_proposed_without_a_promise(study: Study) -> None:
    assert not mends(kr270_study(), PLAN, REPEATS)
    known = np.array(study.prior)
    known[0, 0] += 1e14
    assert not mends(replace(study, prior=known), PLAN, REPEATS)
