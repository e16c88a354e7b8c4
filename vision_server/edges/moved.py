"""Whether the images of a set show one scene: edges that are all elsewhere in one of them.

Lights change which edges an image shows, not where they are. Each edgel votes for the shifts by which it
meets one of the same direction in an earlier image. Where one shift has more votes than by chance, than any
other one has, and than where nothing has moved, something has.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Grey
from numerics.kernels import kernel
from vision_server.channels.channel import ChannelStatistics
from vision_server.edges.merging import merge_channels
from vision_server.edges.suppression import edgel_thresholds

# Chosen by hand, on simulated scenes under four lights and on statues (python -m benchmarks.movement).
REACH_PX = 40  # largest shift that is looked for
DIRECTIONS = 12  # of edges over pi
FEWEST_EDGELS = 60  # that tell something
MOST_EDGELS = 1500  # that vote: so many take 10 ms
# Shortest shift, and in standard deviations of blur: edges of blurred bands wander.
LEAST_PX, BLURS = 3.5, 2.0
BESIDE_PX = 6  # around a shift whatever moved by it meets others, too
# As many as at any other shift: edges of one side of a limb fit those of its other side.
LEAST_OF_OTHERS = 1.2
# More than by chance, as a share of all edgels, and of those that stay: shadows move, too, not alone.
LEAST_OF_ALL, LEAST_OF_STAYING = 0.15, 1.5


class Movement(NamedTuple):
    """What has moved between two images.

    Attributes
    ----------
    shift_px
        By how much, x and y.
    box_px
        Where it is in the later image: left, top, right, bottom.
    """

    shift_px: tuple[float, float]
    box_px: tuple[int, int, int, int]


class SureEdgels(NamedTuple):
    """Where an image has sure edges, flat indices (N,) into (H, W), and which of DIRECTIONS their axes have,
    uint8 (N,); its shape; its blur, px."""

    places: NDArray[np.int32]
    directions: Grey
    shape: tuple[int, int]
    blur_px: float


def sure_edgels(channel: ChannelStatistics) -> SureEdgels:
    """The edgels that `moved_since` compares."""
    edges = merge_channels([channel])
    sure = edges.strength > edgel_thresholds(edges)[1]
    directions = (edges.axis[sure] * (DIRECTIONS / np.pi)).astype(np.uint8) % DIRECTIONS
    return SureEdgels(edges.places[sure], directions, edges.shape, channel.blur_px)


def moved_since(before: Sequence[SureEdgels], after: SureEdgels) -> Movement | None:
    """What is elsewhere than in all earlier images together; None if nothing is, or there is none."""
    if not before:
        return None
    met = _directions_near(before)
    some = slice(None, None, len(after.places) // MOST_EDGELS + 1)
    places = np.ascontiguousarray(after.places[some])
    directions = np.ascontiguousarray(after.directions[some])
    if len(places) < FEWEST_EDGELS:
        return None
    votes = _votes(met, places, directions)
    staying, chance = int(votes[REACH_PX, REACH_PX]), float(np.median(votes))
    least_px = max(LEAST_PX, BLURS * max(one.blur_px for one in (*before, after)))
    y, x = np.mgrid[-REACH_PX : REACH_PX + 1, -REACH_PX : REACH_PX + 1]
    votes[np.hypot(x, y) < least_px] = 0
    at = votes.argmax()
    most, dx, dy = int(votes.flat[at]), int(x.flat[at]), int(y.flat[at])
    others = votes[np.maximum(abs(x - dx), abs(y - dy)) > BESIDE_PX].max()
    least = max(LEAST_OF_ALL * len(places), LEAST_OF_STAYING * (staying - chance))
    if most - chance < least or most < LEAST_OF_OTHERS * others:
        return None
    return Movement((float(dx), float(dy)), _box(met, after, (dx, dy)))


def _directions_near(images: Sequence[SureEdgels]) -> NDArray[np.uint16]:
    """Bits (H, W) of the directions that some image has within a pixel, each with those next to it."""
    bits = np.zeros(images[0].shape, np.uint16)
    for places, directions, _, _ in images:
        one = np.uint16(1) << directions.astype(np.uint16)
        turned = one << 1 | one >> 1 | one << (DIRECTIONS - 1) | one >> (DIRECTIONS - 1)
        np.bitwise_or.at(bits.ravel(), places, one | turned)
    padded = np.pad(bits, 1)
    rows = padded[:-2] | padded[1:-1] | padded[2:]
    return np.ascontiguousarray(rows[:, :-2] | rows[:, 1:-1] | rows[:, 2:])


@kernel()
def _votes(met: NDArray[np.uint16], places: NDArray[np.int32], directions: Grey) -> NDArray[np.int32]:
    """How many edgels meet one of their direction, by the shift from there, -REACH_PX up to REACH_PX each."""
    rows, columns = met.shape
    votes = np.zeros((2 * REACH_PX + 1, 2 * REACH_PX + 1), np.int32)
    for i in range(len(places)):
        y = places[i] // columns
        x = places[i] - y * columns
        for dy in range(max(-REACH_PX, y - rows + 1), min(REACH_PX, y) + 1):
            row, of_row = met[y - dy], votes[dy + REACH_PX]
            for dx in range(max(-REACH_PX, x - columns + 1), min(REACH_PX, x) + 1):
                of_row[dx + REACH_PX] += (row[x - dx] >> directions[i]) & 1
    return votes


def _box(met: NDArray[np.uint16], after: SureEdgels, shift: tuple[int, int]) -> tuple[int, int, int, int]:
    """Around the edgels that come from so far away and are new there: left, top, right, bottom."""
    away = np.zeros_like(met)
    height, width = met.shape
    dx, dy = shift
    to = np.s_[max(dy, 0) : height + min(dy, 0), max(dx, 0) : width + min(dx, 0)]
    away[to] = met[max(-dy, 0) : height - max(dy, 0), max(-dx, 0) : width - max(dx, 0)]
    come = (away & ~met).ravel()[after.places] >> after.directions & 1
    new = np.zeros(met.shape, np.uint8)
    new.ravel()[after.places] = come
    left, top, wide, high = cv2.boundingRect(new)
    return left, top, left + wide, top + high
