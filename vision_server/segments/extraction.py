"""Straight segments of an edge map."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.suppression import edgel_thresholds
from vision_server.segments.bending import cut_bent
from vision_server.segments.growing import grow_lines
from vision_server.segments.joining import join_collinear
from vision_server.segments.line_fit import Edgels, FittedLines, fit_lines, log_chance

MIN_LENGTH_PX = 8.0  # chosen by hand
MAX_SEGMENTS = 600  # in clutter the longest and strongest are kept
MAX_LOG_CHANCE = -5.0  # decades: lines that chance would give less often than once in so many images


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


def extract_segments(edges: EdgeMap) -> Segments:
    """Straight segments of a merged edge map, grown along lines through its edgels; strongest first."""
    chosen = edges.strength > edgel_thresholds(edges)[0]
    edgels = grow_lines(edges, chosen, MIN_LENGTH_PX)
    lines = fit_lines(edgels)
    good = (lines.length >= MIN_LENGTH_PX) & (log_chance(lines, edges, chosen) < MAX_LOG_CHANCE)
    return joined_segments(replace(edgels, groups=edgels.groups[good]), lines.take(good))


def joined_segments(edgels: Edgels, lines: FittedLines) -> Segments:
    """Groups of edgels as segments: pieces of a line joined, curves cut.

    Parameters
    ----------
    edgels
        Edgels in straight groups.
    lines
        Lines fitted to the groups, N.

    Returns
    -------
    At most MAX_SEGMENTS, those with the largest length times strength.
    """
    lines = fit_lines(cut_bent(join_collinear(edgels, lines)))
    segments = Segments(lines.endpoints, lines.strength, lines.normal_sd)
    order = np.argsort(-segments.length * segments.strength, kind="stable")[:MAX_SEGMENTS]
    return segments.take(order)
