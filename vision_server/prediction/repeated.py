"""Two pictures of the same settings: what is between them, pixel by pixel.

Under another light a target keeps its edges, and one lamp or sun that comes or goes changes all pixels to
one side. What comes in the way replaces a part of the picture, brighter here, darker there, and no more.
Where all is about as many times as bright, light flickers or a shutter is not exact: that is no difference.
"""

from __future__ import annotations

import math
from typing import Literal

import cv2
import numpy as np

from numerics.arrays import Field, Flags, Grey

Difference = Literal["replaced", "relit"]

# Chosen by hand on seven scenes, held against others (docs/surprises.md).
AROUND_PX = 12  # beside the target, where something in the way shows as well
SMOOTH_PX = 1.5  # standard deviation of what a pixel is compared in
CHANGED, LEAST_GREY = 4.0, 1.0  # standard deviations, and grey, from which on it differs,
LEAST_SHARE = 0.03  # and share of the brighter one, but for what all differ by,
LEAST_FLICKER, MOST_FLICKER = 0.02, 1.18  # where that is flicker: by so much at least, so many times at most;
DARK = 8.0  # grey, of pixels that tell of it
WIDE_PX = 7  # of what differs less is noise, or an edge that has moved
CLIPPED = 245  # brighter in both pictures is the same
LEAST_REPLACED, MOST_REPLACED = 0.05, 0.6  # share of the target
TO_EITHER_SIDE = 0.04  # share of what differs that is brighter, and that is darker
# Correlation of gradients where they differ: below the first another thing, from the second other light.
SAME_EDGES, RELIT_EDGES = 0.4, 0.45
ONE_SIDED, ONE_SIDED_EDGES = 0.28, 0.2  # most replaced, and correlated, where all is darker, or brighter
EXPLAINED = 0.75  # share of the squared difference that is left when one picture is shifted onto the other


def difference(before: Grey, after: Grey, target: Flags) -> Difference | None:
    """Whether a part of the target (H, W) shows something else in the second picture (H, W), or is relit.

    None where they are the same, one is the other shifted, or that is not clear.
    """
    one, other, read, target = _near(before, after, target)
    if not read.any():
        return None
    one = _as_flickered(one, other, read)
    smooth, brighter = cv2.GaussianBlur(other - one, (0, 0), SMOOTH_PX), cv2.max(one, other)
    least = np.maximum(_least_change(other - one, read), LEAST_SHARE * brighter)
    differs = _wide((np.abs(smooth) > least) & read)
    if (differs & target).sum() < LEAST_REPLACED * target.sum() or _shifted(one, other, read):
        return None
    to_one_side = abs(2.0 * float((smooth[differs] > 0.0).mean()) - 1.0) > 1.0 - 2.0 * TO_EITHER_SIDE
    if to_one_side:  # less light does the same to what was saturated
        differs &= brighter < CLIPPED
    most, most_alike = (ONE_SIDED, ONE_SIDED_EDGES) if to_one_side else (MOST_REPLACED, SAME_EDGES)
    share = float((differs & target).sum() / target.sum())
    alike = _correlation(one, other, differs & target)
    if share > MOST_REPLACED:
        return "relit"
    if alike < most_alike:
        return "replaced" if LEAST_REPLACED <= share <= most else None
    return "relit" if alike >= RELIT_EDGES else None


def flicker(before: Grey, after: Grey, target: Flags) -> float:
    """How many times as bright the second picture (H, W) is about the target, 1 where that is no flicker."""
    one, other, read, _ = _near(before, after, target)
    times = _flicker(one, other, read)
    return times if abs(times - 1.0) > LEAST_FLICKER else 1.0


def _near(before: Grey, after: Grey, target: Flags) -> tuple[Field, Field, Flags, Flags]:
    """Of two pictures (H, W) what is about a target, what can be read there, and the target there."""
    near = cv2.dilate(target.astype(np.uint8), np.ones((2 * AROUND_PX + 1,) * 2, np.uint8))
    x, y, width, height = cv2.boundingRect(near)
    crop = slice(y, y + height), slice(x, x + width)
    one, other = (picture[crop].astype(np.float32) for picture in (before, after))
    return one, other, (near[crop] > 0) & (cv2.min(one, other) < CLIPPED), target[crop]


def _flicker(one: Field, other: Field, read: Flags) -> float:
    smooth, now = (cv2.GaussianBlur(picture, (0, 0), SMOOTH_PX) for picture in (one, other))
    tell = read & (cv2.max(one, other) < CLIPPED) & (cv2.max(smooth, now) > DARK)
    times = float(np.median(now[tell] / np.maximum(smooth[tell], 1.0))) if tell.any() else 1.0
    return times if 1.0 / MOST_FLICKER <= times <= MOST_FLICKER else 1.0


def _as_flickered(one: Field, other: Field, read: Flags) -> Field:
    """The first picture (H, W) as many times as bright as the second is, where that may be flicker.

    What is clipped in the first may be as bright as in the second.
    """
    flickered = np.minimum(_flicker(one, other, read) * one, 255.0).astype(np.float32)
    return np.where(one < CLIPPED, flickered, cv2.max(flickered, other))


def _wide(flags: Flags) -> Flags:
    """Without specks and thin lines: noise, and edges that have moved."""
    return cv2.morphologyEx(flags.astype(np.uint8), cv2.MORPH_OPEN, np.ones((WIDE_PX, WIDE_PX), np.uint8)) > 0


def _least_change(change: Field, read: Flags) -> float:
    """From which on a smooth change (H, W) is more than noise, grey."""
    rough = change - cv2.GaussianBlur(change, (0, 0), 2.0)
    noise = 1.48 * float(np.median(np.abs(rough[read])))
    return max(CHANGED * noise / (2.0 * math.sqrt(math.pi) * SMOOTH_PX), LEAST_GREY)


def _correlation(one: Field, other: Field, where: Flags) -> float:
    """Of the gradients of two pictures (H, W) at some pixels, 0..1: light may turn an edge over."""
    ours, theirs = (_gradients(picture)[:, where] for picture in (one, other))
    both = float(np.sqrt((ours**2).sum() * (theirs**2).sum()))
    return abs(float((ours * theirs).sum())) / both if both > 0.0 else 1.0


def _gradients(picture: Field) -> Field:
    smooth = cv2.GaussianBlur(picture, (0, 0), SMOOTH_PX)
    return np.stack([cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1)])


def _shifted(one: Field, other: Field, read: Flags) -> bool:
    """Whether one picture (H, W) is most of the other where it is shifted."""
    size = one.shape[::-1]
    (x, y), _ = cv2.phaseCorrelate(one, other, cv2.createHanningWindow(size, cv2.CV_32F))
    shift = np.array([[1.0, 0.0, x], [0.0, 1.0, y]])
    moved = cv2.warpAffine(one, shift, size, borderMode=cv2.BORDER_REPLICATE)
    left = float(((other - moved)[read] ** 2).sum())
    return left < EXPLAINED * float(((other - one)[read] ** 2).sum())
