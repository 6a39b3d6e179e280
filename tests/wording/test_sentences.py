"""Every code has one sentence, and what is computed is apart from what is said."""

from __future__ import annotations

import ast
import re
from typing import get_args

import numpy as np
import pytest

from elastocal.errors import Code, Doubt
from elastocal.wording import SENTENCES, ended, worded
from elastocal.wording.numbers import probability, readable
from elastocal.wording.plans import freedom, only_of, told
from tests.test_architecture import MAY_IMPORT, MODULES, room_of

CORE = set(MAY_IMPORT) - set(
    ["wording", "programs", "drawing", "files", "report", "viewer", "terminal", "cli"]
)

WORDING = "elastocal.wording"
LOAD = {"load_case": 3, "x": 0.0, "y": -1.5, "z": 2.0}
MOTION = {"leg": 3, "legs": 4, "part": 1, "parts": 2, "share": 0.25, "keep": 0.01}


def test_every_code_has_its_sentence() -> None:
    assert set(SENTENCES) == set(get_args(Code))


@pytest.mark.parametrize(
    ("doubt", "sentence"),
    [
        (
            Doubt("noisier-than-promised", (), (), {"scale": 251.3, "chi_square": 9.5, "dof": 67}),
            "the residuals scatter 250 times as much as σ promises (χ² = 9.5 with 67 degrees of "
            "freedom): the noise is larger or the model lacks something; the intervals are too "
            "narrow, estimate σ",
        ),
        (
            Doubt("zero-in-interval", ("A1", "A2", "A3", "A4", "A5", "A6", "E1")),
            "A1, A2, A3, A4, A5 and 2 more: the interval contains zero, so the data do not show "
            "that these springs bend at all",
        ),
        (
            Doubt("carried", ("A1",), ("E1",), {"error_ratio": np.inf}),
            "A1: carried by experiment E1 alone; without it nothing is known of these joints, and "
            "no other reading checks it",
        ),
        (
            Doubt("carried", ("A1", "A2"), ("10",), {"error_ratio": 8.6}),
            "A1, A2: carried by experiment 10 alone; without it the standard errors are up to 8.6 "
            "times as large, and no other reading checks it",
        ),
        (
            Doubt("by-chance", (), (), {"p_value": 0.0026}),
            "repeats differ from the model as in one of 385 right models (p = 0.0026); one more "
            "configuration would tell",
        ),
        (
            Doubt(
                "noisier-than-promised",
                numbers={"scale": 1.3, "chi_square": 90.0, "dof": 67, "p_value": 0.025},
            ),
            "the residuals scatter 1.3 times as much as σ promises (χ² = 90 with 67 degrees of "
            "freedom), as in one of 40 right models (p = 0.025)",
        ),
        (
            Doubt(
                "noisier-than-promised",
                numbers={"scale": 7.3, "chi_square": 6616.0, "dof": 123, "estimated": 1.0},
            ),
            "the residuals scatter 7.3 times as much as σ promises (χ² = 6616 with 123 degrees of "
            "freedom): the noise is larger, which the intervals count, or the model lacks "
            "something, which they do not",
        ),
        (
            Doubt(
                "explains-little",
                ("position",),
                (),
                {"whole": 1.73e-3, "left": 3.72e-4, "noise": 5.2e-5},
                "m",
            ),
            "the model explains 78 % of the deflections: of 1.73 mm (RMS) 372 µm are left, where σ "
            "promises 52.0 µm; look at signs, joint values and loads, and at what else gives way",
        ),
        (
            Doubt("grows-with-load", numbers={"correlation": 0.55, "p_value": 7.4e-5}),
            "the residuals grow with the load (rank correlation 0.55), too far for chance "
            "(p = 7.4×10⁻⁵): the loads are not what is recorded, or a spring is missing; the "
            "intervals do not count that",
        ),
        (
            Doubt("held-at-zero", ("A5",), (), {"A5": -1.6e-7}, "rad/(N·m)"),
            "A5: held at zero by the bound; without it the fit says A5 −0.16 µrad/(N·m), which no "
            "spring can be; look at signs and joint values",
        ),
        (
            Doubt(
                "model-lacks",
                ("joint_1",),
                ("turning", "joint_3", "x"),
                {"share": 0.396, "before": 4.05e-4, "after": 3.14e-4, "change": -0.372}
                | {"p_value": 1e-13, "size": 6.2e-7},
            ),
            "a spring about x of joint_3 (0.62 µrad/(N·m)) would remove 40 % of the residual "
            "variance (405 µm → 314 µm when configurations are left out) and change joint_1 by "
            "−37 %",
        ),
        (
            Doubt(
                "model-may-lack",
                ("A2",),
                ("tool-shift",),
                {"share": 0.1, "p_value": 0.02, "size": 1e-3, "y": 0.0, "z": 2e-3},
            ),
            "a tool shifted between the readings without and with load by [1.0 0 2.0] mm in its "
            "frame would remove 10 % of the residual variance, as in one of 50 right models "
            "(p = 0.02); further configurations would tell",
        ),
        (
            Doubt(
                "other-convention",
                ("A4", "A6"),
                ("A3", "A2"),
                {"before": 7.65e-4, "after": 3.72e-4, "tried": 193.0}
                | {"A4": -1, "A6": -1, "A3/A2": -1.0},
            ),
            "of 193 conventions of the joint values another one fits best: the same springs leave "
            "372 µm in place of 765 µm (RMS) if A4 counts the other way (signs: {A4: -1}), A6 "
            "counts the other way (signs: {A6: -1}) and A3 is coupled to A2 (couple: {A3: {A2: "
            "-1}})",
        ),
        (
            Doubt(
                "parallel",
                ("A2", "A4", "A6"),
                numbers={"A2": 1.0, "A4": 0.35, "A6": -0.04, "ratio": 1.5, "seen": 1.0},
            ),
            "A2, A4, A6: told apart by no more than joint values that are off by 0.005° make, so "
            "only the combination A2 + 0.35 A4 − 0.040 A6 is known; measure configurations that "
            "are further apart",
        ),
        (
            Doubt("nearly-parallel", ("A2", "A4"), numbers={"ratio": 19.0}),
            "A2, A4: joint values that are off by 0.005° bias what tells them apart by up to 5 %",
        ),
        (
            Doubt("softer-than-any", ("A6",), (), {"A6": 8.15, "most": 1e-3}, "rad/(N·m)"),
            "A6: softer than any joint of an arm, 8.2×10⁶ µrad/(N·m) where 1000 would be much; "
            "look at units and loads, and whether these experiments tell the joints apart",
        ),
        (
            Doubt("same-load-cases", (), (), {"repeated": 3, "experiments": 12}),
            "3 of 12 experiments repeat load cases of the identification: that tests the noise, "
            "not the model; measure other configurations",
        ),
        (
            Doubt("counts-less", ("E4",), (), {"readings": 60, "unused": 1}),
            "1 of 60 readings count less than half, 1 of them not at all: E4",
        ),
        (
            Doubt("linear-model", (), (), {"deflection": 0.0213}),
            "linear model with deflections up to 21 mm: its estimates are biased at second order; "
            "the model of the equilibrium is not",
        ),
        (
            Doubt("beyond-limit", ("A2",), (), {"value": 0.0123, "limit": -0.0}, "rad"),
            "A2 would need 0.7047°, beyond its limit -0°",
        ),
        (
            Doubt("beyond-limit", ("slide",), (), {"value": 0.0123, "limit": 0.01}, "m"),
            "slide would need 12.3000mm, beyond its limit 10mm",
        ),
        (
            Doubt("hardly-moves", (), (), {"x": 1.0, "y": -1e-5, "z": 0.0, "remaining": 3e-4}),
            "nearly singular: the joints hardly move the tool along [1 0 0]; 0.3 mm remain",
        ),
        (
            Doubt("hardly-turns", (), (), {"x": 0.6, "y": 0.8, "z": 0.0}),
            "nearly singular: the joints hardly turn the tool about [0.6 0.8 0]",
        ),
        (
            Doubt(
                "load-differs",
                (),
                (),
                LOAD | {"wanted_x": 0.0, "wanted_y": 0.0, "wanted_z": 1.0},
                "N·m",
            ),
            "load case 3 has torque [0, -1.5, 2] N·m where the study has [0, 0, 1] N·m",
        ),
        (
            Doubt("load-too-large", (), (), LOAD | {"bound": 2.0}, "N"),
            "load case 3 has force [0, -1.5, 2] N, above the bound of 2 N",
        ),
        (
            Doubt("claims-rho0", (), (), {"claimed": 1e-3, "found": 2e-3}),
            "it claims ρ0 = 1 mm but has 2 mm",
        ),
        (
            Doubt("claims-rho0-at", ("a {pose}",), (), {"claimed": 1e-3, "found": 2e-3}),
            "at 'a {pose}' it claims 1 mm but has 2 mm",
        ),
        (
            Doubt("claims-worst-point", ("path",), (), {"claimed": 1e-3, "found": 2e-3}),
            "at the worst point of 'path' it claims 1 mm but has 2 mm",
        ),
        (
            Doubt("claims-error", ("A{1}",), (), {"claimed": 1e-9, "found": 2e-9}),
            "it claims a standard error of 1e-09 for A{1} but has 2e-09",
        ),
        (
            Doubt("motion-blocked", (), ("wall", "ball"), MOTION | {"distance": -0.15}),
            "the motion from configuration 3 to home, part 1 of 2, hits wall with ball by 150 mm "
            "at 25 %",
        ),
        (
            Doubt(
                "via-breaks",
                (),
                ("height of M1 >= 800 mm",),
                {"via": 2, "leg": 3, "legs": 4, "by": 0.0125},
                "m",
            ),
            "via point 2 from configuration 3 to home breaks height of M1 >= 800 mm by 12.5 mm",
        ),
        (
            Doubt("no-way", (), ("wall", "ball"), MOTION | {"leg": 0, "distance": 0.005}),
            "no motion without collision was found from home to configuration 1: the straight one "
            "passes wall with ball at 5 mm at 25 %, where 10 mm must be kept",
        ),
        (
            Doubt(
                "home-blocked",
                ("home_deg", "home_mm"),
                ("wall", "ball"),
                MOTION | {"distance": 0.005},
            ),
            "home is no place to start from: the robot passes wall with ball at 5 mm; give "
            "another one in motion: home_deg and home_mm, or do not watch the two: constraints: "
            "{collision: {ignore: [[ball, wall]]}}",
        ),
        (
            Doubt("home-blocked", ("home_deg",), ("floor", "A3"), MOTION | {"distance": -0.005}),
            "home is no place to start from: the robot hits floor with A3 by 5 mm; give another "
            "one in motion: home_deg, or do not watch the two: constraints: {floor: off}",
        ),
        (
            Doubt("out-of-reach", ("J3",), (), {"lower": -1.59, "upper": 4.7124}, "rad"),
            "of the range of J3 only -91.1° to 270° can be reached from home: to get beyond, it "
            "would have to pass through itself or its cell; plans keep within",
        ),
        (
            Doubt("chain-as-capsules", (), (), {"least": 0.1, "most": 0.14}),
            "no shapes are given: watched as capsules from joint to joint, 100 to 140 mm in "
            "radius; constraints: {collision: {link_radius_mm: …}} says how thick",
        ),
        (
            Doubt("chain-as-capsules", ("a", "b"), (), {"least": 0.1, "most": 0.1}),
            "no shape was read of a, b: watched as capsules from joint to joint, 100 mm in radius; "
            "constraints: {collision: {link_radius_mm: …}} says how thick",
        ),
        (
            Doubt("search-stopped", numbers={"generations": 3}),
            "the search was stopped before its end, after 3 generations of plans: a longer one may "
            "find a better plan, and the same seed need not lead to this one again",
        ),
        (
            Doubt("too-few-configurations", ("A1", "A2"), (), {"count": 2, "needed": 3}),
            "2 configurations cannot identify the 2 compliances A1, A2: at least 3 are needed",
        ),
    ],
    ids=lambda value: value.code if isinstance(value, Doubt) else "",
)
def test_sentences_say_names_and_numbers(doubt: Doubt, sentence: str) -> None:
    assert worded(doubt) == sentence


def test_what_computes_words_only_what_it_raises() -> None:
    """The core hands on codes and numbers; only the text of an error is a sentence.

    It takes numbers as text for the names of constraints, which say their bounds.
    """
    for path in MODULES:
        if room_of(path) not in CORE:
            continue
        nodes = list(ast.walk(ast.parse(path.read_text())))
        said = {
            alias.asname or alias.name
            for node in nodes
            if isinstance(node, ast.ImportFrom)
            and (node.module or "").startswith(WORDING)
            and node.module != f"{WORDING}.numbers"
            for alias in node.names
        }
        calls = {n for n in nodes if isinstance(n, ast.Name) and n.id in said}
        raised = [ast.walk(node) for node in nodes if isinstance(node, ast.Raise)]
        assert calls <= {node for part in raised for node in part}, path


@pytest.mark.parametrize(
    ("free", "turning", "spread", "sentences"),
    [
        ((), "", 0.0, []),
        (("A1", "A6"), "", 0.0, ["A1, A6: free, set as the cell requires."]),
        (
            (),
            "A1",
            1e-9,
            [
                "A1: free together with the load, turned by the same angle; all loads come from "
                "one side."
            ],
        ),
        (
            ("E1",),
            "J1",
            0.2,
            [
                "E1: free, set as the cell requires.",
                "J1: free together with the load, turned by the same angle; its limits do not let "
                "all loads come from one side, they spread over 11.5°.",
            ],
        ),
    ],
)
def test_which_joints_may_be_set_otherwise(
    free: tuple[str, ...], turning: str, spread: float, sentences: list[str]
) -> None:
    assert freedom(free, turning, spread) == sentences


def test_errors_say_whose_they_are() -> None:
    order = [f"A{i}" for i in range(1, 7)]
    rigid = [Doubt("rigid-at-test-pose", ("A1",), ("milling",), {"A1": 1.0}, "rad/(N·m)")]
    assert only_of(order[1:], rigid, order) == ", of A2 to A6 only"
    assert only_of(["A2", "A3", "A5"], rigid, order) == ", of A2, A3, A5 only"
    assert only_of(["A2", "A3", "A4", "base"], rigid, order) == ", of A2, A3, A4, base only"
    assert only_of(["A5", "A6"], rigid, order) == ", of A5, A6 only"
    assert only_of(order, [], order) == ""
    assert told(rigid[0], "x") == "Weak: x"
    assert told(Doubt("taken-as-rigid", ("A1",)), "x") == "Note: x"


def test_large_compliances_are_in_micro_units() -> None:
    assert readable("rad/(N·m)", 4.23e-4) == (1e6, "µrad/(N·m)")
    assert readable("m/N", 4.23e-5) == (1e6, "µm/N")
    for value in (2e-9, 9e-6, np.inf):
        assert readable("rad/(N·m)", value) == (1e9, "nrad/(N·m)")


def test_a_probability_is_no_smaller_than_distributions_are_known() -> None:
    said = [probability(p) for p in (0.5, 0.02, 7.4e-5, 6e-29, 0.0)]
    assert said == ["p = 0.5", "p = 0.02", "p = 7.4×10⁻⁵", "p < 10⁻⁶", "p < 10⁻⁶"]


def test_a_sentence_ends_with_one_mark() -> None:
    assert [ended(text) for text in ("a", "a?", "a.", "a…")] == ["a.", "a?", "a.", "a…."]
    wrong = re.compile(r"\{(?:worded|together)\([^{}]*\)\}\.|\{(?:sentence|note|remark)\}\.")
    for path in (path for path in MODULES if path.name != "sentences.py"):
        found = wrong.search(path.read_text(encoding="utf-8"))
        assert found is None, f"{path}: {found and found[0]}: use ended()"
