"""Samples of lines that are given by their places in the image, and edgels by what their sides show.

Their arrays are of the kinds that kernels are given by the pipeline: none is compiled anew for others.
"""

import numpy as np

from geometry.visibility import Samples
from numerics.arrays import Floats, Ints
from vision_server.kinds.sides import Sides

STEEP = 1e3  # times as steep as a slope from side to side: the kind of such an edgel hangs on its sides alone


def sampled(line: Ints, image: Floats, direction: Floats) -> Samples:
    """Samples at these places in the image; where they are in space does not matter."""
    empty = np.zeros((len(line), 3))
    return Samples(empty, empty, line, image, direction, np.ones(len(line)), line)


def level_samples(gap_px: float) -> Samples:
    """Two level lines of 20 samples, the second one ``gap_px`` below the first."""
    along = np.arange(20.0)
    image = np.concatenate([np.stack([along, np.full(20, y)], axis=1) for y in (0.0, gap_px)])
    return sampled(np.repeat([0, 1], 20), image, np.tile([1.0, 0.0], (40, 1)))


def edgels_of(near: Floats, noise: float, axis: Floats | float = 0.0) -> Sides:
    """Edgels whose sides show ``near`` (C, 2, N) and no more, all of it known."""
    channels, _, count = near.shape
    shown, ahead, steep = np.ascontiguousarray(near, np.float32), np.full(count, axis), np.full(count, STEEP)
    of_all, known = np.full((channels, count), noise, np.float32), np.ones((channels, count), np.bool_)
    return Sides(shown, shown, of_all, known, ahead.astype(np.float32), sharpness=steep.astype(np.float32))
