"""Growing straight lines through edgels, without leaving the line for texture or junctions.

Linking follows the edge pixel by pixel and splits afterwards; where texture touches an outline the chain
turns into the texture and the outline is lost. Here the line itself is followed: from a strong edgel both
ways, one row or column at a time, each new edgel must lie on the line fitted so far and agree with its
direction, and gaps are stepped over. In the spirit of the region growing of LSD (Grompone von Gioi et al.
2010), on ridges instead of regions, so that axial orientation cannot fuse the two sides of a thin bar."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from numerics.arrays import Flags, Ints
from numerics.kernels import kernel
from vision_server.edges.edge_map import EdgeMap, FreeEdgels
from vision_server.segments.line_fit import Edgels, edgel_groups

MAX_AXIS_DIFFERENCE_RAD = 0.39  # 22.5 deg, LSD's tolerance, between an edgel and its line
LEAST_AXIS_COSINE = float(np.cos(MAX_AXIS_DIFFERENCE_RAD))
# Chosen by hand: `python -m benchmarks.edge_segments` shows what they do.
MAX_OFFSET_PX = 1.5  # farthest, of an edgel from the line, on sharp images
BESIDE_PX = 0.7  # an edgel so near to a finished line says nothing new
MAX_GAP_PX = 4  # rows or columns without an edgel that a line may step over at once
MIN_DENSITY = 0.6  # of rows or columns between the ends that hold an edgel
FEWEST_EDGELS = 4  # of a line
START_RADIUS_PX = 3  # neighbourhood that gives the first direction
FEWEST_FITTED, TRUSTED = 5, 10  # edgels from which on a line is fitted; from which on only the fit counts
TURNED_AWAY = 2.0  # tangent, from the rows or columns that a line is followed by: it is another line


class Line(NamedTuple):
    """A point of a line and the unit vector along it, px."""

    x: float
    y: float
    c: float
    s: float


class Moments(NamedTuple):
    """Number of some points, sums of their coordinates and products; relative to one, to lose no digits."""

    n: float
    x: float
    y: float
    xx: float
    xy: float
    yy: float


@kernel(inline="always")
def _half_angle(c2: float, s2: float) -> tuple[float, float]:
    """Unit vector at half the angle of a vector."""
    length = np.sqrt(c2 * c2 + s2 * s2)
    if length <= 0.0:
        return 1.0, 0.0
    c = np.sqrt(max(0.5 + 0.5 * c2 / length, 0.0))
    s = np.sqrt(max(0.5 - 0.5 * c2 / length, 0.0))
    return c, s if s2 >= 0.0 else -s


@kernel(inline="always")
def _offset(edgels: FreeEdgels, at: int, line: Line) -> float:
    """Distance of an edgel from a line, px."""
    offset: float = abs((edgels.points[at, 0] - line.x) * line.s - (edgels.points[at, 1] - line.y) * line.c)
    return offset


@kernel(inline="always")
def _agree(edgels: FreeEdgels, at: int, nx: float, ny: float) -> bool:
    """Whether an edgel's axis is that of a unit vector, within the tolerance."""
    cosine: float = abs(edgels.normals[at, 0] * nx + edgels.normals[at, 1] * ny)
    return cosine >= LEAST_AXIS_COSINE


@kernel()
def _start(edgels: FreeEdgels, seed: int) -> Line:
    """First direction of a line: along the mean axis of the edgels around that lie on the seed's own line."""
    rows, columns = edgels.number_at.shape
    nx, ny = edgels.normals[seed, 0], edgels.normals[seed, 1]
    x, y = np.float64(edgels.points[seed, 0]), np.float64(edgels.points[seed, 1])
    line = Line(x, y, -np.float64(ny), np.float64(nx))
    y0 = edgels.places[seed] // columns
    x0 = edgels.places[seed] - y0 * columns
    c2, s2 = 0.0, 0.0
    for v in range(max(y0 - START_RADIUS_PX, 0), min(y0 + START_RADIUS_PX + 1, rows)):
        for u in range(max(x0 - START_RADIUS_PX, 0), min(x0 + START_RADIUS_PX + 1, columns)):
            at = edgels.number_at[v, u]
            if at < 0 or not edgels.free[at] or not _agree(edgels, at, nx, ny):
                continue
            if _offset(edgels, at, line) <= MAX_OFFSET_PX:
                mx, my = edgels.normals[at, 0], edgels.normals[at, 1]
                c2 += mx * mx - my * my
                s2 += 2.0 * mx * my
    c, s = _half_angle(c2, s2)
    return Line(line.x, line.y, -s, c)


@kernel(inline="always")
def _nearest(edgels: FreeEdgels, line: Line, steep: bool, place: int) -> int:
    """The free edgel of a row (of a steep line) or column that lies nearest to the line and agrees, or -1."""
    rows, columns = edgels.number_at.shape
    if steep:
        across = line.x + (place - line.y) * line.c / line.s
    else:
        across = line.y + (place - line.x) * line.s / line.c
    middle, reach = int(across + 0.5), int(np.ceil(MAX_OFFSET_PX + 0.5))
    best, least = -1, MAX_OFFSET_PX
    for k in range(max(middle - reach, 0), min(middle + reach + 1, columns if steep else rows)):
        at = edgels.number_at[place, k] if steep else edgels.number_at[k, place]
        if at < 0 or not edgels.free[at] or not _agree(edgels, at, -line.s, line.c):
            continue
        offset = _offset(edgels, at, line)
        if offset < least:
            best, least = at, offset
    return best


@kernel(inline="always")
def _refitted(sums: Moments, line: Line, x0: float, y0: float) -> Line:
    """The total least squares line; a short one trusts the direction it had as much as its points."""
    n = sums.n
    if n < FEWEST_FITTED:
        return line
    mx, my = sums.x / n, sums.y / n
    c2, s2 = sums.xx - sums.yy - n * (mx * mx - my * my), 2.0 * (sums.xy - n * mx * my)
    if n < TRUSTED:
        part = (n - FEWEST_FITTED + 1.0) / (TRUSTED - FEWEST_FITTED + 1.0)
        rest = 1.0 - part
        part /= np.sqrt(c2 * c2 + s2 * s2) + 1e-12
        c2 = part * c2 + rest * (line.c * line.c - line.s * line.s)
        s2 = part * s2 + rest * 2.0 * line.c * line.s
    c, s = _half_angle(c2, s2)
    return Line(x0 + mx, y0 + my, c, s)


@kernel()
def _follow(edgels: FreeEdgels, seed: int, members: Ints) -> tuple[int, int, bool, Line]:
    """The line through one edgel: how many ``members`` it has, rows or columns from end to end, steepness."""
    rows, columns = edgels.number_at.shape
    x0, y0 = np.float64(edgels.points[seed, 0]), np.float64(edgels.points[seed, 1])
    line = _start(edgels, seed)
    steep = abs(line.s) > abs(line.c)
    begin = edgels.places[seed] // columns if steep else edgels.places[seed] % columns
    limit = rows if steep else columns
    sums = Moments(1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    members[0] = seed
    count, low, high = 1, begin, begin
    for sign in (1, -1):
        place, misses = begin, 0
        while misses <= MAX_GAP_PX:
            place += sign
            if place < 0 or place >= limit:
                break
            best = _nearest(edgels, line, steep, place)
            if best < 0:
                misses += 1
                continue
            misses = 0
            members[count] = best
            count += 1
            low, high = min(low, place), max(high, place)
            x, y = edgels.points[best, 0] - x0, edgels.points[best, 1] - y0
            sums = Moments(
                sums.n + 1.0, sums.x + x, sums.y + y, sums.xx + x * x, sums.xy + x * y, sums.yy + y * y
            )
            line = _refitted(sums, line, x0, y0)
            along, across = (line.s, line.c) if steep else (line.c, line.s)
            if abs(across) > TURNED_AWAY * abs(along):
                break
    return count, high - low + 1, steep, line


@kernel()
def _claim(edgels: FreeEdgels, members: Ints, steep: bool, line: Line) -> None:
    """Take a line's edgels, and those beside them, of which a slanted edge has two a step."""
    rows, columns = edgels.number_at.shape
    for member in members:
        edgels.free[member] = False
        y = edgels.places[member] // columns
        x = edgels.places[member] - y * columns
        nx, ny = edgels.normals[member, 0], edgels.normals[member, 1]
        for beside in (-1, 1):
            v, u = (y, x + beside) if steep else (y + beside, x)
            if v < 0 or u < 0 or v >= rows or u >= columns:
                continue
            at = edgels.number_at[v, u]
            if at >= 0 and edgels.free[at] and _offset(edgels, at, line) < BESIDE_PX:
                edgels.free[at] = not _agree(edgels, at, nx, ny)


@kernel()
def _grow(edgels: FreeEdgels, seeds: Ints, shortest: float, members: Ints, starts: Ints) -> int:
    """Lines from all seeds; members of line k are members[starts[k]:starts[k + 1]]. Returns how many."""
    lines = 0
    starts[0] = 0
    for seed in seeds:
        if not edgels.free[seed]:
            continue
        begin = starts[lines]
        count, span, steep, line = _follow(edgels, seed, members[begin:])
        edgels.free[seed] = False
        length = span / max(abs(line.c), abs(line.s))
        if length >= shortest and count >= max(MIN_DENSITY * span, FEWEST_EDGELS):
            _claim(edgels, members[begin : begin + count], steep, line)
            lines += 1
            starts[lines] = begin + count
    return lines


def grow_lines(edges: EdgeMap, chosen: Flags, shortest_px: float) -> Edgels:
    """Straight groups of edgels, each edgel in one group at most; from the strongest seed on.

    Parameters
    ----------
    edges
        Merged edge map.
    chosen
        bool (N,), edgels that may take part.
    shortest_px
        Shorter lines are dropped.
    """
    seeds = edges.strongest_first(chosen)
    members = np.empty(len(seeds) + sum(edges.shape) + 1, np.int64)
    starts = np.zeros(len(seeds) + 2, np.int64)
    count = _grow(edges.free(chosen), seeds, shortest_px, members, starts)
    groups = np.stack([starts[:count], starts[1 : count + 1]], axis=1)
    return edgel_groups(edges, members[: starts[count]], groups)
