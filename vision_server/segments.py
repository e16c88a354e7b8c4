"""Straight segments of an edge map: least-squares lines through sub-pixel edgels, with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision_server.canny import hysteresis
from vision_server.edges import EdgeMap
from vision_server.linking import link_edgels
from vision_server.splitting import split_chains

LOW_NOISE_RATIO = 3.0  # hysteresis thresholds, in standard deviations of the merged contrast ...
HIGH_NOISE_RATIO = 6.0
LOW_GREY = 1.5  # ... and in grey: steps under this are not worth following
HIGH_GREY = 3.0
MIN_LENGTH_PX = 8.0
MAX_SEGMENTS = 600  # in clutter the longest and strongest are kept
EDGEL_SD_PX = 0.1  # smallest believable scatter of edgels about a line


@dataclass(frozen=True)
class Segments:
    """Straight image segments.

    Attributes
    ----------
    endpoints
        float64 (N, 4), x0, y0, x1, y1, px.
    strength
        float64 (N,), mean merged magnitude along the segment, grey at reference exposure.
    normal_sd
        float64 (N, 2), standard deviation across the line of its middle (px) and of its direction (rad).
    """

    endpoints: NDArray[np.float64]
    strength: NDArray[np.float64]
    normal_sd: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.endpoints)

    @property
    def length(self) -> NDArray[np.float64]:
        """float64 (N,), px."""
        return np.hypot(
            self.endpoints[:, 2] - self.endpoints[:, 0], self.endpoints[:, 3] - self.endpoints[:, 1]
        )

    def take(self, chosen: NDArray[np.int64] | NDArray[np.bool_]) -> Segments:
        """The chosen segments, by index or mask."""
        return Segments(self.endpoints[chosen], self.strength[chosen], self.normal_sd[chosen])


@njit(cache=True)
def _fit(
    points: NDArray[np.float64], strengths: NDArray[np.float64], pieces: NDArray[np.int64], edgel_sd: float
) -> NDArray[np.float64]:
    """Total least squares per piece: rows x0, y0, x1, y1, strength, sd of the middle, sd of the direction."""
    rows = np.zeros((len(pieces), 7))
    for p in range(len(pieces)):
        first, stop = pieces[p, 0], pieces[p, 1]
        n = stop - first
        if n < 2:
            continue
        mx, my, strength = 0.0, 0.0, 0.0
        for k in range(first, stop):
            mx += points[k, 0]
            my += points[k, 1]
            strength += strengths[k]
        mx, my = mx / n, my / n
        sxx, sxy, syy = 0.0, 0.0, 0.0
        for k in range(first, stop):
            dx, dy = points[k, 0] - mx, points[k, 1] - my
            sxx += dx * dx
            sxy += dx * dy
            syy += dy * dy
        angle = 0.5 * np.arctan2(2.0 * sxy, sxx - syy)
        c, s = np.cos(angle), np.sin(angle)
        along = sxx * c * c + 2.0 * sxy * c * s + syy * s * s
        across = max(sxx + syy - along, 0.0)
        lowest, highest = 1e18, -1e18
        for k in range(first, stop):
            t = (points[k, 0] - mx) * c + (points[k, 1] - my) * s
            lowest, highest = min(lowest, t), max(highest, t)
        sd = max(np.sqrt(across / max(n - 2, 1)), edgel_sd)
        rows[p, 0], rows[p, 1] = mx + lowest * c, my + lowest * s
        rows[p, 2], rows[p, 3] = mx + highest * c, my + highest * s
        rows[p, 4] = strength / n
        rows[p, 5] = sd / np.sqrt(n)
        rows[p, 6] = sd / np.sqrt(max(along, 1e-9))
    return rows


def edgel_thresholds(edges: EdgeMap) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Hysteresis thresholds at each pixel, (H, W), from the noise there."""
    low = np.maximum(LOW_NOISE_RATIO * edges.floor, np.float32(LOW_GREY))
    high = np.maximum(HIGH_NOISE_RATIO * edges.floor, np.float32(HIGH_GREY))
    return low, high


def extract_segments(
    edges: EdgeMap, *, min_length_px: float = MIN_LENGTH_PX, max_segments: int = MAX_SEGMENTS
) -> Segments:
    """Straight segments of a merged edge map: hysteresis, linking, splitting, least squares.

    Parameters
    ----------
    edges
        Merged edge map.
    min_length_px
        Shorter segments are dropped.
    max_segments
        At most so many, those with the largest length times strength.

    Returns
    -------
    Segments, strongest first; none when there are none.
    """
    low, high = edgel_thresholds(edges)
    chains = link_edgels(edges, hysteresis(edges.ridge, low, high))
    rows = _fit(chains.points, chains.strengths, split_chains(chains), EDGEL_SD_PX)
    segments = Segments(
        np.ascontiguousarray(rows[:, :4]), rows[:, 4].copy(), np.ascontiguousarray(rows[:, 5:])
    )
    segments = segments.take(segments.length >= min_length_px)
    order = np.argsort(-segments.length * segments.strength, kind="stable")[:max_segments]
    return segments.take(order)
