"""Reading stack folders: recorded light stacks of both kinds, read and checked whole."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from bridge.arrays import FramePixels
from bridge.errors import BadInput
from bridge.messages import Describe, LightDescription, PoseMessage, TargetDescription
from numerics.arrays import Field
from stack.exposure import FULL_SCALE_16
from stack.format import (
    STACK_FILE,
    BasisTable,
    FrameList,
    FramesLight,
    FramesTable,
    FrameTable,
    check_light_names,
)
from stack.tables import as_table, read_toml


@dataclass(frozen=True)
class BasisStack:
    """A basis stack in memory: radiances (H, W) float32, 1 clips at the reference exposure and gain 1."""

    folder: Path
    table: BasisTable
    radiances: tuple[Field, ...]
    ambient: Field


@dataclass(frozen=True)
class FramesStack:
    """A frames stack in memory: images (H, W) uint8 or uint16 in recorded order."""

    folder: Path
    table: FramesTable
    images: tuple[FramePixels, ...]


def load_stack(folder: Path) -> BasisStack | FramesStack:
    """Read a stack folder.

    Raises
    ------
    BadInput
        For anything missing, unknown, of the wrong type or of the wrong size; the message names file and key.
    """
    if not folder.is_dir():
        raise BadInput(f"There is no stack folder {folder}.", f"Give a folder that holds {STACK_FILE}.")
    file = folder / STACK_FILE
    frames_of_run = folder / "images"
    if not file.exists() and (frames_of_run / STACK_FILE).exists():
        raise BadInput(
            f"{folder} is a run folder, and not a stack folder.", f"Its frames are one: give {frames_of_run}."
        )
    values = read_toml(file, "stack file")
    kind = values.get("kind")
    if kind not in ("basis", "frames"):
        said = "has no key kind" if kind is None else f"has kind = {kind!r}"
        raise BadInput(f"{file} {said}.", 'Write kind = "basis" or kind = "frames".')
    _check_target(values, file)
    if kind == "basis":
        basis = as_table(values, BasisTable, file)
        check_light_names([light.name for light in basis.lights], file)
        return _load_basis(folder, basis)
    frames = as_table(values, FramesTable, file)
    check_light_names([light.name for light in frames.lights or ()], file)
    return _load_frames(folder, frames)


def recorded_frames(folder: Path) -> dict[str, FrameTable]:
    """What an earlier session has saved of its frames, by name of the image; there may be none yet.

    Raises
    ------
    BadInput
        No readable stack file there.
    """
    return {Path(frame.image).stem: frame for frame in _recorded(folder).frames}


def recorded_seed_pose(folder: Path) -> PoseMessage | None:
    """The seed pose that an earlier session began with; raises as `recorded_frames`."""
    target = _recorded(folder).target
    return None if target is None else target.seed_pose


def _recorded(folder: Path) -> FrameList:
    file = folder / STACK_FILE
    try:
        return as_table(read_toml(file, "stack file"), FrameList, file)
    except BadInput as error:
        raise BadInput(error.message, "Resume from the folder of an earlier run.") from error


def describe_stack(stack: BasisStack | FramesStack, name: str) -> Describe:
    """What can be asked of a stack."""
    table = stack.table
    known = msgspec.convert(table.target, TargetDescription, from_attributes=True)
    target = msgspec.structs.replace(known, model=str((stack.folder / known.model).resolve()))
    if isinstance(table, BasisTable):
        lights: tuple[FramesLight, ...] = table.lights
        shutters, apertures = table.camera.shutters_s, table.camera.apertures
        focals: list[float] = []
        focuses: list[float] = []
    else:
        lights = table.lights or _lights_of(table.frames)
        shutters = tuple(sorted({frame.shutter_s for frame in table.frames}))
        apertures = tuple(sorted({frame.aperture for frame in table.frames}))
        focals = sorted({f.focal_length_mm for f in table.frames if f.focal_length_mm is not None})
        focuses = sorted({f.focus_m for f in table.frames if f.focus_m is not None})
    return Describe(
        device=name,
        lights=tuple(msgspec.convert(light, LightDescription, from_attributes=True) for light in lights),
        shutters_s=shutters,
        apertures=apertures,
        focal_lengths_mm=tuple(focals) or None,
        focuses_m=tuple(focuses) or None,
        camera=table.camera.description(),
        target=target,
        recorded=len(table.frames) if isinstance(table, FramesTable) else None,
    )


def _check_target(values: dict[str, Any], file: Path) -> None:
    target = values.get("target")
    if not isinstance(target, dict) or not isinstance(target.get("model"), str):
        raise BadInput(
            f"{file} has no [target] model.",
            'Write [target] and model = "FILE" (a .cao, OBJ, STL, PLY or glTF).',
        )
    model = file.parent / target["model"]
    if not model.is_file():
        raise BadInput(
            f"{file}: [target] model: there is no file {model}.", "Paths are relative to the stack folder."
        )


def _load_basis(folder: Path, table: BasisTable) -> BasisStack:
    size = (table.camera.height, table.camera.width)
    radiances = tuple(
        _read_radiance(folder, light.radiance, size, f"[[lights]] {light.name!r} radiance")
        for light in table.lights
    )
    if table.ambient is None:
        if table.ambient_scale != 0:
            raise BadInput(
                f"{folder / STACK_FILE} has no key ambient, the image of sun and all that is not a light.",
                "Add it, or write ambient_scale = 0.",
            )
        ambient = np.zeros(size, np.float32)
    else:
        ambient = _read_radiance(folder, table.ambient, size, "ambient")
    return BasisStack(folder, table, radiances, ambient)


def _load_frames(folder: Path, table: FramesTable) -> FramesStack:
    file = folder / STACK_FILE
    count = len(table.frames[0].lights)
    if table.lights is not None:
        count = len(table.lights)
    for number, frame in enumerate(table.frames, 1):
        if len(frame.lights) != count:
            raise BadInput(
                f"{file}: [[frames]] {number} gives {len(frame.lights)} light levels, not {count}.",
                "Every frame needs one level per light.",
            )
        for light, level in zip(table.lights or (), frame.lights, strict=False):
            if level >= light.levels:
                raise BadInput(
                    f"{file}: [[frames]] {number}: light {light.name!r} has no level {level}.",
                    f"Allowed: 0 to {light.levels - 1}.",
                )
    size = (table.camera.height, table.camera.width)
    images = tuple(
        _read_frame(folder, frame.image, size, f"[[frames]] {number} image")
        for number, frame in enumerate(table.frames, 1)
    )
    return FramesStack(folder, table, images)


def _lights_of(frames: tuple[FrameTable, ...]) -> tuple[FramesLight, ...]:
    """Lights of a frames stack that does not list them: as many levels as its frames tell of."""
    columns = zip(*(frame.lights for frame in frames), strict=True)
    return tuple(
        FramesLight(name=f"light {number}", levels=max(column) + 1)
        for number, column in enumerate(columns, 1)
    )


def _read_image(folder: Path, name: str, size: tuple[int, int], key: str) -> NDArray[Any]:
    file = folder / name
    if not file.is_file():
        raise BadInput(f"{folder / STACK_FILE}: {key}: there is no file {file}.")
    image = cv2.imread(str(file), cv2.IMREAD_ANYDEPTH | cv2.IMREAD_ANYCOLOR)  # turned as its EXIF says
    if image is None:
        raise BadInput(f"{folder / STACK_FILE}: {key}: {file} is not an image that can be read.")
    if image.ndim == 3:
        image = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    if image.shape != size:
        raise BadInput(
            f"{folder / STACK_FILE}: {key}: {file} is {image.shape[1]}×{image.shape[0]} px,"
            f" but [camera] says {size[1]}×{size[0]}."
        )
    return np.asarray(image)


def _read_radiance(folder: Path, name: str, size: tuple[int, int], key: str) -> Field:
    image = _read_image(folder, name, size, key)
    if image.dtype != np.uint16:
        raise BadInput(
            f"{folder / STACK_FILE}: {key}: {folder / name} has {8 * image.dtype.itemsize} bits a pixel;"
            " a basis stack needs linear 16-bit images.",
            'Record 8-bit frames as kind = "frames".',
        )
    return image.astype(np.float32) / np.float32(FULL_SCALE_16)


def _read_frame(folder: Path, name: str, size: tuple[int, int], key: str) -> FramePixels:
    image = _read_image(folder, name, size, key)
    if image.dtype not in (np.uint8, np.uint16):
        raise BadInput(
            f"{folder / STACK_FILE}: {key}: {folder / name} has {image.dtype} pixels.",
            "Use 8-bit or 16-bit grey.",
        )
    return image


def with_conditions(
    stack: BasisStack,
    ambient_scale: float | None = None,
    light_power: float | None = None,
    defocus_sigma_px: float | None = None,
    motion_px_per_s: tuple[float, float] | None = None,
) -> BasisStack:
    """The same stack under another sun, other lamps or another blur; None keeps what the stack says.

    `light_power` multiplies the power of every light.
    """
    table = stack.table
    camera = table.camera.blurred_by(defocus_sigma_px, motion_px_per_s)
    lights = table.lights
    if light_power is not None:
        lights = tuple(msgspec.structs.replace(light, power=light.power * light_power) for light in lights)
    scale = table.ambient_scale if ambient_scale is None else ambient_scale
    changed = msgspec.structs.replace(table, camera=camera, lights=lights, ambient_scale=scale)
    return BasisStack(stack.folder, changed, stack.radiances, stack.ambient)
