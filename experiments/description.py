"""What a table is of: the plan, its settings, the code, and the files and values that names stand for."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from bridge.errors import BadInput, DeviceError
from bridge.whole_file import replaced
from experiments.kinds import KINDS
from experiments.plan import PlanSettings
from geometry.errors import GeometryError
from geometry.model import files_of_model
from stack.format import STACK_FILE
from stack.tables import plain_message

FORMAT = 1
DESCRIPTION = "plan.json"
OURS = "Give the folder that a run has written, as it was written."
Named = Mapping[str, Mapping[str, Any]]
"""By axis of a plan and name on it."""


class _Description(msgspec.Struct):
    """What must be told of a table."""

    plan: str
    version: str
    controllers: list[str]
    cells: int
    settings: PlanSettings
    sources: dict[str, dict[str, Any]]
    contents: dict[str, dict[str, str]] = {}


def agreed(
    folder: Path, description: Mapping[str, Any], version: str, check: Callable[[str, str], None]
) -> dict[str, Any]:
    """The description that the folder's rows have from now on; the one it has must fit.

    Parameters
    ----------
    check : of axis and name of what stands for something else than before; raises where it may not.
    """
    mine = {
        "format": FORMAT, "version": version, **description, "contents": _contents(description["sources"])
    }  # fmt: skip
    if (folder / DESCRIPTION).exists():
        theirs = read_description(folder)
        _check_fits(folder, theirs, mine)
        for axis, named in theirs.get("contents", {}).items():
            for name, content in named.items():
                if mine["contents"].get(axis, {}).get(name, content) != content:
                    check(axis, name)
        for key in ("sources", "contents"):  # rows may be of names that the plan no longer has
            mine[key] = {axis: theirs.get(key, {}).get(axis, {}) | named for axis, named in mine[key].items()}
    try:
        with replaced(folder / DESCRIPTION) as new:
            new.write_text(json.dumps(mine, indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise DeviceError(f"Cannot write to {folder}: {error.strerror}.", "Nothing was run.") from None
    return mine


def _check_fits(folder: Path, theirs: Mapping[str, Any], mine: Mapping[str, Any]) -> None:
    if theirs["version"] != mine["version"]:
        raise BadInput(
            f"{folder} holds rows of version {theirs['version']}; this is {mine['version']}.",
            "Rows of two versions are not compared: name another folder, or check out that version.",
        )
    for key, value in theirs["settings"].items():
        said = mine["settings"].get(key)
        if value != said and key != "deadline_s":
            raise BadInput(
                f"{folder} holds cells with {key} = {value}; this plan says {said}.", "Name another folder."
            )


def _contents(sources: Named) -> dict[str, dict[str, str]]:
    """Digests of a plan's files and conditions; what is the project's own is told by its version."""
    return {
        axis: {
            name: _digest(axis, source)
            for name, source in named.items()
            if axis == "conditions" or Path(source).is_absolute()
        }
        for axis, named in sources.items()
    }


def _digest(axis: str, source: Any) -> str:
    if axis == "conditions":
        return hashlib.sha256(json.dumps(source, sort_keys=True).encode()).hexdigest()
    files = [Path(source) / STACK_FILE if axis == "stacks" else Path(source)]
    if axis == "targets":
        appearance = files[0].with_suffix(".toml")
        try:
            files = files_of_model(files[0]) + ([appearance] if appearance.is_file() else [])
        except GeometryError as error:
            raise BadInput(f"{error}.") from None
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def read_description(folder: Path) -> dict[str, Any]:
    """What the table in a folder is of.

    Raises
    ------
    BadInput : there is none, or one of a format that this version does not read.
    """
    file = folder / DESCRIPTION
    try:
        found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        table_format = found["format"]
    except (OSError, ValueError, KeyError, TypeError):
        raise BadInput(f"{folder} holds no experiment.", "Name the --out folder of a run.") from None
    if table_format != FORMAT:
        raise BadInput(
            f"The table in {folder} has format {table_format}; this version reads format {FORMAT}.",
            "Name another folder, or use the version that wrote it.",
        )
    try:
        kind = msgspec.convert(found, _Description).settings.kind
    except msgspec.ValidationError as error:
        raise BadInput(f"{file}: {plain_message(str(error))}", OURS) from None
    if kind not in KINDS:
        raise BadInput(f"{file}: there is no kind {kind!r}.", OURS)
    return found
