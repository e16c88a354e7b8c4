"""TOML files as typed tables: unknown keys and wrong types are errors that name file and key."""

import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import tomli_w

from bridge.errors import BadInput


class Table(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of the tables: every key is known, every value has its type."""


T = TypeVar("T")

LEAST_LENGTH = 1e-9  # of a direction, chosen by hand: the square of a smaller one may be no number any more
MOST_BYTES = 16 * 1024 * 1024  # of a TOML file: a recorded stack of 5000 frames has one sixteenth


def read_toml(file: Path, what: str) -> dict[str, Any]:
    """Plain values of a TOML file; `what` it is, for people.

    Raises
    ------
    BadInput : no such file, not readable, too large, not TOML.
    """
    try:
        return tomllib.loads(read_text(file, what, "TOML"))
    except ValueError as error:
        raise BadInput(f"{file} is not valid TOML: {error}.", "Correct the file.") from None


def read_text(file: Path, what: str, kind: str) -> str:
    """What a file holds that is to be of a kind, such as TOML; `what` it is, for people.

    Raises
    ------
    BadInput : no such file, not readable, too large, not UTF-8.
    """
    try:
        with file.open("rb") as stream:
            content = stream.read(MOST_BYTES + 1)
    except FileNotFoundError:
        raise BadInput(f"There is no {what} {file}.", "Check the name.") from None
    except OSError as error:
        raise BadInput(f"Cannot read {what} {file}: {error.strerror or error}.", "Check the path.") from None
    if len(content) > MOST_BYTES:
        raise BadInput(f"The {what} {file} has more than {MOST_BYTES} bytes.", f"Give a {kind} file.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise BadInput(
            f"{file} is not valid {kind}: it is no text in UTF-8, from line {line} on.",
            "Save it as UTF-8.",
        ) from None


def as_table(values: Any, kind: type[T], file: Path) -> T:
    """Typed table of plain values.

    Raises
    ------
    BadInput : an unknown or missing key, or a value of the wrong type or out of range.
    """
    where = _not_finite(values, "")
    if where is not None:
        raise BadInput(f"{file}: {where} is not a finite number.")
    try:
        return msgspec.convert(values, kind)
    except msgspec.ValidationError as error:
        from bridge.remedy import remedy

        advice = remedy(str(error), kind) or _brackets(str(error))
        raise BadInput(f"{file}: {plain_message(str(error))}", advice) from None


def check_direction(vector: Sequence[float], key: str, file: Path, advice: str) -> None:
    """Raise BadInput for a direction that is none: its length is 0, or nearly so."""
    if math.hypot(*vector) < LEAST_LENGTH:
        raise BadInput(f"{file}: {key} has no length.", advice)


def _brackets(complaint: str) -> str:
    """What to write where a table has one pair of brackets for two, or two for one."""
    said = re.fullmatch(r"Expected `(array|object)\b.*`, got `(array|object)` - at `\$\.(\w+)`", complaint)
    if said is None:
        return ""
    wanted, got, name = said.groups()
    if wanted == got:
        return ""
    return f"Write [[{name}]], as often as there are some." if wanted == "array" else f"Write [{name}]."


def toml_text(values: Mapping[str, Any]) -> str:
    """Plain values as TOML; None, which TOML has not, is left out."""
    return tomli_w.dumps(_without_none(values))


def _without_none(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [_without_none(item) for item in value]
    return value


def _not_finite(value: Any, where: str) -> str | None:
    """Where a NaN or an infinity stands in plain values; None where there is none."""
    if isinstance(value, float):
        return None if math.isfinite(value) else where
    items: list[tuple[str, Any]] = []
    if isinstance(value, dict):
        items = [(f"{where}.{key}".lstrip("."), item) for key, item in value.items()]
    elif isinstance(value, list):
        items = [(f"{where} {number}", item) for number, item in enumerate(value, 1)]
    return next((found for place, item in items if (found := _not_finite(item, place)) is not None), None)


def plain_message(text: str) -> str:
    """A msgspec complaint in the words of a TOML file: keys and tables, no objects and no `$`."""
    message, _, where = text.partition(" - at ")
    message = message.replace("Object contains unknown field", "unknown key")
    message = message.replace("Object missing required field", "missing key").replace("`object`", "`table`")
    message = message.replace("Invalid enum value", "unknown word")
    path = where.strip("`").removeprefix("$").lstrip(".")
    path = re.sub(r"\[(\d+)\]", lambda found: f" {int(found.group(1)) + 1}", path)
    path = path.replace("[...]", "")
    message = message[:1].lower() + message[1:]
    return f"{message} in [{path}]." if path else f"{message}."
