"""Places of a target in its image, what Lambert's law says of light there, and what images show there.

All images are brought to the blur of the least sharp one: then light adds up beside edges, too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Flags, Floats, Ints
from vision_server.prediction.lit_target import LitTarget
from vision_server.prediction.response import LitImage
from vision_server.prediction.small_pictures import SMALLER, smaller

# Chosen by hand.
LEAST_BLUR_PX = 2.0  # images are blurred by so much more than the least sharp one
MOST_PLACES = 16  # a question takes half as long again with 20
READING_SHARE, READING_FLOOR = 0.004, 0.001  # standard deviation of a reading: of it, of full scale
EXPOSED_SHARE = 0.015  # of it, alike in images of one shutter and aperture,
UNEVEN_SHARE = 0.1  # and of how brightness varies around: images are not blurred as measured
SAME_BLUR_PX = 0.5  # images of one exposure whose blur differs by less are of one aperture and shutter
OTHER_LIGHTS = 0.8  # correlation of that, where their lights differ
CLIPPED = 0.93  # brighter pixels say "at least";
MOST_CLIPPED = 0.005  # a place with this share of them is not read
ON_TARGET = 0.5  # share of what is seen at a place that is of the target


class Places(NamedTuple):
    """P places on a target.

    Attributes
    ----------
    at
        (P, 2) px in images of a fourth of the size.
    normal
        (P, 3) of the surface there, towards the camera; (0, 0, 0) where that is not known.
    shape
        (P, 1 + L): what sun and lights are expected to give, as shares of a light's mean.
    located
        (L,): the lights of which the position is known.
    """

    at: Ints
    normal: Floats
    shape: Floats
    located: Flags


class Readings(NamedTuple):
    """What K images show at P places.

    Attributes
    ----------
    value, sd, known
        (K, P): brightness at exposure 1, its standard deviation, whether it is known.
    least
        (K, P): of what is clipped, the brightness that it has at least; 0 of all else.
    shared, alike
        Share (K, P) of the variance that is the image's exposure's or blur's, and how far (K, K) that goes
        together in two images: light adds up between images of one shutter and aperture whatever their blur.
    most
        (K,): brightness from which on an image is clipped.
    """

    value: Floats
    sd: Floats
    known: Flags
    least: Floats
    shared: Floats
    alike: Floats
    most: Floats

    def last(self, images: int) -> Readings:
        """Of so many of the last images."""
        of = slice(-images, None)
        return Readings(
            self.value[of],
            self.sd[of],
            self.known[of],
            self.least[of],
            self.shared[of],
            self.alike[of, of],
            self.most[of],
        )

    def correlation(self, use: Ints) -> Floats:
        """How errors of the readings with these numbers (n,) in a flat list go together, (n, n)."""
        image, place = np.unravel_index(use, self.value.shape)
        root = np.sqrt(self.shared.ravel()[use])
        both = self.alike[np.ix_(image, image)] * (place[:, None] == place[None]) * np.outer(root, root)
        return np.asarray(both + np.diag(1.0 - root**2))


def read(target: LitTarget, images: Sequence[LitImage]) -> tuple[Places, Readings]:
    """Places, perhaps none, that images show well, and what the images, not none, show there."""
    blur = np.array([image.blur_px for image in images])
    common = float(blur.max()) + LEAST_BLUR_PX
    face = target.face
    inside = cv2.GaussianBlur((face >= 0).astype(np.float32), (0, 0), common / SMALLER)
    rows, columns = np.nonzero((face >= 0) & (inside > ON_TARGET))
    looks = [
        _look(image, math.sqrt(common**2 - own**2)) for image, own in zip(images, blur.tolist(), strict=True)
    ]
    value, uneven, clipped = (np.array([look[part][rows, columns] for look in looks]) for part in range(3))
    own = (READING_SHARE * value) ** 2 + READING_FLOOR**2
    sd = np.sqrt(own + (EXPOSED_SHARE * value) ** 2 + (UNEVEN_SHARE * uneven) ** 2)
    known = clipped <= MOST_CLIPPED
    chosen = _spread(known.sum(axis=0), (known * (value / sd) ** 2).sum(axis=0), face[rows, columns])
    exposure = np.array([image.exposure for image in images])[:, None]
    places = _described(target, (rows[chosen], columns[chosen]), common)
    value, sd, own, known = value[:, chosen], sd[:, chosen], own[:, chosen], known[:, chosen]
    value, sd, shared = value / exposure, sd / exposure, 1.0 - own / sd**2
    least = np.where(known, 0.0, value)
    return places, Readings(value, sd, known, least, shared, _alike(images), CLIPPED / exposure[:, 0])


def _alike(images: Sequence[LitImage]) -> Floats:
    """How far errors of exposure and blur go together in two images, (K, K)."""
    first = list[int]()  # of each image, the first one of its shutter and aperture
    for image in images:
        of_one = (
            k
            for k in first
            if math.isclose(images[k].exposure, image.exposure, rel_tol=1e-5)
            and abs(images[k].blur_px - image.blur_px) < SAME_BLUR_PX
        )
        first.append(next(of_one, len(first)))
    lights = np.array([image.lights for image in images])
    same = np.isclose(lights[:, None], lights[None]).all(axis=2)
    return np.equal.outer(first, first) * np.where(same, 1.0, OTHER_LIGHTS)


def _look(image: LitImage, sigma_px: float) -> tuple[Floats, Floats, Floats]:
    """A smaller image, blurred; how uneven it is there; the share of it that is clipped."""
    over = (image.linear > CLIPPED).astype(np.float32)
    seen, over = (smaller(part, sigma_px) for part in (image.linear, over))
    around = cv2.blur(seen, (3, 3))
    uneven = np.sqrt(np.maximum(cv2.blur(seen * seen, (3, 3)) - around * around, 0.0))
    return seen.astype(np.float64), uneven.astype(np.float64), over.astype(np.float64)


def _spread(seen: Floats, told: Floats, face: NDArray[np.int32]) -> Ints:
    """Which places to read, evenly over faces: half of those that most images show, half of the best shown.

    The first are rather dark, where lights show beside a sun; the others are in the sun.
    """
    chosen = np.zeros(0, dtype=np.int64)
    for worth in (seen, told):
        order = np.argsort(-worth, kind="stable")
        order = order[~np.isin(order, chosen)][: max(MOST_PLACES // 2, len(face) // 2)]
        order = order[np.argsort(face[order], kind="stable")]
        at = np.linspace(0, len(order) - 1, min(MOST_PLACES // 2, len(order))).astype(np.int64)
        chosen = np.concatenate([chosen, order[at]])
    return chosen


def _described(target: LitTarget, at: tuple[Ints, Ints], blur_px: float) -> Places:
    located = target.located
    shape = np.ones((len(at[0]), 1 + len(located)))
    normal = target.normals[target.face[at]] if target.model.faces else np.zeros((len(at[0]), 3))
    lit = np.array([cv2.GaussianBlur(one, (0, 0), blur_px / SMALLER)[at] for one in target.by_each])
    if lit.any():
        shape[:, 1:][:, located] = (lit / lit.mean()).T
    return Places(np.stack(at, axis=1), normal, shape, located)
