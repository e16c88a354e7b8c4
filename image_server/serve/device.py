"""What every device is to the server, and what a new one has to be: it takes settings and gives frames."""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from bridge.arrays import FramePixels
from bridge.errors import BadInput, Unsupported
from bridge.image_messages import MoveDone, PoseErrorMessage
from bridge.messages import Describe, EventName, PoseMessage, SettingRange, Settings
from stack.exposure import same_value


@dataclass(frozen=True)
class Frame:
    """One image and what it was taken under.

    Attributes
    ----------
    pixels : (H, W) grey, uint8 or uint16.
    requested, applied : settings asked for, and those the device reports.
    verified : whether the device confirmed that the applied settings held during the exposure.
    sequence : number of this capture, from 1.
    timestamp : seconds since 1970 (UTC) at the middle of the exposure.
    devices : identity of each piece of hardware (or file) that took part.
    """

    pixels: FramePixels
    requested: Settings
    applied: Settings
    verified: bool
    sequence: int
    timestamp: float
    devices: dict[str, str] = field(default_factory=dict)


def sure_frame(
    pixels: FramePixels,
    requested: Settings,
    applied: Settings,
    sequence: int,
    source: str,
) -> Frame:
    """A frame of now from a source that does what it is told: simulated, or recorded."""
    devices = {"camera": source, "lights": source}
    return Frame(pixels, requested, applied, True, sequence, time.time(), devices)


@dataclass(frozen=True)
class Change:
    """Something that happened to scene or hardware; becomes an event."""

    event: EventName
    args: dict[str, Any] = field(default_factory=dict)


class Device(ABC):
    """A camera with lights, real or not.

    A device is used by one thread at a time. What it notices by itself it tells the callback given to
    `listen`, from any thread; the server publishes it.
    """

    name: str

    @abstractmethod
    def describe(self) -> Describe:
        """What can be set, and what is known of camera and target; never the true pose."""

    @abstractmethod
    def capture(self, settings: Settings) -> Frame:
        """Take one frame.

        Raises
        ------
        BadInput : a setting that the device does not offer; the message names those that it does.
        DeviceError : the device did not do it.
        """

    @abstractmethod
    def health(self) -> dict[str, Any]:
        """State of the device as plain values; `status` is "ok" when all is well."""

    def listen(self, notify: Callable[[Change], None]) -> None:  # noqa: B027  # most have nothing to tell
        """Tell `notify` of every fault and change of scene that no request asked for."""

    def restart(self, seed: int, captures_taken: int, moves: Sequence[MoveDone] = ()) -> list[Change]:
        """Become what a device of this seed is after so many captures and these moves.

        Returns
        -------
        What changed with the last of these, so that a session that goes on misses nothing.
        """
        raise Unsupported(f"The {self.name} cannot begin anew with seed {seed}.")

    def come_to(self, number: int) -> None:  # noqa: B027  # hardware cannot
        """Be as before the capture of this number, where a device draws and some were taken in vain."""

    def move(self, range_m: float) -> list[Change]:
        """Bring the target to a range along its line of sight, and say what changed in the scene."""
        raise Unsupported(f"The {self.name} cannot move its target to {range_m:g} m.")

    def score(self, pose: PoseMessage, moves: int | None = None) -> PoseErrorMessage | None:
        """Error of a pose against the true one, None where that is not known. For reports only.

        Parameters
        ----------
        pose : where the target was found.
        moves : after how many moves that was; None where no move came after it.
        """
        raise Unsupported(f"The {self.name} does not know the true pose.", f"Asked for {pose.translation}.")

    def close(self) -> None:  # noqa: B027  # files and simulators hold nothing
        """Leave the hardware dark and free; may be called twice."""


def setting_ranges(describe: Describe) -> tuple[SettingRange, ...]:
    """Unit, minimum, maximum and step of every setting that a request may give."""
    lights = [
        SettingRange(name=f"lights.{light.name}", unit="level", minimum=0, maximum=light.levels - 1, step=1)
        for light in describe.lights
    ]
    listed = [
        SettingRange(name=name, unit=unit, minimum=min(values), maximum=max(values))
        for name, unit, values in (
            ("shutter_s", "s", describe.shutters_s),
            ("aperture", "f-number", describe.apertures),
            ("focal_length_mm", "mm", describe.focal_lengths_mm),
            ("focus_m", "m", describe.focuses_m),
        )
        if values
    ]
    return (*lights, *listed)


def checked_settings(describe: Describe, settings: Settings) -> Settings:
    """Settings with each value replaced by the offered one it equals.

    Raises
    ------
    BadInput
        For a value that is not offered, naming what is. Nothing is ever clipped.
    """
    lights = describe.lights
    if len(settings.lights) != len(lights):
        raise BadInput(
            f"Settings give {len(settings.lights)} light levels, but the {describe.device} has"
            f" {len(lights)} lights ({', '.join(light.name for light in lights)}).",
            "Give one level per light.",
        )
    for light, level in zip(lights, settings.lights, strict=True):
        if not 0 <= level < light.levels:
            raise BadInput(
                f"Light {light.name!r} has no level {level}.", f"Allowed: 0 to {light.levels - 1}."
            )
    return Settings(
        lights=settings.lights,
        shutter_s=_offered("shutter_s", settings.shutter_s, describe.shutters_s, "s"),
        aperture=_offered("aperture", settings.aperture, describe.apertures, ""),
        focal_length_mm=_optional(
            "focal_length_mm", settings.focal_length_mm, describe.focal_lengths_mm, "mm"
        ),
        focus_m=_optional("focus_m", settings.focus_m, describe.focuses_m, "m"),
    )


def _offered(name: str, value: float, offered: Sequence[float], unit: str) -> float:
    for candidate in offered:
        if same_value(value, candidate):
            return candidate
    listed = ", ".join(f"{candidate:g}" for candidate in offered)
    raise BadInput(f"{name} = {value:g} is not offered.", f"Allowed: {listed}{' ' + unit if unit else ''}.")


def _optional(name: str, value: float | None, offered: Sequence[float] | None, unit: str) -> float | None:
    if value is None:
        return offered[0] if offered is not None and len(offered) == 1 else None
    if not offered:
        raise BadInput(f"{name} = {value:g} cannot be set: the lens is fixed.", f"Leave {name} null.")
    return _offered(name, value, offered, unit)
