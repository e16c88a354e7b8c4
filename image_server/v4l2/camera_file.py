"""The camera file: which camera, and which control value each setting means (docs/hardware.md)."""

from pathlib import Path
from typing import Annotated, Generic, TypeVar

import msgspec
import numpy as np
from msgspec import Meta

from bridge.errors import BadInput
from bridge.messages import Aperture, CameraDescription, Length, Shutter
from stack.exposure import REFERENCE
from stack.tables import Table, as_table, read_toml

Positive = Annotated[float, Meta(gt=0)]
Size = Annotated[int, Meta(ge=1, le=65536)]
Value = TypeVar("Value", bound=float)

NOMINAL_APERTURE = REFERENCE.aperture
"""f-number that a lens without an iris is taken to have: the reference exposure's."""
EXACT = 1e-9  # relative; settings come here as the camera file has them, but for a decimal's rounding
DEFAULT_SETTLE_FRAMES = 3  # UVC cameras apply a new exposure one to three frames late


class FormatTable(Table, frozen=True):
    """`[format]`; what is left out stays as the driver has it."""

    pixel_format: Annotated[str, Meta(min_length=1, max_length=4)] | None = None
    width: Size | None = None
    height: Size | None = None
    frame_rate: Positive | None = None


class Axis(Table, Generic[Value], frozen=True):
    """One setting, bounded as in messages: a control with the value for each step, or a fixed number."""

    control: str | None = None
    steps: tuple[tuple[Value, int], ...] = ()
    fixed: Value | None = None

    @property
    def values(self) -> tuple[float, ...]:
        """What can be asked for, in the setting's unit."""
        return tuple(value for value, _ in self.steps) or ((self.fixed,) if self.fixed else ())

    def number(self, name: str, asked: float) -> int:
        """The control's value for a setting, which is called so in the message of the BadInput otherwise."""
        for value, number in self.steps:
            if abs(value - asked) <= EXACT * value:
                return number
        listed = ", ".join(f"{value:g}" for value in self.values)
        raise BadInput(f"{name} = {asked:g} is not offered.", f"Allowed: {listed}.")

    def meaning(self, number: int) -> float:
        """The setting that a control's value stands for, between steps by interpolation."""
        steps = sorted(self.steps, key=lambda step: step[1])
        return float(np.interp(number, [n for _, n in steps], [value for value, _ in steps]))


class CameraFile(Table, frozen=True):
    """A whole camera file."""

    device: str
    card: str | None = None
    settle_frames: Annotated[int, Meta(ge=0, le=100)] = DEFAULT_SETTLE_FRAMES
    format: FormatTable = FormatTable()
    controls: dict[str, int] = msgspec.field(default_factory=dict)
    shutter: Axis[Shutter] | None = None
    aperture: Axis[Aperture] = Axis(fixed=NOMINAL_APERTURE)
    focal_length: Axis[Length] | None = None
    focus: Axis[Length] | None = None
    camera: CameraDescription | None = None

    def axes(self) -> dict[str, Axis[float]]:
        """Every setting that has a control, by its name in the wire protocol."""
        named = {
            "shutter_s": self.shutter,
            "aperture": self.aperture,
            "focal_length_mm": self.focal_length,
            "focus_m": self.focus,
        }
        return {name: axis for name, axis in named.items() if axis is not None and axis.control is not None}


def load_camera_file(given: str) -> CameraFile:
    """A camera file, or a device node as one that says nothing more.

    Raises
    ------
    BadInput : no such file or device, or a file that cannot be used.
    """
    path = Path(given)
    if not path.is_file():
        return CameraFile(device=given)
    table = as_table(read_toml(path, "camera file"), CameraFile, path)
    for name, axis in (
        ("shutter", table.shutter),
        ("aperture", table.aperture),
        ("focal_length", table.focal_length),
        ("focus", table.focus),
    ):
        if axis is not None and (axis.control is None) == (axis.fixed is None):
            raise BadInput(f"{path}: [{name}] needs either control and steps, or fixed.")
        if axis is not None and (axis.control is None) != (not axis.steps):
            raise BadInput(f"{path}: [{name}] control and steps go together.")
        if axis is not None and len(set(axis.values)) < len(axis.values):
            raise BadInput(f"{path}: [{name}] has two steps of the same value.")
    return table
