"""Typed messages of the image server, for each of its operations; and how long a frame may take."""

from typing import Annotated

from msgspec import Meta

from bridge.messages import (
    COMMON_OPERATIONS,
    Describe,
    EventTold,
    Length,
    Message,
    NoArgs,
    Number,
    Operation,
    PoseMessage,
    Seed,
    Settings,
)

CAPTURE_S = 30.0
"""How long one waits for an image server's answer, s: a camera that has to wake up; chosen by hand."""
EXPOSURES_A_CAPTURE = 20
"""Exposures that a capture may take beside: those until settings hold, and its own; chosen by hand."""
MOST_CAPTURES = 10_000
"""Of a session: a simulator that begins anew lets them pass one by one, at most in 2 s; chosen by hand."""
Captures = Annotated[int, Meta(ge=0, le=MOST_CAPTURES)]


def capture_deadline_s(settings: Settings) -> float:
    """How long one waits for a frame under these settings, s."""
    return CAPTURE_S + EXPOSURES_A_CAPTURE * settings.shutter_s


class ImageCaptureArgs(Message, frozen=True):
    """`capture` of the image server; ``number`` says which of the session's captures it is."""

    settings: Settings
    number: Annotated[int, Meta(ge=1, le=MOST_CAPTURES)] | None = None


class ImageCaptureResult(Message, frozen=True):
    """Header of a frame; the frame itself is the reply's only array, (H, W) uint8 or uint16.

    ``timestamp`` is in seconds since 1970 (UTC), ``sha256`` is over the array's bytes in C order, ``events``
    are those of the scene that the frame is the first to see.
    """

    requested: Settings
    applied: Settings
    verified: bool
    sequence: Number
    timestamp: float
    devices: dict[str, str]
    sha256: Annotated[str, Meta(pattern=r"^[0-9a-f]{64}\Z")]
    events: tuple[EventTold, ...] = ()


class MoveArgs(Message, frozen=True):
    """`move`: bring the target to this range along its line of sight."""

    range_m: Length


class MoveDone(Message, frozen=True):
    """A `move` of a session so far: to this range, after so many captures."""

    range_m: Length
    captures_taken: Captures = 0


class RestartArgs(Message, frozen=True):
    """`restart`: be what a server started with this seed is after so many captures and these moves."""

    seed: Seed = 0
    captures_taken: Captures = 0
    moves: tuple[MoveDone, ...] = ()


class ScoreArgs(Message, frozen=True):
    """`score`: how far is this pose from the true one, where the target stands, or stood after so many moves?

    For reports only.
    """

    pose: PoseMessage
    moves: Number | None = None


class PoseErrorMessage(Message, frozen=True):
    """Distance of a pose from the true one."""

    rotation_deg: Annotated[float, Meta(ge=0)]
    translation_m: Annotated[float, Meta(ge=0)]
    translation_fraction_of_range: Annotated[float, Meta(ge=0)]


class MoveResult(Message, frozen=True):
    """`move`: where the target is now, and what that changed in the scene."""

    range_m: Length
    events: tuple[EventTold, ...]


class RestartResult(Message, frozen=True):
    """`restart`: what changed in the scene with the last capture or move."""

    events: tuple[EventTold, ...]


class ScoreResult(Message, frozen=True):
    """`score`: ``None`` where the true pose is not known."""

    error: PoseErrorMessage | None


IMAGE_OPERATIONS: dict[str, Operation] = {
    **COMMON_OPERATIONS,
    "describe": Operation(NoArgs, Describe),
    "capture": Operation(ImageCaptureArgs, ImageCaptureResult),
    "restart": Operation(RestartArgs, RestartResult),
    "move": Operation(MoveArgs, MoveResult),
    "score": Operation(ScoreArgs, ScoreResult),
}
"""The operations of an image server."""
