"""First sight: where in the image, how far and how turned a target may be of which nothing is known.

The target is drawn as it looks from directions all over the sphere, each at several turns about the line of
sight and several sizes: a template is some points of its visible lines with their directions. A template is
laid everywhere on the image at once, by adding up shifted maps of how near the next image edge of like
direction is, as LINEMOD does with its response maps (S. Hinterstoisser et al., 2012), on maps that are the
directional distance transforms of M.-Y. Liu et al. (2010). The best places become poses, which
the matcher aligns.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from numerics.arrays import Floats, Grey, Ints
from numerics.kernels import kernel
from numerics.two_cores import cores
from vision_server.matching.looks import LOOK_POINTS, Look, Looks, cell_px_of, range_of
from vision_server.matching.match import Anywhere, seen_sizes_px, sizes_from_px
from vision_server.matching.nearest_edges import AXIS_BINS, CELL_PX, GAIN_REACH_PX, nearest_edges

Offsets = NDArray[np.int16]
Bytes = Grey

ROLLS = 30  # each look is turned by 12 degrees about the line of sight (by hand: time is in proportion)
LARGEST_SIZE_SHARE, SMALLEST_SIZE_SHARE = 1.3, 0.18  # the target's diameter, over the frame's smaller side
MOST_SIZE_RATIO, SIZES_A_GRID = 1.2, 4  # from one size to the next; sizes that share one grid of cells
REACH_CELLS = 3.0  # an edge this far from a template's point is worth nothing to it
FEWEST_TEMPLATE_POINTS = 8  # of a look: fewer lie on many an edge


class Templates(NamedTuple):
    """Templates of one size; T of them, at most P points each.

    Attributes
    ----------
    offset : (T, P, 2) int16, row and column of each point from the target's middle, cells.
    bin : (T, P) int16, of the directions.
    points : (T,) int64, how many.
    length : (T,) float64, image length of the visible lines, cells.
    """

    offset: Offsets
    bin: Offsets
    points: Ints
    length: Floats


@dataclass(frozen=True, eq=False)
class Candidates:
    """Poses that are worth a look: (N, 3, 3), (N, 3), and what each scored, (N,)."""

    rotations: Floats
    translations: Floats
    scores: Floats


def sizes_px(camera: Camera, diameter: float, anywhere: Anywhere) -> list[Floats]:
    """Diameters of the target in the image that are tried, px, largest first, those that share a grid."""
    side = min(camera.width, camera.height)
    largest, smallest = LARGEST_SIZE_SHARE * side, SMALLEST_SIZE_SHARE * side
    if anywhere.range_m is not None:
        least, most = seen_sizes_px(camera)
        told = sizes_from_px(anywhere.range_m, diameter, camera)
        largest, smallest = (min(max(size, least), most) for size in told)
    count = 1 + math.ceil(math.log(largest / smallest) / math.log(MOST_SIZE_RATIO))
    return np.array_split(np.geomspace(largest, smallest, count), max(1, round(count / SIZES_A_GRID)))


def candidates(
    segments: Floats, model: Model, camera: Camera, sizes: Floats, most: int, looks: Looks
) -> Candidates:
    """The most promising poses anywhere in the frame, best first.

    Parameters
    ----------
    segments : (N, 4), ideal px.
    sizes : diameters of the target in the image, px, that share one grid of cells, largest first.
    looks : of the target, from about as far.
    """
    cell_px = cell_px_of(sizes)
    gain = gains(segments, camera, cell_px)
    with ThreadPoolExecutor(min(2, cores())) as threads:
        found = list(
            threads.map(lambda size: _at_size(gain, looks, model, camera, float(size), cell_px), sizes)
        )
    rotations, translations, scores = (
        np.concatenate([getattr(one, name) for one in found])
        for name in ("rotations", "translations", "scores")
    )
    best = np.argsort(-scores, kind="stable")[:most]
    return Candidates(rotations[best], translations[best], scores[best])


def gains(segments: Floats, camera: Camera, cell_px: float) -> Bytes:
    """How near the next edge of like direction is, (AXIS_BINS, h, w): 255 on it, 0 REACH_CELLS away."""
    scale = CELL_PX / cell_px
    small = Camera(
        max(1, math.ceil(camera.width * scale)), max(1, math.ceil(camera.height * scale)), 1.0, 1.0, 0.0, 0.0
    )
    table = nearest_edges(scale * segments, small)
    steps = GAIN_REACH_PX / CELL_PX / REACH_CELLS
    return np.asarray(np.clip(255.0 - steps * (255.0 - table.gain), 0.0, 255.0).astype(np.uint8))


def _at_size(
    gain: Bytes, looks: Looks, model: Model, camera: Camera, size_px: float, cell_px: float
) -> Candidates:
    """The best place of each view and roll at one size, as poses."""
    distance = range_of(model, camera, size_px)
    made = templates(looks.seen, camera, distance, cell_px)
    score, place = vote(gain, *made)
    number = np.arange(len(score))
    view, roll = number // ROLLS, number % ROLLS
    pixels = (place[:, ::-1] + 0.5) * cell_px - 0.5
    rotations, translations = _poses(looks.frames[view], 2.0 * np.pi * roll / ROLLS, pixels, camera, distance)
    return Candidates(rotations, translations - rotations @ model.middle, score)


def templates(seen: Sequence[Look], camera: Camera, distance: float, cell_px: float) -> Templates:
    """Each look at each roll, as seen from a distance."""
    total = len(seen) * ROLLS
    offset, bins = np.zeros((total, LOOK_POINTS, 2), np.int16), np.zeros((total, LOOK_POINTS), np.int16)
    count, length = np.zeros(total, np.int64), np.zeros(total)
    for number, look in enumerate(seen):
        if len(look.points) < FEWEST_TEMPLATE_POINTS:
            continue
        own = slice(number * ROLLS, (number + 1) * ROLLS)
        _lay(look.points, look.along, distance, camera.fx / cell_px, offset[own], bins[own])
        count[own], length[own] = len(look.points), look.length
    return Templates(offset, bins, count, length)


@kernel()
def _lay(
    points: Floats, along: Floats, distance: float, cells: float, offset: Offsets, bins: Offsets
) -> None:
    """Project the points of a look, and turn them about the line of sight, into one template a roll.

    ``cells`` is the focal length.
    """
    rolls = 2.0 * math.pi * np.arange(len(offset)) / len(offset)
    cosine, sine = np.cos(rolls), np.sin(rolls)
    for p in range(len(points)):
        depth = max(points[p, 2] + distance, 1e-3 * distance)
        x, y = points[p, 0] / depth, points[p, 1] / depth
        angle = math.atan2(along[p, 1] - y * along[p, 2], along[p, 0] - x * along[p, 2])
        for r in range(len(offset)):
            offset[r, p, 0] = round(cells * (sine[r] * x + cosine[r] * y))
            offset[r, p, 1] = round(cells * (cosine[r] * x - sine[r] * y))
            bins[r, p] = min(int((angle + rolls[r]) % math.pi * (AXIS_BINS / math.pi)), AXIS_BINS - 1)


def _poses(
    frames: Floats, rolls: Floats, pixels: Floats, camera: Camera, distance: float
) -> tuple[Floats, Floats]:
    """Rotations (N, 3, 3) and places (N, 3) of the middle: the view along the ray of each pixel."""
    rays = np.column_stack(
        [(pixels[:, 0] - camera.cx) / camera.fx, (pixels[:, 1] - camera.cy) / camera.fy, np.ones(len(pixels))]
    )
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    cosine, sine, zero = np.cos(rolls), np.sin(rolls), np.zeros(len(rolls))
    turn = np.stack([cosine, -sine, zero, sine, cosine, zero, zero, zero, zero + 1.0], axis=1)
    x, y, z = rays.T  # the shortest turn from the optical axis to the ray
    share = 1.0 / (1.0 + z)
    across = -x * y * share
    lean = np.stack([1.0 - x * x * share, across, x, across, 1.0 - y * y * share, y, -x, -y, z], axis=1)
    return lean.reshape(-1, 3, 3) @ turn.reshape(-1, 3, 3) @ frames, distance * rays


@kernel(boundscheck=False)
def vote(gain: Bytes, offset: Offsets, bins: Offsets, count: Ints, length: Floats) -> tuple[Floats, Floats]:
    """The best place of each template, every second row and column tried, and what it is worth there.

    Worth: mean gain over what chance gives in these bins, times the root of the template's length.

    Returns
    -------
    score (T,); place (T, 2), row and column of the target's middle, cells.
    """
    height, width = (gain.shape[1] + 1) // 2, (gain.shape[2] + 1) // 2
    reach = 0
    for t in range(len(count)):
        for p in range(count[t]):
            reach = max(reach, 1 + abs(offset[t, p, 0]) // 2, 1 + abs(offset[t, p, 1]) // 2)
    stride = width + reach
    before = reach * stride + reach
    padded, chance = _of_each_parity(gain, stride, before, before + height * stride + before)
    score, place = np.full(len(count), -np.inf), np.zeros((len(count), 2))
    flat, total = padded.ravel(), np.empty(height * stride, np.uint16)
    first = np.empty(offset.shape[1], np.int64)
    for t in range(len(count)):
        if count[t] == 0:
            continue
        total[:] = 0
        expected = 0.0
        for p in range(count[t]):
            b, dy, dx = bins[t, p], offset[t, p, 0], offset[t, p, 1]
            plane = b * 4 + (dy & 1) * 2 + (dx & 1)
            first[p] = plane * padded.shape[2] + before + (dy >> 1) * stride + (dx >> 1)
            expected += chance[b]
        eights = count[t] // 8 * 8
        for p in range(0, eights, 8):
            _add_eight(total, flat, first[p : p + 8])
        for p in range(eights, count[t]):
            _add(total, flat[first[p] : first[p] + len(total)])
        best, row, column = -1, 0, 0
        for y in range(height):
            most = _most(total[y * stride : y * stride + width])
            if most > best:
                best, row = most, y
        for x in range(width):
            if total[row * stride + x] == best:
                column = x
                break
        score[t] = (best - expected) / count[t] / 255.0 * math.sqrt(length[t])
        place[t, 0], place[t, 1] = 2 * row, 2 * column
    return score, place


@kernel()
def _of_each_parity(gain: Bytes, stride: int, before: int, size: int) -> tuple[Bytes, Floats]:
    """The cells of each parity apart, (AXIS_BINS, 4, size), and the mean of each bin, (AXIS_BINS,).

    So neighbours among the places are neighbours in memory; with as many more columns after each row, and
    rows above and below, as the templates reach, a shift is one number. Outside of the image is what chance
    gives: of a target that is partly there what is inside decides.
    """
    padded, chance = np.empty((len(gain), 4, size), np.uint8), np.zeros(len(gain))
    for b in range(len(gain)):
        chance[b] = gain[b].mean()
        padded[b] = np.uint8(chance[b] + 0.5)
        for row in range(gain.shape[1]):
            start = before + row // 2 * stride
            for column in range(gain.shape[2]):
                padded[b, row % 2 * 2 + column % 2, start + column // 2] = gain[b, row, column]
    return padded, chance


@kernel()
def _add(total: NDArray[np.uint16], some: Bytes) -> None:
    """Add bytes to sums of two bytes; a loop of its own, which the compiler makes wide."""
    for i in range(len(total)):
        total[i] += some[i]


@kernel()
def _add_eight(total: NDArray[np.uint16], flat: Bytes, first: Ints) -> None:
    """`_add` of eight stretches that begin there: one at a time, most of it is reading and writing sums."""
    n = len(total)
    a, b = flat[first[0] : first[0] + n], flat[first[1] : first[1] + n]
    c, d = flat[first[2] : first[2] + n], flat[first[3] : first[3] + n]
    e, f = flat[first[4] : first[4] + n], flat[first[5] : first[5] + n]
    g, h = flat[first[6] : first[6] + n], flat[first[7] : first[7] + n]
    for i in range(n):
        four = np.uint16(a[i]) + np.uint16(b[i]) + np.uint16(c[i]) + np.uint16(d[i])
        total[i] += four + np.uint16(e[i]) + np.uint16(f[i]) + np.uint16(g[i]) + np.uint16(h[i])


@kernel()
def _most(some: NDArray[np.uint16]) -> int:
    """The largest of some sums."""
    out = np.uint16(0)
    for i in range(len(some)):
        out = max(out, some[i])
    return int(out)
