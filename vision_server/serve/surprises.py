"""What has happened before an image that is not as it was foreseen, and what is learnt from that."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import takewhile
from typing import NamedTuple, cast

import numpy as np

from bridge.errors import BadInput
from bridge.start_messages import CauseName, CauseTold
from geometry.pose import Pose
from numerics.arrays import Floats
from vision_server.pose.observation import PoseProblem
from vision_server.prediction.causes import DOUBT_NATS, MOST_IMAGES, Cause, likely_causes, verdict
from vision_server.prediction.lit_target import LitTarget
from vision_server.prediction.new_edges import NEW, NEW_BESIDE_SHADOWS, new_edges
from vision_server.prediction.places import read
from vision_server.prediction.repeated import Difference, difference, flicker
from vision_server.prediction.target_moved import moved_to
from vision_server.serve.prediction import lit_images, outputs
from vision_server.serve.statistics import lit_region, target_region
from vision_server.serve.task import Happened, PoseTask

# That light is as it was, against an image that is relit: of 504 pairs of images of the same light none was.
RELIT_NATS = 12.0


class Surprise(NamedTuple):
    """What has surely happened, or what may have."""

    cause: CauseTold | None = None
    doubt: CauseTold | None = None


def surprise_of(task: PoseTask, image: str) -> Surprise:
    """Hold an image against those before and what was foreseen, if anything; the task keeps what is sure."""
    if task.expected is not None and target_moved(task, image, task.expected):
        task.learn(Happened("target_moved", (), frozenset(task.applied) - {image}))
        return Surprise(cause=CauseTold(cause="target_moved", since=image))
    images = images_of_scene(task)
    sure, doubt = _judged(task, images)
    if doubt is not None and task.doubted in images:  # what was doubted first is not forgotten
        doubt = doubt._replace(since=min(doubt.since, images.index(task.doubted)))
    task.doubted = images[doubt.since] if doubt is not None else None
    if sure is not None:
        task.learn(Happened(sure.name, sure.lights, images_before(task.applied, images[sure.since])))
    return Surprise(_named(task, images, sure), _named(task, images, doubt))


def _judged(task: PoseTask, images: Sequence[str]) -> tuple[Cause | None, Cause | None]:
    """What is sure, and what is doubted; new edges first, as their test shows other light, too.

    Where nothing was foreseen only images of the same settings tell, about where the target is. What is relit
    is doubted, however little of it can be weighed, as where most is saturated.
    """
    since = images.index(task.doubted) if task.doubted in images else len(images) - 1
    pose = task.expected or task.likely_pose()
    differ, flickers = repetitions(task, images, since, pose)
    relit = "relit" in differ
    if "replaced" in differ and not relit:
        return Cause("in_the_way", (), since, np.inf, tested=True), None
    if task.expected is None and not relit:
        return None, None
    target = None if pose is None else LitTarget(task.model, task.camera, pose, _positions(task))
    new = None if relit or target is None else something_new(task, images, target)
    if new is not None:
        return None, new
    weighed = [] if target is None else causes(task, images, target, relit, flickers)
    sure, doubt = verdict(weighed)
    if relit and sure is None and doubt is None:
        doubt = next(iter(weighed), Cause("sun_changed", (), since, DOUBT_NATS))
    return sure, doubt


def target_moved(task: PoseTask, image: str, pose: Pose) -> bool:
    """Whether the target is elsewhere in this image."""
    problem = PoseProblem.at_scale(task.images.gradients([image]), task.model, task.camera)
    return moved_to(problem, pose) is not None


def causes(
    task: PoseTask, images: Sequence[str], target: LitTarget, relit: bool, flickers: Mapping[str, float]
) -> list[Cause]:
    """What may have happened before the last of these images of one scene.

    Some may be relit, and some have so many times the light that they are said to have.
    """
    taken, lit = lit_images(task, images)
    shown = [
        replace(one, exposure=one.exposure * flickers.get(image, 1.0))
        for image, one in zip(images, lit, strict=True)
    ]
    places, readings = read(target, shown)
    doubted = images.index(task.doubted) if task.doubted in images else None
    found = likely_causes(places, readings, taken.lights, doubted)
    if not relit:
        return found
    return [one._replace(nats=one.nats + RELIT_NATS) for one in found if one.name != "in_the_way"]


def repetitions(
    task: PoseTask, images: Sequence[str], since: int, pose: Pose | None
) -> tuple[list[Difference | None], dict[str, float]]:
    """How each of these images since one differs from each before that it repeats, where the target is.

    And how many times the light of that one those have that do not differ. Without a pose the target is all
    that is lit.
    """
    pictures = task.images.images
    pairs = [
        (before, after)
        for after in images[since:]
        for before in images[:since]
        if before in pictures and after in pictures and _alike(task, before, after)
    ]
    if not pairs:
        return [], {}
    if pose is None:
        target = lit_region(pictures[one].statistics.image for pair in pairs for one in pair)
    else:
        target = target_region(task.model, task.camera, pose)
    differ, flickers = [], dict[str, float]()
    for before, after in pairs:
        looks = pictures[before].pixels, pictures[after].pixels
        differ.append(difference(*looks, target))
        if differ[-1] is None:
            flickers[after] = flicker(*looks, target) ** task.gamma
    return differ, flickers


def something_new(task: PoseTask, images: Sequence[str], target: LitTarget) -> Cause | None:
    """What the last of these images may show in front, where nothing is doubted yet and others tell of it."""
    if task.doubted in images or len(images) < 2:
        return None
    _, shown = lit_images(task, images[-MOST_IMAGES:])
    drawn = len(target.positions) > 0 and bool(target.located.all())
    if new_edges(target, shown) < (NEW_BESIDE_SHADOWS if drawn else NEW):
        return None
    return Cause("in_the_way", (), len(images) - 1, DOUBT_NATS)


def _positions(task: PoseTask) -> list[Floats | None]:
    """Of the lights, (3,) m in the camera's frame, None where one is not known."""
    lights = task.describe.lights
    return [None if light.position is None else np.array(light.position) for light in lights]


def _alike(task: PoseTask, one: str, other: str) -> bool:
    """Whether two images were taken under the same settings, as far as is known."""
    first, second = task.applied[one], task.applied[other]
    lights = np.array_equal(outputs(task, first, one), outputs(task, second, other))
    return lights and (first.shutter_s, first.aperture) == (second.shutter_s, second.aperture)


def images_of_scene(task: PoseTask) -> list[str]:
    """The images of the target, sun and what is in the way as they are now, in order of time."""
    ends = "target_moved", "sun_changed", "in_the_way"
    begun = [one.before for one in task.happened if one.cause in ends]
    return [image for image in task.applied if not any(image in before for before in begun)]


def images_before(images: Iterable[str], since: str) -> frozenset[str]:
    """Of images, in order of time, those before one of them."""
    return frozenset(takewhile(lambda image: image != since, images))


def restore(task: PoseTask, told: CauseTold, images: Sequence[str]) -> None:
    """Have a task, which is to have these images, know what an earlier one has named.

    Raises
    ------
    BadInput
        An image that it is not to have, or a light that its device does not have.
    """
    if told.since is not None and told.since not in images:
        raise BadInput(f"What happened since {told.since} is told without that image.", "Name one of images.")
    names = [light.name for light in task.describe.lights]
    for name in told.lights:
        if name not in names:
            raise BadInput(f"The {task.describe.device} has no light {name}.", f"It has {', '.join(names)}.")
    before = frozenset(images) if told.since is None else images_before(images, told.since)
    task.learn(Happened(told.cause, tuple(map(names.index, told.lights)), before))


def _named(task: PoseTask, images: Sequence[str], cause: Cause | None) -> CauseTold | None:
    if cause is None:
        return None
    lights = tuple(task.describe.lights[light].name for light in cause.lights)
    return CauseTold(cause=cast(CauseName, cause.name), lights=lights, since=images[cause.since])
