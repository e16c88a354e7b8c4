"""The tables of `stack.toml` (docs/architecture.md, "Stack folder"), with their defaults and bounds."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import msgspec
from msgspec import Meta

from bridge.errors import BadInput
from bridge.messages import (
    Aperture,
    CameraDescription,
    LightDescription,
    PoseMessage,
    Settings,
    Shutter,
    TargetDescription,
)
from stack.exposure import APERTURES, SHUTTERS_S
from stack.tables import Table, as_table

STACK_FILE = "stack.toml"

MOST_STRENGTH = 1e9  # of a sun or a lamp, chosen by hand: times what a file says a number still
Strength = Annotated[float, Meta(ge=0, le=MOST_STRENGTH)]
NotNegative = Annotated[float, Meta(ge=0)]
Some = Meta(min_length=1)


class CameraTable(CameraDescription, frozen=True, kw_only=True):
    """`[camera]`: calibration, sensor, and the blur in front of it.

    Attributes
    ----------
    gain
        Output per electron, 1 where `full_well_e` electrons clip.
    gamma
        The output is signal^(1/gamma).
    read_noise_e, full_well_e
        Standard deviation of the read-out, and electrons at the clip level at gain 1.
    defocus_sigma_px
        Standard deviation of the defocus blur at the widest aperture, px.
    motion_px_per_s
        Image motion (x, y) during the exposure, px/s.
    prnu
        Standard deviation of the pixels' sensitivity, relative (EMVA 1288).
    dsnu_e
        Standard deviation of the pixels' dark signal, electrons.
    bits
        Of a pixel in images of 16 bits: those of a camera of 12 clip at 4095.
    bayer
        Whether the images are a Bayer mosaic, of any order.
    pattern_seed
        Draws those two patterns.
    blooming
        Share of the charge beyond the well that spills along the column.
    """

    shutters_s: Annotated[tuple[Shutter, ...], Some] = SHUTTERS_S
    apertures: Annotated[tuple[Aperture, ...], Some] = APERTURES
    defocus_sigma_px: NotNegative = 0.0
    motion_px_per_s: tuple[float, float] = (0.0, 0.0)
    prnu: Annotated[float, Meta(ge=0, le=0.5)] = 0.0
    dsnu_e: NotNegative = 0.0
    pattern_seed: Annotated[int, Meta(ge=0)] = 0
    blooming: Annotated[float, Meta(ge=0, le=1)] = 0.0

    def blurred_by(self, defocus_sigma_px: float | None, motion_px_per_s: tuple[float, float] | None) -> Self:
        """The same camera with another blur; None keeps what it has."""
        return msgspec.structs.replace(
            self,
            defocus_sigma_px=self.defocus_sigma_px if defocus_sigma_px is None else defocus_sigma_px,
            motion_px_per_s=self.motion_px_per_s if motion_px_per_s is None else motion_px_per_s,
        )

    def description(self) -> CameraDescription:
        """What `describe` says of this camera."""
        return msgspec.convert(self, CameraDescription, from_attributes=True)


class GivenCameraTable(CameraTable, frozen=True, kw_only=True):
    """`[camera]` of any file that has one: a scenario's has keys of a lens, too, which the simulator reads.

    How many coefficients a distortion has is for `geometry.camera` to judge, which knows the lenses.
    """

    distortion: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0)
    focal_lengths_mm: Any = None
    pixel_um: Any = None
    focuses_m: Any = None
    vignetting: Any = None
    glare: Any = None


class GivenTargetTable(Table, frozen=True, kw_only=True):
    """`[target]` of a file that gives a camera; what a model is needed to check is checked with it."""

    range_m: tuple[float, float] | None = None
    view: tuple[float, float, float] | None = None
    tolerance_m: Any = None
    edge_radius_m: Any = None
    model: Any = None
    unit: Any = None
    seed_pose: Any = None
    true_pose: Any = None
    sha256: Any = None


CAMERA_ADVICE = (
    "[camera] needs width, height, fx, fy, cx and cy; "
    "[target] may have range_m = [least, greatest] in m and view = [x, y, z]."
)


class CameraFile(msgspec.Struct, frozen=True):
    """What a file says of a camera, and perhaps of the target before it, whatever else it holds."""

    camera: GivenCameraTable
    target: GivenTargetTable = GivenTargetTable()


def camera_file(values: Mapping[str, Any], file: Path) -> tuple[CameraFile, dict[str, Any]]:
    """The typed tables of a camera file's values, and those of its ``[camera]`` that it tells itself.

    A file that is all about a camera needs no ``[camera]``. Tables inside are for others.

    Raises
    ------
    BadInput
        As `as_table`.
    """
    camera = values.get("camera", values)
    if isinstance(camera, dict):
        camera = {key: value for key, value in camera.items() if not isinstance(value, dict)}
    try:
        known = as_table({"camera": camera, "target": values.get("target", {})}, CameraFile, file)
    except BadInput as error:
        raise BadInput(error.message, error.hint or CAMERA_ADVICE) from None
    return known, {key: getattr(known.camera, key) for key in camera}


class FramesLight(LightDescription, frozen=True, kw_only=True):
    """One of `[[lights]]` of a frames stack."""

    levels: Annotated[int, Meta(ge=1, le=65536)] = 8


class BasisLight(FramesLight, frozen=True, kw_only=True):
    """One of `[[lights]]` of a basis stack; `radiance` is its linear 16-bit image at full level."""

    radiance: str


def check_light_names(names: Sequence[str], file: Path) -> None:
    """Raise BadInput where two lights of a file have one name, or one has none: they are told apart by it."""
    for name in names:
        if not name.strip():
            raise BadInput(f"{file}: a light has an empty name.", "Give each light a name of its own.")
        if names.count(name) > 1:
            raise BadInput(f"{file}: two lights are called {name!r}.", "Give each light a name of its own.")


class TargetTable(TargetDescription, frozen=True, kw_only=True):
    """`[target]`; ``sha256`` is that of the model file, where the folder tells it."""

    true_pose: PoseMessage | None = None
    sha256: str | None = None


class FrameTable(Settings, frozen=True, kw_only=True):
    """One of `[[frames]]`: an image file and the settings it was taken under.

    ``sha256`` is that of the image file; a session is resumed with the frames that were taken.
    """

    image: str
    sha256: str | None = None

    def settings(self) -> Settings:
        """The settings alone."""
        return msgspec.convert(self, Settings, from_attributes=True)


class BasisTable(Table, frozen=True):
    """`stack.toml` of `kind = "basis"`."""

    kind: Literal["basis"]
    camera: CameraTable
    lights: Annotated[tuple[BasisLight, ...], Some]
    target: TargetTable
    ambient: str | None = None
    ambient_scale: Strength = 1.0


class FramesTable(Table, frozen=True):
    """`stack.toml` of `kind = "frames"`."""

    kind: Literal["frames"]
    camera: CameraTable
    frames: Annotated[tuple[FrameTable, ...], Some]
    target: TargetTable
    lights: tuple[FramesLight, ...] | None = None


class FrameList(msgspec.Struct, frozen=True):
    """Frames and target of a stack file, whatever else it holds, and be there no frame yet."""

    frames: tuple[FrameTable, ...] = ()
    target: TargetTable | None = None
