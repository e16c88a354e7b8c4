"""Straight segments of an edge map."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vision_server.channels.lighting import LENS_BLUR_PX
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.suppression import edgel_thresholds, hysteresis
from vision_server.rivals.linking import link_edgels
from vision_server.rivals.splitting import split_chains
from vision_server.segments.centring import centre_lines
from vision_server.segments.growing import grow_lines
from vision_server.segments.joining import join_collinear
from vision_server.segments.line_fit import fit_lines, log_chance

MIN_LENGTH_PX = 8.0
MAX_SEGMENTS = 600  # in clutter the longest and strongest are kept
MAX_LOG_CHANCE = -5.0  # decades: lines that chance would give less often than once in so many images

BLUR_REACH = 2.5  # how far a blurred edge extends to either side, in standard deviations of the blur

Grouping = Literal["growing", "splitting"]


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
        ends = self.endpoints
        return np.asarray(np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1]), dtype=np.float64)

    def take(self, chosen: NDArray[np.int64] | NDArray[np.bool_]) -> Segments:
        """The chosen segments, by index or mask."""
        return Segments(self.endpoints[chosen], self.strength[chosen], self.normal_sd[chosen])


def extract_segments(
    edges: EdgeMap,
    *,
    grouping: Grouping = "growing",
    min_length_px: float = MIN_LENGTH_PX,
    max_segments: int = MAX_SEGMENTS,
) -> Segments:
    """Straight segments of a merged edge map.

    Parameters
    ----------
    edges
        Merged edge map.
    grouping
        ``growing`` follows straight lines through edgels; ``splitting`` is the paper's way: hysteresis,
        linking into chains, recursive splitting of the chains.
    min_length_px
        Shorter segments are dropped.
    max_segments
        At most so many, those with the largest length times strength.

    Returns
    -------
    Segments, strongest first; none when there are none.
    """
    low, high = edgel_thresholds(edges)
    chosen = edges.strength > low
    if grouping == "growing":
        edgels = grow_lines(edges, chosen, shortest_px=min_length_px)
    else:
        chains = link_edgels(edges, hysteresis(edges, low, high))
        edgels = replace(chains, groups=split_chains(chains))
    lines = fit_lines(edgels)
    good = lines.length >= min_length_px
    if grouping == "growing":
        good &= log_chance(lines, edges, chosen) < MAX_LOG_CHANCE
    edgels = join_collinear(replace(edgels, groups=edgels.groups[good]), lines.take(good))
    lines = fit_lines(edgels)
    ends = lines.endpoints
    if edges.blur_px > LENS_BLUR_PX:
        ends = centre_lines(
            ends, ((c.contrast, c.weight) for c in edges.channels), BLUR_REACH * edges.blur_px
        )
    segments = Segments(ends, lines.strength, lines.normal_sd)
    order = np.argsort(-segments.length * segments.strength, kind="stable")[:max_segments]
    return segments.take(order)
