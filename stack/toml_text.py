"""Plain values as TOML text, for the files that this server writes."""

import json
from collections.abc import Mapping, Sequence
from typing import Any


def toml_text(values: Mapping[str, Any], name: str = "") -> str:
    """A table as TOML: plain keys, then tables, then lists of tables. None is left out.

    Numbers are written so that they read back as they are.
    """
    lines = [
        f"{key} = {_value(value)}"
        for key, value in values.items()
        if value is not None and not _is_table(value) and not _is_tables(value)
    ]
    parts = ["\n".join(lines)] if lines else []
    for key, value in values.items():
        path = f"{name}.{key}" if name else key
        if _is_table(value) and value:
            parts.append(_headed(f"[{path}]", toml_text(value, path)))
        elif _is_tables(value):
            parts += [_headed(f"[[{path}]]", toml_text(entry, path)) for entry in value]
    return "\n\n".join(part.rstrip("\n") for part in parts) + "\n"


def _headed(head: str, body: str) -> str:
    return f"{head}\n{body}" if not body.startswith("[") else body


def _is_table(value: Any) -> bool:
    return isinstance(value, Mapping)


def _is_tables(value: Any) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, str) and bool(value) and _is_table(value[0])


def _value(value: Any) -> str:
    # JSON's strings, numbers, lists and booleans are TOML as they stand
    return json.dumps(value, ensure_ascii=False)
