"""The model's wireframe over an image as SVG paths: drawn here, or as the vision server has drawn it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geometry.camera import Camera
from geometry.drawn_wireframes import WIREFRAMES, drawn_runs
from geometry.errors import GeometryError
from geometry.pose import Pose
from geometry.wireframe import Run, bounds_of, visible_runs
from report.records import LineRecord, PoseRecord
from report.scene import Scene

SUPPORT_ENOUGH = 0.5  # a line with this share of its visible length supported counts as supported
BORDER_PX = 6  # line ends nearer to the border than this are where the image cuts them


@dataclass(frozen=True)
class Strokes:
    """The wireframe as SVG path data in image pixels, and its bounds (left, top, right, bottom)."""

    supported: str
    unsupported: str
    bounds: tuple[float, float, float, float]
    corners: tuple[tuple[float, float], ...]


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
    return _strokes(runs, scene.camera, support)


def drawn_strokes(
    folder: Path, scene: Scene, record: PoseRecord | None, support: Mapping[int, float] | None
) -> Strokes | None:
    """The same, of what the vision server has drawn at this pose, in the run folder's images.

    Where there is no such file, as in a folder of an earlier version, it is drawn here.
    """
    try:
        lines = (folder / "images" / WIREFRAMES).read_bytes().splitlines()
    except OSError:
        return strokes_of(scene, record, support)
    pose = pose_of(record)
    if pose is None or scene.camera is None:
        return None
    runs = drawn_runs(lines, pose)
    return None if runs is None else _strokes(runs, scene.camera, support)


def _strokes(runs: Sequence[Run], camera: Camera, support: Mapping[int, float] | None) -> Strokes | None:
    bounds = bounds_of(runs)
    if bounds is None:
        return None
    good = [run for run in runs if is_supported(run.line, support)]
    poor = [run for run in runs if not is_supported(run.line, support)]
    return Strokes(_path(good), _path(poor), bounds, _spread(runs, camera))


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


def is_supported(line: int, support: Mapping[int, float] | None) -> bool:
    """Whether a line counts as supported; every line does where nothing is known."""
    return support is None or support.get(line, 0.0) >= SUPPORT_ENOUGH


def _path(runs: Sequence[Run]) -> str:
    """Path data in SVG's coordinates, where pixel (0, 0) covers 0 to 1."""
    parts = []
    for run in runs:
        points = " ".join(f"{x + 0.5:.2f} {y + 0.5:.2f}" for x, y in run.points)
        parts.append(f"M{points}")
    return "".join(parts)


def _spread(runs: Sequence[Run], camera: Camera, count: int = 3) -> tuple[tuple[float, float], ...]:
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
