"""The default matcher: quasi-random poses, scored, aligned with the edges (ICP), scored again.

In go segments, a model and a seed pose; out come the few distinct poses that the segments support best. Each
stage looks at fewer poses more closely (`Effort`), so that of thousands two hundred are aligned.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.camera import Camera
from geometry.hidden_lines import trace
from geometry.model import Model
from geometry.occluders import Solid
from geometry.pose import Pose
from geometry.visibility import image_bounds
from numerics.arrays import Floats
from numerics.kernels import kernel
from vision_server.matching.draws import even_numbers, in_range, poses_around, reach_m
from vision_server.matching.icp import SUM, Lookup, Merit, align, align_poses, score_pose, score_poses
from vision_server.matching.match import (
    ONE_PLACE,
    Hypothesis,
    Problem,
    SearchRange,
    at_scale,
    checked_segments,
    distinct,
    matching_problem,
)
from vision_server.matching.nearest_edges import NearestEdges, nearest_edges
from vision_server.matching.views import ViewTable, least_line_px, runs_of, sparse_solid

MATCHED_PX = 640.0  # a target that is larger in the image is looked at as if it were so wide
# Chosen by hand; `python -m benchmarks.matching_ablation` shows what the stages bring.
FINISHED, MOST_HYPOTHESES = 12, 5  # distinct poses that are aligned to the end, and that are told
COARSE_SPACING_PX, FINE_SPACING_PX = 8.0, 2.0  # of samples, of poses by the thousand and of the last ones
SCREEN_EVERY = 3  # of the coarse samples are looked at in the first screening
FIRST_REACHES_PX, KEPT_REACHES_PX = (30.0, 20.0), (12.0, 6.0)  # from poses of the draws, and of those kept
FINISH_REACHES_PX, FINAL_REACH_PX = (6.0, 4.0, 3.0), 5.0  # of the last ones, and of scores
ALIGN_ITERATIONS, FINISH_ITERATIONS = 3, 2  # at each reach


@dataclass(frozen=True)
class Effort:
    """How many poses are looked at, stage by stage.

    Attributes
    ----------
    draws : poses drawn from the search range and scored roughly.
    screened : the best of these, scored with all samples.
    aligned : the best of these, aligned with the edges from afar.
    kept : the best of these that have come to different places, aligned to the end.
    finished : the best distinct ones of these, with exact visibility.
    """

    draws: int = 4096
    screened: int = 1024
    aligned: int = 200
    kept: int = 100
    finished: int = FINISHED


NEAR_DEG, NEAR_SHARE = 3.0, 0.4  # turn, and motion as a share of the size, near a pose (chosen by hand)
USUAL = Effort()
# Of two parts of 5000 lines the usual effort finds the pose with none and one of six seeds, this with four
# and six, at one scale or the other; twice as many draws, kept or finished poses find it with one at most.
THOROUGH = Effort(aligned=800)
LITTLE = Effort(draws=192, screened=96, aligned=16, kept=6, finished=3)  # chosen by hand


def match_search(
    segments: Floats,
    model: Model,
    camera: Camera,
    seed_pose: Pose,
    seed: int,
    search_range: SearchRange = SearchRange(),
    effort: Effort = USUAL,
) -> list[Hypothesis]:
    """Find the poses in the search range that the image segments support best, distinct, best first.

    All reaches are in pixels, so that a larger target is looked at in a smaller image.

    Parameters and errors are those of `matching_problem`.

    Parameters
    ----------
    seed : of the quasi-random draws.
    search_range : around the seed pose.
    """
    factor = min(1.0, MATCHED_PX / size_px(model, camera, seed_pose))
    ends, small = at_scale(checked_segments(segments), camera, factor)
    nearer_m = reach_m(seed_pose, camera, search_range)
    problem = matching_problem(ends, model, small, seed_pose, nearer_m, COARSE_SPACING_PX)
    if len(problem.segments) == 0:
        return []
    edges = nearest_edges(problem.segments, problem.camera)
    return _searched(edges, problem, model, camera, seed_pose, seed, search_range, effort)


def _searched(
    edges: NearestEdges,
    problem: Problem,
    model: Model,
    camera: Camera,
    seed_pose: Pose,
    seed: int,
    search_range: SearchRange,
    effort: Effort,
) -> list[Hypothesis]:
    def scores_within(poses: tuple[Floats, Floats], reach_px: float) -> Floats:
        """Scores (N,); -inf of what has left the search range, so that it takes no other's place."""
        scores = scores_of(edges, problem, *poses, reach_px)
        scores[~in_range(seed_pose, camera, search_range, *poses)] = -np.inf
        return scores

    poses = poses_around(seed_pose, camera, search_range, even_numbers(effort.draws, seed))
    poses = best_of(poses, scores_of(edges, problem, *poses, 0.0, SCREEN_EVERY), effort.screened)
    poses = best_of(poses, scores_of(edges, problem, *poses, 0.0), effort.aligned)
    aligned(edges, problem, *poses, FIRST_REACHES_PX)
    kept = distinct(*poses, scores_within(poses, KEPT_REACHES_PX[0]), effort.kept, ONE_PLACE)
    poses = poses[0][kept], poses[1][kept]
    aligned(edges, problem, *poses, KEPT_REACHES_PX)
    scores = scores_within(poses, FINAL_REACH_PX)
    return finished(edges, model, problem.camera, poses, scores, effort.finished)


def match_near(
    segments: Floats, camera: Camera, seed: int, models: Sequence[Model], pose: Pose
) -> list[list[tuple[float, Pose]]]:
    """Find, with little effort, where each of some models of one size fits segments (N, 4) near a pose.

    Returns
    -------
    For each model scores and poses, best first.
    """
    size = size_px(models[0], camera, pose)
    ends, small = at_scale(checked_segments(segments), camera, min(1.0, MATCHED_PX / size))
    reach = SearchRange(NEAR_DEG, NEAR_SHARE * size)
    out: list[list[tuple[float, Pose]]] = [[] for _ in models]
    edges = None
    for own, model in zip(out, models if pose.translation[2] > 0.0 else (), strict=False):
        nearer_m = reach_m(pose, camera, reach)
        problem = matching_problem(ends, model, small, pose, nearer_m, COARSE_SPACING_PX)
        if len(problem.segments) > 0:
            edges = nearest_edges(problem.segments, problem.camera) if edges is None else edges
            found = _searched(edges, problem, model, camera, pose, seed, reach, LITTLE)
            own += [(one.score, one.pose) for one in found]
    return out


def size_px(model: Model, camera: Camera, pose: Pose) -> float:
    """How wide a model is in the image, px: no more than the frame."""
    distance, side = float(pose.apply(model.middle[None])[0, 2]), float(max(camera.width, camera.height))
    return min(model.diameter * camera.fx / distance, side) if distance > 0.0 else side


def best_of(poses: tuple[Floats, Floats], scores: Floats, count: int) -> tuple[Floats, Floats]:
    """So many of the poses (N, 3, 3), (N, 3), best first by scores (N,); copies."""
    best = np.argsort(-scores, kind="stable")[:count]
    return poses[0][best], poses[1][best]


def aligned(
    edges: NearestEdges,
    problem: Problem,
    rotations: Floats,
    translations: Floats,
    reaches_px: tuple[float, ...],
) -> None:
    """Align poses (N, 3, 3), (N, 3), in place, with the edges."""
    for reach in reaches_px:
        view = problem.views.of(rotations, translations)
        align_poses(_lookup(edges, problem), view, rotations, translations, reach, ALIGN_ITERATIONS)


def scores_of(
    edges: NearestEdges,
    problem: Problem,
    rotations: Floats,
    translations: Floats,
    reach_px: float,
    every: int = 1,
    merit: Merit = SUM,
) -> Floats:
    """Scores (N,) of poses (N, 3, 3), (N, 3), see `score_poses`."""
    view = problem.views.of(rotations, translations)
    lookup = _lookup(edges, problem)
    return np.asarray(score_poses(lookup, view, rotations, translations, reach_px, every, merit))


def _lookup(edges: NearestEdges, problem: Problem) -> Lookup:
    return Lookup(edges, problem.views.table(), problem.camera.intrinsics)


def finished(
    edges: NearestEdges,
    model: Model,
    camera: Camera,
    poses: tuple[Floats, Floats],
    scores: Floats,
    looked_at: int = FINISHED,
    most: int = MOST_HYPOTHESES,
    merit: Merit = SUM,
) -> list[Hypothesis]:
    """The best distinct poses (N, 3, 3), (N, 3), aligned further and scored with their exact visibility."""
    solid, bounds, least_px = sparse_solid(model), image_bounds(camera), least_line_px(model)
    found: list[Hypothesis] = []
    for i in distinct(*poses, scores, looked_at):
        rotation, translation = (part[i].copy() for part in poses)
        score, supported = _finish(
            edges,
            solid,
            rotation,
            translation,
            camera.intrinsics,
            bounds,
            least_px,
            merit,
        )
        if supported > 0.0:
            found.append(Hypothesis(Pose.from_matrix(rotation, translation), float(score), float(supported)))
    found.sort(key=lambda one: -one.score)
    keep = distinct(
        np.array([one.pose.matrix for one in found]).reshape(-1, 3, 3),
        np.array([one.pose.translation for one in found]).reshape(-1, 3),
        np.array([one.score for one in found]),
        most,
    )
    return [found[i] for i in keep]


@kernel()
def exact_view(
    solid: Solid,
    rotation: Floats,
    translation: Floats,
    intrinsics: Floats,
    bounds: Floats,
    min_line_px: float,
) -> ViewTable:
    """The one view from just this pose (3, 3), (3,), at fine spacing; the rest as of `trace`."""
    seen = trace(
        solid, rotation, translation, intrinsics, bounds, FINE_SPACING_PX, FINE_SPACING_PX, min_line_px
    )
    first, ends = runs_of(solid, seen)
    return ViewTable(np.array([0, len(ends)]), first, ends, seen.points, seen.px)


@kernel()
def _finish(
    edges: NearestEdges,
    solid: Solid,
    rotation: Floats,
    translation: Floats,
    intrinsics: Floats,
    bounds: Floats,
    min_line_px: float,
    merit: Merit,
) -> tuple[float, float]:
    """Align one pose, in place, with exact visibility; its score and supported fraction."""
    for reach in FINISH_REACHES_PX:
        views = exact_view(solid, rotation, translation, intrinsics, bounds, min_line_px)
        align(Lookup(edges, views, intrinsics), 0, rotation, translation, reach, FINISH_ITERATIONS)
    views = exact_view(solid, rotation, translation, intrinsics, bounds, min_line_px)
    lookup, unclaimed = Lookup(edges, views, intrinsics), np.empty(edges.first_piece[-1])
    return score_pose(lookup, 0, rotation, translation, FINAL_REACH_PX, 1, merit, unclaimed)
