"""Whether lamps are all the light there is: no sun, and no image that shows what it gives.

With as many images as lamps, and the sun, what each gives cannot be told apart. In a dark room it can: there
is one light less. It shows at the ends of shadows: where one lamp alone steps it is blocked on one side, and
what is left there is what else there is in its image.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Field, Flags, Floats
from numerics.kernels import kernel
from numerics.logarithm import TWO
from vision_server.kinds.light_parts import KnownLights, lights_of, parts_of
from vision_server.kinds.sides import Sides

# Chosen by hand on renders: `python -m benchmarks.edge_kinds`.
FLAT_SD = 0.03  # of two places 4 px apart on one flat surface, of the intensity
SURE = 2.5  # standard deviations: less is no step
LIT_SHARE, LIT_GREY = 0.15, 12.0  # of the brighter side in its best light: in less it shows no light off
LEAST_STEP = 0.25  # of the brighter side in its best light: other steps are rather prints and creases
# Of the brighter side: less is black. So many of the ends are, at least: of sets in the dark .78 and more
# (two .1 and .6), of those with a sun .55 at most (one .86).
BLACK, LEAST_BLACK = 0.04, 0.7
FEWEST = 8  # ends


def lamps_in_the_dark(levels: Floats, sides: Sides) -> KnownLights | None:
    """The lamps whose levels in C channels are (C, K), if N edgels show that there is no other light."""
    lights = lights_of(levels[:, levels.any(axis=0)])
    parts = parts_of(sides, lights)
    return lights if parts is not None and _ends_are_black(parts) else None


def unsure_and_lit(sides: Sides) -> tuple[Field, Flags]:
    """Standard deviation (C, N) of the step between two sides that are alike, and where it would be seen."""
    sd, lit = np.empty_like(sides.noise), np.empty(sides.noise.shape, np.bool_)
    _unsure_and_lit(sides.near, sides.noise, sd, lit)
    return sd, lit


@kernel()
def _unsure_and_lit(near: Field, noise: Field, sd: Field, lit: Flags) -> None:
    """As `unsure_and_lit`; ``sd`` and ``lit`` are outputs."""
    channels, count = noise.shape
    flat, share, least = np.float32(FLAT_SD**2), np.float32(LIT_SHARE), np.float32(LIT_GREY)
    best = np.full(count, least)
    for channel in range(channels):
        for i in range(count):
            best[i] = max(best[i], share * max(near[channel, 0, i], near[channel, 1, i]))
    for channel in range(channels):
        for i in range(count):
            one, other, of_noise = near[channel, 0, i], near[channel, 1, i], noise[channel, i]
            dark, bright = min(one, other), max(one, other)
            sd[channel, i] = np.sqrt(TWO * of_noise * of_noise + flat * dark * dark)
            lit[channel, i] = (bright > best[i]) & (sd[channel, i] < share * bright)


def _ends_are_black(parts: Sides) -> bool:
    """Whether nothing is left where one of L lights alone steps and another one shows both sides alike."""
    dark, bright = parts.near.min(axis=1), parts.near.max(axis=1)
    step, best = bright - dark, bright.max(axis=0)
    sd, lit = unsure_and_lit(parts)
    steps = step > SURE * sd
    most = step.argmax(axis=0)
    is_end = parts.known.all(axis=0) & (lit & ~steps).any(axis=0) & (np.count_nonzero(steps, axis=0) == 1)
    is_end &= step.max(axis=0) > LEAST_STEP * best
    ends = np.flatnonzero(is_end)
    at = most[ends], ends
    is_black = dark[at] - parts.noise[at] < BLACK * bright[at]
    return len(ends) >= FEWEST and bool(is_black.mean() >= LEAST_BLACK)
