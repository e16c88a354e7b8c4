"""A session's `result.json` as typed records, for those who read it; session/folder/result.pl writes it.

A reader also meets files of earlier versions, which have fewer keys, and of later ones, which have more: a
key that is missing has a default, one that is not known is left alone, and one that is known must have the
right type. The JSON Schema states what this version writes, and no other keys; docs/result.md explains them.
"""

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta, Struct, field

from bridge.errors import BadInput
from bridge.image_messages import PoseErrorMessage
from bridge.messages import Fraction, Number, PoseMessage, Positive, Seed, Vector3
from bridge.start_messages import Covariance as Rows
from bridge.start_messages import NotNegative
from bridge.vision_messages import ModelExcess, PoseTold

FORMAT = 1  # its `version`, by session/folder/result.pl
SOMETIMES = frozenset(
    {"advice", "asked", "error", "estimated_with", "free", "hold", "holds", "message", "model_wrong",
     "planned_holds_m", "poses"}
)  # fmt: skip
"""Keys that stand there only where they have something to tell; all others always do."""
NULLABLE = frozenset(
    {"ambiguity", "covariance", "levels", "pose", "rms_px", "scenario", "score", "stack",
     "supported_fraction", "threshold_px", "uncertainty"}
)  # fmt: skip
"""Keys whose value may be null; any other that is None here was missing from the file."""

Covariance = Annotated[Rows, Meta(min_length=6, max_length=6)]
Some = Meta(min_length=1)
Merit = Annotated[float, Meta(ge=0, le=100)]
Counted = Annotated[int, Meta(ge=1)]
Image = Annotated[str, Meta(extra_json_schema={"pattern": "^i[1-9][0-9]*$"})]
Sha256 = Annotated[str, Meta(extra_json_schema={"pattern": "^[0-9a-f]{64}$"})]
ORDER = ["rotation_x", "rotation_y", "rotation_z", "translation_x", "translation_y", "translation_z"]
Order = Annotated[list[str], Meta(extra_json_schema={"const": ORDER})]
Seconds = Annotated[
    dict[str, NotNegative], Meta(extra_json_schema={"required": ["total", "controller", "bridge"]})
]


def _words(*words: str) -> Meta:
    """The words that this version writes; a reader takes others, too."""
    return Meta(extra_json_schema={"enum": list(words)})


Decision = Annotated[str, _words("keep", "discard")]


class SettingsRecord(Struct, frozen=True):
    """One level for each light, shutter (s) and aperture (f-number)."""

    lights: list[Number] = []
    shutter_s: Positive | None = None
    aperture: Positive | None = None


class LineRecord(Struct, frozen=True):
    """A visible model line: how long it is, which share of that the images support, and its RMS error, px."""

    line: Number
    support: Fraction
    visible_px: NotNegative | None = None
    rms_px: NotNegative | None = None


class LightTold(Struct, frozen=True):
    """A light's name and its number of levels, off included; null for a light that died."""

    name: str | None = None
    levels: Counted | None = None


class Estimated(Struct, frozen=True, kw_only=True):
    """An estimate: camera_T_target in rad and m, RMS error in px, and how far it can be trusted.

    The uncertainty is the largest standard deviation: 0.01 is 1 % of the range or 1 degree.
    """

    pose: PoseMessage | None = None
    rms_px: NotNegative | None = None
    uncertainty: NotNegative | None = None
    supported_fraction: Fraction | None = None
    score: Fraction | None = None
    ambiguity: Fraction | None = None
    lines: list[LineRecord] | None = None
    error: PoseErrorMessage | None = None


class StepRecord(Estimated, frozen=True, kw_only=True):
    """One iteration: an image, its settings, and what the controller made of it."""

    iteration: Counted | None = None
    image: str | None = None
    settings: SettingsRecord | None = None
    asked: SettingsRecord | None = None
    settings_words: str | None = None
    qualitative: str | None = None
    decision: Decision | None = None
    reason: str | None = None
    set_size: Number | None = None
    merit: Merit | None = None
    hold: Counted | None = None


class HoldRecord(Estimated, frozen=True, kw_only=True):
    """One hold point of an approach, its range in m."""

    range_m: Positive
    status: Annotated[str, _words("fixed", "reached", "aborted")] = ""
    merit: Merit | None = None
    covariance: Covariance | None = None


class EstimatedWith(Struct, frozen=True):
    """The vision server's parameters at the session's end, and the SHA-256 of images/stack.toml."""

    parameters: dict[str, Any]
    stack_sha256: Sha256 | None = None


class Result(Estimated, frozen=True, kw_only=True):
    """What came of one session. Lengths are in m, angles in rad, unless a name says otherwise."""

    version: Literal[1] = 1
    units: dict[str, str] = {}
    covariance_order: Order = []
    status: Annotated[str, _words("converged", "exhausted", "stopped")]
    controller: str | None = None
    target: str | None = None
    scenario: str | None = None
    stack: str | None = None
    lights: list[LightTold] | None = None
    seed: Seed | None = None
    command: str | None = None
    iterations: Number | None = None
    kept: list[Image] = []
    discarded: list[Image] = []
    merit_px: Merit | None = None
    threshold_px: Positive | None = None
    seconds: Seconds = field(default_factory=dict)
    steps: list[StepRecord] = []
    planned_holds_m: Annotated[list[Positive], Some] | None = None
    holds: list[HoldRecord] | None = None
    covariance: Covariance | None = None
    poses: Annotated[list[PoseTold], Some] | None = None
    free: Annotated[list[Vector3], Some] | None = None
    model_wrong: ModelExcess | None = None
    message: str | None = None
    advice: list[str] = []
    estimated_with: EstimatedWith | None = None


class _Versioned(Struct, frozen=True):
    version: Any = None


def read_result(folder: Path) -> Result:
    """Read RUN_FOLDER/result.json.

    Raises
    ------
    BadInput
        No such folder, no result.json in it, broken JSON, another format, a field of the wrong type.
    """
    if not folder.is_dir():
        raise BadInput(f"{folder}: no such folder;", "give the run folder of a session (--out of main.pl)")
    file = folder / "result.json"
    try:
        data = file.read_bytes()
        version = msgspec.json.decode(data, type=_Versioned).version
        if version in (None, FORMAT):
            return msgspec.json.decode(data, type=Result)
    except FileNotFoundError as error:
        hint = "is it the run folder of a session that has ended?"
        if (folder / "history.pl").exists():
            named = shlex.quote(str(folder))
            hint = f"its session has not ended. Where it was killed, --resume {named} goes on."
        raise BadInput(f"{folder}: no result.json in it;", hint) from error
    except OSError as error:
        raise BadInput(f"{file}: cannot be read ({error.strerror})") from error
    except msgspec.ValidationError as error:
        raise BadInput(f"{file}: {error};", "run the session again or correct that field") from error
    except msgspec.DecodeError as error:
        raise BadInput(f"{file}: not valid JSON ({error});", "run the session again") from error
    raise BadInput(
        f"{file}: of format {version}, and this version reads format {FORMAT};",
        "use the version that wrote it.",
    )


def result_schema() -> dict[str, Any]:
    """The JSON Schema of what this version writes."""
    _, tables = msgspec.json.schema_components([Result], ref_template="#/$defs/{name}")
    for table in tables.values():
        keys = table["properties"]
        table["properties"] = {name: _as_written(name, kind) for name, kind in keys.items()}
        table["required"] = [name for name in keys if name not in SOMETIMES]
        table["additionalProperties"] = False
    result = tables.pop("Result") | {"title": f"result.json, version {FORMAT}"}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **result, "$defs": tables}


def _as_written(name: str, kind: Mapping[str, Any]) -> dict[str, Any]:
    """The schema of a key's value without what only readers need: its default, and null for a missing key."""
    written = {part: value for part, value in kind.items() if part != "default"}
    kinds = [one for one in written.pop("anyOf", []) if name in NULLABLE or one != {"type": "null"}]
    return written | kinds[0] if len(kinds) == 1 else written | ({"anyOf": kinds} if kinds else {})
