"""How densely the lines of a model are sampled."""

from __future__ import annotations

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples, visible_samples

LEAST_SPACING_PX = 2.0  # of samples: the sharpest filter makes nearer ones alike
MOST_SAMPLES = 450
SAMPLES_OF_TYPICAL = 8.0  # line: fewer than three say nothing of a line's straightness
COUNTING_SPACING_PX = 4.0  # while the visible length is looked at


def spacing_for(model: Model, camera: Camera, pose: Pose) -> float:
    """Spacing of samples, px: of large targets about MOST_SAMPLES, of intricate ones enough of a line."""
    seen = visible_samples(model, camera, pose, COUNTING_SPACING_PX)
    sparse = float(seen.px.sum()) / MOST_SAMPLES
    if sparse <= LEAST_SPACING_PX:
        return LEAST_SPACING_PX
    typical = float(np.median(np.bincount(seen.line, seen.px)[seen.line]))  # of the line of a random sample
    return max(LEAST_SPACING_PX, min(sparse, typical / SAMPLES_OF_TYPICAL))


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
