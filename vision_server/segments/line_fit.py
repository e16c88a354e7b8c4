"""Total least squares lines through edgels, and whether they are by chance (Desolneux et al. 2000)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np

from numerics.arrays import Field, Flags, Floats, Ints
from numerics.kernels import kernel
from vision_server.edges.edge_map import EdgeMap

# Chosen by hand where nothing else is said.
EDGEL_SD_PX = 0.1  # smallest believable scatter of edgels about a line
CELL_PX, CELLS = 8, 5  # the density of edgels is taken in 5 x 5 cells of 8 x 8 px


@dataclass(frozen=True)
class Edgels:
    """Groups of edgels, each to become a line.

    Attributes
    ----------
    points
        float64 (P, 2), sub-pixel x, y, px.
    normals
        float64 (P,), orientation across the edge, rad.
    strengths
        float64 (P,), merged magnitude.
    groups
        int64 (N, 2), first point of a group and one past its last.
    """

    points: Floats
    normals: Floats
    strengths: Floats
    groups: Ints


def edgel_groups(edges: EdgeMap, members: Ints, groups: Ints) -> Edgels:
    """Groups (N, 2) given as stretches of a list (P,) of edgels' numbers."""
    return Edgels(
        edges.points[members].astype(np.float64),
        edges.axis[members].astype(np.float64),
        edges.strength[members].astype(np.float64),
        groups,
    )


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

    endpoints: Floats
    strength: Floats
    normal_sd: Floats

    def __len__(self) -> int:
        return len(self.endpoints)

    @property
    def length(self) -> Floats:
        """float64 (N,), px."""
        ends = self.endpoints
        return np.asarray(np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1]), dtype=np.float64)

    def take(self, chosen: Ints | Flags) -> Self:
        """The chosen segments, by index or mask (N,)."""
        return type(self)(*(getattr(self, name)[chosen] for name in self.__dataclass_fields__))


@dataclass(frozen=True)
class FittedLines(Segments):
    """Segments of N groups of edgels, and how well they fit these.

    Attributes
    ----------
    rms_px, rms_axis_rad
        float64 (N,), of the edgels from the line, and of their axes from its normal.
    count
        int64 (N,), edgels.
    """

    rms_px: Floats
    rms_axis_rad: Floats
    count: Ints


@kernel()
def _fit(
    points: Floats,
    normals: Floats,
    strengths: Floats,
    groups: Ints,
    edgel_sd: float,
) -> Floats:
    """Total least squares per group: x0, y0, x1, y1, strength, the two sd, the two rms."""
    rows = np.zeros((len(groups), 9))
    for g in range(len(groups)):
        first, stop = groups[g, 0], groups[g, 1]
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
        lowest, highest, turned = 1e18, -1e18, 0.0
        for k in range(first, stop):
            t = (points[k, 0] - mx) * c + (points[k, 1] - my) * s
            lowest, highest = min(lowest, t), max(highest, t)
            d = (normals[k] - angle) % np.pi - 0.5 * np.pi
            turned += d * d
        sd = max(np.sqrt(across / max(n - 2, 1)), edgel_sd)
        rows[g, 0], rows[g, 1] = mx + lowest * c, my + lowest * s
        rows[g, 2], rows[g, 3] = mx + highest * c, my + highest * s
        rows[g, 4] = strength / n
        rows[g, 5] = sd / np.sqrt(n)
        rows[g, 6] = sd / np.sqrt(max(along, 1e-9))
        rows[g, 7] = np.sqrt(across / n)
        rows[g, 8] = np.sqrt(turned / n)
    return rows


def fit_lines(edgels: Edgels) -> FittedLines:
    """Total least squares line through each group; its ends are the projections of the outermost edgels."""
    rows = _fit(edgels.points, edgels.normals, edgels.strengths, edgels.groups, EDGEL_SD_PX)
    return FittedLines(
        np.ascontiguousarray(rows[:, :4]),
        rows[:, 4].copy(),
        np.ascontiguousarray(rows[:, 5:7]),
        rows[:, 7].copy(),
        rows[:, 8].copy(),
        edgels.groups[:, 1] - edgels.groups[:, 0],
    )


def edgel_density(edges: EdgeMap, chosen: Flags) -> Field:
    """Edgels per px in the 40 x 40 px around each cell of 8 x 8 px, float32 (ceil(H / 8), ceil(W / 8))."""
    rows, columns = (-(-side // CELL_PX) for side in edges.shape)
    y, x = np.divmod(edges.places[chosen], np.int32(edges.shape[1]))
    counts = np.bincount((y // CELL_PX) * columns + x // CELL_PX, minlength=rows * columns)
    per_px = (counts.reshape(rows, columns) / CELL_PX**2).astype(np.float32)
    return np.asarray(cv2.blur(per_px, (CELLS, CELLS)), dtype=np.float32)


def log_chance(lines: FittedLines, edges: EdgeMap, chosen: Flags) -> Floats:
    """Decimal logarithm of a bound on the expected number of lines as good as each, by chance.

    The a-contrario test of Desolneux, Moisan & Morel (2000) with edgels instead of pixels: in a field of
    edgels as dense as that around the line, with independent positions and axes, each step along it would
    hold one within twice the rms distance and rms angle with probability p; k hits in n steps are bounded by
    Chernoff's exp(-n KL(k / n || p)), and there are about (W H)^(5/2) lines to choose from.

    Parameters
    ----------
    lines
        N fitted lines.
    edges, chosen
        The edge map, and which of its edgels may be part of lines, bool.

    Returns
    -------
    float64 (N,); under 0 a line is no accident.
    """
    height, width = edges.shape
    density = edgel_density(edges, chosen)
    ends = lines.endpoints
    x = np.clip(np.round(0.5 * (ends[:, 0] + ends[:, 2])).astype(int), 0, width - 1) // CELL_PX
    y = np.clip(np.round(0.5 * (ends[:, 1] + ends[:, 3])).astype(int), 0, height - 1) // CELL_PX
    across_px = np.maximum(4.0 * lines.rms_px, 0.5)
    axis_share = np.clip(4.0 * lines.rms_axis_rad / np.pi, 0.08, 0.5)
    p = np.clip(density[y, x] * across_px * axis_share, 1e-4, 0.9)
    span = np.maximum(np.abs(ends[:, 2] - ends[:, 0]), np.abs(ends[:, 3] - ends[:, 1])) + 1.0
    steps = np.maximum(span, lines.count)
    share = np.clip(lines.count / steps, 1e-6, 1.0 - 1e-9)
    divergence = share * np.log(share / p) + (1.0 - share) * np.log((1.0 - share) / (1.0 - p))
    surprise = steps * np.where(share > p, divergence, 0.0) / np.log(10.0)
    return np.asarray(2.5 * np.log10(width * height) - surprise, dtype=np.float64)
