"""Plain boxes with rounded edges, ray traced."""

import numpy as np

from benchmarks.printed_boxes import Box, taken
from geometry.pose import Pose
from geometry.rotation import matrix_of
from numerics.arrays import Grey
from tests.vision_server.synthetic import CAMERA, photographed

ALBEDO = (0.3, 0.8, 0.5, 0.9, 0.2, 0.7)
TURNS = ([0.5, 0.6, 0.1], [2.4, 0.5, 0.3], [0.4, -2.2, 0.6], [-0.6, 0.5, 1.4])


def plain_box(radius_m: float) -> Box:
    """Without print."""
    prints = np.ones((6, 8, 8)) * np.reshape(ALBEDO, (6, 1, 1))
    return Box(np.array([0.05, 0.04, 0.03]), radius_m, prints)


def pictured(box: Box, pose: Pose, seed: int = 0) -> Grey:
    lamp = np.array([0.4, -0.5, -1.0])
    behind = np.full((CAMERA.height, CAMERA.width), 0.05)
    return photographed(taken(box, [pose], CAMERA, lamp / np.linalg.norm(lamp), behind), 0.9, seed=seed)


def seen_at(turn: list[float]) -> Pose:
    return Pose.from_matrix(matrix_of(np.array(turn)), np.array([0.01, -0.01, 0.4]))


def framed_box(inset: int, width: int = 3, ink: float = 0.25) -> Box:
    """With a frame printed beside the edges of its faces, in ninety-sixths of their sides."""
    prints = np.ones((6, 96, 96)) * np.reshape(ALBEDO, (6, 1, 1))
    for face, albedo in zip(prints, ALBEDO, strict=True):
        within = inset + width
        face[inset:-inset, inset:-inset] = ink * albedo
        face[within:-within, within:-within] = albedo
    return Box(np.array([0.05, 0.04, 0.03]), 0.0008, prints)
