"""Documents as text."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastocal.files.texts import finite, json_text

SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8)
DOCUMENTS = st.recursive(
    SCALARS,
    lambda inside: st.lists(inside, max_size=4) | st.dictionaries(st.text(max_size=4), inside),
    max_leaves=30,
)


@given(DOCUMENTS)
def test_json_is_what_the_library_writes(document: Any) -> None:
    expected = json.dumps(finite(document), indent=2, ensure_ascii=False) + "\n"
    assert json_text(document) == expected


@pytest.mark.parametrize("empty", [{}, [], {"a": []}, {"a": {}}, [[]], [{}]])
def test_nothing_in_it(empty: Any) -> None:
    assert json_text(empty) == json.dumps(empty, indent=2) + "\n"
