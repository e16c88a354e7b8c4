"""Straight segments as the paper has them ("edge linking"): chains, split recursively from the top down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from numerics.arrays import Floats, Ints
from vision_server.baselines.linking import link_edgels
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.suppression import edgel_thresholds, hysteresis
from vision_server.segments.extraction import MIN_LENGTH_PX, joined_segments
from vision_server.segments.line_fit import Edgels, Segments, fit_lines

# Chosen by hand where nothing else is said.
MAX_DEVIATION_RATIO = 0.03  # of max |d_i| to D, the distance between the piece's ends
MIN_DEVIATION_PX = 1.0  # deviations under this are the noise of edgels, whatever the length
CLOSED_PX = 1e-9  # ends so near to each other have no chord: distances are taken from them


def split_segments(edges: EdgeMap) -> Segments:
    """Straight segments of a merged edge map: hysteresis, linking into chains, splitting; strongest first."""
    chains = link_edgels(edges, hysteresis(edges, *edgel_thresholds(edges)))
    pieces = replace(chains, groups=split_chains(chains))
    lines = fit_lines(pieces)
    good = lines.length >= MIN_LENGTH_PX
    return joined_segments(replace(pieces, groups=pieces.groups[good]), lines.take(good))


def split_chains(chains: Edgels) -> Ints:
    """Straight pieces of chains: split at the farthest point while max|d_i| / D is too large.

    Parameters
    ----------
    chains
        Linked edgels, each group a chain.

    Returns
    -------
    int64 (N, 2), index of a piece's first point and one past its last; neighbours share the split point.
    """
    pieces = [
        piece for first, end in chains.groups.tolist() for piece in _split(chains.points, first, end - 1)
    ]
    return np.array(pieces, np.int64).reshape(-1, 2)


def _split(points: Floats, first: int, last: int) -> list[tuple[int, int]]:
    """Pieces (first, one past the last) of the points from ``first`` to ``last``, both included."""
    chord = points[last] - points[first]
    length = float(np.hypot(*chord))  # D
    x, y = (points[first + 1 : last] - points[first]).T
    distance = abs(x * chord[1] - y * chord[0]) / length if length > CLOSED_PX else np.hypot(x, y)  # |d_i|
    if len(distance) == 0 or distance.max() <= max(MIN_DEVIATION_PX, MAX_DEVIATION_RATIO * length):
        return [(first, last + 1)]
    middle = first + 1 + int(np.argmax(distance))
    return _split(points, first, middle) + _split(points, middle, last)
