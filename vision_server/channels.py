"""The channels of several images at once: one image does not depend on another, and the kernels leave the
interpreter free."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache

from vision_server.channel import ChannelStatistics, Grey, channel_statistics


def set_statistics(
    images: Sequence[Grey], exposures: Sequence[float], gammas: Sequence[float]
) -> list[ChannelStatistics]:
    """`channel_statistics` of each image, in their order; as many at a time as there are processors.

    Raises
    ------
    BadInput
        As `channel_statistics`.
    ValueError
        Not as many exposures or gammas as images.
    """
    if not len(images) == len(exposures) == len(gammas):
        raise ValueError(f"{len(images)} images, {len(exposures)} exposures and {len(gammas)} gammas")
    return list(_workers().map(channel_statistics, images, exposures, gammas))


@cache
def _workers() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(os.cpu_count() or 1, thread_name_prefix="channel")
