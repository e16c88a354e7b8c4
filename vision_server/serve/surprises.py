"""What has happened before an image that is not as it was foreseen, and what is learnt from that."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geometry.pose import Pose
from vision_server.pose.observation import PoseProblem
from vision_server.prediction.causes import Cause, likely_causes, verdict
from vision_server.prediction.places import read
from vision_server.prediction.surprise import moved_to
from vision_server.serve.prediction import lit_images
from vision_server.serve.task import Happened, PoseTask


class Surprise(NamedTuple):
    """What has surely happened, and what may have: a cause and the lights that it is about, or None."""

    cause: tuple[str, tuple[str, ...]] | None = None
    doubt: tuple[str, tuple[str, ...]] | None = None


def surprise_of(task: PoseTask, image: str) -> Surprise:
    """Hold an image, before which something was foreseen, against what was; the task keeps what is sure."""
    pose = task.expected
    if pose is None:
        return Surprise()
    if target_moved(task, image, pose):
        task.expected = task.best = None
        task.happened = [*task.happened, Happened("target_moved", (), image)]
        return Surprise(cause=("target_moved", ()))
    images = images_of_scene(task)
    sure, doubt = verdict(causes(task, images, pose), len(images))
    task.doubted = images[doubt.since] if doubt is not None else None
    if sure is not None:
        task.happened = [*task.happened, Happened(sure.name, sure.lights, images[sure.since])]
    return Surprise(_named(task, sure), _named(task, doubt))


def target_moved(task: PoseTask, image: str, pose: Pose) -> bool:
    """Whether the target is elsewhere in this image."""
    problem = PoseProblem.at_scale(task.images.gradients([image]), task.model, task.camera)
    return moved_to(problem, pose) is not None


def causes(task: PoseTask, images: Sequence[str], pose: Pose) -> list[Cause]:
    """What may have happened before the last of these images of one scene."""
    lights = task.describe.lights
    positions = [None if light.position is None else np.array(light.position) for light in lights]
    shown = lit_images(task, images)
    places, readings = read(task.model, task.camera, pose, positions, shown)
    doubted = images.index(task.doubted) if task.doubted in images else None
    return likely_causes(places, readings, np.array([image.lights for image in shown]), doubted)


def images_of_scene(task: PoseTask) -> list[str]:
    """The images of the target where it is now, under the sun of now, in order of time."""
    images = list(task.applied)
    begun = [one.since for one in task.happened if one.cause in ("target_moved", "sun_changed")]
    first = max((images.index(since) for since in begun if since in images), default=0)
    return images[first:]


def _named(task: PoseTask, cause: Cause | None) -> tuple[str, tuple[str, ...]] | None:
    if cause is None:
        return None
    return cause.name, tuple(task.describe.lights[light].name for light in cause.lights)
