"""Samples of lines that are given by their places in the image."""

import numpy as np

from geometry.visibility import Samples
from numerics.arrays import Floats, Ints


def sampled(line: Ints, image: Floats, direction: Floats) -> Samples:
    """Samples at these places in the image; where they are in space does not matter."""
    empty = np.zeros((len(line), 3))
    return Samples(empty, empty, line, image, direction, np.ones(len(line)), line)


def level_samples(gap_px: float) -> Samples:
    """Two level lines of 20 samples, the second one ``gap_px`` below the first."""
    along = np.arange(20.0)
    image = np.concatenate([np.stack([along, np.full(20, y)], axis=1) for y in (0.0, gap_px)])
    return sampled(np.repeat([0, 1], 20), image, np.tile([1.0, 0.0], (40, 1)))
