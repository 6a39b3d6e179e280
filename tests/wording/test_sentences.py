"""Every code has one sentence, and what is computed is apart from what is said."""

from __future__ import annotations

import ast
from typing import get_args

import numpy as np
import pytest

from elastocal.errors import Code, Doubt
from elastocal.wording import SENTENCES, worded
from tests.test_architecture import MAY_IMPORT, MODULES, room_of

CORE = set(MAY_IMPORT) - set(
    ["wording", "programs", "drawing", "files", "report", "viewer", "terminal", "cli"]
)


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
            Doubt("carried", ("A1",), ("E1", "E2"), {"error_ratio": np.inf}),
            "A1: carried by the repeated experiments E1, E2; without them nothing is known of "
            "these joints, and no other load case checks them",
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
    ],
    ids=lambda value: value.code if isinstance(value, Doubt) else "",
)
def test_sentences_say_names_and_numbers(doubt: Doubt, sentence: str) -> None:
    assert worded(doubt) == sentence


def test_what_computes_words_only_what_it_raises() -> None:
    """The core hands on codes and numbers; only the text of an error is a sentence."""
    for path in MODULES:
        if room_of(path) not in CORE:
            continue
        nodes = list(ast.walk(ast.parse(path.read_text())))
        calls = {n for n in nodes if isinstance(n, ast.Name) and n.id == "worded"}
        raised = [ast.walk(node) for node in nodes if isinstance(node, ast.Raise)]
        assert calls <= {node for part in raised for node in part}, path
