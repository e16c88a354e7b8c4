"""How densely a model's visible lines are sampled in the image, and where on its line each sample is."""

from __future__ import annotations

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import DENSEST_PX, Samples, visible_samples
from numerics.arrays import Floats, Ints
from numerics.kernels import kernel

SAMPLES_A_TARGET = 450  # at most about so many (by hand): time is in proportion
COUNTING_SPACING_PX = 4.0  # while the visible length is looked at
SPARSE_SPACING_PX, MOST_SPARSE_SAMPLES = 4.0, 12  # of a line, for a look at what runs beside it (by hand)


def spacing_for(model: Model, camera: Camera, pose: Pose) -> float:
    """Spacing of samples, px: about SAMPLES_A_TARGET of a large target, short lines apart."""
    seen = visible_samples(model, camera, pose, COUNTING_SPACING_PX)
    return max(DENSEST_PX, float(seen.px.sum()) / SAMPLES_A_TARGET)


def sparse_samples(model: Model, camera: Camera, pose: Pose) -> Samples:
    """A few samples of each visible line, for a look at what runs beside it."""
    return thinned(visible_samples(model, camera, pose, SPARSE_SPACING_PX), MOST_SPARSE_SAMPLES)


def thinned(samples: Samples, most: int) -> Samples:
    """At most so many samples of each line, evenly taken, which stand for its whole visible length."""
    keep, px = _kept(samples.line, samples.px, most)
    points, direction, line, image, image_direction, _, own = samples
    image, image_direction = image[keep], image_direction[keep]
    return Samples(points[keep], direction[keep], line[keep], image, image_direction, px, own[keep])


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


@kernel()
def places_on_lines(samples: Samples, gap_px: float) -> tuple[Floats, Floats]:
    """Where each sample is on its line, and how far from where the line or a visible part of it ends.

    Parameters
    ----------
    gap_px
        Neighbours that are farther apart have something in between that hides the line.

    Returns
    -------
    along (N,), between the ends of all visible parts, -1 to 1; distance (N,) to the nearest end, px.
    """
    line, image, direction = samples.line, samples.image, samples.image_direction
    count = len(line)
    along, distance = np.zeros(count), np.zeros(count)
    start = 0
    while start < count:
        end = start
        while end < count and line[end] == line[start]:
            end += 1
        ux, uy = direction[(start + end) // 2, 0], direction[(start + end) // 2, 1]
        low, high, part = np.inf, -np.inf, start
        for i in range(start, end):
            along[i] = image[i, 0] * ux + image[i, 1] * uy
            low, high = min(low, along[i]), max(high, along[i])
            if i + 1 == end or abs(image[i + 1, 0] * ux + image[i + 1, 1] * uy - along[i]) > gap_px:
                for k in range(part, i + 1):
                    distance[k] = min(abs(along[k] - along[part]), abs(along[k] - along[i])) + 0.25 * gap_px
                part = i + 1
        for i in range(start, end):
            along[i] = 2.0 * (along[i] - low) / (high - low) - 1.0 if high > low else 0.0
        start = end
    return along, distance
