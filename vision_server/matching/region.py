"""Where in a large frame the target can be, of which there is a seed pose: only that part is looked at."""

from __future__ import annotations

from itertools import product

import numpy as np

from geometry.camera import Camera, Region
from geometry.hidden_lines import NEAR_PLANE_SHARE
from geometry.model import Model, about_middle
from geometry.pose import Pose
from vision_server.matching.draws import MARGIN_DEG, MARGIN_PX, MARGIN_SHARE, even_numbers, poses_around
from vision_server.matching.match import SearchRange

LEAST_CUT_FRAME_PIXELS = 2_000_000  # reading all of a smaller frame costs little, and tells more of its noise
MOST_REGION_SHARE = 0.6  # of the frame: cutting less off is not worth it (by hand)
REGION_MARGIN_PX = 48  # around the target: what blurs over its edges and is looked for beside them (by hand)
RANGE_DRAWS = 256  # poses within the range, besides its corners (by hand)


def region_of(model: Model, camera: Camera, seed_pose: Pose, reach: SearchRange) -> Region | None:
    """The part of a large frame in which a search around a seed pose may see the target; None: all of it."""
    if camera.width * camera.height < LEAST_CUT_FRAME_PIXELS:
        return None
    centred, to_middle = about_middle(model)
    wide = SearchRange(
        min(reach.rotation_deg * (1.0 + MARGIN_SHARE) + MARGIN_DEG, 180.0),
        reach.translation_px * (1.0 + MARGIN_SHARE) + MARGIN_PX,
    )
    numbers = np.concatenate([np.array(list(product((-1.0, 1.0), repeat=6))), even_numbers(RANGE_DRAWS, 0)])
    rotations, translations = poses_around(seed_pose.compose(to_middle), camera, wide, numbers)
    low, high = centred.vertices.min(axis=0), centred.vertices.max(axis=0)
    box = np.array(list(product(*zip(low, high, strict=True))))
    points = (box @ rotations.transpose(0, 2, 1) + translations[:, None]).reshape(-1, 3)
    if not points[:, 2].min() > NEAR_PLANE_SHARE * model.diameter:
        return None
    seen = np.concatenate([camera.project(points), camera.ideal.project(points)])  # folded lenses too
    if not np.isfinite(seen).all():
        return None
    low = np.maximum(np.floor(seen.min(axis=0)) - REGION_MARGIN_PX, 0.0)
    high = np.minimum(np.ceil(seen.max(axis=0)) + REGION_MARGIN_PX + 1.0, [camera.width, camera.height])
    size = high - low
    worth = size.prod() <= MOST_REGION_SHARE * camera.width * camera.height
    if not worth or not (size > 2 * REGION_MARGIN_PX).all():
        return None
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])
