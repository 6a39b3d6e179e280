"""What is left of a plan without one of its configurations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.assessment import assess

ROOT = Path(__file__).parents[2]


def test_the_configuration_that_is_missed_most_is_named() -> None:
    """Each left out by hand; load cases of one configuration go together."""
    study = ec.read_study(ROOT / "examples" / "kr270" / "study.yaml")
    rng = np.random.default_rng(0)
    cases = study.space.load_cases(study.space.sample(5, rng))
    twice = LoadCases(np.repeat(cases.q, 2, axis=0), np.repeat(cases.wrench, 2, axis=0))
    repeats = np.arange(1, 11)
    found = assess(study, twice, repeats).loss
    assert found is not None
    left = []
    for g in range(5):
        keep = np.arange(10) // 2 != g
        rest = LoadCases(twice.q[keep], twice.wrench[keep])
        left.append(assess(study, rest, repeats[keep]).rho0)
    assert found.rho0 == pytest.approx(max(left), rel=1e-9)
    assert found.load_case == 2 * int(np.argmax(left)) + 1


def test_two_configurations_cannot_lose_one() -> None:
    study = ec.read_study(ROOT / "examples" / "kr270" / "study.yaml")
    cases = study.space.load_cases(study.space.sample(2, np.random.default_rng(1)))
    found = assess(study, cases, np.array([3, 3])).loss
    assert found is not None
    assert found.rho0 == np.inf
