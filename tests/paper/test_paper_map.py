"""docs/paper-map.md: every item of the paper is there once, and what is named there exists."""

from __future__ import annotations

import re
from collections import Counter
from typing import NamedTuple

import pytest

import elastocal as ec
from tests.test_docs import COMMANDS, DOCS, ROOT, words

MAP = DOCS / "paper-map.md"
ITEMS = {
    *(f"({number})" for number in range(1, 39)),
    *(f"A{number}" for number in range(1, 5)),
    *(f"D{number}" for number in range(1, 4)),
    *(f"Table {number}" for number in range(1, 8)),
    *(f"Fig. {number}" for number in range(1, 10)),
}
NOT_YET = "not in this version"


class Row(NamedTuple):
    """One row of the map."""

    item: str
    says: str
    here: str
    held: str


def rows() -> list[Row]:
    found = []
    for line in MAP.read_text("utf-8").splitlines():
        if line.startswith("|") and not line.startswith(("| paper", "|---")):
            # A bar inside, as in |F|, has no space on both sides.
            found.append(
                Row(*(cell.strip() for cell in re.split(r"(?:^\| | \| | \|$)", line)[1:5]))
            )
    return found


def test_every_item_of_the_paper_is_there_once() -> None:
    named = Counter(
        item.strip() for row in rows() for item in row.item.split(", ") if item.strip() in ITEMS
    )
    assert set(named) == ITEMS, sorted(ITEMS - set(named))
    assert not [item for item, times in named.items() if times > 1]


def test_the_pattern_notices_what_is_missing() -> None:
    """The negative control."""
    assert "(39)" not in ITEMS
    assert {"(1)", "(38)", "A4", "D3", "Table 7", "Fig. 9"} <= ITEMS


@pytest.mark.parametrize("row", rows(), ids=lambda row: f"{row.item} {row.says}"[:40])
def test_a_row_says_where_and_which_test(row: Row) -> None:
    assert row.says
    assert row.here
    tests = re.findall(r"`(tests/[\w/]+\.py)(?:::(\w+))?`", row.held)
    assert tests or NOT_YET in row.here
    for file, function in tests:
        text = (ROOT / file).read_text("utf-8")
        assert not function or f"def {function}(" in text
    for name in re.findall(r"`ec\.(\w+)", row.here):
        assert name in ec.__all__
    for command in re.findall(r"`elastocal (\w+)", row.here):
        assert command in COMMANDS


def test_keys_of_studies_are_those_of_the_format() -> None:
    known = words(DOCS / "file-formats.md") | words(DOCS / "how-to-choose.md")
    for row in rows():
        for span in re.findall(r"`([^`]+)`", row.here):
            if re.fullmatch(r"[a-z][\w]*(: [\w-]+)?", span):
                assert set(re.findall(r"[\w-]+", span)) <= known, span
