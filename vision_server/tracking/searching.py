"""Where a target is searched that was not followed: around a pose, or anywhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geometry.pose import SEARCH_ROTATION_DEG, Pose, search_translation_px
from vision_server.channels.depth import Pixels
from vision_server.image_set import ImageSet
from vision_server.judgement import Estimate
from vision_server.matching.match import Anywhere
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.tracking.following import Sight
from vision_server.tracking.frame import NAME

# Of so many searches that are not believed in a row, one looks without a pose to start from: of a lost target
# there is one in each frame, of one that is followed in each sixth.
EVERYWHERE, EVERYWHERE_FOLLOWED = 6, 4
WIDENED, WIDEST = 1.25, 2.5  # the range of a search, with each frame that found nothing, and at most
FARTHER = 1.6  # than when it was last seen, or nearer, it may be then; chosen by hand


def widened_by(misses: int) -> float:
    """Times the usual range of a search, after so many frames without a pose."""
    return float(min(WIDENED**misses, WIDEST))


def everywhere_is_due(vain: int, lost: bool) -> bool:
    """Whether everything is to be searched, after so many searches in a row that are not believed."""
    return vain > 0 and vain % (EVERYWHERE if lost else EVERYWHERE_FOLLOWED) == 0


class Search:
    """Searches of one frame, whose edges are found once."""

    def __init__(self, sight: Sight, settings: PipelineSettings, pixels: Pixels) -> None:
        self._sight, self._settings = sight, settings
        self._images = ImageSet(sight.camera.width, sight.camera.height)
        self._images.add(NAME, pixels, 1.0, sight.tone.gamma)

    def around(self, start: Pose | Anywhere, widened: float) -> Estimate:
        """The target within so many times the usual range around a pose, or as is known of it."""
        reach_px = widened * search_translation_px(self._sight.camera.width)
        settings = replace(
            self._settings,
            rotation_range_deg=widened * SEARCH_ROTATION_DEG,
            translation_range_px=reach_px,
        )
        return self._found(start, settings)

    def anywhere(self, last: Pose | Anywhere) -> Estimate | None:
        """The target wherever it may be since a pose, of poses that look alike the one turned least.

        Where it was never believed to be anywhere, it is looked for as at first.
        """
        if isinstance(last, Anywhere):
            return self._found(last, self._settings)
        range_m = float(np.linalg.norm(last.apply(self._sight.model.middle[None])[0]))
        seen = self._found(Anywhere((range_m / FARTHER, range_m * FARTHER)), self._settings)
        alike = [one.pose for one in seen.poses] or ([] if seen.pose is None else [seen.pose])
        if not alike:
            return None
        return self._found(min(alike, key=lambda one: one.error_to(last).rotation_deg), self._settings)

    def _found(self, start: Pose | Anywhere, settings: PipelineSettings) -> Estimate:
        return estimate_pose(self._images, [NAME], self._sight.model, self._sight.camera, start, settings)
