"""The matcher that does not miss: quasi-random poses, scored, pulled onto the edges, scored again."""

from __future__ import annotations

import time

import numpy as np
from numba import njit
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import MIN_LINE_PX, Solid, image_bounds, trace
from vision_server.matching.draws import even_numbers, in_range, poses_around
from vision_server.matching.icp import pull, pull_poses, score_poses, supported_fraction
from vision_server.matching.match import (
    Candidate,
    Match,
    SearchRange,
    checked_segments,
    distinct,
    long_enough,
    must_be_in_front,
)
from vision_server.matching.nearest_edges import NearestEdges, nearest_edges
from vision_server.matching.views import Views, ViewTable, sparse_solid

Floats = NDArray[np.float64]

DRAWS = 4096
PULLED = 100
FINISHED = 12
CANDIDATES = 5
COARSE_SPACING_PX = 8.0
FINE_SPACING_PX = 2.0
FINAL_REACH_PX = 5.0
PULL_REACHES_PX = (30.0, 20.0, 12.0, 6.0)
FINISH_REACHES_PX = (6.0, 4.0, 3.0)
PULL_ITERATIONS = 3
FINISH_ITERATIONS = 2


def match_search(
    segments: Floats,
    weights: Floats | None,
    model: Model,
    camera: Camera,
    seed_pose: Pose,
    seed: int,
    search_range: SearchRange = SearchRange(),
) -> Match:
    """Find the poses in the search range that the image segments support best.

    Parameters
    ----------
    segments : (N, 4) float64, [x1, y1, x2, y2] in ideal px.
    weights : (N,) float64, trust in each segment, or None.
    seed_pose : middle of the search range.
    seed : of the quasi-random draws.

    Raises
    ------
    GeometryError : malformed segments or weights, a seed pose behind the camera.
    """
    began = time.perf_counter()
    segments, weights = checked_segments(segments, weights)
    must_be_in_front(seed_pose)
    views = Views(model, camera.ideal, seed_pose, COARSE_SPACING_PX)
    long = (weights > 0) & long_enough(segments, views.typical_line_px(seed_pose))
    if not long.any():
        return Match((), {"segments": 0.0})
    camera = camera.ideal
    edges = nearest_edges(segments[long], np.ones(int(long.sum())), camera)
    built = time.perf_counter()
    rotations, translations = poses_around(seed_pose, camera, search_range, even_numbers(DRAWS, seed))
    scores = _scores(edges, views, rotations, translations, camera, 0.0)
    scored = time.perf_counter()
    best = np.argsort(-scores, kind="stable")[:PULLED]
    rotations, translations = rotations[best].copy(), translations[best].copy()
    for reach in PULL_REACHES_PX:
        view = views.of(rotations, translations)
        pull_poses(
            edges, views.table(), view, rotations, translations, camera.intrinsics, reach, PULL_ITERATIONS
        )
    scores = _scores(edges, views, rotations, translations, camera, FINAL_REACH_PX)
    scores[~in_range(seed_pose, camera, search_range, rotations, translations)] = -np.inf
    pulled = time.perf_counter()
    candidates = _finished(edges, model, camera, rotations, translations, scores)
    done = time.perf_counter()
    return Match(
        candidates,
        {
            "segments": float(long.sum()),
            "views": float(len(views)),
            "seconds_edges": built - began,
            "seconds_draws": scored - built,
            "seconds_pull": pulled - scored,
            "seconds_finish": done - pulled,
        },
    )


def _scores(
    edges: NearestEdges, views: Views, rotations: Floats, translations: Floats, camera: Camera, reach: float
) -> Floats:
    view = views.of(rotations, translations)
    out: Floats = score_poses(edges, views.table(), view, rotations, translations, camera.intrinsics, reach)
    return out


def _finished(
    edges: NearestEdges,
    model: Model,
    camera: Camera,
    rotations: Floats,
    translations: Floats,
    scores: Floats,
) -> tuple[Candidate, ...]:
    """The best distinct poses, pulled on and scored with their exact visibility."""
    solid, bounds = sparse_solid(model), image_bounds(camera)
    found: list[Candidate] = []
    for i in distinct(rotations, translations, scores, FINISHED):
        rotation, translation = rotations[i].copy(), translations[i].copy()
        score, supported = _finish(
            edges, solid, rotation, translation, camera.intrinsics, bounds, np.array(FINISH_REACHES_PX)
        )
        if supported > 0.0:
            found.append(Candidate(Pose.from_matrix(rotation, translation), float(score), float(supported)))
    found.sort(key=lambda candidate: -candidate.score)
    poses = [candidate.pose for candidate in found]
    keep = distinct(
        np.array([pose.matrix for pose in poses]).reshape(-1, 3, 3),
        np.array([pose.translation for pose in poses]).reshape(-1, 3),
        np.array([candidate.score for candidate in found]),
        CANDIDATES,
    )
    return tuple(found[i] for i in keep)


@njit(cache=True)
def exact_view(
    solid: Solid, rotation: Floats, translation: Floats, intrinsics: Floats, bounds: Floats
) -> ViewTable:
    """The one view from just this pose, at fine spacing."""
    line, points, _, _, px = trace(
        solid, rotation, translation, intrinsics, bounds, FINE_SPACING_PX, MIN_LINE_PX
    )
    run = np.empty(len(solid.lines) + 1, dtype=np.int64)
    ends = np.empty((len(solid.lines), 2, 3))
    count = 0
    for i in range(len(line)):
        if i == 0 or line[i] != line[i - 1]:
            run[count] = i
            ends[count, 0] = solid.vertices[solid.lines[line[i], 0]]
            ends[count, 1] = solid.vertices[solid.lines[line[i], 1]]
            count += 1
    run[count] = len(line)
    return ViewTable(np.array([0, count]), run[: count + 1], ends[:count], points, px)


@njit(cache=True)
def _finish(
    edges: NearestEdges,
    solid: Solid,
    rotation: Floats,
    translation: Floats,
    intrinsics: Floats,
    bounds: Floats,
    reaches: Floats,
) -> tuple[float, float]:
    """Pull one pose, in place, with exact visibility; its score and supported fraction."""
    for reach in reaches:
        views = exact_view(solid, rotation, translation, intrinsics, bounds)
        pull(edges, views, 0, rotation, translation, intrinsics, reach, FINISH_ITERATIONS)
    views = exact_view(solid, rotation, translation, intrinsics, bounds)
    only = np.zeros(1, dtype=np.int64)
    score = score_poses(
        edges,
        views,
        only,
        rotation.copy().reshape(1, 3, 3),
        translation.copy().reshape(1, 3),
        intrinsics,
        FINAL_REACH_PX,
    )[0]
    return score, supported_fraction(edges, views, rotation, translation, intrinsics, FINAL_REACH_PX)
