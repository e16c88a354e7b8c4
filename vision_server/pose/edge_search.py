"""Edge points on the normals of samples in all channels, which are prepared where they are looked at."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel
from vision_server.channels.gradients import SCALES_PX, GradientChannel, Region
from vision_server.pose.edge_points import PEAKS, EdgePoints, Normals, find_edge_points

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BEYOND_PX = 4  # of the reach, that the kernel looks at: the next step, bilinear, and around the maximum


def search(channels: Sequence[GradientChannel], scale: Ints, normals: Normals) -> EdgePoints:
    """Edge points in all channels, see `find_edge_points`.

    Parameters
    ----------
    scale
        (C, N), index into SCALES_PX for each channel and sample; C-contiguous, as kernels expect.
    """
    shape = (len(channels), len(normals.image), PEAKS)
    out = EdgePoints(*(np.empty(shape) for _ in EdgePoints._fields))
    if len(normals.image) > 0:
        needed: Region = _bounds(normals.image, float(normals.reach_px.max()) + BEYOND_PX)
        sigmas = np.array(SCALES_PX)
        for c, channel in enumerate(channels):
            channel.prepare(int(scale[c].max()) + 1, needed)
            find_edge_points(
                channel.gradient, channel.noise, channel.near_clipped, scale[c], sigmas, normals, c, out
            )
    return out


@kernel()
def _bounds(image: Floats, margin_px: float) -> Region:
    """Left, top, right and bottom of what points (N, 2) and a margin around them cover."""
    left, top, right, bottom = np.inf, np.inf, -np.inf, -np.inf
    for i in range(len(image)):
        left, right = min(left, image[i, 0]), max(right, image[i, 0])
        top, bottom = min(top, image[i, 1]), max(bottom, image[i, 1])
    return (
        int(left - margin_px),
        int(top - margin_px),
        int(right + margin_px) + 1,
        int(bottom + margin_px) + 1,
    )
