"""Where a model's visible lines lie in an image: runs of points, hidden parts left out."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Floats

DRAWN_SPACING_PX = 1.0  # of samples, as fine as pixels are
DRAWN_GAP_STEPS = 1.6  # samples of a line farther apart than so many steps have something hidden between them
MOST_CHORD_PX = 0.2  # that what is drawn leaves an arc of facets, or a line through a lens (by hand)


@dataclass(frozen=True, eq=False)
class Run:
    """A visible stretch of one model line.

    Attributes
    ----------
    line : index into the model's lines.
    points : (K, 2) float64, px, along the stretch; two points where it is straight.
    """

    line: int
    points: Floats


def visible_runs(model: Model, camera: Camera, pose: Pose) -> list[Run]:
    """Visible stretches of the model's lines in the image, through the lens, in the order of the lines.

    Raises
    ------
    GeometryError : a model or camera that cannot be used.
    """
    from geometry.visibility import visible_samples  # late: who only reads what was drawn needs no kernels

    samples = visible_samples(model, camera, pose, DRAWN_SPACING_PX)
    if len(samples.line) == 0:
        return []
    step = np.linalg.norm(np.diff(samples.image, axis=0), axis=1)
    reach = DRAWN_GAP_STEPS * np.maximum(samples.px[1:], samples.px[:-1])
    starts = np.flatnonzero((np.diff(samples.line) != 0) | (step > reach)) + 1
    edges = [0, *starts.tolist(), len(samples.line)]
    runs = []
    for first, end in itertools.pairwise(edges):
        points = samples.image[first:end]
        half = 0.5 * samples.px[[first, end - 1], None] * samples.image_direction[[first, end - 1]]
        points = np.concatenate([points[:1] - half[:1], points, points[-1:] + half[1:]])
        runs.append(Run(int(samples.line[first]), _cornered(points)))
    return runs


def _cornered(points: Floats) -> Floats:
    """Of points along a stretch, (K, 2), those that tell where it is: its ends where it is straight."""
    import cv2  # late, as the kernels above

    corners = cv2.approxPolyDP(points.astype(np.float32), MOST_CHORD_PX, closed=False)
    return np.asarray(corners[:, 0], dtype=np.float64)


def bounds_of(runs: Sequence[Run]) -> tuple[float, float, float, float] | None:
    """Least x, least y, greatest x, greatest y of the runs, px; None when there are none."""
    if not runs:
        return None
    points = np.concatenate([run.points for run in runs])
    (left, top), (right, bottom) = points.min(axis=0), points.max(axis=0)
    return float(left), float(top), float(right), float(bottom)
