"""Images of a set that show the target elsewhere than a pose, each alone: the set is not of a still scene."""

from __future__ import annotations

from collections.abc import Sequence

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from vision_server.image_set import ImageSet
from vision_server.matching.match import Anywhere
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.pose.observation import PoseProblem
from vision_server.pose.ranking import refined
from vision_server.pose.support import support_at
from vision_server.prediction.surprise import MISSING, REACHES_PX, SPACING_PX, clearly_elsewhere, moved_to


def disagreeing_images(
    images: ImageSet,
    names: Sequence[str],
    model: Model,
    camera: Camera,
    pose: Pose,
    settings: PipelineSettings,
) -> list[str]:
    """Those that clearly show the target elsewhere; none where no image shows it at the pose.

    Raises
    ------
    BadInput : an unknown image.
    """
    distinct = images.distinct(names)
    alone = {name: PoseProblem.at_scale(images.gradients([name]), model, camera) for name in distinct}
    doubted = [name for name in distinct if _support(alone[name], pose) < MISSING]
    if len(doubted) == len(distinct):
        return []
    return [name for name in doubted if _is_elsewhere(images, name, alone[name], pose, settings)]


def _is_elsewhere(
    images: ImageSet, name: str, problem: PoseProblem, pose: Pose, settings: PipelineSettings
) -> bool:
    """Whether an image clearly supports another pose: beside the given one, around it or anywhere."""
    here = support_at(problem, pose, SPACING_PX)
    if here is None or moved_to(problem, pose) is not None:
        return here is not None
    for start in (pose, Anywhere()):
        searched = estimate_pose(images, [name], problem.model, problem.camera, start, settings).pose
        found = None if searched is None else refined(problem, searched, REACHES_PX, SPACING_PX)
        if found is not None and clearly_elsewhere(found, pose, here):
            return True
    return False


def _support(problem: PoseProblem, pose: Pose) -> float:
    here = support_at(problem, pose, SPACING_PX)
    return 1.0 if here is None else here.supported_fraction
