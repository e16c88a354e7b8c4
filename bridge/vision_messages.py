"""Typed messages of the vision server: the arguments and the result of each of its operations."""

from typing import Annotated, Any, Literal

from msgspec import Meta, field

from bridge.image_messages import PoseErrorMessage
from bridge.messages import (
    COMMON_OPERATIONS,
    EventTold,
    Fraction,
    ImageId,
    Message,
    NoArgs,
    Number,
    Operation,
    PoseMessage,
    Settings,
    Vector3,
)
from bridge.start_messages import (
    CauseTold,
    Covariance,
    NotNegative,
    RestoreArgs,
    StartArgs,
    StartResult,
)

Parameter = bool | int | float | str | dict[str, Any] | None
Seconds = dict[str, NotNegative]
MOST_TIME = 1e19
"""Of a frame, if in s: ns since 1970 are less, too, and what motion makes of such a time is finite."""
Time = Annotated[float, Meta(ge=-MOST_TIME, le=MOST_TIME)]


class VisionCaptureArgs(Message, frozen=True):
    """`capture` of the vision server: take a frame and call it ``image``; ``number`` goes on with it."""

    image: ImageId
    settings: Settings
    number: Annotated[int, Meta(ge=1)] | None = None


class AddArgs(Message, frozen=True):
    """`add`: the request's only array, (H, W) uint8 or uint16, is ``image``, taken under ``settings``."""

    image: ImageId
    settings: Settings


class RegionStatistics(Message, frozen=True):
    """How a region of a frame is exposed; intensities are linear shares of full scale."""

    mean: Fraction
    p05: Fraction
    p50: Fraction
    p95: Fraction
    dark_fraction: Fraction
    saturated_fraction: Fraction
    sharpness: Fraction
    noise: NotNegative


class FrameStatistics(RegionStatistics, frozen=True, kw_only=True):
    """Statistics of the target's region, of the whole ``frame``, and the blur of edges."""

    blur_px: NotNegative | None
    frame: RegionStatistics


class MovedTold(Message, frozen=True):
    """What an image shows elsewhere than all before it: by how much, px; its left, top, right, bottom."""

    shift_px: tuple[float, float]
    box_px: tuple[int, int, int, int]


class VisionCaptureResult(Message, frozen=True):
    """Result of `capture` and `add`: what the frame was taken under, and what is in it.

    ``surprise`` is what has happened before, where the frame is not as `predict` foresaw it; ``doubt`` is
    what may have happened, where nothing is sure. ``repeats`` is an earlier image of the set that is the very
    same picture.
    """

    image: ImageId
    applied: Settings
    verified: bool
    statistics: FrameStatistics
    seconds: Seconds
    surprise: CauseTold | None = None
    doubt: CauseTold | None = None
    events: tuple[EventTold, ...] = ()
    moved: MovedTold | None = None
    repeats: ImageId | None = None


class EstimateArgs(Message, frozen=True):
    """`estimate`: the pose from these images together."""

    images: Annotated[tuple[ImageId, ...], Meta(min_length=1, max_length=256)]


class LineTold(Message, frozen=True):
    """One model line: how much of it is visible, and how far the images support it."""

    line: Number
    visible_px: NotNegative
    support: float | None
    rms_px: NotNegative | None
    image: ImageId | None = None


class RivalTold(Message, frozen=True):
    """Another pose that the images allow, and its score as a share of the best one's."""

    pose: PoseMessage
    share: NotNegative


class PoseTold(Message, frozen=True):
    """One of the poses that fit, and the probability that it is the right one."""

    pose: PoseMessage
    probability: Fraction


class ModelExcess(Message, frozen=True):
    """A model that is too long along an axis by this share, beside its others; less than 0: too short."""

    axis: Literal["x", "y", "z"]
    share: float


class EstimateResult(Message, frozen=True):
    """Result of `estimate` and `best`; docs/pose.md explains each key."""

    pose: PoseMessage | None
    covariance: Annotated[Covariance, Meta(min_length=6, max_length=6)] | None
    rms_px: NotNegative | None
    uncertainty: NotNegative | None
    supported_fraction: Fraction
    score: float
    ambiguity: float
    lines: tuple[LineTold, ...]
    rivals: tuple[RivalTold, ...] = ()
    poses: tuple[PoseTold, ...] = ()
    free: tuple[Vector3, ...] = ()
    segments: Number = 0
    seconds: Seconds = field(default_factory=dict)
    model_wrong: ModelExcess | None = None


class PredictArgs(Message, frozen=True):
    """`predict`: what an image under each of these settings would add to a pose.

    Attributes
    ----------
    images
        The set that it would join; none: all that were taken and not discarded.
    search
        So many settings are looked for besides, from the best of those given. A light that is off in all of
        them stays off.
    """

    settings: Annotated[tuple[Settings, ...], Meta(min_length=1, max_length=4096)]
    images: Annotated[tuple[ImageId, ...], Meta(max_length=256)] = ()
    search: Annotated[int, Meta(ge=0, le=256)] = 0


class Gain(Message, frozen=True):
    """Information that an image would add, in bits, and the model line that gains most."""

    bits: float
    line: Number


class FoundSettings(Gain, frozen=True, kw_only=True):
    """Settings that search came upon, and what they would add."""

    settings: Settings


class PredictResult(Message, frozen=True):
    """A gain for each of the settings, ``None`` while there is no pose; what search found, best first."""

    gains: tuple[Gain, ...] | None
    found: tuple[FoundSettings, ...] = ()


class AppraiseArgs(Message, frozen=True):
    """`appraise`: how rich an image's gradients are."""

    image: ImageId


class AppraiseResult(Message, frozen=True):
    """The tone curve under which they would be richest: below 1 the image wants more light."""

    gamma: float


class TrackArgs(Message, frozen=True):
    """`track`: the next frame of a moving target, which is the request's one array, (H, W) uint8 or uint16.

    Attributes
    ----------
    time_s
        When it was taken; ``None`` where nothing tells, and frames come 30 a second.
    """

    time_s: Time | None = None


class TrackResult(Message, frozen=True):
    """`track`; docs/tracking.md explains each key."""

    frame: Number
    state: Literal["sure", "unsure", "lost"]
    pose: PoseMessage | None
    covariance: Annotated[Covariance, Meta(min_length=6, max_length=6)] | None
    seconds: NotNegative
    note: str = ""


class CheckArgs(Message, frozen=True):
    """`check`: whether a pose from anywhere is right, by these images of the set."""

    pose: PoseMessage
    images: Annotated[tuple[ImageId, ...], Meta(min_length=1, max_length=4096)]


class CheckResult(Message, frozen=True):
    """`check`; docs/check.md explains each key."""

    probability: Fraction
    state: Literal["ok", "doubtful", "lost"]
    better: PoseMessage | None
    better_probability: Fraction | None
    covariance: Annotated[Covariance, Meta(min_length=6, max_length=6)] | None
    difference: PoseErrorMessage | None
    disagreeing_lines: tuple[Number, ...]
    disagreeing_images: tuple[str, ...] = ()


class DiscardArgs(Message, frozen=True):
    """`discard`: forget an image."""

    image: ImageId


class DiscardResult(Message, frozen=True):
    """The images that are left."""

    image: ImageId
    images: tuple[ImageId, ...]


ParametersArgs = dict[str, Parameter]
"""`parameters`: new values by name (none: only ask); the vision server knows names and ranges."""


VISION_OPERATIONS: dict[str, Operation] = {
    **COMMON_OPERATIONS,
    "start": Operation(StartArgs, StartResult),
    "capture": Operation(VisionCaptureArgs, VisionCaptureResult),
    "add": Operation(AddArgs, VisionCaptureResult),
    "estimate": Operation(EstimateArgs, EstimateResult),
    "track": Operation(TrackArgs, TrackResult),
    "check": Operation(CheckArgs, CheckResult),
    "discard": Operation(DiscardArgs, DiscardResult),
    "best": Operation(NoArgs, EstimateResult),
    "appraise": Operation(AppraiseArgs, AppraiseResult),
    "predict": Operation(PredictArgs, PredictResult),
    "parameters": Operation(ParametersArgs, dict[str, Any]),
    "restore": Operation(RestoreArgs, StartResult),
    "end": Operation(NoArgs, NoArgs),
}
"""The operations of a vision server."""
