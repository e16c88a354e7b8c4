"""How densely the lines of a model are sampled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import DENSEST_PX, Samples, visible_samples
from numerics.kernels import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_SAMPLES = 450
COUNTING_SPACING_PX = 4.0  # while the visible length is looked at


def spacing_for(model: Model, camera: Camera, pose: Pose) -> float:
    """Spacing of samples, px: about MOST_SAMPLES of a large target, short lines apart."""
    seen = visible_samples(model, camera, pose, COUNTING_SPACING_PX)
    return max(DENSEST_PX, float(seen.px.sum()) / MOST_SAMPLES)


def thinned(samples: Samples, most: int) -> Samples:
    """At most so many samples of each line, evenly taken, which stand for its whole visible length."""
    keep, px = _kept(samples.line, samples.px, most)
    points, direction, line, image, image_direction, _ = samples
    return Samples(points[keep], direction[keep], line[keep], image[keep], image_direction[keep], px)


@kernel()
def _kept(line: Ints, px: Floats, most: int) -> tuple[Ints, Floats]:
    """Which samples are kept, of n of a line number p where p m / n reaches a whole number, and their px."""
    keep, lengths = np.empty(len(line), np.int64), np.empty(len(line))
    found = start = 0
    while start < len(line):
        end, total = start, 0.0
        while end < len(line) and line[end] == line[start]:
            total += px[end]
            end += 1
        count, of_line = end - start, min(end - start, most)
        for place in range(count):
            if place * of_line // count != (place - 1) * of_line // count:
                keep[found], lengths[found] = start + place, total / of_line
                found += 1
        start = end
    return keep[:found], lengths[:found]
