"""Scenes that poses are judged on by `benchmarks.referee`, and poses of them as other programs get them."""

from __future__ import annotations

import cv2
import numpy as np

from benchmarks.films import CAMERA, film
from bridge.messages import Settings
from geometry.camera import Camera
from geometry.model import Model
from geometry.near_symmetries import near_symmetries
from geometry.pose import Pose
from geometry.rotation import matrix_of
from image_server.simulator.simulator import Simulator
from stack.exposure import relative_exposure
from vision_server.image_set import ImageSet
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import refine

POSES = 8  # of a scene
SCENARIOS = ("nominal", "textured", "harsh", "eclipse", "grazing", "back-lit", "blur", "glint")
CORNERS, MOST_OFF_PX, INTERCHANGED = 8, 3.0, 0.3


def scene(number: int) -> tuple[ImageSet, Model, Camera, Pose]:
    """A scene by number: images, and the true pose."""
    rng = np.random.default_rng([number, 77])
    if number % 3 == 0:
        model, shown = film(number, "printed", 3) if number % 2 else film(4 * number + 3, "lights", 3)
        frame = next(shown)
        images = ImageSet(CAMERA.width, CAMERA.height)
        images.add("i1", frame.pixels, 1.0, 1.0)
        return images, model, CAMERA, frame.pose
    target = ("cube", "fixture", "satellite")[int(rng.integers(3))]
    device = Simulator(target, str(rng.choice(SCENARIOS)), number)
    told = device.describe()
    images = ImageSet(device.camera.width, device.camera.height)
    for k in range(int(rng.integers(1, 4))):
        settings = Settings(
            lights=tuple(int(rng.integers(0, light.levels)) for light in told.lights),
            shutter_s=float(rng.choice(told.shutters_s)),
            aperture=float(rng.choice(told.apertures)),
            focal_length_mm=told.focal_lengths_mm[0] if told.focal_lengths_mm else None,
            focus_m=told.focuses_m[0] if told.focuses_m else None,
        )
        exposure = relative_exposure(settings.shutter_s, settings.aperture, told.reference)
        images.add(f"i{k + 1}", device.capture(settings).pixels, exposure, 1.0)
    return images, device.model, device.camera, device.true_pose


def given_poses(
    number: int, images: ImageSet, model: Model, camera: Camera, true: Pose
) -> list[tuple[str, Pose]]:
    """Poses right and wrong, and where each is from."""
    rng = np.random.default_rng([number, 78])
    problem = PoseProblem.at_scale(images.gradients(list(images.images)), model, camera)
    turns = near_symmetries(model)
    poses = []
    for k in range(POSES):
        source, pose = "drawn", _off(rng, model, true, 10.0 ** rng.uniform(-1.7, 1.48))
        if k >= POSES - 2:  # as programs get them: refined from too far away
            solution = refine(problem, _off(rng, model, true, rng.uniform(2.0, 15.0)))
            if solution is not None:
                source, pose = "refined", solution.pose
        elif k == POSES - 3:  # and from corners that a network found
            found = _of_corners(rng, model, camera, true)
            if found is not None:
                source, pose = "corners", found
        elif k == 0 and len(turns):
            turned = true.compose(turns[int(rng.integers(len(turns)))])
            source, pose = "turned", _off(rng, model, turned, 0.05)
        poses.append((source, pose))
    return [(source, pose) for source, pose in poses if pose.apply(model.middle[None])[0, 2] > 0.0]


def _of_corners(rng: np.random.Generator, model: Model, camera: Camera, true: Pose) -> Pose | None:
    """A pose from corners that are off by some px, now and then with two of them interchanged."""
    chosen = rng.permutation(len(model.vertices))[:CORNERS]
    points = model.vertices[chosen]
    pixels = camera.project(true.apply(points)) + rng.uniform(0.0, MOST_OFF_PX) * rng.normal(
        size=(len(points), 2)
    )
    if rng.random() < INTERCHANGED:
        pixels[:2] = pixels[1::-1].copy()
    rays = (pixels - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
    found, turn, shift = cv2.solvePnP(points, rays, np.eye(3), None, flags=cv2.SOLVEPNP_SQPNP)
    return Pose(np.asarray(turn[:, 0], np.float64), np.asarray(shift[:, 0], np.float64)) if found else None


def _off(rng: np.random.Generator, model: Model, pose: Pose, degrees: float) -> Pose:
    """A pose that is off by so many degrees at most, and shifted as far as that moves its corners."""
    axis = rng.normal(size=3)
    turn = matrix_of(np.radians(degrees) * rng.uniform(0.2, 1.0) * axis / np.linalg.norm(axis))
    centre = pose.apply(model.middle[None])[0]
    shift = np.radians(degrees) * 0.5 * model.diameter * rng.normal(size=3) * [1.0, 1.0, 2.0]
    return Pose.from_matrix(turn @ pose.matrix, centre + shift + turn @ (pose.translation - centre))
