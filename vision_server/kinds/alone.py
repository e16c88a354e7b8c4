"""Shadows where each image has a lamp of its own beside the sun, and none shows the sun alone.

What each lamp gives cannot be told apart then. But where it is blocked its image shows the sun and nothing
else, and no image shows less than the sun. So on the dark side of a shadow's end all lamps that are blocked
there show the same, which is the least of all images; all others show the same on both sides. A crease does
so by coincidence only, and so does the end of a lamp's shadow that is on in several of the images.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Field, Flags, Ints
from numerics.kernels import kernel
from numerics.logarithm import HALF, ONE, TWO, ZERO, log_of, log_of_sum
from vision_server.kinds.blocked import FLAT_SD, KNOWN_DEPTH_SD
from vision_server.kinds.dark_room import LEAST_STEP, SURE, unsure_and_lit
from vision_server.kinds.densities import UNKNOWN_SD, log_normal, ratio_of
from vision_server.kinds.scatter import SURFACE_SD
from vision_server.kinds.sides import Sides

# Chosen by hand on renders: `python -m benchmarks.edge_kinds --alone 4`.
BLOCKED = np.float32(0.1)  # share of the lamps that are blocked where one is
CURVED = np.float32(0.02)  # share of the others that are not quite alike, as the surface is curved
NEVER = np.float32(-80.0)  # the logarithm of how likely
ON_BY_ONE = np.float32(0.2)  # step, as a share of the largest, from which on a lamp is blocked
AGREE = np.float32(0.05)  # of it, by so much what blocked lamps leave may differ from the least
MOST_NOISE = np.float32(0.12)  # of a step, as a share of the largest
FEWEST = 8  # ends of a lamp's shadows
# Share of the steps in some images and not in others that agree: of drawn parts .6 and more, of targets with
# a texture .3 to .6 or hardly any, of curved bodies .5 and less, of lamps on in two images each .3 and less.
LEAST_AGREEING = 0.5


def lamps_are_alone(sides: Sides) -> bool:
    """Whether N edgels show that each of C images has a lamp of its own: the shadows of most lamps end so.

    On curved bodies they do not: there most of what looks like an end is where shading falls off.
    """
    sd, lit = unsure_and_lit(sides)
    ends, steps = _agreeing(sides, sd, lit)
    return bool(ends[-1] >= LEAST_AGREEING * steps and np.count_nonzero(ends[:-1] >= FEWEST) > len(sd) / 2)


@kernel()
def _agreeing(of: Sides, sd: Field, lit: Flags) -> tuple[Ints, int]:
    """Steps in some of C images and none in others, and in which of these what is left agrees.

    ``sd`` and ``lit`` are those of `unsure_and_lit`.

    Returns
    -------
    Of how many of the latter each image is, and how many they are, int64 (C + 1,); how many steps there are.
    """
    channels, count = of.noise.shape
    ends, steps = np.zeros(channels + 1, np.int64), 0
    near, sure = of.near, np.float32(SURE)
    for i in range(count):
        total, largest, best, unsure, is_known = ZERO, ZERO, ZERO, ZERO, True
        for channel in range(channels):
            step = near[channel, 1, i] - near[channel, 0, i]
            total += step
            largest, unsure = max(largest, abs(step)), max(unsure, sd[channel, i])
            best = max(best, near[channel, 0, i], near[channel, 1, i])
            is_known &= of.known[channel, i]
        if not is_known or unsure >= MOST_NOISE * largest or largest <= np.float32(LEAST_STEP) * best:
            continue
        dark = 0 if total > ZERO else 1
        least, most, is_clear, others = np.float32(np.inf), ZERO, True, False
        for channel in range(channels):
            left, limit = near[channel, dark, i], sure * sd[channel, i]
            step = near[channel, 1 - dark, i] - left
            least = min(least, left)
            if step > max(limit, ON_BY_ONE * largest):
                most = max(most, left)
            else:
                is_clear &= abs(step) < limit
                others |= lit[channel, i]
        if not is_clear or not others:
            continue
        steps += 1
        if most - least < sure * unsure + AGREE * largest:
            ends[-1] += 1
            for channel in range(channels):
                step = near[channel, 1 - dark, i] - near[channel, dark, i]
                ends[channel] += step > max(sure * sd[channel, i], ON_BY_ONE * largest)
    return ends, steps


def shadow_of_some(sides: Sides, dark_side: Field) -> Field:
    """Log-likelihood (N,) that some of the lamps are blocked on one side, and none on the other.

    Parameters
    ----------
    sides
        Of N edgels in C channels, in each of which another lamp is on.
    dark_side
        (C, N), how much likelier than any other the darker side is to be that of a shadow of each lamp.
    """
    found = np.empty(sides.noise.shape[1], np.float32)
    _some_blocked(sides, np.float32(sides.dark), np.log(dark_side), found)
    return found


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _some_blocked(of: Sides, dark: np.float32, dark_side: Field, found: Field) -> None:
    """As `shadow_of_some`, of the logarithm of ``dark_side``; ``found`` is an output."""
    channels, count = of.noise.shape
    flat, curved = np.float32(FLAT_SD**2), np.float32(SURFACE_SD**2)
    depth, unknown = np.float32(KNOWN_DEPTH_SD**2), np.float32(UNKNOWN_SD**2)
    even, uneven = log_of((ONE - BLOCKED) * (ONE - CURVED)), log_of((ONE - BLOCKED) * CURVED)
    for i in range(count):
        both = ZERO
        for side in range(2):
            sun, first = np.float32(np.inf), 0
            for channel in range(channels):
                if of.known[channel, i] and of.near[channel, side, i] < sun:
                    sun, first = of.near[channel, side, i], channel
            total = ZERO
            for channel in range(channels):
                here, there = of.near[channel, side, i], of.near[channel, 1 - side, i]
                noise = of.noise[channel, i]
                ratio, variance = ratio_of(there, here, noise, dark)
                if not of.known[channel, i]:
                    variance += unknown
                alike = log_of_sum(
                    even + log_normal(ratio, variance + flat), uneven + log_normal(ratio, variance + curved)
                )
                blocked = NEVER
                if ratio > ZERO and of.known[channel, i]:
                    if channel == first:
                        blocked = log_of(TWO) + log_normal(ratio, variance + depth)
                    else:
                        above, unsure = ratio_of(here, sun, noise, dark)
                        blocked = log_normal(above, unsure + flat)
                    blocked += log_of(BLOCKED) + dark_side[channel, i]
                total += log_of_sum(alike, blocked)
            both = total if side == 0 else log_of_sum(both, total)
        found[i] = both + log_of(HALF)
