"""`python -m vision_server warm`: compile every kernel into numba's cache, on two cores."""

from __future__ import annotations

import os
import subprocess
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import TYPE_CHECKING

from numerics.stale_kernels import remove_stale_kernels
from numerics.two_cores import cores
from numerics.warming import warming

if TYPE_CHECKING:
    import numpy as np

    from geometry.camera import Camera
    from geometry.model import Model
    from geometry.pose import Pose
    from vision_server.image_set import ImageSet

LONGEST_S = 900.0  # that the second process is waited for; it takes one minute


def add_options(_: ArgumentParser) -> None:
    """It has none."""


def run(_: Namespace) -> None:
    """Compile what has changed.

    A second process begins with what this one comes to last: each kernel is compiled by one of them, and
    found on the disk by the other.
    """
    remove_stale_kernels()
    with warming("vision server", "numerics", "geometry", "vision_server"), _beside():
        warm_up()


@contextmanager
def _beside() -> Iterator[None]:
    """The second process, `refine`, while the block runs; what it leaves the block does.

    It is in a session of its own: Ctrl-C reaches this process, with which it ends.
    """
    if cores() == 1:
        yield
        return
    words = f"from {__name__} import refine; refine({os.getpid()})"
    with subprocess.Popen([sys.executable, "-c", words], start_new_session=True) as second:
        try:
            yield
            with suppress(subprocess.TimeoutExpired):
                second.wait(LONGEST_S)
        finally:
            second.kill()


def warm_up() -> None:
    """Find the pose of a cube in every way there is, and its edges, their kinds, and what has moved."""
    from vision_server.edges.suppression import edge_picture
    from vision_server.matching import Anywhere
    from vision_server.pipeline import PipelineSettings, estimate_pose
    from vision_server.prediction.small_pictures import faces_seen
    from vision_server.tracking.tracker import Tracker

    model, camera, pose, images = _photographed_cube()
    estimate_pose(images, ["sharp"], model, camera, Anywhere())
    for names, matcher in (
        (["sharp"], "search"),
        (["blurred", "bright"], "search"),
        (["sharp", "blurred"], "genetic"),
    ):
        estimate_pose(images, names, model, camera, pose, PipelineSettings(matcher=matcher))
    for edge_radius_m in (0.0, 0.01 * model.diameter):
        tracker = Tracker(replace(model, edge_radius_m=edge_radius_m), camera, pose)
        for name in ("sharp", "noisy"):
            tracker.step(images.images[name].pixels)
    edge_picture(images.edge_map(["sharp", "bright"]))
    images.moved("bright")
    faces_seen(model, camera, pose)
    _find_kinds(model, camera, pose, images)
    assert images.images["sharp"].statistics.lone_blur_px is not None


def refine(parent_pid: int) -> None:
    """Find the kinds of a cube's edges, refine its pose and weigh it anew, while a process lives."""
    from bridge.lifeline import Lifeline
    from vision_server.pose.observation import PoseProblem
    from vision_server.trust.likely import last_step
    from vision_server.trust.ranking import best_first
    from vision_server.trust.told_apart import evidence_apart

    Lifeline(parent_pid).enforce()
    model, camera, pose, images = _photographed_cube()
    _find_kinds(model, camera, pose, images)
    problem = PoseProblem.at_scale(images.gradients(["sharp"]), model, camera, 0, 0.01, 0.0)
    for found in best_first(problem, [pose]):
        last_step(found)
        evidence_apart(found.support, found.support)


def _find_kinds(model: Model, camera: Camera, pose: Pose, images: ImageSet) -> None:
    """The kinds of edges of images, and of a cube in a sun and under lamps: where these are told, and not."""
    import numpy as np

    from vision_server.image_set import ImageSet
    from vision_server.kinds.kinds import edge_kinds

    under = ImageSet(camera.width, camera.height)
    lamps = [drawn(model, camera, pose, 0.7, turn, ground=2) for turn in (0, 2, 4)]
    for number, picture in enumerate([*lamps, np.minimum.reduce(lamps)]):
        under.add(str(number), picture, 1.0, 1.0)
    channels = [image.statistics for image in under.images.values()]
    edge_kinds([image.statistics for image in images.images.values()])
    edge_kinds(channels[:-1])
    for levels in (None, np.eye(4), np.eye(4, 3)):
        edge_kinds(channels, levels)


def _photographed_cube() -> tuple[Model, Camera, Pose, ImageSet]:
    """A model, its camera and pose, and images of it of several kinds."""
    import numpy as np

    from geometry.camera import Camera
    from geometry.model import TARGETS, load_model
    from geometry.pose import Pose
    from vision_server.channels.depth import PER_GREY
    from vision_server.image_set import ImageSet

    model = load_model(TARGETS / "cube.cao")
    camera = Camera(320, 240, 400.0, 400.0, 159.5, 119.5)
    pose = Pose(np.array([0.5, 0.7, 0.1]), np.array([0.0, 0.0, 4.0 * model.diameter]))
    images = ImageSet(camera.width, camera.height)
    sharp = drawn(model, camera, pose, 0.7)
    noise = np.random.default_rng(0).normal(0.0, 4.0, sharp.shape)
    images.add("sharp", sharp, 1.0, 1.0)
    images.add("blurred", drawn(model, camera, pose, 3.0), 1.0, 1.0)
    images.add("bright", np.minimum(2 * sharp.astype(np.uint16), 255).astype(np.uint8), 2.0, 1.0)
    images.add("toned", sharp, 1.0, 2.2)
    images.add("deep", sharp.astype(np.uint16) * np.uint16(PER_GREY), 1.0, 1.0)
    images.add("noisy", np.clip(sharp + noise, 0.0, 255.0).astype(np.uint8), 1.0, 1.0)
    return model, camera, pose, images


def drawn(
    model: Model, camera: Camera, pose: Pose, sigma_px: float, turn: int = 0, ground: int = 20
) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """A plain picture of a convex model, uint8 (H, W): each face that looks at the camera in one grey.

    Another ``turn`` gives the faces each other's greys.
    """
    import cv2
    import numpy as np

    picture = np.full((camera.height, camera.width), ground, dtype=np.uint8)
    points = pose.apply(model.vertices)
    normals = model.face_normals @ pose.matrix.T
    pixels = camera.project(points)
    for index, face in enumerate(model.faces):
        if normals[index] @ points[face[0]] < 0.0:
            grey = 80 + 140 * ((index + turn) % len(model.faces)) // max(1, len(model.faces) - 1)
            cv2.fillConvexPoly(picture, np.round(pixels[face] * 16).astype(np.int32), grey, cv2.LINE_AA, 4)
    blurred = cv2.GaussianBlur(picture, (0, 0), sigma_px)
    return np.asarray(blurred, dtype=np.uint8)
