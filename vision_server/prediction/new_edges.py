"""Edges of an image that no light makes of the images before: something else is seen there.

Light adds up, so that about a place what an image shows is a sum of what images before have shown, each so
many times as bright: texture, and the target's edges, stay where they are. What comes in the way, and a
shadow of a light that no image has told apart, has edges of its own. How bright the model's faces are beside
each other is left free: two of them say little of how bright they will be under a light not seen alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations_with_replacement

import cv2
import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Flags, Floats
from vision_server.prediction.lit_target import LitTarget
from vision_server.prediction.places import CLIPPED, LEAST_BLUR_PX
from vision_server.prediction.response import LitImage
from vision_server.prediction.small_pictures import SMALLER, shrunk, smaller

# Chosen on 42 images without a fault, 42 of an arm and 115 of other light (docs/surprises.md).
NEW = 0.03  # share of the target with new edges from which on something may be in the way,
NEW_BESIDE_SHADOWS = 0.01  # and where the target's own shadows are drawn (docs/surprises.md)
GREYS = 0.618, 0.414  # from one face to the next: no two alike
AROUND = 7  # smaller pixels: light is about one there
UNEXPLAINED = 0.7  # share of the squared gradient about a place from which on it is new
FLOOR = 0.0012  # noise of a gradient, of full scale
ABOVE_FLOOR, SHARE = 6.0, 0.01  # an edge: times the noise, squared, and beside it a share of the brightness
RIDGE = 0.02  # share of an image's squared gradient that is not to be relied on
CLIPPED_AROUND, MOST_CLIPPED = 5, 0.02  # smaller pixels about one of which so much is clipped are not read


def new_edges(target: LitTarget, images: Sequence[LitImage]) -> float:
    """Share of the target at which the last of images shows edges that none before (one at least) has.

    The model is drawn twice, in greys of its faces, so that its edges may come to anything. Where all lights
    are located it is drawn once so, and for each image as its lights should show it: with the shadows that it
    casts on itself. Then fewer new edges tell.
    """
    common = max(image.blur_px for image in images) + LEAST_BLUR_PX
    looks = [smaller(image.linear, math.sqrt(common**2 - image.blur_px**2)) for image in images]
    region = target.face >= 0
    read = cv2.dilate(region.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    *before, last = (_clipped(image) for image in images)
    read &= ~last & ~np.all(before, axis=0)
    if not read.any():
        return 0.0
    drawn = target.under([image.lights for image in images])
    drawn += [_drawn(target.face, greys) for greys in (GREYS[:1] if drawn else GREYS)]
    looks[:0] = [np.asarray(cv2.GaussianBlur(one, (0, 0), common / SMALLER)) for one in drawn]
    edges = np.stack([_gradients(look) for look in looks])  # (K, 2, H, W) at each image's own exposure
    between = np.empty((len(edges), len(edges), int(read.sum())))
    for one, other in combinations_with_replacement(range(len(edges)), 2):
        between[one, other] = between[other, one] = _around((edges[one] * edges[other]).sum(axis=0))[read]
    floor = FLOOR**2
    shown, products, own = between[-1, -1], between[:-1, -1].T, between[:-1, :-1].transpose(2, 0, 1)
    ridge = (floor + RIDGE * own) * np.eye(len(looks) - 1)
    sums = np.linalg.solve(own + ridge, products[..., None])[..., 0]
    left = shown - 2.0 * (products * sums).sum(axis=1) + np.einsum("pi,pij,pj->p", sums, own, sums)
    is_edge = shown > ABOVE_FLOOR * floor + (SHARE * _around(looks[-1])[read]) ** 2
    return float((is_edge & (left > UNEXPLAINED * shown)).sum() / max(int(region.sum()), 1))


def _drawn(face: NDArray[np.int32], step: float) -> Field:
    """A picture of the model in which faces have greys of 0.5 to 1, neighbours other ones."""
    return np.asarray(np.where(face >= 0, 0.5 + 0.5 * np.mod(face * step, 1.0), 0.0), dtype=np.float32)


def _clipped(image: LitImage) -> Flags:
    share = shrunk((image.linear > CLIPPED).astype(np.float32))
    return cv2.dilate(share, np.ones((CLIPPED_AROUND, CLIPPED_AROUND), np.uint8)) > MOST_CLIPPED


def _gradients(look: Field) -> Floats:
    return np.stack([cv2.Sobel(look, cv2.CV_64F, *axis, scale=1 / 8) for axis in ((1, 0), (0, 1))])


def _around(field: Field | Floats) -> Floats:
    return np.asarray(cv2.blur(np.asarray(field, dtype=np.float64), (AROUND, AROUND)))
