"""What is proved, in certificates: never more than that, and beside what a search found."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elastocal.errors import Doubt, InputError
from elastocal.files.plans.plan_file import plan_document
from elastocal.files.plans.proved_section import claimed_proof, proved_section
from elastocal.planning.aim import aim_of
from elastocal.planning.certificate import Certificate, with_proof
from elastocal.planning.plan import Plan
from elastocal.planning.proved import Proved
from elastocal.report.charts.bounds import bounds_chart
from elastocal.report.verdict import proof, verdict
from elastocal.terminal.certificates import certificate_sentences
from elastocal.wording.proofs import (
    at_most,
    claimed_kind,
    duration,
    foretold,
    going_on,
    proved_length,
    so_far,
)
from tests.report.examples import three_link_plan

LEFT_OUT = (
    Doubt("proof-leaves-out", ("A2 against A5", "line of sight of M1")),
    Doubt("proof-best-noise", numbers={"sigma": 2e-5}, unit="m"),
)


def proved(share: float = 0.95, **changed: Any) -> Proved:
    """A proof of so much of the bound of the plan by hand."""
    bound = three_link_plan().certificate.lower_bound
    known = Proved(share * bound, 0.99 * bound, 1.5, 350_005, 1.23, "reached", LEFT_OUT)
    return replace(known, record="plan.proof", sha256="ab" * 32, **changed)


def certified(share: float = 0.95, **changed: Any) -> Plan:
    plan = three_link_plan()
    certificate = with_proof(plan.certificate, aim_of(plan.study), proved(share, **changed))
    return replace(plan, certificate=certificate)


def test_what_is_proved_stands_beside_what_was_found() -> None:
    plan, made = three_link_plan(), certified().certificate
    assert (plan.certificate.kind, made.kind) == ("numerical", "rigorous")
    assert made.lower_bound == plan.certificate.lower_bound
    assert made.efficiency == plan.certificate.efficiency
    assert made.proved is not None
    # φ is the inverse square of the loss.
    assert made.proved.efficiency == pytest.approx(0.95**2 * made.efficiency)
    assert made.gap == pytest.approx(0.05)
    assert plan.certificate.gap == 1.0


def test_nothing_proved_changes_nothing() -> None:
    plan = three_link_plan()
    aim = aim_of(plan.study)
    assert with_proof(plan.certificate, aim, proved(0.0)) is plan.certificate
    none = Certificate("test-pose", "none")
    assert with_proof(none, aim, proved()) is none


def test_a_proof_that_the_plan_refutes_is_none() -> None:
    """The plan by hand is 1/.9 of its bound."""
    assert certified(1.1).certificate.lower_bound == pytest.approx(proved(1.1).loss)
    with pytest.raises(InputError, match="such a proof is none"):
        certified(1.12)


def test_what_is_said_is_what_is_proved() -> None:
    plan = certified()
    first, second = certificate_sentences(plan.certificate, plan.count)
    assert first.startswith(
        "Rigorous certificate: no plan of 6 experiments has ρ0 below "
        f"{proved_length(proved().loss)}, so at most "
        "15 % can be gained in the error. This is proved, as a theorem about the model"
    )
    for words in (
        "350\u202f005 boxes, which cover all load cases, were bounded; the last run took 1 s.",
        "The proof does not use: A2 against A5, line of sight of M1; it holds for more",
        "The proof takes the noise of the tracker as 20",
        "5 % below the bound of the search, and what it leaves out costs 1 %, as near as",
        "The record is plan.proof; 'elastocal check-proof plan.proof' verifies it",
    ):
        assert words in first
    assert second.startswith("By the search, which proves nothing: no plan of 6 experiments has")
    assert "Numerical certificate: " in second


@pytest.mark.parametrize(
    ("ended", "words"),
    [
        ("time", "it ended when its time was over, and goes on from its record"),
        ("stopped", "it ended when it was stopped"),
        ("open", "with what it uses no more can be proved"),
    ],
)
def test_an_unfinished_proof_says_so(ended: str, words: str) -> None:
    plan = certified(ended=ended)
    assert not proved(ended=ended).finished
    assert words in certificate_sentences(plan.certificate, plan.count)[0]
    assert words in " ".join(proof(plan.certificate, plan.count))


def test_the_report_says_which_bound_is_which() -> None:
    tiles = {tile.name: tile for tile in verdict(certified(), None).tiles}
    assert tiles["Proved bound"].value == proved_length(proved().loss)
    assert "theorem" in tiles["Proved bound"].meaning
    assert "By a search, not proved:" in tiles["Proved bound"].meaning
    assert "proved is 27 % at most" in tiles["Efficiency"].meaning
    plain = {tile.name: tile for tile in verdict(three_link_plan(), None).tiles}
    assert "not proved" in plain["Lower bound"].meaning
    assert "By a search, not proved." in plain["Efficiency"].meaning
    assert "Proved bound" not in plain
    said = proof(three_link_plan().certificate, 6)
    assert said[0].startswith("Numerical certificate: ")


@pytest.mark.parametrize("width", [860.0, 350.0])
@pytest.mark.parametrize("gap", [0.2, 1e-3, 1e-6, 0.0])
def test_a_picture_of_the_bounds(width: float, gap: float) -> None:
    drawn = str(bounds_chart(2.8e-6, 2.78e-6, 2.78e-6 * (1.0 - gap), width))
    assert drawn.count("mark own") == 1
    assert 'class="bound proved"' in drawn
    assert "nan" not in drawn
    ticks = re.findall(r'class="tick"[^>]*>([^<]*)', drawn)
    assert len(ticks) == len({*ticks}) > 0
    same = str(bounds_chart(2.8e-6, 2.8e-6, 2.8e-6, width))
    assert "nan" not in same


def test_a_plan_file_has_it_and_gives_it_back(tmp_path: Path) -> None:
    document = json.loads(json.dumps(plan_document(certified())))
    section = document["certificate"]
    assert section["kind"] == "rigorous"
    assert section["proved"]["lower_bound_mm"] == pytest.approx(1e3 * proved().loss)
    assert "proved" not in plan_document(three_link_plan())["certificate"]
    again = claimed_proof(section, "plan.json")
    assert again is not None
    assert again.left_out == LEFT_OUT
    known = certified().certificate.proved
    assert known is not None
    for name in ("loss", "reachable", "largest", "seconds", "efficiency"):
        assert getattr(again, name) == pytest.approx(getattr(known, name), rel=1e-12)
    for name in ("boxes", "ended", "record", "sha256"):
        assert getattr(again, name) == getattr(known, name)
    assert claimed_proof({}, "plan.json") is None


def test_what_is_no_length_has_no_unit() -> None:
    plan = certified()
    made = replace(plan.certificate, criterion="A")
    section = proved_section(made)["proved"]
    assert section["lower_bound"] == proved().loss
    again = claimed_proof({"proved": section}, "")
    assert again is not None
    assert again.loss == proved().loss
    (first, _) = certificate_sentences(made, 6)
    assert "against every plan of 6 experiments, by A, at most 15 % can be gained" in first


def test_numbers_of_proofs_are_never_rounded_towards_more() -> None:
    rng = np.random.default_rng(0)
    for share in 10.0 ** rng.uniform(-5.0, 0.0, 300):
        shown = float(at_most(share).split()[0]) / 100.0
        assert share <= shown * (1.0 + 1e-9)
        assert shown <= 1.11 * share + 1e-5
    assert at_most(0.0261) == "2.7 %"
    assert at_most(1e-4) == "0.01 %"
    assert at_most(0.2) == "20 %"


def test_a_proved_length_is_never_rounded_up() -> None:
    assert proved_length(60.7288e-6) == "60.72 µm"
    assert proved_length(60.73e-6) == "60.73 µm"
    assert proved_length(2.7e-6) == "2.700 µm"
    assert proved_length(0.0) == "0 µm"
    rng = np.random.default_rng(1)
    for value in 10.0 ** rng.uniform(-7.0, -1.0, 300):
        shown, unit = proved_length(value).split()
        size = float(shown) * {"µm": 1e-6, "mm": 1e-3}[unit]
        assert size <= value * (1.0 + 1e-9)
        assert size >= value * (1.0 - 1.1e-3)


def test_what_is_told_on_the_way() -> None:
    line = so_far("ρ0", 12, 2.71e-6, 2.782e-6, is_length=True)
    assert line == (
        "proved: no plan of 12 experiments has ρ0 below 2.710 µm (numerical bound 2.782 µm): 2.6 %"
    )
    assert so_far("ρ0", 12, 0.0, 1.0, is_length=True) == "nothing is proved yet"
    assert so_far("A", 12, 0.99, 1.0, is_length=False) == (
        "proved: no plan of 12 experiments is better by A than the bound less 1 %"
    )
    now = going_on(0.01, 12.3, 350_005, "2.710 µm")
    assert now == "to 1 %, about 12 s more, 350\u202f005 boxes; 2.710 µm is proved"
    assert going_on(0.2, float("inf"), 1, "") == "to 20 %, 1 box"
    gaps = (0.2, 0.1, 0.05, 0.01, 1e-3, 1e-4)
    times = (1.0, 2.0, 3.0, 4.2, 8.0, 12.0)
    assert foretold(list(zip(gaps, times, strict=True))) == (
        "the proof takes about 1 s to 20 %, about 4 s to 1 %, about 12 s to 0.01 %"
    )
    late = list(zip(gaps, (30.0, 900.0, *[float("inf")] * 4), strict=True))
    assert foretold(late) == (
        "the proof takes about 30 s to 20 %, about 15 min to 10 %; how long 5 % takes cannot be "
        "foretold"
    )
    assert foretold([(0.2, float("inf"))]) == "how long the proof takes cannot be foretold"
    assert foretold([(0.2, 0.1), (0.01, 0.7)]) == "the proof takes less than 1 s to 1 %"
    assert duration(8000.0) == "2.2 h"


def test_what_the_live_view_says_of_a_plan() -> None:
    assert "by its record plan.proof" in claimed_kind("rigorous", 3e-6, proved())
    assert claimed_kind("rigorous", 3e-6, None).startswith("Numerical certificate")
    assert "not proved" in claimed_kind("numerical", None, None)
    assert claimed_kind("none", None, None).startswith("No certificate")
