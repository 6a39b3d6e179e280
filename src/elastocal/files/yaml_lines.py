"""YAML that remembers its lines, and refuses what people do not mean.

Repeated keys, aliases and tags are errors: in a study file they are mistakes, or hostile. A number
is what everybody reads as the same number. YAML 1.1 has more: 02500 is 1344 there, 1:30:00 is 5400.
Such words, and dates, are text here: where a number belongs the section refuses them by their key.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml

from elastocal.errors import InputError, StudyError

Path_ = tuple[str | int, ...]
NUMBER = re.compile(r"[-+]?((0|[1-9]\d*)(\.\d*)?|\.\d+)([eE][-+]?\d+)?", re.ASCII)
"""A number, in decimal and without leading zeros."""
_WHOLE = re.compile(r"[-+]?\d+", re.ASCII)
_LONGEST = 100  # characters of a number
_WORDS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
_UNSEEN = re.compile(
    "[\\x00-\\x08\\x0b\\x0c\\x0e-\\x1f\\x7f-\\x9f\\u2028\\u2029\\ud800-\\udfff\\ufffe\\uffff]"
)
"""What YAML does not have, and what it takes for ends of lines where nobody sees one."""
_NOT_FINITE = re.compile(r"([-+]?)\.(inf|Inf|INF)|(\.(nan|NaN|NAN))")


class Located:
    """A parsed document: plain values, and the line of every key.

    Attributes:
        value: Dictionaries, lists and scalars.
        file: Where it came from.
    """

    def __init__(self, value: Any, lines: dict[Path_, int], file: Path) -> None:
        self.value, self._lines, self.file = value, lines, file

    def line(self, path: Path_) -> int:
        """Line of the deepest known part of `path`."""
        while path and path not in self._lines:
            path = path[:-1]
        return self._lines.get(path, 1)

    def where(self, path: Path_) -> str:
        """'study.yaml, line 12' for the deepest known part of `path`; the file if no line is."""
        return f"{self.file}, line {self.line(path)}" if self._lines else str(self.file)


class LocatedError(InputError):
    """An error at a key below the section being read."""

    def __init__(self, path: Path_, message: str) -> None:
        super().__init__(message)
        self.path = path


@contextmanager
def at(*path: str | int) -> Iterator[None]:
    """Within, every error knows where it belongs: at `path`, or at its own path below that."""
    try:
        yield
    except LocatedError as error:
        error.path = (*path, *error.path)
        raise
    except InputError as error:
        raise LocatedError(path, str(error)) from None


def parse(text: str, file: Path) -> Located:
    """Parse a YAML document.

    Raises:
        StudyError: not YAML, a control character, a repeated key, an alias, or nested without
            measure.
    """
    if found := _UNSEEN.search(text):
        before = text[: found.start()].replace("\r\n", "\n").replace("\r", "\n")
        line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
        raise StudyError(
            f"{file}, line {line}, column {column}: character U+{ord(found[0]):04X} is no text; "
            "remove it"
        )
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
        if node is None:
            raise StudyError(f"{file}: the file is empty")
        lines: dict[Path_, int] = {}
        value = _construct(node, (), lines, set(), file)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f", line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        raise StudyError(f"{file}{place}: not valid YAML: {error.problem}") from None
    except yaml.YAMLError as error:
        reason = str(error).splitlines()[0]
        raise StudyError(f"{file}: not valid YAML: {reason}") from None
    except RecursionError:
        raise StudyError(f"{file}: nested too deeply") from None
    return Located(value, lines, file)


def _construct(
    node: yaml.Node, path: Path_, lines: dict[Path_, int], seen: set[int], file: Path
) -> Any:
    line = node.start_mark.line + 1
    if id(node) in seen:  # the node has the line of its anchor: say that of the key instead
        raise StudyError(
            f"{Located(None, lines, file).where(path)}: YAML aliases are not supported; repeat the "
            "value"
        )
    seen.add(id(node))
    lines.setdefault(path, line)
    if node.tag not in _own_tags(node):
        raise StudyError(f"{file}, line {line}: YAML tags such as {node.tag!r} are not supported")
    if isinstance(node, yaml.ScalarNode):
        if NUMBER.fullmatch(node.value) and len(node.value) > _LONGEST:
            raise StudyError(
                f"{Located(None, lines, file).where(path)}: expected a number of at most "
                f"{_LONGEST} characters, found one of {len(node.value)}"
            )
        return node.value if node.style else _plain(node.value)
    if isinstance(node, yaml.SequenceNode):
        return [_construct(n, (*path, i), lines, seen, file) for i, n in enumerate(node.value)]
    result: dict[str, Any] = {}
    assert isinstance(node, yaml.MappingNode)
    for key_node, value_node in node.value:
        key = str(getattr(key_node, "value", key_node))
        line = key_node.start_mark.line + 1
        if not isinstance(key_node, yaml.ScalarNode):
            raise StudyError(f"{file}, line {line}: a key must be a word")
        if key in result:
            raise StudyError(f"{file}, line {line}: key {key!r} appears twice")
        lines[(*path, key)] = line
        result[key] = _construct(value_node, (*path, key), lines, seen, file)
    return result


def number(word: str) -> int | float | None:
    """The number that a word is, None if it is none or longer than numbers are."""
    if len(word) > _LONGEST or not NUMBER.fullmatch(word):
        return None
    return int(word) if _WHOLE.fullmatch(word) else float(word)


def _own_tags(node: yaml.Node) -> tuple[str, ...]:
    """The tags that a node has if nobody wrote one."""
    if not isinstance(node, yaml.ScalarNode):
        return ("tag:yaml.org,2002:map", "tag:yaml.org,2002:seq")
    unsaid = (not node.style, bool(node.style))
    resolve: Any = yaml.SafeLoader("").resolve
    return (resolve(yaml.ScalarNode, node.value, unsaid),)


def _plain(word: str) -> str | float | bool | None:
    """What a word without quotes means: nothing, yes or no, a number, or itself."""
    if word in ("", "~", "null", "Null", "NULL"):
        return None
    if word in (word.lower(), word.capitalize(), word.upper()) and word.lower() in _WORDS:
        return _WORDS[word.lower()]
    if (value := number(word)) is not None:
        return value
    if found := _NOT_FINITE.fullmatch(word):
        return float("nan") if found[3] else float(f"{found[1]}inf")
    return word
