"""What a study says that plans are to withstand: a number, or limits."""

from __future__ import annotations

from pathlib import Path

import pytest

from elastocal.errors import StudyError
from elastocal.files.study.study_file import parse_study
from elastocal.study.robustness import Robustness
from tests.kr270 import FOLDER

TEXT = (FOLDER / "study.yaml").read_text("utf-8")
LINE = 1 + TEXT[: TEXT.index("  max_configurations")].count("\n")


def asked(value: str) -> Robustness | None:
    text = TEXT.replace("max_configurations: 3 ", f"robust: {value} ")
    return parse_study(text, Path("study.yaml")).experiments.robust


@pytest.mark.parametrize(
    ("value", "wish"),
    [
        ("1.25", Robustness(loss=1.25)),
        ("{loss: 1.25}", Robustness(loss=1.25)),
        ("{loss: 1.5, blind_um: 16}", Robustness(loss=1.5, blind=16e-6)),
        ("{within: 1.05}", Robustness(within=1.05)),
    ],
)
def test_forms(value: str, wish: Robustness) -> None:
    assert asked(value) == wish


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("1", "robust.*must be above 1 and finite, found 1"),
        ("{}", "give loss, blind or within"),
        ("{within: 0.95}", "within is how many times.*found 0.95"),
        ("{blind_um: 16, within: 1.05}", "give either blind"),
        ("{blind_um: 0}", "blind_um: expected a positive number, found 0"),
        ("{blind_mm: 0.016}", "blind_mm"),
        ("yes please", "expected a number"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(value: str, said: str) -> None:
    with pytest.raises(StudyError, match=f"(?s)line {LINE}.*{said}"):
        asked(value)
