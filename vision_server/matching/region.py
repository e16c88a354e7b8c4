"""Where in a large frame the target can be, of which there is a seed pose: only that part is looked at."""

from __future__ import annotations

from itertools import product

import numpy as np

from geometry.camera import Camera, Region
from geometry.model import Model, about_middle
from geometry.pose import Pose
from vision_server.matching.draws import MARGIN, MARGIN_DEG, MARGIN_PX, even_numbers, poses_around
from vision_server.matching.match import SearchRange

# Chosen by hand where nothing else is said.
LEAST_PIXELS = 2_000_000  # of a frame: reading all of a smaller one costs little, and tells more of its noise
WORTH_SHARE = 0.6  # of the frame: more than that is not cut
BESIDE_PX = 48  # around the target: what blurs over its edges, and what the refinement looks for beside them
LOOKED_AT = 256  # poses within the range, besides its corners
NEAR = 1e-3  # of the target's size: a corner so near to the camera's plane may be anywhere


def region_of(model: Model, camera: Camera, seed_pose: Pose, reach: SearchRange) -> Region | None:
    """The part of a large frame in which a search around a seed pose may see the target; None: all of it."""
    if camera.width * camera.height < LEAST_PIXELS:
        return None
    centred, to_middle = about_middle(model)
    wide = SearchRange(
        min(reach.rotation_deg * (1.0 + MARGIN) + MARGIN_DEG, 180.0),
        reach.translation_px * (1.0 + MARGIN) + MARGIN_PX,
    )
    numbers = np.concatenate([np.array(list(product((-1.0, 1.0), repeat=6))), even_numbers(LOOKED_AT, 0)])
    rotations, translations = poses_around(seed_pose.compose(to_middle), camera, wide, numbers)
    low, high = centred.vertices.min(axis=0), centred.vertices.max(axis=0)
    box = np.array(list(product(*zip(low, high, strict=True))))
    points = (box @ rotations.transpose(0, 2, 1) + translations[:, None]).reshape(-1, 3)
    if not points[:, 2].min() > NEAR * model.diameter:
        return None
    seen = np.concatenate([camera.project(points), camera.ideal.project(points)])  # folded lenses too
    if not np.isfinite(seen).all():
        return None
    low = np.maximum(np.floor(seen.min(axis=0)) - BESIDE_PX, 0.0)
    high = np.minimum(np.ceil(seen.max(axis=0)) + BESIDE_PX + 1.0, [camera.width, camera.height])
    size = high - low
    if not (size > 2 * BESIDE_PX).all() or size.prod() > WORTH_SHARE * camera.width * camera.height:
        return None
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])
