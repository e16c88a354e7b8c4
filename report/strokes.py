"""The model's wireframe over an image as SVG paths: drawn here, or as the vision server has drawn it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bridge.messages import PoseMessage
from bridge.result_file import LineRecord
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model
from geometry.pose import Pose
from geometry.wireframe import Run, bounds_of, visible_runs
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
    scene: Scene, record: PoseMessage | None, support: Mapping[int, float] | None, at_once: bool = False
) -> Strokes | None:
    """The visible wireframe at a pose as SVG paths; None where it cannot be drawn or is out of view.

    `at_once`: what the vision server draws and has not drawn yet is not waited for: None.
    """
    pose = pose_of(record)
    if pose is None or scene.camera is None or scene.model is None:
        return None
    if at_once and scene.wireframes is not None and scene.wireframes.at(pose) is None:
        return None
    try:
        runs = runs_of(scene, scene.model, scene.camera, pose)
    except GeometryError:
        return None
    bounds = bounds_of(runs)
    if bounds is None:
        return None
    good = [run for run in runs if is_supported(run.line, support)]
    poor = [run for run in runs if not is_supported(run.line, support)]
    return Strokes(_path(good), _path(poor), bounds, _spread(runs, scene.camera))


def runs_of(scene: Scene, model: Model, camera: Camera, pose: Pose) -> Sequence[Run]:
    """What is seen of the scene's model at a pose: as the vision server has drawn it there, or drawn here.

    Raises
    ------
    GeometryError : a model or camera that cannot be used.
    """
    drawn = None if scene.wireframes is None else scene.wireframes.at(pose)
    return visible_runs(model, camera, pose) if drawn is None else drawn


def support_of(lines: list[LineRecord] | None) -> dict[int, float] | None:
    """Best support of each line, by line index; None where nothing was recorded."""
    if not lines:
        return None
    support: dict[int, float] = {}
    for record in lines:
        support[record.line] = max(record.support, support.get(record.line, 0.0))
    return support


def pose_of(record: PoseMessage | None) -> Pose | None:
    """The pose of a record."""
    return None if record is None else Pose.of(record)


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
