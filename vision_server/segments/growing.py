"""Growing straight lines through edgels, without leaving the line for texture or junctions.

Linking follows the edge pixel by pixel and splits afterwards; where texture touches an outline the chain
turns into the texture and the outline is lost. Here the line itself is followed: from a strong edgel both
ways, one row or column at a time, each new edgel must lie on the line fitted so far and agree with its
direction, and gaps are stepped over. In the spirit of the region growing of LSD (Grompone von Gioi et al.
2010), on ridges instead of regions, so that axial orientation cannot fuse the two sides of a thin bar."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel
from vision_server.edges.edge_map import EdgeMap
from vision_server.segments.line_fit import Edgels, edgel_groups

Field = NDArray[np.float32]
Ints = NDArray[np.int64]

MAX_AXIS_DIFFERENCE_RAD = 0.39  # 22.5 deg, LSD's tolerance, between an edgel and its line
LEAST_AXIS_COSINE = float(np.cos(MAX_AXIS_DIFFERENCE_RAD))
MAX_OFFSET_PX = 1.5  # of an edgel from the line, on sharp images
BESIDE_PX = 0.7  # an edgel so near to a finished line says nothing new
MAX_GAP_PX = 4  # rows or columns without an edgel that a line may step over at once
MIN_DENSITY = 0.6  # of rows or columns between the ends that hold an edgel
START_RADIUS_PX = 3  # neighbourhood that gives the first direction
FEWEST_FITTED, TRUSTED = 5, 10  # edgels from which on a line is fitted; from which on only the fit counts


@kernel(inline="always")
def _half_angle(c2: float, s2: float) -> tuple[float, float]:
    """Unit vector at half the angle of a vector."""
    length = np.sqrt(c2 * c2 + s2 * s2)
    if length <= 0.0:
        return 1.0, 0.0
    c = np.sqrt(max(0.5 + 0.5 * c2 / length, 0.0))
    s = np.sqrt(max(0.5 - 0.5 * c2 / length, 0.0))
    return c, s if s2 >= 0.0 else -s


@kernel(nogil=True, error_model="numpy")
def _start(
    seed: int, x0: int, y0: int, index: NDArray[np.int32], free: NDArray[np.bool_], points: Field,
    normals: Field, tolerance: float,
) -> tuple[float, float]:  # fmt: skip
    """First direction of a line: along the mean axis of the edgels around that lie on the seed's own line."""
    rows, columns = index.shape
    nx, ny = normals[seed, 0], normals[seed, 1]
    c2, s2 = 0.0, 0.0
    for v in range(max(y0 - START_RADIUS_PX, 0), min(y0 + START_RADIUS_PX + 1, rows)):
        for u in range(max(x0 - START_RADIUS_PX, 0), min(x0 + START_RADIUS_PX + 1, columns)):
            at = index[v, u]
            if at < 0 or not free[at]:
                continue
            mx, my = normals[at, 0], normals[at, 1]
            if abs(mx * nx + my * ny) < LEAST_AXIS_COSINE:
                continue
            dx, dy = points[at, 0] - points[seed, 0], points[at, 1] - points[seed, 1]
            if abs(dx * nx + dy * ny) > tolerance:
                continue
            c2 += mx * mx - my * my
            s2 += 2.0 * mx * my
    c, s = _half_angle(c2, s2)
    return -s, c


@kernel(nogil=True, error_model="numpy")
def _grow(
    seeds: Ints,
    free: NDArray[np.bool_],
    index: NDArray[np.int32],
    places: NDArray[np.int32],
    points: Field,
    normals: Field,
    tolerance: float,
    max_gap: int,
    shortest: float,
    density: float,
    members: Ints,
    starts: Ints,
) -> int:
    """Lines from all seeds; members of line k are members[starts[k]:starts[k + 1]]. Returns how many."""
    rows, columns = index.shape
    lines = 0
    starts[0] = 0
    reach = int(np.ceil(tolerance + 0.5))
    for seed in seeds:
        if not free[seed]:
            continue
        y0 = places[seed] // columns
        x0 = places[seed] - y0 * columns
        begin = starts[lines]
        qx, qy = float(points[seed, 0]), float(points[seed, 1])
        tx, ty = _start(seed, x0, y0, index, free, points, normals, tolerance)
        steep = abs(ty) > abs(tx)
        # sums are relative to the seed: no digits are lost
        mx, my = 0.0, 0.0
        n, sx, sy, sxx, sxy, syy = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
        members[begin] = seed
        filled = begin + 1
        low = y0 if steep else x0
        high = low
        limit, other = (rows, columns) if steep else (columns, rows)
        for side in range(2):
            sign = 1 if side == 0 else -1
            place = high if side == 0 else low
            misses = 0
            while misses <= max_gap:
                place += sign
                if place < 0 or place >= limit:
                    break
                if steep:
                    across = qx + mx + (place - qy - my) * tx / ty
                else:
                    across = qy + my + (place - qx - mx) * ty / tx
                middle = int(across + 0.5)
                best, best_offset = -1, tolerance
                for k in range(max(middle - reach, 0), min(middle + reach + 1, other)):
                    at = index[place, k] if steep else index[k, place]
                    if at < 0 or not free[at]:
                        continue
                    if abs(normals[at, 1] * tx - normals[at, 0] * ty) < LEAST_AXIS_COSINE:
                        continue
                    offset = abs((points[at, 0] - qx - mx) * ty - (points[at, 1] - qy - my) * tx)
                    if offset < best_offset:
                        best, best_offset = at, offset
                if best < 0:
                    misses += 1
                    continue
                misses = 0
                members[filled] = best
                filled += 1
                x, y = points[best, 0] - qx, points[best, 1] - qy
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
                if n < FEWEST_FITTED:
                    continue
                mx, my = sx / n, sy / n
                c2, s2 = sxx - syy - n * (mx * mx - my * my), 2.0 * (sxy - n * mx * my)
                if n < TRUSTED:  # a short line still trusts its edgels' axes as much as its points
                    part = (n - FEWEST_FITTED + 1.0) / (TRUSTED - FEWEST_FITTED + 1.0)
                    part /= np.sqrt(c2 * c2 + s2 * s2) + 1e-12
                    rest = (TRUSTED - n) / (TRUSTED - FEWEST_FITTED + 1.0)
                    c2, s2 = part * c2 + rest * (tx * tx - ty * ty), part * s2 + rest * 2.0 * tx * ty
                tx, ty = _half_angle(c2, s2)
                if (abs(ty) > 2.0 * abs(tx)) if not steep else (abs(tx) > 2.0 * abs(ty)):
                    break  # turned away: not this line any more
        span = high - low + 1
        free[seed] = False
        if span / max(abs(tx), abs(ty)) < shortest or n < density * span or n < 4.0:
            continue
        for k in range(begin, filled):  # with the edgels beside them, of which a slanted edge has two a step
            member = members[k]
            free[member] = False
            y = places[member] // columns
            x = places[member] - y * columns
            for beside in range(-1, 2, 2):
                v, u = (y, x + beside) if steep else (y + beside, x)
                if v < 0 or u < 0 or v >= rows or u >= columns:
                    continue
                at = index[v, u]
                if at < 0 or not free[at]:
                    continue
                if abs((points[at, 0] - qx - mx) * ty - (points[at, 1] - qy - my) * tx) >= BESIDE_PX:
                    continue
                agreement = abs(normals[at, 0] * normals[member, 0] + normals[at, 1] * normals[member, 1])
                if agreement > LEAST_AXIS_COSINE:
                    free[at] = False
        lines += 1
        starts[lines] = filled
    return lines


def grow_lines(
    edges: EdgeMap,
    chosen: NDArray[np.bool_],
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
    chosen
        bool (N,), edgels that may take part.
    shortest_px
        Shorter lines are dropped.
    tolerance_px
        Farthest an edgel may lie from its line.
    max_gap_px
        Longest gap stepped over, in rows or columns.
    """
    seeds = np.flatnonzero(chosen)
    seeds = seeds[np.argsort(-edges.strength[seeds], kind="stable")]
    members = np.empty(len(seeds) + sum(edges.shape) + 1, np.int64)
    starts = np.zeros(len(seeds) + 2, np.int64)
    count = _grow(
        seeds,
        chosen.copy(),
        edges.index,
        edges.places,
        edges.points,
        edges.normals,
        tolerance_px,
        max_gap_px,
        shortest_px,
        MIN_DENSITY,
        members,
        starts,
    )
    groups = np.stack([starts[:count], starts[1 : count + 1]], axis=1)
    return edgel_groups(edges, members[: starts[count]], groups)
