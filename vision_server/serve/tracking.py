"""Frames of a moving target, and poses from elsewhere, as a session's operations take them."""

from __future__ import annotations

from typing import Any

import numpy as np

from bridge.arrays import FramePixels
from bridge.errors import BadInput
from bridge.vision_messages import CheckArgs
from geometry.errors import GeometryError
from geometry.pose import Pose
from vision_server.serve.inputs import checked_pose
from vision_server.serve.results import judgement_result, tracked_result
from vision_server.serve.task import PoseTask
from vision_server.serve.witnesses import disagreeing_images
from vision_server.tracking.referee import judged
from vision_server.tracking.tracker import Tracker


def tracked(task: PoseTask, pixels: FramePixels, time_s: float | None) -> dict[str, Any]:
    """The next frame of the session; the first one is looked for around its seed pose."""
    if task.tracker is None:
        settings = task.settings
        task.tracker = Tracker(
            task.model,
            task.camera,
            task.seed_pose,
            task.gamma,
            settings.tone_sd_px,
            settings.seed,
            task.edge_radius_m,
        )
    told = task.tracker.step(task.raw.grey(pixels), time_s)
    return {**tracked_result(told), "note": told.note}


def checked(task: PoseTask, args: CheckArgs) -> dict[str, Any]:
    """Whether a pose is right, by images of the session."""
    pose = Pose(np.array(args.pose.rotation_vector), np.array(args.pose.translation))
    try:
        checked_pose(pose, task.model)
        found = judged(
            task.images,
            args.images,
            task.model,
            task.camera,
            pose,
            task.settings,
            edge_radius_m=task.edge_radius_m,
        )
    except GeometryError as error:
        raise BadInput(f"The pose to be checked: {error}.") from error
    against = disagreeing_images(task.images, args.images, task.model, task.camera, pose, task.settings)
    return judgement_result(found, against)
