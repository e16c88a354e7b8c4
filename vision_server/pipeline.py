"""The vision pipeline: image set -> edges -> segments -> match -> refine -> estimate."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.model import Model, about_middle
from geometry.pose import SEARCH_ROTATION_DEG, SEARCH_TRANSLATION_PX, Pose
from geometry.symmetries import ASYMMETRIC, symmetry_of
from numerics.arrays import Floats
from vision_server.baselines.genetic import match_genetic
from vision_server.channels.gradients import SCALES_PX, GradientChannel
from vision_server.channels.tone import KNOWN_TONE_SD_PX
from vision_server.edges.edge_map import EdgeMap
from vision_server.image_set import ImageSet
from vision_server.matching import Anywhere, Hypothesis, SearchRange, match_search
from vision_server.matching.draws import beyond_of, in_range_of
from vision_server.matching.match import ideal_segments, worth_refining
from vision_server.matching.search import match_near
from vision_server.pose.observation import PoseProblem
from vision_server.segments.extraction import extract_segments, extract_with_pieces
from vision_server.trust.all_sides import of_most_evidence
from vision_server.trust.judgement import Estimate, about_origin, judged, of_all_lines, with_poses
from vision_server.trust.likely import last_step, likely_of
from vision_server.trust.ranking import best_first, fewer_lines
from vision_server.trust.rivals import likeliest_first, rivals_at_first_sight, rivals_of
from vision_server.trust.spun import unseen_turns

LOOKED_AT = 10  # hypotheses, at first sight
SURE_SCORE = 1.0 - 1.0 / 15.0  # from here on a session ends with a pose: domain/reasoning/merit.pl
# Where noise drowns edges a coarse gradient shows more of them: of 22 sets of clean images the segments are
# at most 1.05 times as long together, of 25 noisy ones 1.2 to 30 times but for four. There alone the coarse
# scale is asked: it tells less of a model that is not true.
MORE_IN_COARSE = 1.15
COARSE_REFINEMENT_PX = 4.0  # least softness of edges at the coarse scale, one of SCALES_PX
Matcher = Callable[[Floats, Model, Camera, Pose, int, SearchRange], list[Hypothesis]]
MATCHERS: dict[str, Matcher] = {"search": match_search, "genetic": match_genetic}


@dataclass(frozen=True)
class PipelineSettings:
    """What a caller may choose.

    Attributes
    ----------
    matcher
        ``search`` or ``genetic``.
    seed
        Of the matcher's draws.
    rotation_range_deg, translation_range_px
        How far the true pose may be from the seed pose.
    generations, population
        Of the genetic matcher.
    edge_contrast_grey
        Segments of less mean contrast, grey at reference exposure, are left out of the matching.
    refinement_scale_px
        Least softness that edges are taken for in refinement, one of SCALES_PX.
    tone_sd_px
        How well the images' tone curve is known, see refinement.
    tolerance_m
        How far each line of the part may be off the model's, one standard deviation.
    fusion
        Whether images are fused into one before edges are looked for (a rival, see `baselines.exposures`).
    coarse
        Whether what shows no sure pose is looked at once more at a coarser scale, where it shows more edges.
    """

    matcher: str = "search"
    seed: int = 0
    rotation_range_deg: float = SEARCH_ROTATION_DEG
    translation_range_px: float = SEARCH_TRANSLATION_PX
    generations: int = 10
    population: int = 200
    edge_contrast_grey: float = 0.0
    refinement_scale_px: float = SCALES_PX[0]
    tone_sd_px: float = KNOWN_TONE_SD_PX
    tolerance_m: float = 0.0
    fusion: bool = False
    coarse: bool = True

    @property
    def search_range(self) -> SearchRange:
        """How far the matchers look."""
        return SearchRange(self.rotation_range_deg, self.translation_range_px)


class _Stopwatch:
    """Seconds per stage; `lap` gives a stage what has passed since the last one."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        before, self._last = self._last, time.perf_counter()
        self.seconds[stage] = self._last - before


def estimate_pose(
    images: ImageSet,
    names: Sequence[str],
    model: Model,
    camera: Camera,
    seed_pose: Pose | Anywhere,
    settings: PipelineSettings = PipelineSettings(),
    show: Callable[[EdgeMap], None] = lambda _edges: None,
) -> Estimate:
    """Estimate the pose of the target from the named images of a set; `show` is given their edge map.

    Where there is no seed pose, it is looked for in the whole frame (`matching.first_sight`). Where no pose
    is sure, and a coarser gradient shows more edges, as in the dark, it is looked for once more by these.

    Raises
    ------
    BadInput
        No images, an unknown one, or an unknown matcher.
    GeometryError
        A search range that cannot be.
    """
    asked = _Asked(images, names, model, camera, seed_pose, settings)
    seen = _segments(asked, coarse=False)
    show(seen.edges)
    fine = _estimated(asked, seen)
    wrong_model = fine.misfit is not None and fine.misfit.suspected is not None
    if fine.score >= SURE_SCORE or wrong_model or not settings.coarse:
        return fine
    coarser = _segments(asked, coarse=True)
    if coarser.length_px <= MORE_IN_COARSE * seen.length_px:
        return _with_seconds_of(fine, coarser.seconds)
    softness = max(settings.refinement_scale_px, COARSE_REFINEMENT_PX)
    asked = replace(asked, settings=replace(settings, refinement_scale_px=softness))
    coarse = _estimated(asked, coarser)
    if coarse.score <= fine.score:
        return _with_seconds_of(fine, coarse.seconds)
    show(coarser.edges)
    return _with_seconds_of(coarse, fine.seconds)


@dataclass(frozen=True, eq=False)
class _Asked:
    """What `estimate_pose` is asked."""

    images: ImageSet
    names: Sequence[str]
    model: Model
    camera: Camera
    seed_pose: Pose | Anywhere
    settings: PipelineSettings


class _Seen(NamedTuple):
    """The edge map of a set, its segments (N, 4) px and their length together, and seconds by stage."""

    edges: EdgeMap
    endpoints: Floats
    length_px: float
    seconds: dict[str, float]


def _segments(asked: _Asked, coarse: bool) -> _Seen:
    """What there is to be matched, by the images' fine or their coarse edges."""
    watch = _Stopwatch()
    edges = asked.images.edge_map(asked.names, coarse)
    watch.lap("edges")
    extract = extract_with_pieces if isinstance(asked.seed_pose, Anywhere) else extract_segments
    found = extract(edges)
    ends = found.take(found.strength >= asked.settings.edge_contrast_grey).endpoints
    watch.lap("linking")
    return _Seen(edges, ends, float(np.hypot(*(ends[:, :2] - ends[:, 2:]).T).sum()), watch.seconds)


def _estimated(asked: _Asked, seen: _Seen) -> Estimate:
    """The pose by these segments."""
    channels = asked.images.gradients(asked.names)
    estimate = pose_of_segments(
        seen.endpoints, channels, asked.model, asked.camera, asked.seed_pose, asked.settings
    )
    return _with_seconds_of(estimate, seen.seconds)


def _with_seconds_of(estimate: Estimate, spent: Mapping[str, float]) -> Estimate:
    """The estimate with what else was spent on it, by stage."""
    stages = {**spent, **estimate.seconds}
    return replace(
        estimate, seconds={one: estimate.seconds.get(one, 0.0) + spent.get(one, 0.0) for one in stages}
    )


def pose_of_segments(
    endpoints: Floats,
    channels: Sequence[GradientChannel],
    model: Model,
    camera: Camera,
    seed_pose: Pose | Anywhere,
    settings: PipelineSettings = PipelineSettings(),
) -> Estimate:
    """Match segments (N, 4) px, from wherever they come, and refine on the channels; errors as above.

    A model far from its file's origin is looked for about its middle: small turns would else carry it away.
    """
    centred, to_middle = about_middle(model)
    if centred is not model:
        seed_pose = seed_pose if isinstance(seed_pose, Anywhere) else seed_pose.compose(to_middle)
        found = pose_of_segments(endpoints, channels, centred, camera, seed_pose, settings)
        return about_origin(found, to_middle.inverse())
    watch = _Stopwatch()
    hypotheses = worth_refining(_matched(endpoints, model, camera, seed_pose, settings))
    watch.lap("matching")
    least = SCALES_PX.index(settings.refinement_scale_px)
    every_line = PoseProblem.at_scale(
        channels, model, camera, least, settings.tone_sd_px, settings.tolerance_m
    )
    problem = fewer_lines(every_line)
    asked = isinstance(seed_pose, Anywhere) or model.smooth.any()  # nothing else may look quite the same
    symmetry = symmetry_of(model) if asked else ASYMMETRIC
    match = partial(match_near, ideal_segments(endpoints, camera), camera, settings.seed)
    estimate, last = Estimate(), None
    if isinstance(seed_pose, Anywhere):
        likely = likely_of(of_most_evidence(problem, hypotheses, LOOKED_AT, match), symmetry)
        if likely:
            first, last = likely[0].refined, likely[0].last
            estimate = judged(first, last, rivals_at_first_sight(likely, symmetry), symmetry, match)
        if estimate.pose is not None:
            allowed = partial(seed_pose.allows, middle=model.middle)
            estimate = with_poses(estimate, likely, symmetry, allowed)
    else:
        searched = in_range_of(seed_pose, camera, settings.search_range)
        beyond = beyond_of(seed_pose, camera, settings.search_range)
        spin_rad = 2.0 * math.radians(settings.rotation_range_deg)  # from one end of the range to the other
        refined = best_first(problem, hypotheses, spin_rad=spin_rad, searched=searched)
        if refined:
            refined = likeliest_first(refined, beyond)
            last = last_step(refined[0])
            rivals = rivals_of(refined, symmetry, searched, beyond)
            estimate = judged(refined[0], last, rivals, symmetry, match)
    if estimate.pose is not None and last is not None:
        unseen = unseen_turns(last.best.problem, last.best.pose, last.best.spacing_px)
        estimate = replace(estimate, free=estimate.free + unseen)
        if problem is not every_line:
            estimate = of_all_lines(estimate, every_line, last.best.spacing_px)
    watch.lap("refinement")
    return replace(estimate, segments=len(endpoints), seconds=watch.seconds)


def _matched(
    ends: Floats, model: Model, camera: Camera, seed_pose: Pose | Anywhere, settings: PipelineSettings
) -> list[Hypothesis]:
    if settings.matcher not in MATCHERS:
        raise BadInput(f"Unknown matcher {settings.matcher!r}.", f"Use {' or '.join(sorted(MATCHERS))}.")
    ends = ideal_segments(ends, camera)
    if isinstance(seed_pose, Anywhere):
        if settings.matcher != PipelineSettings.matcher:
            raise BadInput(f"The {settings.matcher} matcher needs a seed pose.", "Give one, or use search.")
        from vision_server.matching.first_sight import match_anywhere  # most sessions have a seed pose

        return match_anywhere(ends, model, camera, seed_pose)
    matcher = MATCHERS[settings.matcher]
    if settings.matcher == "genetic":
        matcher = partial(match_genetic, generations=settings.generations, population=settings.population)
    return matcher(ends, model, camera, seed_pose, settings.seed, settings.search_range)
