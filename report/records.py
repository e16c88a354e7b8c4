"""`result.json` as typed records: the fields of it that the report reads.

Fields that the report does not know are left alone, since the session's record may grow; a field it
does know must have the right type.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta, Struct, field

from bridge.errors import BadInput
from bridge.result_file import decoded_result
from report.errors import ReportError

Triple = Annotated[list[float], Meta(min_length=3, max_length=3)]
Six = Annotated[list[float], Meta(min_length=6, max_length=6)]
Covariance = Annotated[list[Six], Meta(min_length=6, max_length=6)]


class PoseRecord(Struct, frozen=True):
    """camera_T_target: rotation vector (rad) and translation (m)."""

    rotation_vector: Triple
    translation: Triple


class ErrorRecord(Struct, frozen=True):
    """Difference from the true pose, where that is known."""

    rotation_deg: float
    translation_m: float
    translation_fraction_of_range: float


class SettingsRecord(Struct, frozen=True):
    """One level per light, shutter (s), aperture (f-number), focal length (mm) and focus (m)."""

    lights: list[float] = field(default_factory=list)
    shutter_s: float | None = None
    aperture: float | None = None
    focal_length_mm: float | None = None
    focus_m: float | None = None


class LineRecord(Struct, frozen=True):
    """How well the images support one model line: its share of supported px, 0 to 1."""

    line: int
    support: float
    visible_px: float | None = None
    rms_px: float | None = None


class LightRecord(Struct, frozen=True):
    """A light's name, its number of levels, off included, and its place in the camera frame, m."""

    name: str | None = None
    levels: int | None = None
    position: Triple | None = None


class CandidateRecord(Struct, frozen=True):
    """Settings that could be chosen, and what was predicted of an image under them.

    Attributes
    ----------
    brightness, highlight : median and 95th percentile of the target, fractions of full scale.
    information : of the place of an edge, bit; with the likelihood's part it makes the promise.
    bits, line : what it was predicted to add to the pose, and to which model line most; or a promise.
    """

    words: str = ""
    state: str | None = None
    promise: float | None = None
    likelihood: float | None = None
    information: float | None = None
    bits: float | None = None
    line: int | None = None
    brightness: float | None = None
    highlight: float | None = None
    blur_px: float | None = None
    dark: float | None = None
    saturated: float | None = None


class ReasonRecord(Struct, frozen=True):
    """Why the controller did something, as session/reasons.pl tells it: chosen, seen or measured."""

    kind: str
    chosen: CandidateRecord | None = None
    best: list[CandidateRecord] = []
    candidates: int = 0
    left_out_alike: int = 0
    left_out_unfavourable: int = 0
    quality: str = ""
    expected: CandidateRecord | None = None
    seen: CandidateRecord | None = None
    rms_px: float | None = None
    merit: float | None = None


class StepRecord(Struct, frozen=True):
    """One iteration: an image, its settings, and what the controller made of it."""

    iteration: int | None = None
    image: str | None = None
    settings: SettingsRecord | None = None
    asked: SettingsRecord | None = None
    settings_words: str | None = None
    qualitative: str | None = None
    decision: str | None = None
    reason: str | None = None
    set_size: int | None = None
    rms_px: float | None = None
    merit: float | None = None
    supported_fraction: float | None = None
    uncertainty: float | None = None
    pose: PoseRecord | None = None
    error: ErrorRecord | None = None
    lines: list[LineRecord] | None = None
    hold: int | None = None


class HoldRecord(Struct, frozen=True):
    """One hold point of an approach."""

    range_m: float
    status: str = ""
    rms_px: float | None = None
    merit: float | None = None
    pose: PoseRecord | None = None
    covariance: Covariance | None = None
    uncertainty: float | None = None
    error: ErrorRecord | None = None
    lines: list[LineRecord] | None = None
    iterations: int | None = None
    kept: list[str] | None = None


class Result(Struct, frozen=True):
    """A whole session as its run folder tells it (docs/architecture.md)."""

    status: str
    controller: str | None = None
    target: str | None = None
    scenario: str | None = None
    stack: str | None = None
    seed: int | None = None
    iterations: int | None = None
    kept: list[str] = field(default_factory=list)
    rms_px: float | None = None
    merit_px: float | None = None
    threshold_px: float | None = None
    pose: PoseRecord | None = None
    covariance: Covariance | None = None
    uncertainty: float | None = None
    score: float | None = None
    error: ErrorRecord | None = None
    seconds: dict[str, float | None] = field(default_factory=dict)
    steps: list[StepRecord] = field(default_factory=list)
    lines: list[LineRecord] | None = None
    lights: list[LightRecord] | None = None
    holds: list[HoldRecord] | None = None
    planned_holds_m: list[float] | None = None
    command: str | list[str] | None = None
    message: str | None = None
    advice: list[str] = field(default_factory=list)


def read_result(folder: Path) -> Result:
    """Read RUN_FOLDER/result.json.

    Raises
    ------
    ReportError : no such folder, no result.json in it, broken JSON, a field of the wrong type.
    """
    if not folder.is_dir():
        raise ReportError(f"{folder}: no such folder; give the run folder of a session (--out of main.pl)")
    path = folder / "result.json"
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        raise ReportError(
            f"{folder}: no result.json in it; is it the run folder of a session that has ended?"
        ) from error
    except OSError as error:
        raise ReportError(f"{path}: cannot be read ({error.strerror})") from error
    try:
        return decoded_result(path, data, Result)
    except BadInput as error:
        raise ReportError(str(error)) from error
    except msgspec.ValidationError as error:
        raise ReportError(f"{path}: {error}; run the session again or correct that field") from error
    except msgspec.DecodeError as error:
        raise ReportError(f"{path}: not valid JSON ({error}); run the session again") from error
