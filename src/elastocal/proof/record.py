"""The record of a proof as a file: the statement, and the tree of boxes that shows it.

A zip archive of `statement.json` and `tree`, a byte a box in depth-first order: the variable that
is halved, or 255 for a leaf. Of a search that has ended before, 253 is a box that nobody has
looked at and 254 one that is too small to be halved. For going on there are `top`, the tree down
to the parts that are searched one by one, and `parts.json`: their lengths in `tree`, and what is
proved of them.
"""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path

import numpy as np

from elastocal.arrays import Array
from elastocal.core.layout import PENDING
from elastocal.errors import InputError
from elastocal.proof.folded import folded
from elastocal.proof.plain_data import as_data, from_data
from elastocal.proof.statement import Statement
from elastocal.proof.tree import BoxTree, Region, halves, joined, proved, symbols_of

_PACKED = 4_000_000  # bytes of a tree from which on packing well takes too long


def proof_bytes(statement: Statement, root: Region) -> bytes:
    """The file of a proof, or of a search for one that has not ended."""
    assert root.settled is not None
    table = bytearray(range(256))  # boxes have the variables that move, the record has them all
    for k, variable in enumerate(folded(statement).variables.tolist()):
        table[k] = variable
    inner = [symbols_of(part) for part in root.settled.parts]
    symbols = joined(root.settled.symbols, inner).translate(table)
    parts = [(len(own), proved(part)) for own, part in zip(inner, root.settled.parts, strict=True)]
    packing = zipfile.ZIP_LZMA if len(symbols) < _PACKED else zipfile.ZIP_DEFLATED
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", packing) as archive:
        archive.writestr("statement.json", json.dumps(as_data(statement), indent=1))
        archive.writestr("tree", symbols)
        archive.writestr("top", root.settled.symbols.translate(table))
        archive.writestr("parts.json", json.dumps(parts))
    return file.getvalue()


def read_proof(path: Path) -> tuple[Statement, Region]:
    """The statement of a proof file, and its tree in parts, to go on with.

    Raises:
        InputError: it is no such file.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            data = json.loads(archive.read("statement.json"))
            symbols, top = archive.read("tree"), archive.read("top")
            parts = [
                (int(length), float(bound))
                for length, bound in json.loads(archive.read("parts.json"))
            ]
    except (OSError, ValueError, KeyError, zipfile.BadZipFile, TypeError) as error:
        raise InputError(f"{path} is no proof file that can be gone on with ({error})") from error
    statement = from_data(data)
    variables = folded(statement).variables
    table = bytearray(range(256))
    for k, variable in enumerate(variables.tolist()):
        table[variable] = k
    symbols, top = symbols.translate(table), top.translate(table)
    boxes = _boxes(top, len(variables))
    if len(boxes) != len(parts):
        raise InputError(f"{path}: its tree has {len(boxes)} parts, and {len(parts)} are described")
    inside = [i for i, symbol in enumerate(top) if symbol == PENDING]
    found, at = [], 0
    for k, (box, (length, bound)) in enumerate(zip(boxes, parts, strict=True)):
        start = inside[k] - k + at  # what stands before it in `tree`
        own = symbols[start : start + length]
        known = (
            BoxTree(bound, own, ()) if np.isfinite(bound) and bytes([PENDING]) not in own else None
        )
        found.append(Region(box, known))
        at += length
    root = Region(np.full(2 * len(variables), 0.5), BoxTree(0.0, top, tuple(found)))
    return statement, root


def _boxes(top: bytes, variables: int) -> list[Array]:
    """(2a,) boxes of the parts of a tree, in the order of their symbols."""
    found, way = [], [np.full(2 * variables, 0.5)]
    for symbol in top:
        box = way.pop()
        if symbol == PENDING:
            found.append(box)
        if symbol >= PENDING:
            continue
        way += reversed(halves(box, symbol))
    return found
