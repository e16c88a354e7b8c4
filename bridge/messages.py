"""Typed messages of wire protocol 1: what both servers speak of.

Unknown fields, wrong types, out-of-range values and numbers that are not finite are refused, never clipped.
Bounds hold for whatever is decoded (`msgspec.json.decode`, `msgspec.convert`); finiteness holds always.
"""

import math
from typing import Annotated, Any, Literal, NamedTuple

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
MOST_COORDINATE = 1e6
"""In metres, or rad about an axis; far beyond what anything of this is used for, and its square is finite."""
Coordinate = Annotated[float, Meta(ge=-MOST_COORDINATE, le=MOST_COORDINATE)]
Vector3 = tuple[Coordinate, Coordinate, Coordinate]
Length = Annotated[float, Meta(gt=0, le=1e6)]
Shutter = Annotated[float, Meta(ge=1e-9, le=1e5)]
Aperture = Annotated[float, Meta(ge=1e-2, le=1e4)]
Number = Annotated[int, Meta(ge=0, le=2**53)]
"""What is counted; exact as a float, too."""
Seed = Annotated[int, Meta(ge=0, le=2**63 - 1)]
ImageId = Annotated[str, Meta(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}\Z")]
"""Name of an image of the set, e.g. ``i1``; safe as a file name."""
Endpoint = Annotated[str, Meta(pattern=r"^(ipc|tcp)://[^\0]+\Z", max_length=256)]
FileName = Annotated[str, Meta(pattern=r"^[^\0]+\Z", max_length=4096)]
Unit = Literal["m", "cm", "mm", "in"]


def check_finite(value: object, where: str) -> None:
    """Raise ValueError for a number that is not finite, anywhere in what `where` names."""
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{where} is {value}, which is not a finite number")
    elif isinstance(value, (tuple, list)):
        for index, item in enumerate(value):
            check_finite(item, f"{where}[{index}]")
    elif isinstance(value, dict):
        for key, item in value.items():
            check_finite(item, f"{where}.{key}")


class Message(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of all messages: strict, immutable, all numbers finite.

    Of what a server answers, `bridge.received` lets unknown fields be.
    """

    def __post_init__(self) -> None:
        for name in self.__struct_fields__:
            check_finite(getattr(self, name), name)


class Operation(NamedTuple):
    """The types of an operation's arguments and of its result."""

    args: Any
    result: Any


class NoArgs(Message, frozen=True):
    """Nothing: arguments of `hello`, `describe`, `health`, `best`; result of `shutdown`, `end`."""


class HelloResult(Message, frozen=True):
    """`hello`: who this is."""

    server: str
    version: str
    protocol: int
    operations: tuple[str, ...]
    pid: int


class HealthResult(Message, frozen=True, forbid_unknown_fields=False):
    """`health`: ``ok``, and whatever else the server knows of itself."""

    status: str


COMMON_OPERATIONS = {
    "hello": Operation(NoArgs, HelloResult),
    "health": Operation(NoArgs, HealthResult),
    "shutdown": Operation(NoArgs, NoArgs),
}


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
    shutter_s: Shutter
    aperture: Aperture
    focal_length_mm: Length | None = None
    focus_m: Length | None = None


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
    """Pinhole camera with OpenCV distortion (4, 5, 8 or 12 numbers), pixel centres at integers; its sensor.

    ``bits`` are those of a pixel in frames of 16 bits: a camera of 12 clips at 4095. With ``bayer``
    they are a mosaic of colours, in any order.
    """

    width: Count
    height: Count
    fx: Positive
    fy: Positive
    cx: float
    cy: float
    distortion: Annotated[tuple[float, ...], Meta(min_length=4, max_length=12)] = (0.0, 0.0, 0.0, 0.0, 0.0)
    lens: Literal["pinhole", "fisheye"] = "pinhole"
    gain: Positive = 1.0
    gamma: Positive = 1.0
    read_noise_e: Annotated[float, Meta(ge=0)] = 2.0
    full_well_e: Positive = 10000.0
    bits: Annotated[int, Meta(ge=8, le=16)] = 16
    bayer: bool = False


class ReferenceExposure(Message, frozen=True):
    """The exposure that counts as 1."""

    shutter_s: Shutter = 1 / 60
    aperture: Aperture = 4.0


class TargetDescription(Message, frozen=True):
    """The docking target: its model file (absolute path), the file's unit, and where it may be.

    Attributes
    ----------
    range_m, view
        What narrows the search where there is no seed pose: least and greatest distance of the target's
        middle, metres; the direction from there to the camera in the target's frame, roughly.
    tolerance_m
        How far lines of the part may be off the model's, one standard deviation, metres; 0 for a part that is
        its model, None where nobody knows.
    """

    model: FileName
    unit: Unit = "m"
    seed_pose: PoseMessage | None = None
    range_m: tuple[Length, Length] | None = None
    view: Vector3 | None = None
    tolerance_m: Annotated[float, Meta(ge=0, le=1e6)] | None = None


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
    ``nearest_m`` is the least range that `move` brings the target to; ``recorded`` how many frames there are,
    where a device has no others.
    """

    device: str
    lights: tuple[LightDescription, ...]
    shutters_s: Annotated[tuple[Shutter, ...], Meta(min_length=1)]
    apertures: Annotated[tuple[Aperture, ...], Meta(min_length=1)]
    focal_lengths_mm: tuple[Positive, ...] | None = None
    focuses_m: tuple[Positive, ...] | None = None
    camera: CameraDescription | None = None
    reference: ReferenceExposure = ReferenceExposure()
    target: TargetDescription | None = None
    movable: bool = False
    nearest_m: Positive | None = None
    recorded: Annotated[int, Meta(ge=1)] | None = None
    ranges: tuple[SettingRange, ...] = ()
    setting_tolerance: Annotated[float, Meta(ge=0)] = SETTING_TOLERANCE
    events: str | None = None


EventName = Literal["sun_changed", "target_moved", "camera_fault", "light_fault"]


class _EventArgs(Message, frozen=True, forbid_unknown_fields=False):
    """What an event must tell, and may."""


class LightFaultArgs(_EventArgs, frozen=True):
    """`light_fault`: which light, by its name of `describe`, and why."""

    light: str
    reason: str | None = None


class CameraFaultArgs(_EventArgs, frozen=True):
    """`camera_fault`: why."""

    reason: str | None = None


class TargetMovedArgs(_EventArgs, frozen=True):
    """`target_moved`: its range now."""

    range_m: Length | None = None


EVENT_ARGS: dict[str, type[_EventArgs]] = {
    "sun_changed": _EventArgs,
    "target_moved": TargetMovedArgs,
    "camera_fault": CameraFaultArgs,
    "light_fault": LightFaultArgs,
}
"""By event, what its ``args`` are."""


class _Happening(Message, frozen=True):
    event: EventName
    args: dict[str, Any] = {}

    def __post_init__(self) -> None:
        super().__post_init__()
        try:
            msgspec.convert(self.args, EVENT_ARGS[self.event])
        except msgspec.ValidationError as error:
            raise ValueError(f"args of {self.event}: {error}") from error


class Event(_Happening, frozen=True, kw_only=True):
    """What a server publishes unasked; ``sequence`` counts from 1 without gaps."""

    v: Literal[1] = 1
    sequence: Annotated[int, Meta(ge=1)]


class EventTold(_Happening, frozen=True):
    """An event that came with a request, told in its reply too; ``sequence`` as it was published."""

    sequence: Annotated[int, Meta(ge=0)] = 0
