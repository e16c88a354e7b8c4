"""The pose without a seed pose: candidates from templates, aligned and scored as around a seed pose."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from vision_server.matching.match import (
    Anywhere,
    Hypothesis,
    Problem,
    at_scale,
    checked_segments,
    long_enough,
)
from vision_server.matching.nearest_edges import NearestEdges, nearest_edges
from vision_server.matching.search import (
    COARSE_SPACING_PX,
    FINAL_REACH_PX,
    FIRST_REACHES_PX,
    KEPT_REACHES_PX,
    aligned,
    best_of,
    finished,
    scores_of,
)
from vision_server.matching.templates import candidates, directions_of, range_of, sizes_px
from vision_server.matching.views import Views

Floats = NDArray[np.float64]

NORMAL_PX = 400.0  # the largest target of a grid of sizes is looked at as if it were so wide
CANDIDATES, ALIGNED, KEPT = 1500, 300, 60  # poses of each grid of sizes
FINISHED, HYPOTHESES = 40, 12


def match_anywhere(segments: Floats, model: Model, camera: Camera, anywhere: Anywhere) -> list[Hypothesis]:
    """The poses in the frame that the image segments support best, distinct, best first.

    Parameters
    ----------
    segments : (N, 4) float64, [x1, y1, x2, y2] in ideal px.

    Raises
    ------
    GeometryError : malformed segments.
    """
    segments, camera = checked_segments(segments), camera.ideal
    if len(segments) == 0:
        return []
    directions = directions_of(anywhere)
    found = [
        _of_sizes(segments, model, camera, sizes, directions)
        for sizes in sizes_px(camera, model.diameter, anywhere)
    ]
    rotations, translations, scores = (np.concatenate(part) for part in zip(*found, strict=True))
    edges = nearest_edges(segments, camera)
    return finished(edges, model, camera, rotations, translations, scores, FINISHED, HYPOTHESES)


def _of_sizes(
    segments: Floats, model: Model, camera: Camera, sizes: Floats, directions: Floats
) -> tuple[Floats, Floats, Floats]:
    """Poses (N, 3, 3), (N, 3) of the sizes that share a grid, aligned, and their scores (N,).

    The image is looked at as if the target were of one size, so that all reaches are shares of it.
    """
    found = candidates(segments, model, camera, sizes, CANDIDATES, directions)
    scale = NORMAL_PX / sizes[0]
    problem, edges = _scaled(segments, model, camera, scale, float(sizes[len(sizes) // 2]))
    poses = best_of(
        (found.rotations, found.translations),
        scores_of(edges, problem, found.rotations, found.translations, 0.0),
        ALIGNED,
    )
    aligned(edges, problem, *poses, FIRST_REACHES_PX)
    poses = best_of(poses, scores_of(edges, problem, *poses, KEPT_REACHES_PX[0]), KEPT)
    aligned(edges, problem, *poses, KEPT_REACHES_PX)
    scores = scores_of(edges, problem, *poses, FINAL_REACH_PX) / scale
    scores[(poses[1] + poses[0] @ model.middle)[:, 2] <= 0.0] = -np.inf
    return *poses, scores


def _scaled(
    segments: Floats, model: Model, camera: Camera, scale: float, size_px: float
) -> tuple[Problem, NearestEdges]:
    """The image at another scale, and the model as seen where it is so wide in the image, px."""
    ends, small = at_scale(segments, camera, scale)
    ahead = Pose(np.zeros(3), np.array([0.0, 0.0, range_of(model, camera, size_px)]) - model.middle)
    views = Views(model, small, ahead, COARSE_SPACING_PX)
    ends = ends[long_enough(ends, views.typical_line_px(ahead))]
    return Problem(ends, views, small), nearest_edges(ends, small)
