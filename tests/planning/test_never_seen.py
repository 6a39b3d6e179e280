"""What no plan of a study can show, and whether another load would."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import elastocal as ec
from elastocal.elastic.allowed_loads import FreeDirection
from elastocal.planning.blind import BlindEffect
from elastocal.planning.needed import half_known, hardly_needed
from elastocal.planning.never_seen import ASLANT, never_seen, turned
from elastocal.study.two_steps import with_nuisance
from elastocal.wording.blind import never_seen_sentence
from tests.kr270 import kr270_study
from tests.planning.test_promise import ALL, PLAN, REPEATS, two_axes_a_joint


def places(effects: tuple[BlindEffect, ...]) -> set[tuple[str, str]]:
    return {(effect.kind, " ".join(effect.carriers)) for effect in effects}


def test_a_hung_weight_never_shows_what_turns_about_the_vertical() -> None:
    """The one marker at the load point does not tell the bracket from A6 however one pulls."""
    found = never_seen(kr270_study(), np.random.default_rng(0))
    assert {("joint", "A1"), ("bearing", "A2"), ("foot-sliding", "")} <= places(found.effects)
    assert places(found.aslant) == {("tool-sliding", "")}
    assert not found.markers
    said = never_seen_sentence(found.effects, found.aslant, found.markers)
    assert "joint A1 (up to 941 µm by 1.0 µrad/(N·m))" in said
    assert "would show joint A1; bearing of A2 about z; foot sliding along y." in said
    assert said.endswith("Three markers, with these loads, would show tool sliding along its y.")
    assert not never_seen_sentence((), (), ())


def test_loads_to_all_sides_show_everything_but_the_bracket() -> None:
    study = kr270_study()
    aslant = FreeDirection(2500.0, np.array([0.0, 0.0, -1.0]), ASLANT)
    free = replace(study, experiments=replace(study.experiments, force=aslant))
    found = never_seen(free, np.random.default_rng(0))
    assert places(found.effects) == {("tool-sliding", "")}
    said = never_seen_sentence(found.effects, found.aslant, found.markers)
    assert said.endswith("Three markers and loads aslant would show tool sliding along its y.")
    assert never_seen_sentence(found.effects, found.effects, found.effects).endswith("passes.")


def test_turned_loads_keep_their_size() -> None:
    wrench = np.array([[0.0, 0.0, -2500.0, 1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]])
    made = turned(wrench, np.random.default_rng(0))
    np.testing.assert_allclose(np.linalg.norm(made[0, :3]), 2500.0)
    np.testing.assert_allclose(made[0, 2], -2500.0 * np.cos(ASLANT))
    np.testing.assert_array_equal(made[:, 3:], wrench[:, 3:])
    np.testing.assert_array_equal(made[1], wrench[1])


def test_what_is_hardly_needed_and_what_is_half_known() -> None:
    """The milling tool stands along A6, which so moves nothing; by hand of the others."""
    study = with_nuisance(kr270_study(), two_axes_a_joint(ALL))
    worth = ec.assess(study, PLAN, REPEATS)
    (little,) = hardly_needed(study, worth)
    assert (little.code, little.about) == ("hardly-needed", ("A6",))
    assert little.numbers["A6"] < 1e-12
    assert worth.promise is not None
    assert study.nuisance is not None
    shares = worth.promise.standard_error / study.nuisance.nominal[1:]
    (bad,) = half_known(study, worth)
    expected = [n for n, s in zip(study.springs.names, shares, strict=True) if s > 0.5]
    assert list(bad.about) == expected
    plain = kr270_study()
    without = ec.assess(plain, PLAN, REPEATS)
    assert not [*hardly_needed(plain, without), *half_known(plain, without)]
