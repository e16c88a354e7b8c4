"""Non-maximum suppression of the merged edges, where the weights of the channels cannot move an edge.

The weights change from pixel to pixel, most of all across an edge whose sides different lights reach, and
would pull the crest of the merged mass to one side. So each candidate is judged by the three contrasts across
the edge that its own weights give.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision_server.channel import ChannelStatistics

Field = NDArray[np.float32]

MOST_OFFSET_PX = 0.7  # from a ridge pixel to the ridge: half a diagonal


@njit(cache=True)
def across(field: Field, y: int, x: int, cosine: float, sine: float) -> tuple[float, float]:
    """The field one step ahead and behind along a direction, interpolated on the ring of neighbours."""
    u = 1 if cosine > 0.0 else -1
    v = 1 if sine > 0.0 else -1
    along_x, along_y = abs(cosine), abs(sine)
    if along_x >= along_y:
        t = along_y / along_x
        ahead = (1.0 - t) * field[y, x + u] + t * field[y + v, x + u]
        behind = (1.0 - t) * field[y, x - u] + t * field[y - v, x - u]
    else:
        t = along_x / along_y
        ahead = (1.0 - t) * field[y + v, x] + t * field[y + v, x + u]
        behind = (1.0 - t) * field[y - v, x] + t * field[y - v, x - u]
    return ahead, behind


@njit(cache=True)
def _add_profiles(
    contrast: Field,
    weight: Field,
    places: NDArray[np.int64],
    cosine: Field,
    sine: Field,
    profiles: NDArray[np.float64],
) -> None:
    """Add one channel to the profiles across the edge: behind, here, ahead, with the weight of the middle."""
    columns = contrast.shape[1]
    for i in range(len(places)):
        y, x = places[i] // columns, places[i] % columns
        w = weight[y, x]
        ahead, behind = across(contrast, y, x, cosine[i], sine[i])
        profiles[i, 0] += w * behind
        profiles[i, 1] += w * contrast[y, x]
        profiles[i, 2] += w * ahead


@njit(cache=True)
def _peaks(
    places: NDArray[np.int64],
    cosine: Field,
    sine: Field,
    profiles: NDArray[np.float64],
    magnitude: Field,
    ridge: Field,
    offset: Field,
) -> None:
    """Keep the places whose profile peaks in the middle; where between the three, as for a Gaussian."""
    columns = magnitude.shape[1]
    for i in range(len(places)):
        behind, here, ahead = profiles[i, 0], profiles[i, 1], profiles[i, 2]
        if here < ahead or here <= behind:
            continue
        y, x = places[i] // columns, places[i] % columns
        ridge[y, x] = magnitude[y, x]
        if behind > 0.0 and ahead > 0.0:
            behind, here, ahead = np.log(behind), np.log(here), np.log(ahead)
        curvature = ahead - 2.0 * here + behind
        if curvature < 0.0:
            stretch = 1.0 / max(abs(cosine[i]), abs(sine[i]))
            place = 0.5 * (behind - ahead) / curvature * stretch
            offset[y, x] = np.float32(min(max(place, -MOST_OFFSET_PX), MOST_OFFSET_PX))


def _profiles(
    channels: Iterable[ChannelStatistics], places: NDArray[np.int64], cosine: Field, sine: Field
) -> NDArray[np.float64]:
    profiles = np.zeros((len(places), 3))
    for channel in channels:
        _add_profiles(channel.contrast, channel.weight, places, cosine, sine, profiles)
    return profiles


def near_crest(
    channels: Iterable[ChannelStatistics], places: NDArray[np.int64], axes: Field, slack: float
) -> NDArray[np.bool_]:
    """Which places (flat indices) hold at least ``slack`` times the contrast one step to either side."""
    profiles = _profiles(channels, places, np.cos(axes), np.sin(axes))
    return np.asarray(profiles[:, 1] >= slack * np.maximum(profiles[:, 0], profiles[:, 2]))


def find_crests(
    channels: Iterable[ChannelStatistics], magnitude: Field, orientation: Field
) -> tuple[Field, Field]:
    """Thin the merged magnitude to ridges with sub-pixel positions.

    Parameters
    ----------
    channels
        All channels of the set.
    magnitude, orientation
        float32 (H, W); only pixels with magnitude above 0 are candidates.

    Returns
    -------
    ridge
        float32 (H, W), the magnitude on ridges, else 0.
    offset
        float32 (H, W), px along the orientation from the pixel's centre to the ridge.
    """
    places = np.flatnonzero(magnitude)
    angle = orientation.ravel()[places]
    cosine, sine = np.cos(angle), np.sin(angle)
    profiles = _profiles(channels, places, cosine, sine)
    ridge, offset = np.zeros_like(magnitude), np.zeros_like(magnitude)
    _peaks(places, cosine, sine, profiles, magnitude, ridge, offset)
    return ridge, offset
