"""Whether lamps are all the light there is: no sun, and no image that shows what it gives.

With as many images as lamps, and the sun, what each gives cannot be told apart. In a dark room it can: there
is one light less. It shows at the ends of shadows: where one lamp alone steps it is blocked on one side, and
what is left there is what else there is in its image.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Field, Flags, Floats
from vision_server.edges.light_parts import KnownLights, lights_of, parts_of
from vision_server.edges.sides import Sides

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
    dark, bright = sides.near.min(axis=1), sides.near.max(axis=1)
    sd = np.sqrt(2.0 * np.square(sides.noise) + np.square(FLAT_SD * dark))
    lit = (bright > np.maximum(LIT_SHARE * bright.max(axis=0), LIT_GREY)) & (sd < LIT_SHARE * bright)
    return sd, lit


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
