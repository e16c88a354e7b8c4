"""Lamps that are on alone in one image each, beside an image of all of them or of the sun alone.

Such images tell the level in the other one without any shadow: no light gives less than nothing at any place.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Field, Floats
from numerics.kernels import kernel
from numerics.logarithm import ZERO
from numerics.ranks import at_share
from vision_server.kinds.dark_room import SURE
from vision_server.kinds.light_parts import KnownLights, known_lights, parts_of
from vision_server.kinds.sides import Sides

# Chosen by hand on renders: `python -m benchmarks.edge_kinds`.
LEVEL_SD = 0.12  # of a level by one place: darker ones tell none
LEVEL_SLACK, LEVEL_UNSURE = 0.04, 0.2  # by so much the least that it may be is above, or below, the most
MIXED = 1.1  # times its noise, what is left of images of several lamps: .8 at most, of one lamp 1.5 at least
FEWEST_PLACES, OUTSIDE = 20, 0.03  # that tell one; share of them that may be outside of what it allows
MOST_NEGATIVE = 0.05  # share of them with a light's part that is negative: of wrong levels .2 and more


def alone_and_together(sides: Sides) -> KnownLights | None:
    """Each lamp alone in one of C images, all at one level x in another; None if that explains them not.

    With K lamps alone, whose images add up to S and of which the darkest has m, and I in the other image, the
    sun gives s = (x S - I) / (K x - 1). That neither it nor any lamp, m - s, is less than nothing holds x
    between I / S and (I - m) / (S - K m) at each place: an image that shows anything else leaves no x. The
    sun alone, x = 0, is nowhere brighter than m; then there may be images of several lamps, too.
    """
    sides = sides.of(np.flatnonzero(sides.known.all(axis=0)))
    near, count = sides.near, len(sides.near) - 1
    variance = np.square(sides.noise)
    bright_first = np.argsort(-near.sum(axis=(1, 2))).tolist()
    for other in (*bright_first[-1:], *bright_first[:-1]):
        least_level, most_level = _bounds(near, variance, other)
        if min(len(least_level), len(most_level)) < FEWEST_PLACES:
            continue
        lower = at_share(least_level, 1.0 - OUTSIDE)
        upper, most = at_share(most_level, OUTSIDE), at_share(most_level, 1.0 - OUTSIDE)
        is_sun = most < LEVEL_SLACK
        if not is_sun and (not -LEVEL_SLACK < upper - lower < LEVEL_UNSURE or count * upper < 1.0):
            continue
        levels = np.insert(np.eye(count), other, 0.0 if is_sun else max(lower, upper), axis=0)
        lights = known_lights(levels)
        parts = parts_of(sides, lights)
        if parts is None:
            continue
        of_lamps = _of_lamps(parts.near[:-1], np.delete(variance, other, axis=0), variance[other])
        if of_lamps.shape[1] < count:  # some of the images are of several lamps
            if not is_sun:
                continue
            lights = known_lights(np.insert(of_lamps, other, 0.0, axis=0))
            parts = parts_of(sides, lights)
        if parts is not None and are_lights(parts):
            return lights
    return None


@kernel()
def _bounds(near: Field, variance: Field, other: int) -> tuple[Field, Field]:
    """The least and the most that the level of all lamps in the ``other`` one of C images (C, 2, N) may be.

    Of the sides that tell each; see `alone_and_together`.
    """
    channels, _, places = near.shape
    count, sd = np.float32(channels - 1), np.float32(LEVEL_SD)
    lit = turned = 0
    bounds = np.empty((2, 2 * places), np.float32)
    for i in range(places):
        noise = ZERO
        for channel in range(channels):
            noise += variance[channel, i]
        noise = np.sqrt(noise)
        for side in range(2):
            total, least = ZERO, np.float32(np.inf)
            for channel in range(channels):
                if channel != other:
                    total, least = total + near[channel, side, i], min(least, near[channel, side, i])
            uneven = total - count * least
            if sd * total > noise:
                bounds[0, lit] = near[other, side, i] / total
                lit += 1
            if sd * uneven > noise:
                bounds[1, turned] = (near[other, side, i] - least) / uneven
                turned += 1
    return bounds[0, :lit], bounds[1, :turned]


def _of_lamps(near: Field, variance: Field, of_sun: Field) -> Floats:
    """Levels (C, K) of the lamps in what C images (C, 2, N) show without the sun, by their variances (C, N).

    What is up to noise a sum of some of the others, each on as far as fits, is of several lamps; any other is
    a lamp's.
    """
    from scipy.optimize import nnls  # late: few image sets need it, and it takes half of a start

    # as long and as far from each other as the images: what fits these fits those
    flat = np.asarray(np.linalg.qr(near.reshape(len(near), -1).T.astype(np.float64), mode="r")).T
    lamps = list(range(len(near)))
    for one in range(len(near)):
        others = [lamp for lamp in lamps if lamp != one]
        if not others:
            break
        levels = np.zeros(len(near))
        levels[others] = nnls(flat[others].T, flat[one])[0]
        if _left_over(near, variance, of_sun, levels, one) < MIXED**2:
            lamps = others
    return np.array(
        [
            np.eye(len(lamps))[lamps.index(one)] if one in lamps else nnls(flat[lamps].T, flat[one])[0]
            for one in range(len(near))
        ]
    )


@kernel()
def _left_over(near: Field, variance: Field, of_sun: Field, levels: Floats, one: int) -> float:
    """Mean square of what ``one`` image shows beside a sum of all by ``levels``, in its variance by noise."""
    count, sun, total = len(of_sun), (1.0 - levels.sum()) ** 2, 0.0
    for i in range(count):
        expected = variance[one, i] + sun * of_sun[i]
        for channel in range(len(levels)):
            expected += levels[channel] ** 2 * variance[channel, i]
        for side in range(2):
            left = np.float64(near[one, side, i])
            for channel in range(len(levels)):
                left -= levels[channel] * near[channel, side, i]
            total += left * left / expected
    return total / (2 * count)


def are_lights(parts: Sides) -> bool:
    """Whether what each of some lights gives to the sides is never less than nothing, but for noise."""
    negative = np.any(parts.near < -SURE * parts.noise[:, None] - parts.dark, axis=(0, 1))
    return bool(np.mean(negative & parts.known[0]) < MOST_NEGATIVE)
