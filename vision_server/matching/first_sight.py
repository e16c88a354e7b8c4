"""The pose without a seed pose: candidates from templates, aligned and scored as around a seed pose.

In go segments, a model and what is known of the pose (`Anywhere`); out come hypotheses as of `search`. The
sizes that the target may have in the image are tried in grids of a few (`templates`), then compared.
"""

from __future__ import annotations

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Floats
from vision_server.matching.icp import SIGNIFICANCE
from vision_server.matching.looks import Looks, cell_px_of, directions_of, looks_of, range_of
from vision_server.matching.match import (
    Anywhere,
    Hypothesis,
    Problem,
    at_scale,
    checked_segments,
    distinct,
    long_enough,
)
from vision_server.matching.nearest_edges import nearest_edges
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
from vision_server.matching.templates import candidates, sizes_px
from vision_server.matching.views import Views

# By hand, as time is in proportion: `python -m benchmarks.first_sight` says what other numbers find.
GRID_TARGET_PX = 400.0  # the largest target of a grid of sizes is looked at as if it were so wide
CANDIDATES, ALIGNED, KEPT, FINISHED_A_GRID = 1500, 300, 60, 12  # poses of each grid of sizes, stage by stage
MOST_FIRST_SIGHT_HYPOTHESES = 12  # of all grids, whose scores are only roughly comparable
WIDEST_FRAME_PX = 1280.0  # a frame that is wider is looked at as if it were so wide, when these are finished
FAR_DIAMETERS = 2.5  # diameters: from there on, what is seen of a target hardly depends on how far it is


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
    found: list[tuple[Floats, Floats, Floats]] = []
    looks, views = None, None
    for sizes in sizes_px(camera, model.diameter, anywhere):
        if looks is None or views is None or looks.distance < FAR_DIAMETERS * model.diameter:
            distance = range_of(model, camera, float(sizes[len(sizes) // 2]))
            views = _views(model, camera, sizes, distance)
            looks = looks_of(views, model, distance, directions, cell_px_of(sizes) * _scale(sizes))
        found.append(_of_sizes(segments, model, camera, sizes, looks, views))
    rotations, translations, scores = (np.concatenate(part) for part in zip(*found, strict=True))
    ends, small = at_scale(segments, camera, min(1.0, WIDEST_FRAME_PX / max(camera.width, camera.height)))
    edges, poses = nearest_edges(ends, small), (rotations, translations)
    return finished(
        edges, model, small, poses, scores, len(scores), MOST_FIRST_SIGHT_HYPOTHESES, SIGNIFICANCE
    )


def _of_sizes(
    segments: Floats, model: Model, camera: Camera, sizes: Floats, looks: Looks, views: Views
) -> tuple[Floats, Floats, Floats]:
    """Distinct poses (N, 3, 3), (N, 3) of the sizes that share a grid, aligned, and their scores (N,).

    The image is looked at as if the target were of one size, so that all reaches are shares of it, and what
    is seen of a target that is far away serves for all sizes.
    """
    found = candidates(segments, model, camera, sizes, CANDIDATES, looks)
    scale = _scale(sizes)
    ends, small = at_scale(segments, camera, scale)
    ahead = Pose(np.zeros(3), np.array([0.0, 0.0, looks.distance]) - model.middle)
    ends = ends[long_enough(segments, views.typical_line_px(ahead) / scale, least_px=0.0)]
    problem, edges = Problem(ends, views, small), nearest_edges(ends, small)
    poses = best_of(
        (found.rotations, found.translations),
        scores_of(edges, problem, found.rotations, found.translations, 0.0, merit=SIGNIFICANCE),
        ALIGNED,
    )
    aligned(edges, problem, *poses, FIRST_REACHES_PX)
    poses = best_of(poses, scores_of(edges, problem, *poses, KEPT_REACHES_PX[0], merit=SIGNIFICANCE), KEPT)
    aligned(edges, problem, *poses, KEPT_REACHES_PX)
    scores = scores_of(edges, problem, *poses, FINAL_REACH_PX, merit=SIGNIFICANCE)
    scores[(poses[1] + poses[0] @ model.middle)[:, 2] <= 0.0] = -np.inf
    kept = distinct(*poses, scores, FINISHED_A_GRID)
    return poses[0][kept], poses[1][kept], scores[kept]


def _scale(sizes: Floats) -> float:
    """Of the image in which the largest of the sizes is GRID_TARGET_PX."""
    return float(GRID_TARGET_PX / sizes[0])


def _views(model: Model, camera: Camera, sizes: Floats, distance: float) -> Views:
    """What is seen of the model from such a distance, in the scaled image of these sizes."""
    ahead = Pose(np.zeros(3), np.array([0.0, 0.0, distance]) - model.middle)
    return Views(model, camera.scaled(_scale(sizes)), ahead, COARSE_SPACING_PX)
