"""XML of strangers, read without trust: no document types, no entities, no depths.

In: bytes. Out: plain nodes that know their line. The parser is the one of the standard library;
what makes XML dangerous needs a document type, and a robot file has none.
"""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass, field
from xml.parsers import expat

from elastocal.errors import InputError
from elastocal.reading import is_character_set

_DEEPEST, _MOST = 100, 200_000
_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
    (b"<\0", "utf-16-le"),
    (b"\0<", "utf-16-be"),
)
"""How a file in each encoding begins, if it is not one that holds ASCII as it is."""
_DECLARED = re.compile(rb"""\s*<\?xml[^>]{0,80}?\sencoding\s*=\s*["']([A-Za-z0-9._-]{1,40})["']""")
_DECLARATION = re.compile(r"\A\s*<\?xml\s[^>]{0,200}\?>")


@dataclass
class Node:
    """One element.

    Attributes:
        tag: Its name, with prefix.
        place: "arm.urdf, line 12", for messages.
        attributes: Attributes by name.
        children: Elements inside, in order.
        text: The text directly inside, if it was asked for.
    """

    tag: str
    place: str
    attributes: dict[str, str] = field(default_factory=dict)
    children: list[Node] = field(default_factory=list)
    text: str = ""

    def all(self, tag: str) -> list[Node]:
        """Children called `tag`."""
        return [child for child in self.children if child.tag == tag]

    def error(self, message: str) -> InputError:
        """An error that says where it is."""
        return InputError(f"{self.place}: {message}")


def parse_xml(data: bytes, where: str, *, texts: bool = False) -> Node:
    """The root element of `data`; `where` names the file in messages; `texts` are kept on demand.

    Raises:
        InputError: not well-formed, with a document type, nested too deeply or too long.
    """
    builder = _Builder(where)
    text = decoded(data, where)
    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True
    parser.StartElementHandler = lambda tag, found: builder.start(
        tag, found, parser.CurrentLineNumber
    )
    parser.EndElementHandler = lambda _: builder.end()
    if texts:
        parser.CharacterDataHandler = builder.text
    parser.StartDoctypeDeclHandler = lambda *_: builder.refuse(
        parser.CurrentLineNumber,
        "a document type (<!DOCTYPE>) is not accepted, nor are entities; remove it",
    )
    try:
        parser.Parse(text.encode(), True)
    except expat.ExpatError as error:
        raise InputError(
            f"{where}, line {error.lineno}, column {error.offset + 1}: not valid XML: "
            f"{expat.ErrorString(error.code)}"
        ) from None
    assert builder.root is not None
    return builder.root


def decoded(data: bytes, where: str) -> str:
    """The text of `data`: by its byte order mark, else as it declares, else UTF-8.

    What declares the encoding is blanked. `where` names the file in messages.

    Raises:
        InputError: it is not in that encoding, or the encoding is not known.

    Source: Extensible Markup Language (XML) 1.0, appendix F.
    """
    marked = next((name for mark, name in _MARKS if data.startswith(mark)), "")
    declared = _DECLARED.match(data)
    said = declared[1].decode() if declared else ""
    encoding = marked or said or "utf-8"
    try:
        if not is_character_set(encoding):
            raise LookupError
        text = data.decode(encoding)
        # What declares the encoding is done with, also behind blank lines, which XML forbids.
        return _DECLARATION.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text, count=1)
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        mend = (
            "mend that byte or what it declares"
            if said or marked
            else 'save it as UTF-8, or let it begin with <?xml version="1.0" encoding="…"?>'
        )
        how = "begins" if marked else "is said to be" if said else "is taken to be"
        raise InputError(
            f"{where}, line {line}: byte 0x{data[error.start]:02X} is not {encoding.upper()}, as "
            f"which the file {how}; {mend}"
        ) from None
    except LookupError:
        raise InputError(
            f"{where}, line 1: encoding {said[:40]!r} is not known; save the file as UTF-8"
        ) from None


class _Builder:
    """Puts the nodes together while the parser reads."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.root: Node | None = None
        self.count = 0
        self.open: list[Node] = []
        self.texts: list[list[str]] = []

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
        self.texts.append([])

    def text(self, piece: str) -> None:
        """A piece of text."""
        self.texts[-1].append(piece)

    def end(self) -> None:
        """An element ends."""
        self.open.pop().text = "".join(self.texts.pop())

    def refuse(self, line: int, why: str) -> None:
        """Stop reading."""
        raise InputError(f"{self.where}, line {line}: {why}")
