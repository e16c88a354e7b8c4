"""The ground: what is behind all that stands before it, and which edges it adjoins.

The ground goes on to the border of the image, where what stands before it does not. It is dark in every
light, or even in the best light of each place, in which no shadow is left, or it has the grey of a lit
wall. Strong edges bar its way. From each edgel one walks to either side: where the ground is met before
another edge is, the edgel is of the outermost edge there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Flags, Grey
from numerics.kernels import kernel
from numerics.logarithm import ZERO
from vision_server.edges.edge_map import EdgeMap
from vision_server.kinds.sides import Sides, furthest_reach

# Chosen by hand on rendered statues (`python -m benchmarks.statue_edges`) and renders.
CELL_PX = 2  # side of the squares of which it is asked whether they are of the ground
LEAST_AT_LARGE = 0.5  # share of what is dark, where the background is
DARK_RATIO = 2.0  # of a cell's grey in its best light to that of a dark background: more is none
EVEN = 0.3  # between the logarithms of a cell and of those beside it, in their best lights: no edge is there
LIKE_WALL, LEAST_LIKE_WALL = 0.2, 0.33  # share of its grey that a cell may be off, and in which of the lights
BRIGHTEST_WALL = 1.5  # times its grey: the light of lamps that are near is not quite a quadratic of the place
# Of a step in the best lights to the brighter side, and to its noise: such an edge bars the way. Else the
# ground runs into dark bronze before dark cloth.
BARRING, SURELY_BARRING = 0.5, 4.0
FIRST_PX, NEXT_EDGE_PX = 2, 3  # from an edgel, where the walk and the look for another edge begin
SAME_AXIS = np.float32(0.7)  # cosine between the axes of edges that run beside each other
NEITHER, ONE, BOTH = range(3)  # sides that meet the ground


def free_cells(edges: EdgeMap, sides: Sides, shape: tuple[int, int]) -> Flags:
    """Which cells, (rows, columns) as ``shape``, hold no edgel that bars the ground's way."""
    free = np.ones(shape, np.bool_)
    _bar(edges.places, edges.shape[1], sides, free)
    return free


@kernel()
def _bar(places: NDArray[np.int32], width: int, sides: Sides, free: Flags) -> None:
    """Let the cells of the N places in an image so wide that bar the ground's way not be free."""
    rows, columns = free.shape
    for i in range(len(places)):
        one, other, noise = ZERO, ZERO, ZERO
        for channel in range(len(sides.noise)):
            one, other = max(one, sides.near[channel, 0, i]), max(other, sides.near[channel, 1, i])
            noise = max(noise, sides.noise[channel, i])
        step, bright = abs(one - other), max(one, other) + np.float32(sides.dark)
        if step > np.float32(BARRING) * bright and step > np.float32(SURELY_BARRING) * noise:
            y = places[i] // width
            free[min(y // CELL_PX, rows - 1), min((places[i] - y * width) // CELL_PX, columns - 1)] = False


def dark_or_even(best: Field, background: float, dark: float, free: Flags) -> Grey:
    """1 for cells of a ground that is dark or even.

    All are where most of what is dark does not go on to the border: then the background is not dark.

    Parameters
    ----------
    best
        Grey of each cell at reference exposure, in its best light.
    background, dark
        Grey of the dark background, and what is added before logarithms are taken.
    free
        As `free_cells` gives them.
    """
    is_dark = best + np.float32(dark) < DARK_RATIO * (background + dark)
    at_large = _up_to_the_border(is_dark & free)
    if cv2.countNonZero(at_large) < LEAST_AT_LARGE * np.count_nonzero(is_dark):
        return np.ones_like(at_large)
    return np.asarray(at_large | _up_to_the_border(_even(best, dark) & free), np.uint8)


def like_wall(greys: Iterable[Field], walls: Field, best: Field, dark: float, free: Flags) -> Grey:
    """1 for cells of a lit wall, or even ones that go on to where the border is not like it.

    A wall's cell is like it in some of the lights, may be in a shadow in others, and is much brighter in
    none: what is painted in its grey turns to some light more than the wall does.

    Parameters
    ----------
    greys
        Of each cell at reference exposure, in each light.
    walls
        What it has there, with ``dark`` added, (C, rows, columns).
    best
        The largest of each cell's ``greys``.
    """
    likes, is_brighter = np.zeros(free.shape, np.uint16), np.zeros(free.shape, np.bool_)
    for grey, wall in zip(greys, walls, strict=True):
        ratio = (grey + np.float32(dark)) / wall
        likes += np.abs(ratio - 1.0) < LIKE_WALL
        is_brighter |= ratio > BRIGHTEST_WALL
    ground = _up_to_the_border((likes >= LEAST_LIKE_WALL * len(walls)) & ~is_brighter & free)
    return np.asarray(ground | _up_to_the_border(_even(best, dark) & free & (ground == 0)), np.uint8)


def sides_met(edges: EdgeMap, ground: Grey) -> Grey:
    """How many sides of each edgel meet the ground before another edge: NEITHER, ONE or BOTH, uint8 (N,)."""
    reach = int(furthest_reach(edges))
    within = 2 * (reach // CELL_PX + 2) + 1
    beside = np.asarray(cv2.dilate(ground, np.ones((within, within), np.uint8)), np.uint8)
    return _sides_met(edges.index, edges.points, edges.normals, ground, beside, reach)


def _even(best: Field, dark: float) -> Flags:
    """Which cells have neighbours of their grey."""
    beside, added = np.ones((3, 3), np.uint8), best + np.float32(dark)
    return np.asarray(cv2.dilate(added, beside) < np.float32(math.exp(EVEN)) * cv2.erode(added, beside))


def _up_to_the_border(cells: Flags) -> Grey:
    """1 for those of the cells that adjoin each other up to the border of the image."""
    framed = np.ones((cells.shape[0] + 2, cells.shape[1] + 2), np.uint8)
    framed[1:-1, 1:-1] = cells
    cv2.floodFill(framed, None, (0, 0), (2,))  # to the four sides of each
    return np.asarray(framed[1:-1, 1:-1] == 2, np.uint8)


@kernel()
def _sides_met(
    number_at: NDArray[np.int32], points: Field, normals: Field, ground: Grey, beside: Grey, reach: int
) -> Grey:
    """As `sides_met`; where the cells ``beside`` the ground are not, none is within reach."""
    rows, columns = number_at.shape
    last_row, last_column = len(ground) - 1, ground.shape[1] - 1
    met = np.zeros(len(points), np.uint8)
    for i in range(len(points)):
        nx, ny = normals[i, 0], normals[i, 1]
        x, y = max(int(points[i, 0]), 0), max(int(points[i, 1]), 0)
        if not beside[min(y // CELL_PX, last_row), min(x // CELL_PX, last_column)]:
            continue
        for side in (-1, 1):
            for away in range(FIRST_PX, reach + 1):
                u = int(points[i, 0] + np.float32(side * away) * nx + np.float32(0.5))
                v = int(points[i, 1] + np.float32(side * away) * ny + np.float32(0.5))
                x, y = min(max(u, 0), columns - 1), min(max(v, 0), rows - 1)
                if ground[min(y // CELL_PX, last_row), min(x // CELL_PX, last_column)]:
                    met[i] += 1
                    break
                at = number_at[y, x]
                if away < NEXT_EDGE_PX or at < 0:
                    continue
                if abs(normals[at, 0] * nx + normals[at, 1] * ny) > SAME_AXIS:
                    break
    return met
