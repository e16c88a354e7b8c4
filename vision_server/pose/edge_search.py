"""Edge points on the normals of samples in all channels; tiles of gradients are made where it looks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from numerics.arrays import Ints
from vision_server.channels.gradients import SCALES_PX, GradientChannel, Normals
from vision_server.pose.edge_points import PEAKS, EdgePoints, find_edge_points

# Of the reach, that the kernel looks at: the next step, bilinear, around the maximum; and the flanks of that.
PREPARED_BEYOND_PX = 12


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
        sigmas = np.array(SCALES_PX)
        for c, channel in enumerate(channels):
            channel.prepare(scale[c], normals, PREPARED_BEYOND_PX)
            find_edge_points(channel.frame, channel.tiles, scale[c], sigmas, normals, c, out)
    return out
