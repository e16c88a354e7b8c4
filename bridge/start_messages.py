"""Typed messages that begin a session of the vision server, or one that goes on."""

from typing import Annotated, Any, Literal, get_args

from msgspec import Meta, field

from bridge.messages import (
    CameraDescription,
    Describe,
    Endpoint,
    FileName,
    ImageId,
    Message,
    Number,
    PoseMessage,
    Seed,
    Unit,
)

Matcher = Literal["search", "genetic"]
MATCHER_NAMES: tuple[str, ...] = get_args(Matcher)
"""Names of the matchers: the project's own search, and the paper's genetic algorithm."""
NotNegative = Annotated[float, Meta(ge=0)]
Covariance = tuple[tuple[float, float, float, float, float, float], ...]
"""6 × 6, of (rotation in rad, translation in m)."""


class StartArgs(Message, frozen=True):
    """`start`: a session on an image server. What is ``None`` comes from its `describe`.

    Attributes
    ----------
    image_server
        Endpoint of the image server; ``None`` where frames are given by `add`.
    model, unit
        Model file of the target, and the unit of its numbers.
    camera_file, seed_pose_file
        TOML files with ``[camera]`` and ``[target.seed_pose]``.
    camera, seed_pose
        The same as values; not beside the files.
    first_sight
        Look for the target everywhere, whatever seed pose `describe` knows.
    matcher
        ``search`` or the paper's ``genetic``.
    seed
        Seed of every random draw.
    out
        Folder where ``images/`` is saved as a stack that can be replayed.
    """

    image_server: Endpoint | None = None
    model: FileName | None = None
    unit: Unit | None = None
    camera_file: FileName | None = None
    seed_pose_file: FileName | None = None
    camera: CameraDescription | None = None
    seed_pose: PoseMessage | None = None
    first_sight: bool = False
    matcher: Matcher = "search"
    seed: Seed = 0
    out: FileName | None = None


class EstimateTold(Message, frozen=True):
    """What an earlier `estimate` with a pose has answered; keys as there."""

    pose: PoseMessage
    covariance: Annotated[Covariance, Meta(min_length=6, max_length=6)]
    rms_px: float
    uncertainty: float
    supported_fraction: float
    score: float
    ambiguity: float


CauseName = Literal["target_moved", "light_dead", "lights_swapped", "sun_changed", "in_the_way"]


class CauseTold(Message, frozen=True):
    """What has happened, or may have: a cause, and the names of the lights that it is about.

    ``since`` is the first image after it, None one that is still to come.
    """

    cause: CauseName
    lights: tuple[str, ...] = ()
    since: ImageId | None = None


class ToldStep(Message, frozen=True):
    """One thing that a server must know again.

    An answer of `estimate`, arguments of `parameters`, that `predict` was asked, an image that was discarded,
    or what has happened.
    """

    estimate: EstimateTold | None = None
    parameters: dict[str, Any] = field(default_factory=dict)
    predicted: bool = False
    discarded: ImageId | None = None
    happened: CauseTold | None = None


class RestoreArgs(StartArgs, frozen=True, kw_only=True):
    """`restore`: go on with a session from its folder ``out``; ``images`` are those that were in the set.

    ``discarded`` names images that were taken and are not in it, so that their names are not used again;
    ``told`` is, in order, what best estimate, seed pose, parameters and predictions depend on, and
    ``doubted`` the image before which something may have happened.
    """

    out: FileName
    images: tuple[ImageId, ...] = ()
    discarded: tuple[ImageId, ...] = ()
    told: tuple[ToldStep, ...] = ()
    doubted: ImageId | None = None


class ModelTold(Message, frozen=True):
    """The target's model as it was read."""

    name: str
    lines: Number
    faces: Number
    diameter_m: NotNegative | None = None
    picture_px: NotNegative | None = None
    """How large it would be in the image from the seed pose; without one, ``None``."""
    doubt: str | None = None
    """Where that cannot be: what is to be checked."""


class StartResult(Message, frozen=True):
    """Result of `start` and `restore`."""

    model: ModelTold
    describe: Describe
