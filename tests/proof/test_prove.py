"""Proofs of bounds: what is proved, in what time, and what a proof may never say."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastocal.core.library import Library, library
from elastocal.errors import InputError
from elastocal.planning.certificate import Bound, lower_bound
from elastocal.proof import prove as module
from elastocal.proof.boxes import Boxes
from elastocal.proof.branching import Branching
from elastocal.proof.posing import posed
from elastocal.proof.prove import ProofError, _ladder, largest_for, loss_of, prove
from elastocal.proof.record import proof_bytes, read_proof
from elastocal.proof.reference import margins, sensitivity
from elastocal.proof.statement import Statement
from elastocal.proof.tree import Region, divided, is_complete, proved, symbols_of
from elastocal.proof.trigonometric import third_derivatives
from elastocal.study.study import Study, TestPose
from tests.kr270 import kr270_study
from tests.paper.problems import three_link_study
from tests.paper.published import A0, A0_PLUS
from tests.paper.test_three_link import CONTINUOUS
from tests.proof.bounds import bound_by_chance

pytestmark = pytest.mark.skipif(library() is None, reason="proofs need the compiled core")


@pytest.fixture(scope="module")
def three() -> tuple[Study, Bound]:
    study = three_link_study(4)
    return study, lower_bound(study, np.random.default_rng(0))


@pytest.fixture(scope="module")
def kr270() -> tuple[Study, Bound]:
    study = kr270_study()
    return study, lower_bound(study, np.random.default_rng(0))


def test_three_links_in_closed_form(three: tuple[Study, Bound]) -> None:
    """m ρ0² ≥ 1.48456 σ² for every plan; the true value is 1.484704 σ²."""
    found = prove(*three, threads=1, gap=4e-5)
    assert 1.48456 < 4.0 * found.loss**2 < CONTINUOUS * (1.0 + 1e-6)
    assert found.ended == "reached"
    assert 0.0 < found.gap <= 4e-5 * (1.0 + 1e-9)
    assert is_complete(symbols_of(found.tree))
    assert not len(found.refuted)


def test_kr270_to_a_ten_thousandth(kr270: tuple[Study, Bound]) -> None:
    """Symmetries of the wrist are found, so that half a million boxes do."""
    told: list[float] = []
    found = prove(*kr270, threads=1, proved=lambda gap, _: told.append(gap))
    assert found.ended == "reached"
    assert found.loss > (1.0 - 1e-4) * 9.6446e-6 / np.sqrt(12)
    assert len(found.statement.halved) == 2
    assert [one.variable for one in found.statement.held] == [0]
    assert found.boxes < 800_000
    assert told == [1e-4]


@pytest.mark.parametrize(("asked", "least"), [(A0, 9.6441), (A0_PLUS, 7.4405)])
def test_the_bounds_of_the_paper_are_theorems(asked: np.ndarray, least: float) -> None:
    """ρ0 √m in 1e-3 mm, of every plan: 9.64460 and 7.44092 by searches; see docs/validation.md."""
    study = replace(kr270_study(), test_poses=(TestPose("printed", asked),))
    found = prove(study, lower_bound(study, np.random.default_rng(0)), threads=1, gap=4e-5)
    assert 1e6 * found.loss * np.sqrt(study.experiments.count) >= least
    assert not found.doubts


def test_a_bound_that_is_false_is_never_proved(kr270: tuple[Study, Bound]) -> None:
    """Not even with large boxes: half of the largest d, and a thousandth less."""
    found = prove(*kr270, threads=1, gap=0.2)
    boxes = Boxes(_library(), found.statement, third_derivatives(found.statement, 0.1))
    best = largest_for(found.statement, 0.0, found.numerical)
    for share in (0.5, 0.9, 0.999):
        end = time.monotonic() + 0.3
        search = Branching(boxes, divided(boxes, share * best, 64), 1)
        assert not search.prove(share * best, lambda end=end: time.monotonic() > end)  # type: ignore[misc]
        assert search.proved > share * best


def test_what_is_feasible_must_be_in_the_tree(
    kr270: tuple[Study, Bound], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A proof that calls everything empty contradicts what is known; nothing is claimed."""

    def nothing(boxes: Boxes, *_: float) -> Region:
        root = divided(boxes, np.inf, 1)
        assert root.settled is not None
        root.settled = replace(root.settled, symbols=bytes([255]), parts=())
        return root

    monkeypatch.setattr(module, "divided", nothing)
    monkeypatch.setattr(Branching, "predicted", lambda *_: [0.0] * 6)
    with pytest.raises(ProofError, match="contradicts itself at the configuration"):
        prove(*kr270, threads=1)


def test_time_ends_and_the_record_is_gone_on_with(
    kr270: tuple[Study, Bound], tmp_path: Path
) -> None:
    study, bound = kr270
    kept: list[Statement] = []
    first = prove(study, bound, threads=1, gap=0.05, saved=lambda s, _: kept.append(s))
    path = tmp_path / "plan.proof"
    path.write_bytes(proof_bytes(first.statement, first.tree))
    statement, root = read_proof(path)
    assert statement.largest == first.statement.largest
    assert proved(root) == pytest.approx(proved(first.tree))
    assert symbols_of(root) == symbols_of(first.tree)
    then = prove(study, bound, threads=1, resumed=(statement, root))
    assert then.ended == "reached"
    again = prove(study, bound, threads=1)
    assert then.loss == pytest.approx(again.loss, rel=1e-4)
    assert then.boxes < again.boxes
    other = replace(statement, sigma=2.0 * statement.sigma)
    with pytest.raises(InputError, match="of another study"):
        prove(study, bound, resumed=(other, root))


def test_without_time_nothing_is_claimed(kr270: tuple[Study, Bound]) -> None:
    found = prove(*kr270, threads=1, stop=lambda: True)
    assert found.ended == "stopped"
    assert found.loss == 0.0
    assert found.statement.rho0 is None
    assert found.gap == 1.0


def test_what_comes_on_top_is_not_in_the_record(
    kr270: tuple[Study, Bound], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A checker has the inequality alone."""
    study, bound = kr270
    plain = prove(study, bound, threads=1, gap=0.2)
    monkeypatch.setattr(module, "posed", lambda *given: replace(posed(*given), beyond=9e-12))
    found = prove(study, bound, threads=1, gap=0.2)
    assert found.statement.rho0 is not None
    assert found.statement.rho0 == pytest.approx(np.sqrt(found.loss**2 - 9e-12))
    assert found.loss > 1.2 * plain.loss


def test_something_is_proved_before_the_time_is_over() -> None:
    """The last gap at once where that is short; the first one first where nothing is sure."""
    thresholds = [6.0, 5.0, 4.0, 3.0, 2.0, 1.0]

    def gaps(*seconds: float, budget: float = np.inf) -> list[float]:
        expected = list(zip(module.GAPS, seconds, strict=True))
        return [step[0] for step in _ladder(expected, thresholds, budget)]

    short, long = (0.1, 0.2, 0.3, 0.4, 0.5, 4.0), (2.0, 3.0, 4.0, 7.0, 10.0, 13.0)
    assert gaps(*short) == gaps(*short, budget=60.0) == [1e-4]
    assert gaps(*short, budget=10.0) == [0.2, 1e-4]
    assert gaps(*long) == gaps(*long, budget=60.0) == [0.05, 1e-4]
    assert gaps(*long, budget=12.0) == [0.2, 0.05, 1e-4]
    assert gaps(2.0, *[np.inf] * 5) == [0.2, 0.1, 0.05, 0.01, 1e-3, 1e-4]


def test_the_loss_and_the_largest_d_that_allows_it(kr270: tuple[Study, Bound]) -> None:
    s = prove(*kr270, threads=1, gap=0.2).statement
    for beyond in (0.0, 1e-13):
        loss = loss_of(s, beyond, 1.3)
        assert largest_for(s, beyond, loss) == pytest.approx(1.3)
    assert largest_for(s, 1.0, 0.5) == np.inf


@pytest.mark.parametrize("study", [three_link_study(4), kr270_study()], ids=["free", "steady"])
def test_a_better_point_ends_a_proof_that_cannot_be(study: Study) -> None:
    """V is of load cases by chance, and no search looked for where d is largest."""
    begun = time.monotonic()
    found = prove(study, bound_by_chance(study), threads=1, seconds=30.0)
    assert time.monotonic() - begun < 20.0
    assert found.ended == "open"
    (q,) = found.refuted
    x = np.linalg.solve(found.statement.mix, q)[None]
    assert (margins(found.statement, x) >= 0.0).all()
    known = largest_for(found.statement, 0.0, found.numerical)
    assert sensitivity(found.statement, x)[0] > known * (1.0 + 1e-4)
    assert found.statement.largest is None or found.statement.largest > known


def _library() -> Library:
    found = library()
    assert found is not None
    return found
