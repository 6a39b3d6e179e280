"""Sections: what is taken, what it becomes, and where each problem is."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import pytest

from elastocal.files.schema import json_schema
from elastocal.files.sections import (
    NOTHING,
    After,
    Before,
    OpenSection,
    PartSection,
    Section,
    SectionError,
    Told,
    Variant,
    fresh,
)


def _above(value: Any) -> Any:
    if value is None or value < 0:
        raise ValueError("expected more than nothing")
    return value


Length = Annotated[float, Before(_above), After(lambda value: value / 1e3)]
Either = Annotated[
    Annotated[Length, Variant("one")] | Annotated[dict[str, Length], Variant("by name")],
    Told(lambda value: "by name" if isinstance(value, dict) else "one"),
]


class Part(Section):
    """A part."""

    length_mm: Length = 20.0


class Whole(Section):
    """Of every kind."""

    name: str
    sign: Literal[1, -1] = 1
    axis: Literal["x", "y"] | list[float] | None = None
    parts: list[Part] = fresh(list)
    radius_mm: Either | None = None
    self: bool = True
    anything: Any = None


def problems(section: type[Section], document: Any) -> list[tuple[str, Any, str]]:
    with pytest.raises(SectionError) as caught:
        section.of(document)
    return [(one.kind, one.place, one.said) for one in caught.value.problems]


def test_values_and_defaults_are_converted() -> None:
    whole = Whole.of({"name": "a", "parts": [{}, {"length_mm": 5}], "radius_mm": {"b": 7}})
    assert [part.length_mm for part in whole.parts] == [0.02, 0.005]
    assert whole.radius_mm == {"b": 0.007}
    assert (whole.sign, whole.axis, whole.self) == (1, None, True)
    assert Whole.of({"name": "a"}).parts is not Whole.of({"name": "a"}).parts
    assert Whole(name="b", axis=[1, 2.5]).axis == [1.0, 2.5]


def test_problems_come_in_the_order_of_the_keys_with_their_places() -> None:
    document = {
        "sign": True,
        "parts": [{}, {"length_mm": -1, "width": 2}],
        "radius_mm": {"b": -1},
        "self": "yes",
    }
    assert problems(Whole, document) == [
        ("missing", ("name",), ""),
        ("wrong", ("sign",), "expected 1 or -1, found true"),
        ("wrong", ("parts", 1, "length_mm"), "expected more than nothing"),
        ("unknown", ("parts", 1, "width"), ""),
        ("wrong", ("radius_mm", "b"), "expected more than nothing"),
        ("wrong", ("self",), "expected true or false, found 'yes'"),
    ]


@pytest.mark.parametrize(
    ("document", "said"),
    [
        ({"name": 1}, "expected a text, found 1"),
        ({"name": None}, "expected a text, found nothing"),
        ({"name": "a", "sign": 1.0}, "expected 1 or -1, found 1.0"),
        ({"name": "a", "parts": {}}, "expected a list, found dict"),
        ({"name": "a", "parts": [3]}, "expected a section of keys, found 3"),
        ({"name": "a", "axis": [True]}, "expected a number, found true"),
        ([], "expected a section of keys, found list"),
    ],
)
def test_what_is_of_another_kind_is_said(document: Any, said: str) -> None:
    assert said in [sentence for _, _, sentence in problems(Whole, document)]


def test_other_keys_are_refused_kept_or_left() -> None:
    class Open(OpenSection):
        a: int = 0

    class Some(PartSection):
        a: int = 0

    assert Open.of({"a": 1, "b": 2}).others == {"b": 2}
    assert Some.of({"a": 1, "b": 2}).others == {}
    assert problems(Part, {"b": 2}) == [("unknown", ("b",), "")]


def test_a_check_says_itself_that_its_key_is_missing() -> None:
    class Asked(PartSection):
        length_mm: Length = NOTHING

    assert problems(Asked, {}) == [("wrong", ("length_mm",), "expected more than nothing")]


def test_a_contradiction_is_asked_for_where_each_key_is_right() -> None:
    class Pair(Section):
        low: int
        high: int

        def contradiction(self) -> str:
            return "low is above high" if self.low > self.high else ""

    assert Pair.of({"low": 1, "high": 2}).high == 2
    assert problems(Pair, {"low": 3, "high": 2}) == [("wrong", (), "low is above high")]
    assert problems(Pair, {"low": 3, "high": "2"}) == [
        ("wrong", ("high",), "expected a whole number, found '2'")
    ]


def test_the_schema_says_the_same() -> None:
    schema = json_schema(Whole)
    assert schema["required"] == ["name"]
    assert schema["additionalProperties"] is False
    assert schema["properties"]["sign"] == {"enum": [1, -1], "default": 1}
    assert schema["properties"]["parts"] == {
        "type": "array",
        "items": {"$ref": "#/$defs/Part"},
        "default": [],
    }
    assert schema["$defs"]["Part"]["properties"]["length_mm"] == {
        "type": "number",
        "default": 20.0,
    }
    assert schema["properties"]["anything"] == {"default": None}


def test_what_is_none_of_the_words_is_shown_as_it_stands() -> None:
    (wrong,) = problems(Whole, {"name": "a", "sign": [1]})
    assert wrong[2] == "expected 1 or -1, found [1]"
