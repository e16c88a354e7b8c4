"""Writing stack folders that `stack.load_stack` reads (DESIGN.md §5)."""

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from bridge.messages import Describe, Settings
from stack.reading import FULL_SCALE_16, STACK_FILE
from stack.toml_text import toml_text


def new_folder(folder: Path) -> None:
    """Make a folder for a stack.

    Raises
    ------
    BadInput : there is a stack already, or it cannot be made.
    """
    if (folder / STACK_FILE).exists():
        raise BadInput(f"{folder} holds a stack already.", "Give another folder.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(
            f"Cannot make the folder {folder}: {error.strerror}.", "Give another folder."
        ) from None


def described(folder: Path, describe: Describe) -> dict[str, Any]:
    """Camera, lights and target of a stack; the model file is copied into its folder.

    Raises
    ------
    BadInput : calibration or target is not known.
    """
    if describe.camera is None:
        raise BadInput(
            "A stack needs the camera's calibration.", "Give --camera-model TOML, or [camera] in its file."
        )
    if describe.target is None:
        raise BadInput("A stack needs its target.", "Give --target NAME_OR_FILE.")
    model = Path(describe.target.model)
    shutil.copyfile(model, folder / model.name)
    target = {**msgspec.to_builtins(describe.target), "model": model.name}
    return {
        "camera": {
            **msgspec.to_builtins(describe.camera),
            "shutters_s": list(describe.shutters_s),
            "apertures": list(describe.apertures),
        },
        "lights": [msgspec.to_builtins(light) for light in describe.lights],
        "target": target,
    }


def write_frames(
    folder: Path, describe: Describe, frames: Sequence[tuple[Settings, NDArray[np.uint8]]]
) -> None:
    """A stack of kind "frames": each frame, bit for bit, with the settings it was taken under."""
    table = {"kind": "frames", **described(folder, describe), "frames": []}
    for number, (settings, pixels) in enumerate(frames, 1):
        name = f"frame{number:04d}.png"
        _write_png(folder / name, pixels)
        table["frames"].append({"image": name, **msgspec.to_builtins(settings)})
    _write_table(folder, table)


def write_basis(
    folder: Path,
    describe: Describe,
    aperture: float,
    radiances: Mapping[str, NDArray[np.floating[Any]]],
    ambient: NDArray[np.floating[Any]],
) -> None:
    """A stack of kind "basis", for one aperture.

    Parameters
    ----------
    radiances : (H, W) of each light at full level, by its name; 1 clips at the reference exposure, gain 1.
    ambient : the same of everything else.

    An image brighter than 1 is stored at full scale with the light's `power`, or `ambient_scale`, as factor.
    """
    table = {"kind": "basis", "ambient": "ambient.png", **described(folder, describe)}
    table["camera"]["apertures"] = [aperture]
    table["ambient_scale"] = _write_radiance(folder / "ambient.png", ambient)
    for number, light in enumerate(table["lights"], 1):
        light["radiance"] = f"light{number}.png"
        light["power"] = _write_radiance(folder / light["radiance"], radiances[light["name"]])
    _write_table(folder, table)


def _write_radiance(file: Path, radiance: NDArray[np.floating[Any]]) -> float:
    """Write an image scaled to 16 bits; the factor that undoes the scaling."""
    peak = float(radiance.max(initial=0.0))
    factor = peak if peak > 1.0 else 1.0
    scaled = np.rint(radiance.clip(0.0) * (FULL_SCALE_16 / factor)).astype(np.uint16)
    _write_png(file, scaled)
    return factor


def _write_png(file: Path, image: NDArray[Any]) -> None:
    if not cv2.imwrite(str(file), image, [cv2.IMWRITE_PNG_COMPRESSION, 3]):
        raise BadInput(f"Cannot write {file}.", "Is there space, and may you write there?")


def _write_table(folder: Path, table: Mapping[str, Any]) -> None:
    try:
        (folder / STACK_FILE).write_text(toml_text(table), encoding="utf-8")
    except OSError as error:
        raise BadInput(f"Cannot write {folder / STACK_FILE}: {error.strerror}.") from None
