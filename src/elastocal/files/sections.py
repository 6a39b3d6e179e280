"""Sections of files: what their keys may be, and every problem with its place.

A section is a class of annotated fields, called as the keys of the file are. An annotation is a
plain type, a list or dict of what may be there, a `Literal`, another section, or some of these
with `|`; `Annotated` adds what is checked and converted before and after. It is read when the
first file is, for importing a class of many keys takes no time then.
"""

from __future__ import annotations

import types
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    Self,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

Place = tuple[str | int, ...]
"""Keys, and entries from 0, that lead to something in a document."""
Check = Callable[[Any, Place, list["Mistake"]], Any]
"""What a value of a document is for us; what is wrong with it joins the list."""
_REQUIRED = object()
NOTHING: Any = None
"""Default of a key whose check says in its own words that it is missing."""
_PLAIN: dict[type, tuple[type | tuple[type, ...], str]] = {
    float: ((int, float), "a number"),
    int: (int, "a whole number"),
    str: (str, "a text"),
    bool: (bool, "true or false"),
}


@dataclass(frozen=True)
class Mistake:
    """One thing that is wrong.

    Attributes:
        place: Where it is; of a missing key, where it should be.
        said: What is wrong, behind the name of the key.
        kind: Whether a key is missing or unknown, or its value is wrong.
    """

    place: Place
    said: str = ""
    kind: Literal["wrong", "missing", "unknown"] = "wrong"


class SectionError(Exception):
    """A document is not as its section wants it: `problems` in the order of the keys."""

    def __init__(self, problems: list[Mistake]) -> None:
        super().__init__(problems[0].said)
        self.problems = tuple(problems)


@dataclass(frozen=True)
class Before:
    """`make` is given what the file has; the type is asked of what it returns."""

    make: Callable[[Any], Any]


@dataclass(frozen=True)
class After:
    """`make` is given a value of the type, and returns what the section has."""

    make: Callable[[Any], Any]


@dataclass(frozen=True)
class Variant:
    """What one of several forms is called; `Told` says which one a value has."""

    name: str


@dataclass(frozen=True)
class Told:
    """Tells the form of a value, so that errors speak of one form only."""

    by: Callable[[Any], str]


@dataclass(frozen=True)
class _Fresh:
    make: Callable[[], Any]


def fresh(make: Callable[[], Any]) -> Any:
    """A default value that is made anew for every section."""
    return _Fresh(make)


class Section:
    """A mapping of the file; unknown keys are errors.

    Fields are called as the keys of the file are; their values are in SI units, their defaults,
    as those of the file, in the unit of the key.

    Attributes:
        others: Keys that are no fields, where these are kept.
    """

    _unknown: ClassVar[Literal["refused", "kept", "ignored"]] = "refused"
    others: ClassVar[Mapping[str, Any]] = types.MappingProxyType({})

    def __init__(self, **keys: Any) -> None:
        problems: list[Mistake] = []
        self._take(keys, (), problems)
        if problems:
            raise SectionError(problems)

    @classmethod
    def of(cls, document: Any) -> Self:
        """The section that a document is.

        Raises:
            SectionError: it is not.
        """
        problems: list[Mistake] = []
        found = cls._checked(document, (), problems)
        if problems:
            raise SectionError(problems)
        return found

    def contradiction(self) -> str:
        """What keys say against each other, empty if nothing; asked where each alone is right."""
        return ""

    @classmethod
    def _checked(cls, value: Any, place: Place, problems: list[Mistake]) -> Any:
        if not isinstance(value, dict):
            return _wrong("a section of keys", value, place, problems)
        found = cls.__new__(cls)
        found._take(value, place, problems)
        return found

    def _take(self, value: dict[str, Any], place: Place, problems: list[Mistake]) -> None:
        before, section = len(problems), type(self)
        for key, check in _checks(section).items():
            may_lack, default = (True, None) if key in value else default_of(section, key)
            if may_lack:
                given = value.get(key, default)
                self.__dict__[key] = check(given, (*place, key), problems)
            else:
                problems.append(Mistake((*place, key), kind="missing"))
        others = {key: v for key, v in value.items() if key not in fields_of(section)}
        if self._unknown == "refused":
            problems += [Mistake((*place, key), kind="unknown") for key in others]
        elif self._unknown == "kept":
            self.__dict__["others"] = others
        if len(problems) == before and (said := self.contradiction()):
            problems.append(Mistake(place, said))


class OpenSection(Section):
    """A section that may say more than is looked at: what programs write for each other."""

    _unknown = "kept"


class PartSection(Section):
    """Some keys of a section, of which others are looked at elsewhere."""

    _unknown = "ignored"


def fields_of(section: type[Section]) -> Mapping[str, Any]:
    """The annotations of all fields, by key."""
    if section not in _HINTS:
        hints = get_type_hints(section, include_extras=True)
        _HINTS[section] = {k: hint for k, hint in hints.items() if get_origin(hint) is not ClassVar}
    return _HINTS[section]


def default_of(section: type[Section], key: str) -> tuple[bool, Any]:
    """Whether a key may be left out, and what it is then, as the file would have it."""
    default = getattr(section, key, _REQUIRED)
    return default is not _REQUIRED, default.make() if isinstance(default, _Fresh) else default


def _checks(section: type[Section]) -> Mapping[str, Check]:
    """The checks of all fields, by key."""
    if section not in _CHECKS:
        _CHECKS[section] = {key: _check(hint) for key, hint in fields_of(section).items()}
    return _CHECKS[section]


_HINTS: dict[type[Section], Mapping[str, Any]] = {}
_CHECKS: dict[type[Section], Mapping[str, Check]] = {}


def _check(hint: Any) -> Check:
    """What an annotation asks."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _annotated(parts[0], hint.__metadata__)
    if origin in (Union, types.UnionType):
        return _one_of([_check(part) for part in parts if part is not type(None)], parts)
    if origin is Literal:
        return _literal(parts)
    if origin is list:
        return _list(_check(parts[0]))
    if origin is dict:
        return _dict(_check(parts[0]), _check(parts[1]))
    if isinstance(hint, type) and issubclass(hint, Section):
        return hint._checked
    return _plain(hint)


def _annotated(hint: Any, metadata: tuple[Any, ...]) -> Check:
    told = next((part for part in metadata if isinstance(part, Told)), None)
    check = _check(hint) if told is None else _told(told.by, get_args(hint))
    for part in metadata:
        if isinstance(part, Before):
            check = _after(_making(part.make), check)
        elif isinstance(part, After):
            check = _after(check, _making(part.make))
    return check


def _making(make: Callable[[Any], Any]) -> Check:
    def check(value: Any, place: Place, problems: list[Mistake]) -> Any:
        try:
            return make(value)
        except ValueError as error:
            problems.append(Mistake(place, str(error)))
            return None

    return check


def _after(first: Check, then: Check) -> Check:
    """One check, and another of what comes out if nothing was wrong."""

    def check(value: Any, place: Place, problems: list[Mistake]) -> Any:
        before = len(problems)
        value = first(value, place, problems)
        return value if len(problems) > before else then(value, place, problems)

    return check


def _told(by: Callable[[Any], str], forms: tuple[Any, ...]) -> Check:
    checks = {
        part.name: _check(form)
        for form in forms
        for part in form.__metadata__
        if isinstance(part, Variant)
    }
    return lambda value, place, problems: checks[by(value)](value, place, problems)


def _one_of(checks: list[Check], parts: tuple[Any, ...]) -> Check:
    """The first that takes the value; what each of them says if none does."""

    def check(value: Any, place: Place, problems: list[Mistake]) -> Any:
        if value is None and type(None) in parts:
            return None
        found: list[Mistake] = []
        for check in checks:
            before = len(found)
            taken = check(value, place, found)
            if len(found) == before:
                return taken
        problems += found
        return None

    return check


def _literal(words: tuple[Any, ...]) -> Check:
    *first, last = map(repr, words)
    expected = f"{', '.join(first)} or {last}" if first else last

    def check(value: Any, place: Place, problems: list[Mistake]) -> Any:
        if any(type(value) is type(word) and value == word for word in words):
            return value
        problems.append(Mistake(place, f"expected {expected}, found {as_written(value)}"))
        return None

    return check


def _list(entry: Check) -> Check:
    def check(value: Any, place: Place, problems: list[Mistake]) -> Any:
        if not isinstance(value, list):
            return _wrong("a list", value, place, problems)
        return [entry(one, (*place, i), problems) for i, one in enumerate(value)]

    return check


def _dict(key: Check, entry: Check) -> Check:
    def check(value: Any, place: Place, problems: list[Mistake]) -> Any:
        if not isinstance(value, dict):
            return _wrong("a section of keys", value, place, problems)
        found = {}
        for name, one in value.items():
            here = (*place, name)
            found[key(name, here, problems)] = entry(one, here, problems)
        return found

    return check


def _plain(kind: Any) -> Check:
    """A plain type; true and false are no numbers. Whatever else is asked nothing of."""
    if kind not in _PLAIN:
        return lambda value, _, __: value
    types_, expected = _PLAIN[kind]

    def check(value: Any, place: Place, problems: list[Mistake]) -> Any:
        if not isinstance(value, types_) or (isinstance(value, bool) and kind is not bool):
            return _wrong(expected, value, place, problems)
        return kind(value)

    return check


def _wrong(expected: str, found: Any, place: Place, problems: list[Mistake]) -> None:
    plain = found is None or isinstance(found, (str, int, float))
    shown = as_written(found) if plain else type(found).__name__
    problems.append(Mistake(place, f"expected {expected}, found {shown}"))


def as_written(value: Any) -> str:
    """A value as a file has it: true for what Python calls True, nothing for None."""
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "nothing"}[value]
    return f"{value!r:.80}"
