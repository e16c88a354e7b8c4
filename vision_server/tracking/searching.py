"""Searches for a target that is not followed, around a pose or everywhere, and whether they are believed.

A search is a session's estimate of one frame, and costs as much. It is around the pose that was told last; of
a lost target each second one is around the last pose that was believed, and the range widens with each frame
that finds nothing. Each so many-th search in vain is followed by one of everything.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geometry.pose import SEARCH_ROTATION_DEG, Pose, search_translation_px
from vision_server.channels.depth import Pixels
from vision_server.image_set import ImageSet
from vision_server.matching.match import Anywhere
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.tracking.acceptance import HELD, STAYS, SURE, found_belief, is_elsewhere, is_whole
from vision_server.tracking.following import Found, Sight
from vision_server.tracking.frame import FRAME_NAME
from vision_server.tracking.history import History
from vision_server.tracking.usual import Usual
from vision_server.trust.judgement import Estimate
from vision_server.trust.probability import quality

# By hand: a search costs as much as an estimate. Of so many searches that are not believed in a row, one
# looks without a pose to start from. A lost target is searched in each frame, a followed one in each fifth.
EVERYWHERE_AFTER, EVERYWHERE_FOLLOWED_AFTER = 6, 4
WIDENED_TIMES, WIDEST_TIMES = 1.25, 2.5  # times the range, with each frame that found nothing, and at most
FARTHER = 1.6  # than it was last seen, or nearer, it may be when it is looked for everywhere
# Searches that doubted what they found count up to this; as many must believe it before it is believed.
MOST_AGAINST = 3


def everywhere_is_due(vain: int, lost: bool) -> bool:
    """Whether everything is to be searched, after so many searches in a row that are not believed."""
    return vain > 0 and vain % (EVERYWHERE_AFTER if lost else EVERYWHERE_FOLLOWED_AFTER) == 0


class Searches:
    """For one target, from frame to frame; what they find and think of it is kept in its history."""

    def __init__(self, sight: Sight, settings: PipelineSettings, history: History, usual: Usual) -> None:
        self._sight, self._settings, self._history, self._usual = sight, settings, history, usual

    def estimate(self, pixels: Pixels) -> Estimate:
        """What is found in a frame, whose edges are found once for all searches of it."""
        history, images = self._history, ImageSet(self._sight.camera.width, self._sight.camera.height)
        images.add(FRAME_NAME, pixels, 1.0, self._sight.tone.gamma)
        found = self._around(images, history.trusted if history.lost % 2 else history.last)
        believed = found.score >= SURE and self._is_like_before(found)
        history.vain = 0 if believed else history.vain + 1
        if not everywhere_is_due(history.vain, history.lost > 0):
            return found
        both = (found, self._anywhere(images, history.trusted) or found)
        return max(both, key=lambda one: (self._is_like_before(one), one.score))

    def believe(self, estimate: Estimate, found: Found | None, unasked: float) -> bool:
        """Whether an estimate, and what is ``found`` on whole lines there, is believed but for look-alikes.

        What searches doubted is believed when as many have believed it: a rectangle of the background may
        look like the target now and then. For ``unasked`` see `Rivals`.
        """
        history, belief = self._history, found_belief(estimate, found)
        if estimate.pose is None or belief < HELD:
            return False
        if is_elsewhere(estimate.pose, history.last, self._sight.model):
            history.against = 0
        like = self._is_like_before(estimate)
        if belief * (1.0 + estimate.ambiguity) >= SURE * (1.0 + unasked) and like:
            history.against = max(history.against - 1, 0)
            return history.against == 0
        if belief < STAYS or not like:
            history.against = min(history.against + 1, MOST_AGAINST)
        return False

    def _is_like_before(self, estimate: Estimate) -> bool:
        """Whether a searched pose is seen as well as the target was; a wider search meets more like it."""
        support = estimate.support
        if support is None or not self._usual.is_like_before(quality(support)):
            return False
        return self._history.lost == 0 or is_whole(support)

    def _around(self, images: ImageSet, start: Pose | Anywhere) -> Estimate:
        """The target around a pose, or as is known of it; farther with each frame without a pose."""
        times = min(WIDENED_TIMES**self._history.lost, WIDEST_TIMES)
        settings = replace(
            self._settings,
            rotation_range_deg=times * SEARCH_ROTATION_DEG,
            translation_range_px=times * search_translation_px(self._sight.camera.width),
        )
        return self._found(images, start, settings)

    def _anywhere(self, images: ImageSet, last: Pose | Anywhere) -> Estimate | None:
        """The target wherever it may be since a pose, of poses that look alike the one turned least.

        Where it was never believed to be anywhere, it is looked for as at first.
        """
        if isinstance(last, Anywhere):
            return self._found(images, last, self._settings)
        range_m = float(np.linalg.norm(last.apply(self._sight.model.middle[None])[0]))
        seen = self._found(images, Anywhere((range_m / FARTHER, range_m * FARTHER)), self._settings)
        alike = [one.pose for one in seen.poses] or ([] if seen.pose is None else [seen.pose])
        if not alike:
            return None
        nearest = min(alike, key=lambda one: one.error_to(last).rotation_deg)
        return self._found(images, nearest, self._settings)

    def _found(self, images: ImageSet, start: Pose | Anywhere, settings: PipelineSettings) -> Estimate:
        model, camera = self._sight.model, self._sight.camera
        return estimate_pose(images, [FRAME_NAME], model, camera, start, settings, turn_known=True)
