"""Image segments as a perfect edge detector would see them, broken up, shaken and with clutter."""

import numpy as np

from geometry.camera import Camera
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose
from geometry.visibility import visible_samples
from numerics.arrays import Floats

CAMERA = Camera(640, 480, 700.0, 700.0, 319.5, 239.5)
SATELLITE = load_model(find_target("satellite"))
CUBE = load_model(find_target("cube"))
POSE = Pose(np.array([0.5, 0.4, 0.2]), np.array([0.02, -0.01, 1.0]))


def segments_of(
    model: Model, pose: Pose, camera: Camera = CAMERA, noise_px: float = 0.3, clutter: int = 0, seed: int = 0
) -> Floats:
    """Segments (N, 4) px of the visible lines, each cut in pieces, with noise and random ones among them."""
    random = np.random.default_rng(seed)
    samples = visible_samples(model, camera, pose, spacing_px=1.0)
    found = []
    for line in np.unique(samples.line):
        pixels = samples.image[samples.line == line]
        for piece in np.array_split(pixels, max(1, len(pixels) // 90)):
            if len(piece) > 8:
                found.append(np.concatenate([piece[0], piece[-1]]) + random.normal(0, noise_px, 4))
    middle = random.uniform([0, 0], [camera.width, camera.height], (clutter, 2))
    angle, half = random.uniform(0, np.pi, clutter), random.uniform(8, 30, clutter)
    step = np.column_stack([np.cos(angle), np.sin(angle)]) * half[:, None]
    return np.vstack([np.array(found).reshape(-1, 4), np.hstack([middle - step, middle + step])])
