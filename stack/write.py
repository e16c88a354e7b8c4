"""Writing stack folders that `stack.read.load_stack` reads."""

import hashlib
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from bridge.arrays import FramePixels
from bridge.errors import BadInput
from bridge.messages import Describe, Settings, TargetDescription
from bridge.whole_file import replaced
from geometry.errors import GeometryError
from geometry.model import files_of_model
from stack.exposure import FULL_SCALE_16
from stack.format import STACK_FILE, FrameTable
from stack.tables import toml_text

PNG_COMPRESSION = 3  # of 9; zlib's higher steps take longer and gain 1 % on noisy frames
Radiance = NDArray[np.floating[Any]]


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


def known_target(describe: Describe) -> TargetDescription:
    """The target of what a stack can be of.

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
    return describe.target


def described(folder: Path, describe: Describe) -> dict[str, Any]:
    """Camera, lights and target of a stack; the model file is copied into its folder, with what it reads.

    Raises
    ------
    BadInput : calibration or target is not known, or the model cannot be copied.
    """
    model = Path(known_target(describe).model)
    for file in _files_of(model):
        copy = folder / file.relative_to(model.parent)
        try:
            copy.parent.mkdir(parents=True, exist_ok=True)
            if not (copy.exists() and copy.samefile(file)):
                shutil.copyfile(file, copy)
        except OSError as error:
            raise BadInput(
                f"Cannot copy {file} to {copy}: {error.strerror or error}.",
                "Is there space, and may you write there?",
            ) from None
    table = msgspec.to_builtins({key: getattr(describe, key) for key in ("camera", "lights", "target")})
    table["camera"] |= {"shutters_s": list(describe.shutters_s), "apertures": list(describe.apertures)}
    table["target"] |= {"model": model.name, "sha256": file_sha256(folder / model.name)}
    return dict(table)


def _files_of(model: Path) -> list[Path]:
    try:
        return files_of_model(model)
    except GeometryError as error:
        raise BadInput(f"{error}.") from None


def file_sha256(file: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


@contextmanager
def frames_stack(folder: Path, describe: Describe) -> Iterator[Callable[[Settings, FramePixels], None]]:
    """A stack of kind "frames": what writes a frame, bit for bit, with the settings it was taken under.

    However it ends, the frames that were written are a stack; without any there is none.
    """
    table = described(folder, describe)
    listed: list[FrameTable] = []

    def write(settings: Settings, pixels: FramePixels) -> None:
        name = f"frame{len(listed) + 1:04d}.png"
        try:
            write_png(folder / name, pixels)
        except BadInput:
            (folder / name).unlink(missing_ok=True)  # half of it may be there
            raise
        listed.append(frame_table(name, settings))

    try:
        yield write
    finally:
        if listed:
            write_table(folder, {"kind": "frames", **table, "frames": msgspec.to_builtins(listed)})


def frame_table(image: str, settings: Settings) -> FrameTable:
    """An image file and the settings it was taken under."""
    return FrameTable(image=image, **{name: getattr(settings, name) for name in Settings.__struct_fields__})


def write_basis(
    folder: Path, describe: Describe, aperture: float, radiances: Mapping[str, Radiance], ambient: Radiance
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
    write_table(folder, table)


def write_table(folder: Path, table: Mapping[str, Any]) -> None:
    """The stack file; who reads it meanwhile finds the old one or the new one, whole.

    It is on the disk afterwards, as is the folder: what it lists is there after a loss of power too.

    Raises
    ------
    BadInput : it cannot be written.
    """
    try:
        with replaced(folder / STACK_FILE) as new:
            _write(new, toml_text(table).encode())
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
    except OSError as error:
        raise BadInput(
            f"Cannot write {folder / STACK_FILE}: {error.strerror or error}.", "Is the folder still there?"
        ) from None


def _write_radiance(file: Path, radiance: Radiance) -> float:
    """Write an image scaled to 16 bits; the factor that undoes the scaling."""
    factor = max(1.0, float(radiance.max(initial=0.0)))
    write_png(file, np.rint(radiance.clip(0.0) * (FULL_SCALE_16 / factor)).astype(np.uint16))
    return factor


def write_png(file: Path, image: NDArray[Any], compression: int = PNG_COMPRESSION) -> None:
    """An image (H, W), uint8 or uint16, bit for bit.

    Raises
    ------
    BadInput : it cannot be written.
    """
    encoded, content = cv2.imencode(".png", image, [cv2.IMWRITE_PNG_COMPRESSION, compression])
    if not encoded:
        raise BadInput(f"{file} cannot be encoded.")
    _write(file, content.tobytes())


def _write(file: Path, content: bytes) -> None:
    try:
        with file.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
    except OSError as error:
        raise BadInput(
            f"Cannot write {file}: {error.strerror or error}.", "Is there space, and may you write there?"
        ) from None
