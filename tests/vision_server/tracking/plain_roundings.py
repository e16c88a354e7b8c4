"""How far rounded edges lie from the model's, as NumPy says it."""

from __future__ import annotations

import numpy as np

from geometry.pose import Pose
from geometry.roundings import FLAT_FACES, sharp_and_convex
from numerics.arrays import Floats
from vision_server.pose.observation import Observation, PoseProblem


def plain_shifts(problem: PoseProblem, pose: Pose, seen: Observation) -> tuple[Floats, Floats]:
    """See `rounding_shifts`."""
    model, camera, line = problem.model, problem.camera, seen.samples.line
    normals = model.face_normals @ pose.matrix.T
    one, two = (normals[model.line_faces[line, side]] for side in (0, 1))
    points = pose.apply(seen.samples.points)
    sight = points / np.linalg.norm(points, axis=1, keepdims=True)
    both, apart = one + two, 1.0 + (one * two).sum(axis=1)
    apex = both / np.maximum(apart, FLAT_FACES)[:, None]
    outward = np.cross(sight, seen.samples.direction @ pose.matrix.T)
    outward *= (np.sign((outward * both).sum(axis=1)) / np.linalg.norm(outward, axis=1))[:, None]
    outline = (1.0 - (outward * apex).sum(axis=1))[:, None] * outward
    crease = both / np.maximum(np.linalg.norm(both, axis=1), FLAT_FACES)[:, None] - apex
    creased = ((one * sight).sum(axis=1) < 0.0) & ((two * sight).sum(axis=1) < 0.0)
    shift = np.where(creased[:, None], crease, outline)
    slack = np.where(creased[:, None], 0.5 * (one - two), 0.0)
    rounds = sharp_and_convex(model)[line] & (apart > FLAT_FACES)
    along = []
    for change in (shift, slack):
        image = (change[:, :2] - change[:, 2:] * points[:, :2] / points[:, 2:]) / points[:, 2:]
        pixels = (image * [camera.fx, camera.fy] * seen.samples.normal).sum(axis=1)
        along.append(np.where(rounds, pixels, 0.0))
    return along[0], np.abs(along[1])
