"""Whether a session's images show the target at a pose from elsewhere, together and each alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import Model
from geometry.pose import Pose
from vision_server.image_set import ImageSet
from vision_server.matching.match import Anywhere
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.pose.observation import PoseProblem
from vision_server.prediction.target_moved import MISSING, REACHES_PX, SPACING_PX, clearly_elsewhere, moved_to
from vision_server.serve.inputs import checked_pose
from vision_server.serve.results import judgement_result
from vision_server.tracking.referee import judged
from vision_server.trust.ranking import refined
from vision_server.trust.support import support_at

if TYPE_CHECKING:
    from bridge.vision_messages import CheckArgs
    from vision_server.serve.task import PoseTask


def checked(task: PoseTask, args: CheckArgs) -> dict[str, Any]:
    """Whether a pose is right, by images of the session."""
    images, model, camera, settings = task.images, task.model, task.camera, task.settings
    pose = Pose.of(args.pose)
    try:
        checked_pose(pose, model)
        radius_m = task.edge_radius_m
        found = judged(images, args.images, model, camera, pose, settings, edge_radius_m=radius_m)
    except GeometryError as error:
        raise BadInput(f"The pose to be checked: {error}.") from error
    against = disagreeing_images(images, args.images, model, camera, pose, found.better, settings)
    return judgement_result(found, against)


def disagreeing_images(
    images: ImageSet,
    names: Sequence[str],
    model: Model,
    camera: Camera,
    pose: Pose,
    better: Pose | None,
    settings: PipelineSettings,
) -> list[str]:
    """Images that, each alone, clearly show the target elsewhere, as the set is not of a still scene then.

    There are none where no image shows it at the pose, or all do at a ``better`` one.

    Raises
    ------
    BadInput : an unknown image.
    """
    distinct = images.distinct(names)
    alone = {name: PoseProblem.at_scale(images.gradients([name]), model, camera) for name in distinct}
    doubted = _not_showing(alone, pose)
    if len(doubted) in (0, len(distinct)) or (better is not None and not _not_showing(alone, better)):
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


def _not_showing(alone: Mapping[str, PoseProblem], pose: Pose) -> list[str]:
    """Those images that do not show the target at a pose."""
    return [name for name, problem in alone.items() if _support(problem, pose) < MISSING]


def _support(problem: PoseProblem, pose: Pose) -> float:
    here = support_at(problem, pose, SPACING_PX)
    return 1.0 if here is None else here.supported_fraction
