"""Whether a target is still where images before have seen it.

A prediction says where the lines of a target will be. Where most of them are missing in an image, and are
found a little beside, the target has moved. What else may have happened: `causes`.
"""

from __future__ import annotations

import math

import numpy as np

from geometry.pose import Pose
from vision_server.pose.observation import PoseProblem
from vision_server.trust.probability import quality
from vision_server.trust.ranking import Refined, refined
from vision_server.trust.support import PoseSupport, support_at

# How they were chosen: benchmarks/surprises.py counts moves that are told, and false alarms.
MISSING = 0.45  # supported share of the lines from which on they are where they were
FOUND, CLEARLY = 0.35, 4.0  # supported share at the new place, and how many times the old one's quality
CLEARLY_NATS = 20.0  # and how much more evidence: of an image that shows little both qualities are small
REACHES_PX, SPACING_PX = (16.0, 8.0, 4.0), 4.0
MOVED_PX = 2.0  # of the target's middle, or as much turned: less is no move
ASIDE_PX = 8.0  # other starts, where the first finds nothing


def moved_to(problem: PoseProblem, pose: Pose) -> Pose | None:
    """Where the target is in an image in which it is not where it was; None where that is not sure.

    Parameters
    ----------
    problem
        The image alone, as refinement sees it.
    pose
        Of the images before, rather right than wrong.
    """
    here = support_at(problem, pose, SPACING_PX)
    if here is None or here.supported_fraction >= MISSING:
        return None
    aside = ASIDE_PX * float(np.linalg.norm(pose.translation)) / problem.camera.fx
    for step in np.array([[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]) * aside:
        start = Pose(pose.rotation_vector, pose.translation + step)
        found = refined(problem, start, REACHES_PX, SPACING_PX)
        if found is not None and clearly_elsewhere(found, pose, here):
            return found.pose
    return None


def clearly_elsewhere(found: Refined, pose: Pose, here: PoseSupport) -> bool:
    """Whether a target is where it was found rather than at a pose, which has this support in the image."""
    model, camera = found.problem.model, found.problem.camera
    middles = np.stack([one.apply(model.middle[None])[0] for one in (pose, found.pose)])
    moved_px = float(np.linalg.norm(np.diff(camera.project(middles), axis=0)))
    px_per_m = camera.fx / float(np.linalg.norm(pose.translation))
    turned_px = 0.5 * model.diameter * px_per_m * math.radians(found.pose.error_to(pose).rotation_deg)
    better = found.quality >= CLEARLY * quality(here) and found.support.supported_fraction >= FOUND
    clear = found.support.evidence >= here.evidence + CLEARLY_NATS
    return better and clear and max(moved_px, turned_px) >= MOVED_PX
