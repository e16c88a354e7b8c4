"""The camera file: which camera, and which control value each setting means (docs/hardware.md)."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta

from bridge.errors import BadInput
from bridge.messages import CameraDescription
from image_server.v4l2.controls import EXPOSURE_MANUAL, EXPOSURE_UNIT_S, Control
from stack.exposure import SHUTTERS_S
from stack.tables import Table, as_table, read_toml

Positive = Annotated[float, Meta(gt=0)]
Size = Annotated[int, Meta(ge=1, le=65536)]

NOMINAL_APERTURE = 4.0
"""f-number that a lens without an iris is taken to have: the reference exposure's."""
SAME_STEP = 0.05  # a shutter that the control can only approach by more than this is left out
DEFAULT_SETTLE_FRAMES = 3  # UVC cameras apply a new exposure one to three frames late


class FormatTable(Table, frozen=True):
    """`[format]`; what is left out stays as the driver has it."""

    pixel_format: Annotated[str, Meta(min_length=1, max_length=4)] | None = None
    width: Size | None = None
    height: Size | None = None
    frame_rate: Positive | None = None


class Axis(Table, frozen=True):
    """One setting: a control with the value for each step, or a fixed number."""

    control: str | None = None
    steps: tuple[tuple[Positive, int], ...] = ()
    fixed: Positive | None = None

    @property
    def values(self) -> tuple[float, ...]:
        """What can be asked for, in the setting's unit."""
        return tuple(value for value, _ in self.steps) or ((self.fixed,) if self.fixed else ())


class CameraFile(Table, frozen=True):
    """A whole camera file."""

    device: str
    card: str | None = None
    settle_frames: Annotated[int, Meta(ge=0, le=100)] = DEFAULT_SETTLE_FRAMES
    format: FormatTable = FormatTable()
    controls: dict[str, int] = msgspec.field(default_factory=dict)
    shutter: Axis | None = None
    aperture: Axis = Axis(fixed=NOMINAL_APERTURE)
    focal_length: Axis | None = None
    focus: Axis | None = None
    camera: CameraDescription | None = None

    def axes(self) -> dict[str, Axis]:
        """Every setting that has a control, by its name in the wire protocol."""
        named = {
            "shutter_s": self.shutter,
            "aperture": self.aperture,
            "focal_length_mm": self.focal_length,
            "focus_m": self.focus,
        }
        return {name: axis for name, axis in named.items() if axis is not None and axis.control is not None}


@dataclass(frozen=True)
class Proposal:
    """What a camera without a file is taken to be: automatic modes off, usual shutters."""

    controls: dict[str, int]
    shutter: Axis | None


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


def proposal(controls: Mapping[str, Control]) -> Proposal:
    """What can be known of a camera from its list of controls alone."""
    fixed = {}
    for name, value in (
        ("exposure_auto", EXPOSURE_MANUAL),
        ("exposure_auto_priority", 0),  # else a dark scene halves the frame rate
        ("autogain", 0),
        ("auto_white_balance", 0),
        ("focus_auto", 0),
        ("backlight_compensation", 0),
    ):
        control = controls.get(name)
        if control is not None and not control.read_only and _offers(control, value):
            fixed[name] = value
    for name in ("gain", "analogue_gain"):
        if name in controls and not controls[name].read_only:
            fixed[name] = controls[name].minimum  # least noise
    return Proposal(fixed, _shutters(controls.get("exposure_absolute")))


def _shutters(control: Control | None) -> Axis | None:
    if control is None or control.read_only:
        return None
    steps = {}
    for seconds in SHUTTERS_S:
        step = max(1, control.step)
        value = control.minimum + step * round((seconds / EXPOSURE_UNIT_S - control.minimum) / step)
        held = value * EXPOSURE_UNIT_S
        if control.minimum <= value <= control.maximum and abs(held / seconds - 1) < SAME_STEP:
            steps[value] = round(held, 9)
    if not steps:
        return None
    return Axis(control=control.name, steps=tuple((seconds, value) for value, seconds in steps.items()))


def _offers(control: Control, value: int) -> bool:
    return value in control.menu if control.menu else control.minimum <= value <= control.maximum
