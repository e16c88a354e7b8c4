"""The vision pipeline: image set -> edges -> segments -> match -> refine -> estimate."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from geometry.camera import Camera
from geometry.model import Model, about_middle
from geometry.pose import SEARCH_ROTATION_DEG, SEARCH_TRANSLATION_PX, Pose
from geometry.symmetries import Symmetry, if_round, symmetry_of
from numerics.arrays import Floats
from vision_server.channels.gradients import SCALES_PX, GradientChannel
from vision_server.channels.tone import KNOWN_TONE_SD_PX
from vision_server.edges.edge_map import EdgeMap
from vision_server.image_set import ImageSet
from vision_server.matchers import DEFAULT_MATCHER, Matching
from vision_server.matching import Anywhere, SearchRange
from vision_server.matching.draws import beyond_of, in_range_of
from vision_server.matching.match import ideal_segments
from vision_server.matching.search import match_near
from vision_server.pose.observation import PoseProblem
from vision_server.segments.extraction import extract_segments, extract_with_pieces
from vision_server.trust.all_sides import of_most_evidence
from vision_server.trust.judgement import Estimate, about_origin, judged, of_all_lines, with_poses
from vision_server.trust.likely import last_step, likely_of
from vision_server.trust.ranking import best_first, fewer_lines
from vision_server.trust.rivals import likeliest_first, rivals_at_first_sight, rivals_of, symmetric_images
from vision_server.trust.spun import unseen_turns

MERIT_PX = 15.0  # of a score of 0: docs/result.md, by domain/reasoning/merit.pl
SURE_SCORE = 1.0 - 1.0 / MERIT_PX  # from here on a session ends with a pose: a merit of 1 px
# Where noise drowns edges a coarse gradient shows more of them: of 22 sets of clean images the segments are
# at most 1.05 times as long together, of 25 noisy ones 1.2 to 30 times but for four. There alone the coarse
# scale is asked: it tells less of a model that is not true.
MORE_IN_COARSE = 1.15
COARSE_REFINEMENT_PX = 4.0  # least softness of edges at the coarse scale, one of SCALES_PX
# By hand: a pose with a rival that is as likely, or with less of its lines seen, tells nothing of its model.
LEAST_AMBIGUOUS, LEAST_SUPPORTED = 0.5, 0.5


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
    untold_tolerance_m
        The same where nobody has told it: the covariance allows for it, the pose only where lines ask for it.
    fusion
        Whether images are fused into one before edges are looked for (a rival, see `baselines.exposures`).
    coarse
        Whether what shows no sure pose is looked at again, at a coarser scale and with more effort.
    """

    matcher: str = DEFAULT_MATCHER
    seed: int = 0
    rotation_range_deg: float = SEARCH_ROTATION_DEG
    translation_range_px: float = SEARCH_TRANSLATION_PX
    generations: int = 10
    population: int = 200
    edge_contrast_grey: float = 0.0
    refinement_scale_px: float = SCALES_PX[0]
    tone_sd_px: float = KNOWN_TONE_SD_PX
    tolerance_m: float = 0.0
    untold_tolerance_m: float = 0.0
    fusion: bool = False
    coarse: bool = True

    @property
    def search_range(self) -> SearchRange:
        """How far the matchers look."""
        return SearchRange(self.rotation_range_deg, self.translation_range_px)

    @property
    def matching(self) -> Matching:
        """The matcher, as it looks first."""
        return Matching(self.matcher, self.seed, self.search_range, self.generations, self.population)


class _Stopwatch:
    """Seconds per stage; `lap` adds to a stage what has passed since the last one."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        before, self._last = self._last, time.perf_counter()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + self._last - before


def estimate_pose(
    images: ImageSet,
    names: Sequence[str],
    model: Model,
    camera: Camera,
    seed_pose: Pose | Anywhere,
    settings: PipelineSettings = PipelineSettings(),
    show: Callable[[EdgeMap], None] = lambda _edges: None,
    turn_known: bool = False,
) -> Estimate:
    """Estimate the pose of the target from the named images of a set; `show` is given their edge map.

    Where there is no seed pose, it is looked for in the whole frame (`matching.first_sight`). Where no pose
    is sure, it is looked for again (`_looked_at_again`). Of the turns that leave the target as it is, those
    within the range of a seed pose are rivals, where it is not `turn_known`, as from frame to frame, which of
    them is meant.

    Raises
    ------
    BadInput
        No images, an unknown one, or an unknown matcher.
    GeometryError
        A search range that cannot be.
    """
    centred, to_middle = about_middle(model)
    if centred is not model:
        start = seed_pose if isinstance(seed_pose, Anywhere) else seed_pose.compose(to_middle)
        found = estimate_pose(images, names, centred, camera, start, settings, show, turn_known)
        return about_origin(found, to_middle.inverse())
    looks = _Looks(images, names, _Asked(model, camera, seed_pose, settings, turn_known))
    seen = looks.segments(coarse=False)
    hypotheses = looks.matched(seen, settings.matching)
    best = looks.estimated(seen, hypotheses)
    if best.score < SURE_SCORE and not _of_wrong_model(best) and settings.coarse:
        best, seen = _looked_at_again(looks, seen, hypotheses, best)
    show(seen.edges)
    return replace(best, seconds=looks.watch.seconds)


@dataclass(frozen=True, eq=False)
class _Asked:
    """Of what model, by what camera and where a pose is asked for."""

    model: Model
    camera: Camera
    seed_pose: Pose | Anywhere
    settings: PipelineSettings
    turn_known: bool = False


class _Seen(NamedTuple):
    """The edge map of a set, and its segments (N, 4) px."""

    edges: EdgeMap
    endpoints: Floats

    @property
    def length_px(self) -> float:
        """Of all segments together."""
        return float(np.hypot(*(self.endpoints[:, :2] - self.endpoints[:, 2:]).T).sum())


class _Looks:
    """The ways to look at a set's images, and where the time goes."""

    def __init__(self, images: ImageSet, names: Sequence[str], asked: _Asked) -> None:
        self.asked = asked
        self.watch = _Stopwatch()
        self._images, self._names = images, names

    def segments(self, coarse: bool) -> _Seen:
        """What there is to be matched, by the images' fine or their coarse edges."""
        edges = self._images.edge_map(self._names, coarse)
        self.watch.lap("edges")
        extract = extract_with_pieces if isinstance(self.asked.seed_pose, Anywhere) else extract_segments
        found = extract(edges)
        ends = found.take(found.strength >= self.asked.settings.edge_contrast_grey).endpoints
        self.watch.lap("linking")
        return _Seen(edges, ends)

    def matched(self, seen: _Seen, matching: Matching) -> list[Pose]:
        """Poses that are worth refining, by these segments."""
        asked = self.asked
        found = matching.hypotheses(seen.endpoints, asked.model, asked.camera, asked.seed_pose)
        self.watch.lap("matching")
        return found

    def estimated(self, seen: _Seen, hypotheses: Sequence[Pose], least_softness_px: float = 0.0) -> Estimate:
        """What there is to say of these hypotheses, with edges taken for at least so soft."""
        softness = max(self.asked.settings.refinement_scale_px, least_softness_px)
        asked = replace(self.asked, settings=replace(self.asked.settings, refinement_scale_px=softness))
        found = _refined(asked, hypotheses, seen.endpoints, self._images.gradients(self._names))
        self.watch.lap("refinement")
        return found


def _of_wrong_model(found: Estimate) -> bool:
    """Whether what was found tells that the target is not as its model."""
    tells = found.ambiguity < LEAST_AMBIGUOUS and found.supported_fraction >= LEAST_SUPPORTED
    return tells and found.misfit is not None and found.misfit.suspected is not None


def _looked_at_again(
    looks: _Looks, fine: _Seen, hypotheses: list[Pose], first: Estimate
) -> tuple[Estimate, _Seen]:
    """The best of what there is to say where the first look has made nothing sure, and by which edges.

    A coarser gradient shows more edges in the dark, and to some poses only more effort leads, at either
    scale. A pose that one scale has found is asked about at the other, and at last all ``hypotheses`` are.
    """
    best, by, found = first, fine, [first.pose]
    coarse = looks.segments(coarse=True)
    more_edges = coarse.length_px > MORE_IN_COARSE * fine.length_px
    if more_edges:
        others = looks.matched(coarse, looks.asked.settings.matching)
        hypotheses = hypotheses + others
        other = looks.estimated(coarse, _poses(found) + others, COARSE_REFINEMENT_PX)
        found.append(other.pose)
        if other.score > best.score:
            best, by = other, coarse
    if best.score >= SURE_SCORE or isinstance(looks.asked.seed_pose, Anywhere):
        return best, by
    closely = looks.asked.settings.matching.thorough
    others = [pose for seen in (coarse, fine) for pose in looks.matched(seen, closely)]
    other = looks.estimated(fine, _poses(found) + others + hypotheses)
    return (other, fine) if other.score > best.score else (best, by)


def _poses(found: Sequence[Pose | None]) -> list[Pose]:
    return [pose for pose in found if pose is not None]


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
    hypotheses = settings.matching.hypotheses(endpoints, model, camera, seed_pose)
    return _refined(_Asked(model, camera, seed_pose, settings), hypotheses, endpoints, channels)


def _without_rivals(asked: _Asked) -> Symmetry:
    """The turns that make no rivals of a pose, as they leave the target as it is."""
    if isinstance(asked.seed_pose, Anywhere) or (asked.turn_known and asked.model.smooth.any()):
        return symmetry_of(asked.model)
    return if_round(asked.model)


def _refined(
    asked: _Asked, hypotheses: Sequence[Pose], endpoints: Floats, channels: Sequence[GradientChannel]
) -> Estimate:
    """Refine hypotheses on the channels, and judge the best of them beside the others."""
    model, camera, seed_pose, settings = asked.model, asked.camera, asked.seed_pose, asked.settings
    least = SCALES_PX.index(settings.refinement_scale_px)
    every_line = PoseProblem.at_scale(
        channels,
        model,
        camera,
        least,
        settings.tone_sd_px,
        settings.tolerance_m,
        settings.untold_tolerance_m,
    )
    problem = fewer_lines(every_line)
    symmetry = _without_rivals(asked)
    match = partial(match_near, ideal_segments(endpoints, camera), camera, settings.seed)
    estimate, last = Estimate(), None
    if isinstance(seed_pose, Anywhere):
        likely = likely_of(of_most_evidence(problem, hypotheses, match), symmetry)
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
        refined = best_first(problem, hypotheses, spin_rad, searched)
        if refined:
            refined = likeliest_first(refined, beyond)
            last = last_step(refined[0])
            rivals = rivals_of(refined, symmetry, searched, beyond)
            if not asked.turn_known:
                rivals += symmetric_images(refined[0].pose, symmetry_of(model), beyond)
            estimate = judged(refined[0], last, rivals, symmetry, match)
    if estimate.pose is not None and last is not None:
        unseen = unseen_turns(last.best.problem, last.best.pose, last.best.spacing_px)
        estimate = replace(estimate, free=estimate.free + unseen)
        if problem is not every_line:
            estimate = of_all_lines(estimate, every_line, last.best.spacing_px)
    return replace(estimate, segments=len(endpoints))
