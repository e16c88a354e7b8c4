"""What to do about a value that is not of its type, by msgspec's complaint."""

import re
from difflib import get_close_matches
from typing import Any

from msgspec import inspect


def remedy(complaint: str, kind: Any) -> str:
    """What may be meant by an unknown key or word; nothing where something else is wrong."""
    # of a word of a megabyte it is not asked what is near it
    said = re.match(
        r"(Object contains unknown field `|Invalid enum value ')(.{1,64}?)[`'](?: - at `\$(.*)`)?$", complaint
    )
    if said is None:
        return ""
    trouble, word, path = said.groups()
    tables = [inspect.type_info(kind)]
    for name in re.findall(r"\.(\w+)|\[", path or ""):  # a number or anything else in brackets has no name
        tables = [inner for table in tables for inner in _inside(table, name)]
    if trouble.startswith("Object"):
        known = [name for table in tables for name in _keys(table)]
    else:
        known = [str(value) for table in tables for value in getattr(table, "values", ())]
    near = get_close_matches(word, known, 1)
    if near:
        return f"Did you mean {near[0]}?"
    return f"There are {', '.join(sorted(set(known)))}." if known else ""


def _alternatives(table: Any) -> list[Any]:
    return list(getattr(table, "types", [table]))


def _keys(table: Any) -> dict[str, Any]:
    """Keys of a table, with the types of their values."""
    return {
        field.encode_name: field.type
        for field in getattr(table, "fields", ())
        if hasattr(field, "encode_name")
    }


def _inside(table: Any, name: str) -> list[Any]:
    """Types of what stands under a key, or in a list without one."""
    if name:
        inner = [_keys(table)[name]] if name in _keys(table) else []
    else:
        inner = [*getattr(table, "item_types", ()), *filter(None, [getattr(table, "item_type", None)])]
    return [one for found in inner for one in _alternatives(found)]
