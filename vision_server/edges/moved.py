"""Whether the images of a set show one scene: edges that are all elsewhere in one of them.

Lights change which edges an image shows, not where they are. The image is looked at in tiles. Where hardly
any edge of a tile is where the other image has one, but most are once the tile is moved by some pixels, and
other tiles tell the same, something has moved.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from vision_server.channels.channel import ChannelStatistics
from vision_server.edges.merging import merge_channels
from vision_server.edges.suppression import edgel_thresholds

Grey = NDArray[np.uint8]

# Chosen by hand, on simulated scenes under four lights and on statues (python -m benchmarks.movement).
TILE_PX = 96
REACH_PX = 40  # largest shift that is looked for
NEAR = np.ones((3, 3), np.uint8)  # edges so near to each other are in the same place
FEWEST_EDGELS = 60  # of a tile that tells something
MOST_STAYING = 0.4  # share of a moved tile's edgels that happen to be where the other image has some
LEAST_MOVED = 0.6  # share of them that are, once it is moved back
LEAST_GAIN = 2.0  # times as many as before
AGREEING_PX = 16.0  # between the shifts of tiles and their median: a turn by 5 degrees over 200 px
FEWEST_TILES = 2
LEAST_PX, BLURS = (
    3.0,
    2.0,
)  # shortest shift, and in standard deviations of blur: edges of blurred bands wander
LEAST_OF_STAYING = 0.5  # such edgels for each that stays anywhere: a shadow moves, too, not alone
# Such edgels for each in a tile where hardly any stays: opposite low lights leave few edges in common, and
# those of one side of a limb fit those of its other side.
LEAST_OF_TELLING = 0.25


class Movement(NamedTuple):
    """What has moved between two images.

    Attributes
    ----------
    shift_px
        By how much, x and y: the median over the tiles that show it.
    box_px
        Where it is in the later image: left, top, right, bottom.
    """

    shift_px: tuple[float, float]
    box_px: tuple[int, int, int, int]


class SureEdgels(NamedTuple):
    """Where an image has sure edges, flat indices (N,) into (H, W); its shape; its blur, px."""

    places: NDArray[np.int32]
    shape: tuple[int, int]
    blur_px: float

    @property
    def at(self) -> Grey:
        """1 where there is one, uint8 (H, W)."""
        out = np.zeros(self.shape, np.uint8)
        out.ravel()[self.places] = 1
        return out


def sure_edgels(channel: ChannelStatistics) -> SureEdgels:
    """The edgels that `movement` compares."""
    edges = merge_channels([channel])
    sure = edges.places[edges.strength > edgel_thresholds(edges)[1]]
    return SureEdgels(sure, edges.shape, channel.blur_px)


def movement(first: SureEdgels, second: SureEdgels) -> Movement | None:
    """What is elsewhere in the second image; None if nothing is."""
    before, after = first.at, second.at
    near = np.asarray(cv2.dilate(before, NEAR), np.uint8)
    all_staying = int((after & near).sum())
    if (1.0 + LEAST_OF_STAYING) * all_staying > after.sum():
        return None
    wide = np.pad(near, REACH_PX).astype(np.float32)
    shifts, boxes, counts = [], [], []
    telling = 0
    for top in range(0, after.shape[0], TILE_PX):
        for left in range(0, after.shape[1], TILE_PX):
            rows, columns = slice(top, top + TILE_PX), slice(left, left + TILE_PX)
            tile = after[rows, columns]
            count, staying = int(tile.sum()), int((tile & near[rows, columns]).sum())
            if count < FEWEST_EDGELS or staying > MOST_STAYING * count:
                continue
            telling += count
            height, width = (side + 2 * REACH_PX for side in tile.shape)
            around = wide[top : top + height, left : left + width]
            matches = cv2.matchTemplate(around, tile.astype(np.float32), cv2.TM_CCORR)
            _, most, _, (u, v) = cv2.minMaxLoc(matches)
            if most >= max(LEAST_MOVED * count, LEAST_GAIN * staying):
                shifts.append((REACH_PX - u, REACH_PX - v))
                there = around[v : v + tile.shape[0], u : u + tile.shape[1]].astype(np.uint8)
                x, y, width, height = cv2.boundingRect(tile & there)
                counts.append(count)
                boxes.append((left + x, top + y, left + x + width, top + y + height))
    if len(shifts) < FEWEST_TILES:
        return None
    median = np.median(shifts, axis=0)
    agree = np.abs(np.array(shifts) - median).max(axis=1) <= AGREEING_PX
    least_px = max(LEAST_PX, BLURS * max(first.blur_px, second.blur_px))
    few = np.array(counts)[agree].sum() < max(LEAST_OF_STAYING * all_staying, LEAST_OF_TELLING * telling)
    if agree.sum() < FEWEST_TILES or few or np.hypot(*median) < least_px:
        return None
    corners = np.array(boxes)[agree]
    left, top = (int(corner) for corner in corners[:, :2].min(axis=0))
    right, bottom = (int(corner) for corner in corners[:, 2:].max(axis=0))
    return Movement((float(median[0]), float(median[1])), (left, top, right, bottom))


def moved_since(before: Iterable[SureEdgels], after: SureEdgels) -> Movement | None:
    """What is elsewhere than in each earlier image, by the last of them; None if one shows it there."""
    last = None
    for earlier in before:
        last = movement(earlier, after)
        if last is None:
            return None
    return last
