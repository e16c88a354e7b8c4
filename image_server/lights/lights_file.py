"""The lights file: which driver, and which channels each light has (docs/hardware.md)."""

import os
import stat
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal

from msgspec import Meta

from bridge.errors import BadInput
from bridge.messages import LightDescription
from image_server.lights.driver import LightDriver
from stack.format import check_light_names
from stack.tables import Table, as_table, read_toml

Protocol = Literal["line", "dmx_usb_pro"]
DEFAULT_LEVELS = 8  # the paper's testbed
DEFAULT_DARK_AFTER_S = 60.0  # chosen by hand: many times a session's longest pause


class LightChannels(LightDescription, frozen=True, kw_only=True):
    """One of `[[lights]]`: its channels, and the value that they get for each level."""

    channels: Annotated[tuple[Annotated[int, Meta(ge=1, le=512)], ...], Meta(min_length=1)]
    levels: Annotated[int, Meta(ge=2, le=65536)] = DEFAULT_LEVELS
    full: Annotated[int, Meta(ge=1, le=65535)] | None = None
    values: tuple[Annotated[int, Meta(ge=0, le=65535)], ...] | None = None

    def value(self, level: int, driver_full: int) -> int:
        """Channel value of a level: as listed, or in even steps up to `full`."""
        if self.values is not None:
            return self.values[level]
        return round(level / (self.levels - 1) * (self.full or driver_full))


class LightsFile(Table, frozen=True):
    """A whole lights file.

    Attributes
    ----------
    device : serial device.
    protocol : what it speaks.
    settle_s : from a change of level to steady light, as the camera sees it.
    dark_after_s : the lights go out when no request has come for so long; 0: never.
    hold_off_s : the lights go out when the server has been silent for so long, by the driver itself (line
        protocol) and by the watchdog; 0: never.
    """

    device: str
    protocol: Protocol
    lights: Annotated[tuple[LightChannels, ...], Meta(min_length=1)]
    settle_s: Annotated[float, Meta(ge=0, le=60)] = 0.05
    dark_after_s: Annotated[float, Meta(ge=0, le=86400)] = DEFAULT_DARK_AFTER_S
    hold_off_s: Annotated[float, Meta(ge=0, le=600)] = 2.0


def load_lights_file(path: Path) -> LightsFile:
    """Read and check a lights file.

    Raises
    ------
    BadInput : names file and key.
    """
    table = as_table(read_toml(path, "lights file"), LightsFile, path)
    check_light_names([light.name for light in table.lights], path)
    used: dict[int, str] = {}
    for light in table.lights:
        for channel in light.channels:
            if channel in used:
                raise BadInput(f"{path}: channel {channel} is used by {used[channel]!r} and {light.name!r}.")
            used[channel] = light.name
        if light.values is not None and len(light.values) != light.levels:
            raise BadInput(
                f"{path}: light {light.name!r} has {light.levels} levels, but {len(light.values)} values."
            )
        if light.values is not None and light.values[0] != 0:
            raise BadInput(f"{path}: light {light.name!r} is not off at level 0 (values[0] is not 0).")
        if light.values is not None and any(high < low for low, high in pairwise(light.values)):
            raise BadInput(f"{path}: the values of light {light.name!r} fall from a level to the next.")
        if light.values is not None and light.full is not None:
            raise BadInput(f"{path}: light {light.name!r} has full and values.", "Keep one of them.")
    return table


def check_channels(file: LightsFile, driver: LightDriver) -> None:
    """Refuse channels and values that a driver does not have."""
    for light in file.lights:
        if max(light.channels) > driver.channels:
            raise BadInput(
                f"Light {light.name!r} uses channel {max(light.channels)}, but {driver.identity} has"
                f" {driver.channels} channels."
            )
        top = max(light.values or (light.full or driver.full,))
        if top > driver.full:
            raise BadInput(
                f"Light {light.name!r} has a channel value of {top};"
                f" {driver.identity} goes up to {driver.full}."
            )


def is_device(path: str) -> bool:
    """Whether a path is a device node rather than a file."""
    try:
        return stat.S_ISCHR(os.stat(path).st_mode)
    except OSError:
        return False
