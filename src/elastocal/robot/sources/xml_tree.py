"""XML of strangers, read without trust: no document types, no entities, no depths.

In: bytes. Out: plain nodes that know their line. The parser is the one of the standard library;
what makes XML dangerous needs a document type, and a robot file has none.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from xml.parsers import expat

from elastocal.errors import InputError

_DEEPEST, _MOST = 100, 200_000


@dataclass
class Node:
    """One element.

    Attributes:
        tag: Its name, with prefix.
        place: "arm.urdf, line 12", for messages.
        attributes: Attributes by name.
        children: Elements inside, in order; text is left out.
    """

    tag: str
    place: str
    attributes: dict[str, str] = field(default_factory=dict)
    children: list[Node] = field(default_factory=list)

    def all(self, tag: str) -> list[Node]:
        """Children called `tag`."""
        return [child for child in self.children if child.tag == tag]

    def error(self, message: str) -> InputError:
        """An error that says where it is."""
        return InputError(f"{self.place}: {message}")


def parse_xml(data: bytes, where: str) -> Node:
    """The root element of `data`; `where` names the file in messages.

    Raises:
        InputError: not well-formed, with a document type, nested too deeply or too long.
    """
    builder = _Builder(where)
    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler = lambda tag, found: builder.start(
        tag, found, parser.CurrentLineNumber
    )
    parser.EndElementHandler = lambda _: builder.end()
    parser.StartDoctypeDeclHandler = lambda *_: builder.refuse(
        parser.CurrentLineNumber,
        "a document type (<!DOCTYPE>) is not accepted, nor are entities; remove it",
    )
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise InputError(
            f"{where}, line {error.lineno}, column {error.offset + 1}: not valid XML: "
            f"{expat.ErrorString(error.code)}"
        ) from None
    except (ValueError, LookupError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{where}: not valid XML: {error}") from None
    assert builder.root is not None
    return builder.root


class _Builder:
    """Puts the nodes together while the parser reads."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.root: Node | None = None
        self.count = 0
        self.open: list[Node] = []

    def start(self, tag: str, attributes: dict[str, str], line: int) -> None:
        """An element begins."""
        self.count += 1
        if self.count > _MOST:
            self.refuse(line, f"more than {_MOST} elements")
        if len(self.open) >= _DEEPEST:
            self.refuse(line, f"elements are nested more than {_DEEPEST} deep")
        node = Node(tag, f"{self.where}, line {line}", attributes)
        if self.open:
            self.open[-1].children.append(node)
        else:
            self.root = node
        self.open.append(node)

    def end(self) -> None:
        """An element ends."""
        self.open.pop()

    def refuse(self, line: int, why: str) -> None:
        """Stop reading."""
        raise InputError(f"{self.where}, line {line}: {why}")
