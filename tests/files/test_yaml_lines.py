"""Words of YAML: what is a number, what is yes or no, what is itself."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from elastocal.errors import StudyError
from elastocal.files.yaml_lines import NUMBER, parse
from tests.cli.test_bad_studies import GOOD, run

FILE = Path("study.yaml")
NUMBERS = {
    "0": 0, "7": 7, "-7": -7, "+7": 7, "2500": 2500, "1.5": 1.5, "-.5": -0.5, ".5": 0.5, "5.": 5.0,
    "1e3": 1000.0, "1E3": 1000.0, "1e-8": 1e-8, "-2.5e+3": -2500.0, ".5e1": 5.0, "0.0": 0.0,
    "0e0": 0.0, "-0": 0, "1e999": math.inf, "9" * 100: int("9" * 100),
}  # fmt: skip
OTHERS = (
    "010", "02500", "-012", "+08", "09", "00", "007.5", "00.5", "0o17", "0O17", "0x1F", "-0xff",
    "0b11", "1_000", "2_500", "1_0.5", "1:30:00", "-1:30", "1:30.5", "190:20:30", "1e", "1e+",
    "e5", "1.2.3", "--1", "+-1", "1 000", "1,5", "1.5mm", "٣", "１２", "²", "2024-01-05",
    "2024-99-99", "2024-01-05T10:00:00Z", "12:30:45", "=", "<<", ".", "-.", "inf", "nan",
    ".infinity", "0x", "1e5.5",
)  # fmt: skip
PLAIN_WORDS: dict[str, Any] = {
    "true": True, "True": True, "yes": True, "on": True, "ON": True, "false": False, "no": False,
    "off": False, "Off": False, "null": None, "~": None, "Null": None, "y": "y", "n": "n",
    "tRUE": "tRUE", ".inf": math.inf, "-.inf": -math.inf, "+.INF": math.inf,
}  # fmt: skip


@pytest.mark.parametrize("word", NUMBERS)
def test_numbers(word: str) -> None:
    value = parse(f"a: {word}", FILE).value["a"]
    assert value == NUMBERS[word]
    assert type(value) is type(NUMBERS[word])


@pytest.mark.parametrize("word", [w for w in OTHERS if w not in ("=", "<<")])
def test_words_that_are_no_numbers_are_themselves(word: str) -> None:
    assert parse(f"a: {word}\nb: [{word.replace(',', '.')}]", FILE).value["a"] == word


@pytest.mark.parametrize("word", PLAIN_WORDS)
def test_words_with_a_meaning(word: str) -> None:
    assert parse(f"a: {word}", FILE).value["a"] == PLAIN_WORDS[word]
    assert parse(f"a: '{word}'", FILE).value["a"] == word, "in quotes every word is itself"


@pytest.mark.parametrize(
    "sign", ["\0", "\x07", "\x1b", "\x7f", "\x85", "\x9b", "\u2028", "\u2029", "\ufffe", "\ud800"]
)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_control_characters_are_refused_with_their_place(sign: str, end: str) -> None:
    text = end.join(["a: 1", "# µ", f"bcd: 'x{sign}y'", "e: 2"])
    with pytest.raises(StudyError) as caught:
        parse(text, FILE)
    said = f"study.yaml, line 3, column 8: character U+{ord(sign):04X} is no text; remove it"
    assert str(caught.value) == said


def test_not_a_number() -> None:
    assert math.isnan(parse("a: .nan", FILE).value["a"])


@given(st.text(alphabet="0123456789+-.eE_:xob", min_size=1, max_size=8))
@example("1:30:00")
@example("0777")
def test_a_number_is_what_everybody_reads_as_the_same(word: str) -> None:
    """Python, JSON and YAML 1.1 agree on it wherever they take it for a number."""
    if not NUMBER.fullmatch(word):
        return
    assert math.isfinite(float(word)) or "e" in word.lower()
    value = parse(f"a: {word}", FILE).value["a"]
    assert value == float(word)
    old = yaml.safe_load(f"a: {word}")["a"]
    assert isinstance(old, str) or old == value


@pytest.mark.parametrize("word", [*OTHERS[:33], ".inf", "-.inf", ".nan", "1e999", "yes", "~"])
@pytest.mark.parametrize(
    ("key", "place"),
    [
        ("force_N: [0, 0, -2500]", "force_N: [0, 0, {}]"),
        ("count: 12", "count: {}"),
        ("sigma_mm: 0.03", "sigma_mm: {}"),
        ("min_z_mm: 800", "min_z_mm: {}"),
        ("max_deg: 30", "max_deg: {}"),
    ],
)
def test_other_words_are_refused_where_a_number_belongs(
    word: str, key: str, place: str, tmp_path: Path
) -> None:
    if word == "~" and key.startswith(("min_z", "max_deg")):
        return  # nothing said
    text = GOOD.replace(key, place.format(f'"{word}"' if "," in word else word))
    assert text != GOOD
    line = text[: text.rindex(place.split(":")[0] + ":")].count("\n") + 1
    study = tmp_path / "study.yaml"
    study.write_text(text, encoding="utf-8")
    code, said = run("check", study)
    assert code == 2, said
    assert f"study.yaml, line {line}" in said
    assert place.split(":")[0] in said
    assert said.count("\n") == 1


@pytest.mark.parametrize("word", ["010", "0x1F", "1:30:00", "2024-99-99", "2024-01-05", "2_500"])
def test_names_are_as_they_are_written(word: str, tmp_path: Path) -> None:
    study = tmp_path / "study.yaml"
    study.write_text(GOOD.replace("name: milling", f"name: {word}", 1), encoding="utf-8")
    assert run("check", study)[0] == 0
    assert parse(GOOD.replace("name: milling", f"name: {word}", 1), FILE).value


@pytest.mark.parametrize(
    ("text", "place"),
    [
        (f"a: 1\nb: {'9' * 5000}", "line 2: expected a number of at most 100 characters"),
        (f"a: 1\nb: [1, -{'0' * 5}.{'1' * 5000}]", None),
        ("a: 1\nb: !!int x", "line 2: YAML tags such as 'tag:yaml.org,2002:int'"),
        ("a: 1\nb: !!str 010", "line 2: YAML tags"),
        ("a: 1\nb: !!timestamp 2024", "line 2: YAML tags"),
        ("a: 1\nb: !!binary x", "line 2: YAML tags"),
        ("a: 1\nb: !!float x", "line 2: YAML tags"),
        ("a: 1\nb: !x y", "line 2: YAML tags"),
        ("a: 1\nb: !!python/name:os.system", "line 2: YAML tags"),
        ("!!set {a, b}", "line 1: YAML tags"),
    ],
)
def test_what_is_refused_has_its_line(text: str, place: str | None) -> None:
    if place is None:
        assert isinstance(parse(text, FILE).value["b"][1], str)
        return
    with pytest.raises(StudyError, match=place):
        parse(text, FILE)
