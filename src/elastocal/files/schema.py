"""The JSON schema of a section, for editors that complete and check what is typed."""

from __future__ import annotations

import inspect
import types
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from elastocal.files.sections import OpenSection, Section, default_of, fields_of

_WORDS: dict[Any, dict[str, Any]] = {
    float: {"type": "number"},
    int: {"type": "integer"},
    str: {"type": "string"},
    bool: {"type": "boolean"},
    type(None): {"type": "null"},
}


def json_schema(section: type[Section]) -> dict[str, Any]:
    """The JSON schema (draft 2020-12) of files that are such a section.

    Numbers and names are asked for by their types alone; the reader asks more.
    """
    known: dict[str, Any] = {}
    whole = _section(section, known)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **whole, "$defs": known}


def _section(section: type[Section], known: dict[str, Any]) -> dict[str, Any]:
    keys = {}
    for key, hint in fields_of(section).items():
        given, default = default_of(section, key)
        keys[key] = _of(hint, known) | ({"default": default} if given else {})
    return {
        "title": section.__name__,
        "description": inspect.getdoc(section) or "",
        "type": "object",
        "properties": keys,
        "required": [key for key in keys if not default_of(section, key)[0]],
        "additionalProperties": issubclass(section, OpenSection),
    }


def _of(hint: Any, known: dict[str, Any]) -> dict[str, Any]:
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _of(parts[0], known)
    if origin in (Union, types.UnionType):
        return {"anyOf": [_of(part, known) for part in parts]}
    if origin is Literal:
        return {"enum": list(parts)}
    if origin is list:
        return {"type": "array", "items": _of(parts[0], known)}
    if origin is dict:
        return {"type": "object", "additionalProperties": _of(parts[1], known)}
    if isinstance(hint, type) and issubclass(hint, Section):
        if hint.__name__ not in known:
            known[hint.__name__] = {}  # it may be in itself
            known[hint.__name__] = _section(hint, known)
        return {"$ref": f"#/$defs/{hint.__name__}"}
    return dict(_WORDS.get(hint, {}))
