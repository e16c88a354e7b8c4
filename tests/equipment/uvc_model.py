"""What a model of USB camera has: its controls with ranges, from a file of `tests/equipment/cameras/`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from msgspec import Meta

from bridge.errors import BadInput
from stack.tables import Table, as_table, read_toml

FOLDER = Path(__file__).parent / "cameras"

CAMERA_TERMINAL, PROCESSING_UNIT, OUTPUT_TERMINAL = 1, 2, 3
"""Numbers of the units that a picture passes through."""


@dataclass(frozen=True)
class Selector:
    """Where a control is (UVC 1.1, tables 3-6, 3-8, A-12 and A-13).

    Attributes
    ----------
    unit : camera terminal or processing unit.
    number : its control selector.
    size : bytes of its value, little-endian.
    bit : of the unit's bmControls.
    signed : whether values may be negative.
    """

    unit: int
    number: int
    size: int
    bit: int
    signed: bool = False


SELECTORS = {
    "exposure_auto": Selector(CAMERA_TERMINAL, 0x02, 1, 1),
    "exposure_auto_priority": Selector(CAMERA_TERMINAL, 0x03, 1, 2),
    "exposure_absolute": Selector(CAMERA_TERMINAL, 0x04, 4, 3),
    "focus_absolute": Selector(CAMERA_TERMINAL, 0x06, 2, 5),
    "focus_auto": Selector(CAMERA_TERMINAL, 0x08, 1, 17),
    "iris_absolute": Selector(CAMERA_TERMINAL, 0x09, 2, 7),
    "zoom_absolute": Selector(CAMERA_TERMINAL, 0x0B, 2, 9),
    "backlight_compensation": Selector(PROCESSING_UNIT, 0x01, 2, 8),
    "brightness": Selector(PROCESSING_UNIT, 0x02, 2, 0, signed=True),
    "contrast": Selector(PROCESSING_UNIT, 0x03, 2, 1),
    "gain": Selector(PROCESSING_UNIT, 0x04, 2, 9),
    "power_line_frequency": Selector(PROCESSING_UNIT, 0x05, 1, 10),
    "hue": Selector(PROCESSING_UNIT, 0x06, 2, 2, signed=True),
    "saturation": Selector(PROCESSING_UNIT, 0x07, 2, 3),
    "sharpness": Selector(PROCESSING_UNIT, 0x08, 2, 4),
    "gamma": Selector(PROCESSING_UNIT, 0x09, 2, 5),
    "white_balance_temperature": Selector(PROCESSING_UNIT, 0x0A, 2, 6),
    "auto_white_balance": Selector(PROCESSING_UNIT, 0x0B, 1, 12),
}
"""Controls by the names that `image_server.v4l2.controls` gives them."""

Word = Annotated[int, Meta(ge=0, le=0xFFFF)]
Range = tuple[int, int, int, int]


class CameraModel(Table, frozen=True):
    """A file of `tests/equipment/cameras/`.

    Attributes
    ----------
    card : its product string.
    vendor, product : its USB numbers.
    controls : minimum, maximum, step and default of each control it has.
    """

    card: str
    vendor: Word
    product: Word
    controls: dict[str, Range]


def model_names() -> list[str]:
    """Models that can be named."""
    return sorted(file.stem for file in FOLDER.glob("*.toml"))


def load_camera_model(given: str) -> CameraModel:
    """A model by its name, or from a file.

    Raises
    ------
    BadInput : no such model, or a file that cannot be used.
    """
    named = FOLDER / f"{given}.toml"
    path = named if named.is_file() else Path(given)
    if not path.is_file():
        raise BadInput(
            f"There is no model of camera {given!r}.", f"Give {', '.join(model_names())} or a file."
        )
    model = as_table(read_toml(path, "camera model"), CameraModel, path)
    for name in model.controls:
        if name not in SELECTORS:
            raise BadInput(f"{path}: there is no control {name}.", f"Known: {', '.join(SELECTORS)}.")
    return model
