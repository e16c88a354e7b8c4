"""From an edge map to straight segments: grown (`growing`), joined, cut where they bend, judged by chance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.suppression import edgel_thresholds
from vision_server.segments.bending import cut_bent
from vision_server.segments.curves import SHORTEST_PX, chained_surprise
from vision_server.segments.growing import grow_lines
from vision_server.segments.joining import join_collinear
from vision_server.segments.line_fit import Edgels, FittedLines, Segments, fit_lines, log_chance

MIN_LENGTH_PX = 8.0  # chosen by hand
MAX_SEGMENTS = 600  # in clutter the longest and strongest are kept
MAX_LOG_CHANCE = -5.0  # decades: lines that chance would give less often than once in so many images


def extract_segments(edges: EdgeMap) -> Segments:
    """Straight segments of a merged edge map, grown along lines through its edgels; strongest first."""
    chosen = edges.strength > edgel_thresholds(edges)[0]
    edgels = grow_lines(edges, chosen, MIN_LENGTH_PX)
    lines = fit_lines(edgels)
    good = (lines.length >= MIN_LENGTH_PX) & (log_chance(lines, edges, chosen) < MAX_LOG_CHANCE)
    return joined_segments(replace(edgels, groups=edgels.groups[good]), lines.take(good))


def extract_with_pieces(edges: EdgeMap) -> Segments:
    """Straight segments, and the pieces of bent edges that are no accident together; strongest first."""
    chosen = edges.strength > edgel_thresholds(edges)[0]
    edgels = grow_lines(edges, chosen, SHORTEST_PX)
    lines = fit_lines(edgels)
    places = 2.5 * np.log10(edges.shape[0] * edges.shape[1])  # decades of lines to choose from
    surprise = places - log_chance(lines, edges, chosen)
    chance = places - chained_surprise(lines.endpoints, lines.strength, surprise)
    good = (lines.length >= SHORTEST_PX) & (chance < MAX_LOG_CHANCE)
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
