"""Growing straight lines through edgels, without leaving the line for texture or junctions.

Linking follows the edge pixel by pixel and splits afterwards; where texture touches an outline the chain
turns into the texture and the outline is lost. Here the line itself is followed: from a strong edgel both
ways, one row or column at a time, each new edgel must lie on the line fitted so far and agree with its
direction, and gaps are stepped over. In the spirit of the region growing of LSD (Grompone von Gioi et al.
2010), on ridges instead of regions, so that axial orientation cannot fuse the two sides of a thin bar."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vision_server.edges import EdgeMap
from vision_server.line_fit import Edgels

MAX_AXIS_DIFFERENCE_RAD = 0.39  # 22.5 deg, LSD's tolerance, between an edgel and its line
MAX_OFFSET_PX = 1.5  # of an edgel from the line, on sharp images
BESIDE_PX = 0.7  # an edgel so near to a finished line says nothing new
MAX_GAP_PX = 4  # rows or columns without an edgel that a line may step over at once
MIN_DENSITY = 0.6  # of rows or columns between the ends that hold an edgel
START_RADIUS_PX = 3  # neighbourhood that gives the first direction


@njit(cache=True)
def _line(n: float, sx: float, sy: float, sxx: float, sxy: float, syy: float) -> tuple[float, float, float]:
    """Total least squares from sums: middle x, y and direction, rad."""
    mx, my = sx / n, sy / n
    return mx, my, 0.5 * np.arctan2(2.0 * (sxy - n * mx * my), (sxx - n * mx * mx) - (syy - n * my * my))


@njit(cache=True)
def _axis_difference(a: float, b: float) -> float:
    """Angle between two axes, rad, 0 .. pi/2."""
    d = abs(a - b) % np.pi
    return min(d, np.pi - d)


@njit(cache=True)
def _grow(
    seeds: NDArray[np.int64],
    free: NDArray[np.bool_],
    px: NDArray[np.float32],
    py: NDArray[np.float32],
    normal: NDArray[np.float32],
    tolerance: float,
    max_gap: int,
    shortest: float,
    density: float,
    members: NDArray[np.int64],
    starts: NDArray[np.int64],
) -> int:
    """Lines from all seeds; members of line k are members[starts[k]:starts[k + 1]]. Returns how many."""
    rows, columns = free.shape
    lines = 0
    starts[0] = 0
    reach = int(np.ceil(tolerance + 0.5))
    for seed in seeds:
        y0, x0 = seed // columns, seed % columns
        if not free[y0, x0]:
            continue
        axis = float(normal[y0, x0])
        begin = starts[lines]
        filled = begin
        n, sx, sy, sxx, sxy, syy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        c2, s2 = 0.0, 0.0
        qx, qy = float(px[y0, x0]), float(py[y0, x0])
        # first direction: the axes of the edgels around that lie on the seed's own line
        nx, ny = np.cos(axis), np.sin(axis)
        for v in range(max(y0 - START_RADIUS_PX, 0), min(y0 + START_RADIUS_PX + 1, rows)):
            for u in range(max(x0 - START_RADIUS_PX, 0), min(x0 + START_RADIUS_PX + 1, columns)):
                if not free[v, u] or _axis_difference(float(normal[v, u]), axis) > MAX_AXIS_DIFFERENCE_RAD:
                    continue
                if abs((px[v, u] - qx) * nx + (py[v, u] - qy) * ny) > tolerance:
                    continue
                c2 += np.cos(2.0 * normal[v, u])
                s2 += np.sin(2.0 * normal[v, u])
        direction = 0.5 * np.arctan2(s2, c2) + 0.5 * np.pi
        tx, ty = np.cos(direction), np.sin(direction)
        steep = abs(ty) > abs(tx)
        mx, my = qx, qy
        members[filled] = seed
        filled += 1
        n, sx, sy = 1.0, qx, qy
        sxx, sxy, syy = qx * qx, qx * qy, qy * qy
        low = y0 if steep else x0
        high = low
        for side in range(2):
            sign = 1 if side == 0 else -1
            place = high if side == 0 else low
            misses = 0
            limit = rows if steep else columns
            while misses <= max_gap:
                place += sign
                if place < 0 or place >= limit:
                    break
                across = my + (place - mx) * ty / tx if not steep else mx + (place - my) * tx / ty
                middle = int(np.round(across))
                best, best_offset = -1, tolerance
                for k in range(middle - reach, middle + reach + 1):
                    v, u = (place, k) if steep else (k, place)
                    if v < 0 or u < 0 or v >= rows or u >= columns or not free[v, u]:
                        continue
                    if (
                        _axis_difference(float(normal[v, u]), direction + 0.5 * np.pi)
                        > MAX_AXIS_DIFFERENCE_RAD
                    ):
                        continue
                    offset = abs((px[v, u] - mx) * ty - (py[v, u] - my) * tx)
                    if offset < best_offset:
                        best, best_offset = v * columns + u, offset
                if best < 0:
                    misses += 1
                    continue
                misses = 0
                members[filled] = best
                filled += 1
                v, u = best // columns, best % columns
                x, y = float(px[v, u]), float(py[v, u])
                n += 1.0
                sx += x
                sy += y
                sxx += x * x
                sxy += x * y
                syy += y * y
                if side == 0:
                    high = place
                else:
                    low = place
                if n >= 5.0:
                    mx, my, fitted = _line(n, sx, sy, sxx, sxy, syy)
                    if n < 10.0:  # a short line still trusts its edgels' axes as much as its points
                        share = (n - 4.0) / 6.0
                        d = (fitted - direction + 0.5 * np.pi) % np.pi - 0.5 * np.pi
                        fitted = direction + share * d
                    direction = fitted
                    tx, ty = np.cos(direction), np.sin(direction)
                    if (abs(ty) > 2.0 * abs(tx)) if not steep else (abs(tx) > 2.0 * abs(ty)):
                        break  # turned away: not this line any more
        span = high - low + 1
        length = span / max(abs(tx), abs(ty))
        if length < shortest or n < density * span or n < 4.0:
            free[y0, x0] = False
            continue
        for k in range(begin, filled):  # with the edgels beside them, of which a slanted edge has two a step
            y, x = members[k] // columns, members[k] % columns
            for beside in range(-1, 2):
                v, u = (y, x + beside) if steep else (y + beside, x)
                if v < 0 or u < 0 or v >= rows or u >= columns or not free[v, u]:
                    continue
                near = abs((px[v, u] - mx) * ty - (py[v, u] - my) * tx) < BESIDE_PX
                if (
                    near
                    and _axis_difference(float(normal[v, u]), float(normal[y, x])) < MAX_AXIS_DIFFERENCE_RAD
                ):
                    free[v, u] = False
            free[y, x] = False
        lines += 1
        starts[lines] = filled
    return lines


def grow_lines(
    edges: EdgeMap,
    mask: NDArray[np.bool_],
    *,
    shortest_px: float,
    tolerance_px: float = MAX_OFFSET_PX,
    max_gap_px: int = MAX_GAP_PX,
) -> Edgels:
    """Straight groups of edgels, each edgel in one group at most; from the strongest seed on.

    Parameters
    ----------
    edges
        Merged edge map.
    mask
        bool (H, W), edgels that may take part.
    shortest_px
        Shorter lines are dropped.
    tolerance_px
        Farthest an edgel may lie from its line.
    max_gap_px
        Longest gap stepped over, in rows or columns.
    """
    seeds = np.flatnonzero(mask)
    seeds = seeds[np.argsort(-edges.ridge.ravel()[seeds], kind="stable")]
    rows, columns = mask.shape
    y, x = np.mgrid[:rows, :columns].astype(np.float32)
    px = (x + edges.offset * np.cos(edges.orientation)).astype(np.float32)
    py = (y + edges.offset * np.sin(edges.orientation)).astype(np.float32)
    members = np.empty(len(seeds) + rows + columns + 1, np.int64)
    starts = np.zeros(len(seeds) + 2, np.int64)
    count = _grow(
        seeds,
        mask.copy(),
        px,
        py,
        edges.orientation,
        tolerance_px,
        max_gap_px,
        shortest_px,
        MIN_DENSITY,
        members,
        starts,
    )
    chosen = members[: starts[count]]
    points = np.stack([px.ravel()[chosen], py.ravel()[chosen]], axis=1).astype(np.float64)
    normals = edges.orientation.ravel()[chosen].astype(np.float64)
    strengths = edges.ridge.ravel()[chosen].astype(np.float64)
    return Edgels(points, normals, strengths, np.stack([starts[:count], starts[1 : count + 1]], axis=1))
