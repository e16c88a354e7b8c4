"""How far edges stray beyond their noise: measured about the lines of the pose that a set has.

Texture, neighbours that blur together and a model that is not quite true move edges alike in every image. A
variance of `expected_straying` is what is expected of that; a target before its own background shows up to
seven times as little or three times as much, and its images say which.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats
from vision_server.channels.noise import MAD_TO_SD
from vision_server.pose.observation import Observation
from vision_server.pose.weights import SYSTEMATIC_SD_PX

# As in the controller's prediction of whole images (domain/reasoning/prediction.pl), which explains it.
CROWDING = 0.05
FOUND, ENOUGH = 0.5, 8  # share of a line's samples, and how many, for its scatter to be measured
# The expectation counts like so many lines: one image of a cube shows about nine.
PRIOR_LINES = 4
LEAST_SHARE = 0.01  # of the expected variance: a tenth of its standard deviation, below all that was measured


def expected_straying(blur_px: Floats) -> Floats:
    """Variance, px^2, by which an edge strays beyond its noise where the image is so blurred, same shape."""
    return np.asarray(SYSTEMATIC_SD_PX**2 + CROWDING * blur_px**3)


def line_scatter(seen: Observation) -> Floats:
    """Variance, px^2, of each line's edge points about it, (C, L); NaN where too little of it is found."""
    scatter = np.full(seen.sigma.shape, np.nan)
    for line in np.unique(seen.samples.line).tolist():
        for channel, offsets in enumerate(seen.offset[:, seen.samples.line == line]):
            found = offsets[np.isfinite(offsets)]
            if len(found) >= max(ENOUGH, FOUND * len(offsets)):
                scatter[channel, line] = (MAD_TO_SD * np.median(np.abs(found))) ** 2
    return scatter


def straying_share(scatter: Floats, noise: Floats, expected: Floats) -> float:
    """By how much what is not noise differs from what is expected, over all lines: a factor of its variance.

    Parameters
    ----------
    scatter
        (C, L) px^2, of `line_scatter`.
    noise
        (C, L) px^2, what noise is expected to contribute.
    expected
        (C,) px^2, of `expected_straying`.
    """
    shares = np.maximum(scatter - noise, 0.0) / expected[:, None]
    measured = shares[np.isfinite(shares)]
    return max(float(np.median(np.concatenate([measured, np.ones(PRIOR_LINES)]))), LEAST_SHARE)
