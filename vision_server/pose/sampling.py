"""How densely the lines of a model are sampled."""

from __future__ import annotations

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import DENSEST_PX, Samples, visible_samples

MOST_SAMPLES = 450
COUNTING_SPACING_PX = 4.0  # while the visible length is looked at


def spacing_for(model: Model, camera: Camera, pose: Pose) -> float:
    """Spacing of samples, px: about MOST_SAMPLES of a large target, short lines apart."""
    seen = visible_samples(model, camera, pose, COUNTING_SPACING_PX)
    return max(DENSEST_PX, float(seen.px.sum()) / MOST_SAMPLES)


def thinned(samples: Samples, most: int) -> Samples:
    """At most so many samples of each line, evenly taken, which stand for its whole visible length."""
    line = samples.line
    counts = np.bincount(line, minlength=1)
    kept_counts = np.minimum(counts, most)
    starts = np.cumsum(counts) - counts
    place = np.arange(len(line)) - starts[line]  # lines are ascending
    # sample number p of n is kept when it is the first whose share p m / n reaches a whole number
    share = place * kept_counts[line]
    keep = (share // counts[line]) != ((share - kept_counts[line]) // counts[line])
    lengths = np.bincount(line, samples.px, minlength=1)
    px = (lengths[line] / kept_counts[line])[keep]
    return Samples(*(field[keep] for field in samples))._replace(px=px)
