"""`python -m bridge schema`: the JSON Schema of `result.json`, for `session/result.schema.json`."""

import json
from argparse import ArgumentParser, Namespace
from typing import Any

from bridge.result_file import result_schema

COLUMNS = 110  # what is no longer stands on one line


def add_options(parser: ArgumentParser) -> None:
    """It has none."""


def run(options: Namespace) -> None:
    """Print it."""
    print(laid_out(result_schema()))


def laid_out(value: Any, indent: str = "") -> str:
    """A value as JSON; objects that do not fit on a line have a line for each of their keys."""
    text = json.dumps(value)
    if not isinstance(value, dict) or len(indent) + len(text) < COLUMNS:
        return text
    inner = indent + "  "
    lines = ",\n".join(f"{inner}{json.dumps(key)}: {laid_out(one, inner)}" for key, one in value.items())
    return f"{{\n{lines}\n{indent}}}"
