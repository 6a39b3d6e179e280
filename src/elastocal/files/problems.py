"""What is said of a file that is not as its sections want it: the first problem, with its line."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator
from typing import Any, get_args

from elastocal.files.sections import Mistake, Section, SectionError, fields_of
from elastocal.files.tables.units import UNITS
from elastocal.files.yaml_lines import Located, Path_
from elastocal.names import shown

_WORDS = [*(unit.replace(".", "") for units in UNITS.values() for unit in units), "inch", "Nm2"]
_UNIT = rf"_({'|'.join(map(re.escape, [*_WORDS, 'min', 's', 'h']))})(_s)?$"


def first_problem(document: Located, error: SectionError, model: type[Section]) -> str:
    """A sentence on the first thing that is wrong, with its line.

    Args:
        document: The file.
        error: What its section says of it.
        model: What the whole file should be.
    """
    # A misspelt key is also reported as missing: one mistake, one message.
    spoilt = {one.place[:-1] for one in error.problems if one.kind == "unknown"}
    problems = sorted(
        _described(document, one, model)
        for one in error.problems
        if one.kind != "missing" or one.place[:-1] not in spoilt
    )
    more = len({line for (line, _), _ in problems}) - 1
    rest = f" (and {more} more line{'s' if more > 1 else ''} to mend)" if more > 0 else ""
    return problems[0][1] + rest


def _described(
    document: Located, one: Mistake, model: type[Section]
) -> tuple[tuple[int, int], str]:
    """((line, -depth), sentence) for one problem."""
    path = one.place
    if one.kind == "unknown":
        sentence = f"unknown key {path[-1]!r}{_suggestion(document.value, path, model)}"
    elif one.kind == "missing":
        parent = _spelled(path[:-1])
        sentence = f"key {path[-1]!r} is missing" + (f" in {parent}" if parent else "")
    else:
        sentence = f"{_spelled(path)}: {one.said}"
    # A missing key has no line of its own, so it comes last; on one line the deepest comes first.
    place = (document.line(path) + (1_000_000 if one.kind == "missing" else 0), -len(path))
    return place, f"{document.where(path)}: {sentence}"


def _spelled(path: Path_) -> str:
    """'test_poses.q_deg, entry 2' for a path; entries of lists counted from 1, the last only."""
    words = ".".join(shown(part) for part in path if isinstance(part, str))
    last = path[-1] if path else ""
    return f"{words}, entry {last + 1}" if isinstance(last, int) else words


def _suggestion(value: Any, path: Path_, model: type[Section]) -> str:
    """What the unknown key at the end of `path` was probably meant to be."""
    key, likely = str(path[-1]), [model]
    for part in path[:-1]:
        value = value[part]
        field = fields_of(model).get(str(part))
        # Of several forms of a section, the one of which most keys are there, but not this one.
        forms = list(_parts(field)) if field else []
        forms = [form for form in forms if key not in fields_of(form)] or forms
        shared = [len(fields_of(form).keys() & _keys(value)) for form in forms]
        likely = [f for f, n in zip(forms, shared, strict=True) if n == max(shared)] or [model]
        model = likely[0]
    allowed = list(dict.fromkeys(name for form in likely for name in fields_of(form)))
    stem = re.sub(_UNIT, "", key)
    with_unit = [name for name in allowed if re.sub(_UNIT, "", name) == stem]
    if with_unit and with_unit[0] != key:
        if stem == key:
            return f": the key has no unit, write {with_unit[0]!r}"
        nearest = difflib.get_close_matches(key, with_unit, 1, 0.0)[0]
        return f": this unit is not accepted here, write {nearest!r}"
    close = difflib.get_close_matches(key, allowed, 1)
    if close:
        return f"; did you mean {close[0]!r}?"
    return f"; expected one of {', '.join(allowed)}"


def _keys(value: Any) -> set[str]:
    return set(value) if isinstance(value, dict) else set()


def sections_of(model: type[Section]) -> Iterator[type[Section]]:
    """A section and all that are below it."""
    yield model
    for field in fields_of(model).values():
        for part in _parts(field):
            yield from sections_of(part)


def _parts(annotation: Any) -> Iterator[type[Section]]:
    """The sections that a type names."""
    if isinstance(annotation, type) and issubclass(annotation, Section):
        yield annotation
    for part in get_args(annotation):
        yield from _parts(part)
