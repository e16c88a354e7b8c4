"""Short films of a cuboid that moves, with known truth."""

from collections.abc import Iterator

import numpy as np

from geometry.model import Model
from geometry.pose import Pose, disturbed
from geometry.rotation import matrix_of
from numerics.arrays import Grey
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, photographed

GREYS = (0.3, 0.7, 0.2, 0.9, 0.5, 0.8)
TURN = np.radians([0.8, 1.5, -0.6])  # rad a frame
SHIFT = np.array([0.0025, -0.001, 0.002])  # m a frame: some 2.5 px
NEAR = disturbed(POSE, np.random.default_rng(1), 10.0, 10.0, CAMERA.fx)  # where films are looked at first


def moving(count: int, still: int = 0) -> list[Pose]:
    """True poses; the first ``still`` are one."""
    poses = [POSE]
    for k in range(1, count):
        turn = matrix_of(TURN if k >= still else np.zeros(3))
        shift = SHIFT if k >= still else np.zeros(3)
        poses.append(Pose.from_matrix(turn @ poses[-1].matrix, poses[-1].translation + shift))
    return poses


def filmed(model: Model, poses: list[Pose | None], exposure: float = 0.8) -> Iterator[Grey]:
    """A frame for each pose; without one the target is not there."""
    for number, pose in enumerate(poses):
        if pose is None:
            picture = np.full((CAMERA.height, CAMERA.width), 0.08)
        else:
            picture = linear_picture(model, CAMERA, pose, GREYS)
        yield photographed(picture, exposure, seed=number)
