"""The session's images for the page: read, made small for embedding, drawn over for the run folder."""

import base64
import re
from collections.abc import Mapping
from pathlib import Path

import cv2
import numpy as np
import numpy.ma  # np.percentile loads it: now, while what the page shows is not there yet

from bridge.errors import BadInput
from bridge.messages import PoseMessage
from numerics.arrays import Grey
from report.overlay import draw_runs
from report.scene import Scene
from report.story import Picture
from report.strokes import pose_of, runs_of

STEP_WIDTH_PX, HERO_WIDTH_PX = 640, 1600  # chosen by hand, with the quality: a page of some hundred KB
STEP_QUALITY = 80  # of JPEG, per cent
PNG_FASTEST = [cv2.IMWRITE_PNG_COMPRESSION, 1]
SAFE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


def read_picture(folder: Path, name: str | None, scene: Scene) -> Picture:
    """Read RUN_FOLDER/images/<name>.png as grey; what is missing becomes a problem, not an error.

    Raises
    ------
    BadInput : an image id that is no plain file name.
    """
    if name is None:
        return Picture("", None, "No image was recorded for this step.")
    if not SAFE_NAME.fullmatch(name):
        raise BadInput(f"{folder / 'result.json'}: image id {name!r} is no plain file name such as i1")
    path = folder / "images" / f"{name}.png"
    if not path.is_file():
        return Picture(name, None, f"The file images/{name}.png is missing.")
    pixels = _read(path)
    if pixels is None:
        return Picture(name, None, f"The file images/{name}.png is no readable image.")
    camera = scene.camera
    if camera is not None and pixels.shape != (camera.height, camera.width):
        size = f"{pixels.shape[1]}×{pixels.shape[0]}"
        return Picture(name, None, f"images/{name}.png is {size}, its camera {camera.width}×{camera.height}.")
    return Picture(name, np.asarray(pixels, dtype=np.uint8), edges=_edges(path.with_stem(f"{name}-edges")))


def _read(path: Path) -> Grey | None:
    """A file as it is to be looked at: one of 16 bits as bright as its brightest pixel lets it."""
    grey = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH
    pixels = cv2.imdecode(np.fromfile(path, np.uint8), grey) if path.stat().st_size else None
    if pixels is None or pixels.dtype == np.uint8:
        return None if pixels is None else np.asarray(pixels, np.uint8)
    return np.asarray(cv2.convertScaleAbs(pixels, alpha=255.0 / max(float(pixels.max()), 1.0)), np.uint8)


def _edges(path: Path) -> Grey | None:
    edges = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) if path.is_file() else None
    return None if edges is None else np.asarray(edges, dtype=np.uint8)


def data_uri(pixels: Grey, large: bool) -> str:
    """An image as a data URI: a small JPEG, or, for looking at single pixels, a large PNG."""
    width_px = HERO_WIDTH_PX if large else STEP_WIDTH_PX
    if pixels.shape[1] > width_px:
        height = max(1, round(pixels.shape[0] * width_px / pixels.shape[1]))
        pixels = np.asarray(cv2.resize(pixels, (width_px, height), interpolation=cv2.INTER_AREA), np.uint8)
    kind = "png" if large else "jpeg"
    options = PNG_FASTEST if large else [cv2.IMWRITE_JPEG_QUALITY, STEP_QUALITY]
    _, data = cv2.imencode(f".{kind}", pixels, options)
    return f"data:image/{kind};base64,{base64.b64encode(data.tobytes()).decode('ascii')}"


def write_overlay(
    folder: Path,
    picture: Picture,
    scene: Scene,
    record: PoseMessage | None,
    support: Mapping[int, float] | None,
) -> bool:
    """Write RUN_FOLDER/images/<name>-overlay.png; False where there is no image, camera, model or pose.

    Raises
    ------
    BadInput : the picture cannot be written.
    """
    pose = pose_of(record)
    if picture.pixels is None or scene.camera is None or scene.model is None or pose is None:
        return False
    runs = runs_of(scene, scene.model, scene.camera, pose)
    drawn = draw_runs(picture.pixels, runs, scene.camera, support)
    path = folder / "images" / f"{picture.name}-overlay.png"
    _, data = cv2.imencode(".png", drawn, PNG_FASTEST)
    try:
        path.write_bytes(data.tobytes())
    except OSError as error:
        raise BadInput(f"{path}: cannot be written ({error.strerror})") from error
    return True


def legibility(pixels: Grey, bounds: tuple[float, float, float, float] | None) -> float:
    """How well the target can be made out: spread of its grey values, less what is saturated."""
    if bounds is not None:
        left, top, right, bottom = (round(value) for value in bounds)
        pixels = pixels[max(0, top) : bottom + 1, max(0, left) : right + 1]
    if pixels.size == 0:
        return 0.0
    low, high = np.percentile(pixels, [5, 95])
    return float(high - low) * (1.0 - float((pixels >= 250).mean()))
