"""The session's images for the page: read, made small for embedding, drawn over for the run folder."""

import base64
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.pose import Pose
from report.errors import ReportError
from report.overlay import draw_overlay, is_supported
from report.records import LineRecord, PoseRecord
from report.scene import Scene
from report.wireframe import Run, bounds_of, visible_runs

Pixels = NDArray[np.uint8]

STEP_WIDTH_PX, HERO_WIDTH_PX = 640, 1600  # chosen by hand, with the quality: a page of some hundred KB
STEP_QUALITY = 80  # of JPEG, per cent
BORDER_PX = 6  # line ends nearer to the border than this are where the image cuts them
PNG_FASTEST = [cv2.IMWRITE_PNG_COMPRESSION, 1]
SAFE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


@dataclass(frozen=True, eq=False)
class Picture:
    """An image of the session, or why there is none.

    Attributes
    ----------
    name : the image's id.
    pixels : grey, or None.
    edges : edge map of the set with this image, or None.
    problem : what is wrong, in a sentence; empty when the image is there.
    """

    name: str
    pixels: Pixels | None
    problem: str = ""
    edges: Pixels | None = None


@dataclass(frozen=True)
class Strokes:
    """The wireframe as SVG path data in image pixels, and its bounds (left, top, right, bottom)."""

    supported: str
    unsupported: str
    bounds: tuple[float, float, float, float]
    corners: tuple[tuple[float, float], ...]


def read_picture(folder: Path, name: str | None, scene: Scene) -> Picture:
    """Read RUN_FOLDER/images/<name>.png as grey; what is missing becomes a problem, not an error.

    Raises
    ------
    ReportError : an image id that is no plain file name.
    """
    if name is None:
        return Picture("", None, "No image was recorded for this step.")
    if not SAFE_NAME.fullmatch(name):
        raise ReportError(f"{folder / 'result.json'}: image id {name!r} is no plain file name such as i1")
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


def _read(path: Path) -> Pixels | None:
    """A file as it is to be looked at: one of 16 bits as bright as its brightest pixel lets it."""
    grey = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH
    pixels = cv2.imdecode(np.fromfile(path, np.uint8), grey) if path.stat().st_size else None
    if pixels is None or pixels.dtype == np.uint8:
        return None if pixels is None else np.asarray(pixels, np.uint8)
    return np.asarray(cv2.convertScaleAbs(pixels, alpha=255.0 / max(float(pixels.max()), 1.0)), np.uint8)


def _edges(path: Path) -> Pixels | None:
    edges = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) if path.is_file() else None
    return None if edges is None else np.asarray(edges, dtype=np.uint8)


def data_uri(pixels: Pixels, large: bool) -> str:
    """An image as a data URI: a small JPEG, or, for looking at single pixels, a large PNG."""
    width_px = HERO_WIDTH_PX if large else STEP_WIDTH_PX
    if pixels.shape[1] > width_px:
        height = max(1, round(pixels.shape[0] * width_px / pixels.shape[1]))
        pixels = np.asarray(cv2.resize(pixels, (width_px, height), interpolation=cv2.INTER_AREA), np.uint8)
    kind = "png" if large else "jpeg"
    options = PNG_FASTEST if large else [cv2.IMWRITE_JPEG_QUALITY, STEP_QUALITY]
    _, data = cv2.imencode(f".{kind}", pixels, options)
    return f"data:image/{kind};base64,{base64.b64encode(data.tobytes()).decode('ascii')}"


def support_of(lines: list[LineRecord] | None) -> dict[int, float] | None:
    """Best support of each line, by line index; None where nothing was recorded."""
    if not lines:
        return None
    support: dict[int, float] = {}
    for record in lines:
        support[record.line] = max(record.support, support.get(record.line, 0.0))
    return support


def pose_of(record: PoseRecord | None) -> Pose | None:
    """The pose of a record."""
    return None if record is None else Pose(np.array(record.rotation_vector), np.array(record.translation))


def strokes_of(
    scene: Scene, record: PoseRecord | None, support: Mapping[int, float] | None
) -> Strokes | None:
    """The visible wireframe at a pose as SVG paths; None where it cannot be drawn or is out of view."""
    pose = pose_of(record)
    if pose is None or scene.camera is None or scene.model is None:
        return None
    try:
        runs = visible_runs(scene.model, scene.camera, pose)
    except GeometryError:
        return None
    bounds = bounds_of(runs)
    if bounds is None:
        return None
    good = [run for run in runs if is_supported(run.line, support)]
    poor = [run for run in runs if not is_supported(run.line, support)]
    return Strokes(_path(good), _path(poor), bounds, _spread(runs, scene.camera))


def write_overlay(
    folder: Path,
    picture: Picture,
    scene: Scene,
    record: PoseRecord | None,
    support: Mapping[int, float] | None,
) -> bool:
    """Write RUN_FOLDER/images/<name>-overlay.png; False where there is no image, camera, model or pose.

    Raises
    ------
    ReportError : the picture cannot be written.
    """
    pose = pose_of(record)
    if picture.pixels is None or scene.camera is None or scene.model is None or pose is None:
        return False
    drawn = draw_overlay(picture.pixels, scene.model, scene.camera, pose, support)
    path = folder / "images" / f"{picture.name}-overlay.png"
    _, data = cv2.imencode(".png", drawn, PNG_FASTEST)
    try:
        path.write_bytes(data.tobytes())
    except OSError as error:
        raise ReportError(f"{path}: cannot be written ({error.strerror})") from error
    return True


def legibility(pixels: Pixels, bounds: tuple[float, float, float, float] | None) -> float:
    """How well the target can be made out: spread of its grey values, less what is saturated."""
    if bounds is not None:
        left, top, right, bottom = (round(value) for value in bounds)
        pixels = pixels[max(0, top) : bottom + 1, max(0, left) : right + 1]
    if pixels.size == 0:
        return 0.0
    low, high = np.percentile(pixels, [5, 95])
    return float(high - low) * (1.0 - float((pixels >= 250).mean()))


def _path(runs: list[Run]) -> str:
    """Path data in SVG's coordinates, where pixel (0, 0) covers 0 to 1."""
    parts = []
    for run in runs:
        points = " ".join(f"{x + 0.5:.2f} {y + 0.5:.2f}" for x, y in run.points)
        parts.append(f"M{points}")
    return "".join(parts)


def _spread(runs: list[Run], camera: Camera, count: int = 3) -> tuple[tuple[float, float], ...]:
    """Ends of runs that lie far apart and not where the image cuts a line: places to look at closely."""
    ends = np.concatenate([run.points[[0, -1]] for run in runs])
    inside = ((ends > BORDER_PX) & (ends < [camera.width - BORDER_PX, camera.height - BORDER_PX])).all(axis=1)
    ends = ends[inside]
    if len(ends) == 0:
        return ()
    chosen = [int(np.argmin(ends[:, 0]))]
    while len(chosen) < min(count, len(ends)):
        nearest = np.linalg.norm(ends[:, None] - ends[chosen], axis=2).min(axis=1)
        chosen.append(int(np.argmax(nearest)))
    return tuple((float(ends[i, 0]), float(ends[i, 1])) for i in chosen)
