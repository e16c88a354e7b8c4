"""Typed messages of wire protocol 1: the arguments of every operation, and the results that both sides read.

Unknown fields, wrong types, out-of-range values and numbers that are not finite are refused, never clipped.
Bounds hold for whatever is decoded (`msgspec.json.decode`, `msgspec.convert`); finiteness holds always.
"""

import math
from typing import Annotated, Any, Literal, get_args

import msgspec
from msgspec import Meta

PROTOCOL = 1
"""Version of the wire protocol."""

SETTING_TOLERANCE = 1e-3
"""Relative difference under which two values of a setting are the same one (1/60 written as 0.01667). Chosen
by hand, far less than any camera's steps; `describe` tells it to those who choose settings."""

Positive = Annotated[float, Meta(gt=0)]
Fraction = Annotated[float, Meta(ge=0, le=1)]
Level = Annotated[int, Meta(ge=0, le=65535)]
Count = Annotated[int, Meta(ge=1, le=65536)]
Vector3 = tuple[float, float, float]
ImageId = Annotated[str, Meta(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
"""Name of an image of the set, e.g. ``i1``; safe as a file name."""
Endpoint = Annotated[str, Meta(pattern=r"^(ipc|tcp|inproc)://.+$")]
FileName = Annotated[str, Meta(min_length=1, max_length=4096)]
Unit = Literal["m", "cm", "mm", "in"]
Matcher = Literal["search", "genetic"]
MATCHERS: tuple[str, ...] = get_args(Matcher)
"""Names of the matchers: the project's own search, and the paper's genetic algorithm."""
Parameter = bool | int | float | str | dict[str, Any] | None


def _check_finite(value: object, where: str) -> None:
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{where} is {value}, which is not a finite number")
    elif isinstance(value, (tuple, list)):
        for index, item in enumerate(value):
            _check_finite(item, f"{where}[{index}]")
    elif isinstance(value, dict):
        for key, item in value.items():
            _check_finite(item, f"{where}.{key}")


class Message(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of all messages: strict, immutable, all numbers finite."""

    def __post_init__(self) -> None:
        for name in self.__struct_fields__:
            _check_finite(getattr(self, name), name)


class NoArgs(Message, frozen=True):
    """Arguments of `hello`, `describe`, `health`, `best` and `shutdown`."""


# --- what both servers speak of ---------------------------------------------------------------------------


class Settings(Message, frozen=True):
    """What a frame is taken under.

    Attributes
    ----------
    lights
        One level per light; 0 is off, ``levels - 1`` is full.
    shutter_s
        Exposure time in seconds.
    aperture
        f-number.
    focal_length_mm, focus_m
        ``None`` leaves a fixed lens as it is.
    """

    lights: tuple[Level, ...]
    shutter_s: Positive
    aperture: Positive
    focal_length_mm: Positive | None = None
    focus_m: Positive | None = None


class PoseMessage(Message, frozen=True):
    """``camera_T_target``: rotation vector in rad, translation in metres."""

    rotation_vector: Vector3
    translation: Vector3


class LightDescription(Message, frozen=True):
    """One light: how many levels it has, where it is (camera frame, metres), and its relative power."""

    name: str
    levels: Annotated[int, Meta(ge=1, le=65536)]
    position: Vector3 | None = None
    power: Annotated[float, Meta(ge=0)] = 1.0


class CameraDescription(Message, frozen=True):
    """Pinhole camera with OpenCV distortion (4, 5 or 8 numbers), pixel centres at integers; its sensor."""

    width: Count
    height: Count
    fx: Positive
    fy: Positive
    cx: float
    cy: float
    distortion: Annotated[tuple[float, ...], Meta(min_length=4, max_length=8)] = (0.0, 0.0, 0.0, 0.0, 0.0)
    gain: Positive = 1.0
    gamma: Positive = 1.0
    read_noise_e: Annotated[float, Meta(ge=0)] = 2.0
    full_well_e: Positive = 10000.0


class ReferenceExposure(Message, frozen=True):
    """The exposure that counts as 1."""

    shutter_s: Positive = 1 / 60
    aperture: Positive = 4.0


class TargetDescription(Message, frozen=True):
    """The docking target: its model file (absolute path), the file's unit, and where it may be."""

    model: FileName
    unit: Unit = "m"
    seed_pose: PoseMessage | None = None


class SettingRange(Message, frozen=True):
    """Unit, bounds and step of one setting; without a step, only the values listed elsewhere are taken."""

    name: str
    unit: str
    minimum: float
    maximum: float
    step: float | None = None


class Describe(Message, frozen=True):
    """Result of `describe`: what an image server can do. Never the true pose.

    A setting whose relative difference from a listed value is within ``setting_tolerance`` is that value.
    """

    device: str
    lights: tuple[LightDescription, ...]
    shutters_s: Annotated[tuple[Positive, ...], Meta(min_length=1)]
    apertures: Annotated[tuple[Positive, ...], Meta(min_length=1)]
    focal_lengths_mm: tuple[Positive, ...] | None = None
    focuses_m: tuple[Positive, ...] | None = None
    camera: CameraDescription | None = None
    reference: ReferenceExposure = ReferenceExposure()
    target: TargetDescription | None = None
    movable: bool = False
    ranges: tuple[SettingRange, ...] = ()
    setting_tolerance: Annotated[float, Meta(ge=0)] = SETTING_TOLERANCE
    events: str | None = None


EventName = Literal["sun_changed", "target_moved", "camera_fault", "light_fault"]


class Event(Message, frozen=True, kw_only=True):
    """What a server publishes unasked; ``sequence`` counts from 1 without gaps."""

    v: Literal[1] = 1
    event: EventName
    args: dict[str, Any] = {}
    sequence: Annotated[int, Meta(ge=1)]


# --- image server -----------------------------------------------------------------------------------------


class ImageCaptureArgs(Message, frozen=True):
    """`capture` of the image server."""

    settings: Settings


class ImageCaptureResult(Message, frozen=True):
    """Header of a frame; the frame itself is the reply's only array, (H, W) uint8.

    ``timestamp`` is in seconds since 1970 (UTC), ``sha256`` is over the array's bytes in C order.
    """

    requested: Settings
    applied: Settings
    verified: bool
    sequence: Annotated[int, Meta(ge=0)]
    timestamp: float
    devices: dict[str, str]
    sha256: Annotated[str, Meta(pattern=r"^[0-9a-f]{64}$")]


class MoveArgs(Message, frozen=True):
    """`move`: bring the target to this range along its line of sight."""

    range_m: Positive


class RestartArgs(Message, frozen=True):
    """`restart`: be what a server started with this seed is; noise goes on after so many captures."""

    seed: Annotated[int, Meta(ge=0, le=2**63 - 1)] = 0
    captures_taken: Annotated[int, Meta(ge=0)] = 0


class ScoreArgs(Message, frozen=True):
    """`score`: how far is this pose from the true one? For reports only."""

    pose: PoseMessage


class PoseErrorMessage(Message, frozen=True):
    """Distance of a pose from the true one."""

    rotation_deg: Annotated[float, Meta(ge=0)]
    translation_m: Annotated[float, Meta(ge=0)]
    translation_fraction_of_range: Annotated[float, Meta(ge=0)]


# --- vision server ----------------------------------------------------------------------------------------


class StartArgs(Message, frozen=True):
    """`start`: a session on an image server. What is ``None`` comes from its `describe`.

    Attributes
    ----------
    image_server
        Endpoint of the image server.
    model, unit
        Model file of the target, and the unit of its numbers.
    camera_file, seed_pose_file
        TOML files with ``[camera]`` and ``[target.seed_pose]``.
    matcher
        ``search`` or the paper's ``genetic``.
    seed
        Seed of every random draw.
    out
        Folder where ``images/`` is saved as a stack that can be replayed.
    """

    image_server: Endpoint
    model: FileName | None = None
    unit: Unit | None = None
    camera_file: FileName | None = None
    seed_pose_file: FileName | None = None
    matcher: Matcher = "search"
    seed: Annotated[int, Meta(ge=0, le=2**63 - 1)] = 0
    out: FileName | None = None


class EstimateTold(Message, frozen=True):
    """What an earlier `estimate` with a pose has answered; keys as there."""

    pose: PoseMessage
    covariance: tuple[tuple[float, ...], ...]
    rms_px: float
    uncertainty: float
    supported_fraction: float
    score: float
    ambiguity: float


class ToldStep(Message, frozen=True):
    """One thing that a server must know again: an answer of `estimate`, or arguments of `parameters`."""

    estimate: EstimateTold | None = None
    parameters: dict[str, Any] = {}


class RestoreArgs(StartArgs, frozen=True, kw_only=True):
    """`restore`: go on with a session from its folder ``out``; ``images`` are those that were in the set.

    ``discarded`` names images that were taken and dropped, so that their names are not used again; ``told``
    is, in order, what best estimate, seed pose and parameters depend on.
    """

    out: FileName
    images: tuple[ImageId, ...] = ()
    discarded: tuple[ImageId, ...] = ()
    told: tuple[ToldStep, ...] = ()


class VisionCaptureArgs(Message, frozen=True):
    """`capture` of the vision server: take a frame and call it ``image``."""

    image: ImageId
    settings: Settings


class EstimateArgs(Message, frozen=True):
    """`estimate`: the pose from these images together."""

    images: Annotated[tuple[ImageId, ...], Meta(min_length=1, max_length=256)]


class DiscardArgs(Message, frozen=True):
    """`discard`: forget an image."""

    image: ImageId


ParametersArgs = dict[str, Parameter]
"""`parameters`: new values by name (none: only ask); the vision server knows names and ranges."""


IMAGE_OPERATIONS: dict[str, Any] = {
    "hello": NoArgs,
    "describe": NoArgs,
    "capture": ImageCaptureArgs,
    "health": NoArgs,
    "restart": RestartArgs,
    "move": MoveArgs,
    "score": ScoreArgs,
    "shutdown": NoArgs,
}
"""Argument type of each operation of an image server."""

VISION_OPERATIONS: dict[str, Any] = {
    "hello": NoArgs,
    "start": StartArgs,
    "capture": VisionCaptureArgs,
    "estimate": EstimateArgs,
    "discard": DiscardArgs,
    "best": NoArgs,
    "parameters": ParametersArgs,
    "restore": RestoreArgs,
    "health": NoArgs,
    "shutdown": NoArgs,
}
"""Argument type of each operation of a vision server."""
