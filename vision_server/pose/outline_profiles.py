"""Where the outline of a curved surface lies, by its profile across: a step, and shading that rises inside.

Inside of its outline a surface turns towards the camera as the root of the distance does, and with it, by
how the light falls, its shading changes. The derivative across is a Gaussian at the outline, as wide as the
image is blurred, and what the shading adds inside: the root's own derivative, and an even slope, both blurred
alike. Where it lies depends on how wide the blur is taken for. That all outlines of an image tell together,
and how well they do is what all of them may be off by alike.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from numerics.arrays import Floats, Ints

REACH_STEPS = 3  # steps to either side of an outline that are looked at
WIDTHS = np.arange(0.7, 2.45, 0.1)  # sd of the blurred outline, in steps
PLACES = np.arange(-1.2, 1.25, 0.1)  # of the outline, in steps
BLURS_PX = np.arange(0.4, 6.0, 0.1)  # sd of the image's blur
ROOTS = np.linspace(0.0, 3.0, 121)  # of the distances inside, in steps, over which shading rises
# Read off 1450 outlines at the true poses of 96 bodies, large, small and soft, under lamps drawn at random.
SHADING_PENALTY = 0.002  # for the squares of what shading adds, beside what is not explained
SEEMING_BLUR_RATIO = 0.96  # image's own blur over that which explains most: shading widens outlines
# Standard deviation of a place, over the root of what is not explained by how fast that grows beside it.
SD_OF_REST = 0.7
MOST_BLUR_SD_PX = 0.3  # of an image's blur, by its outlines, at most


class Optics(NamedTuple):
    """How M profiles were taken, (M,): in which image, by a filter of what sd, in steps of how much, px."""

    image: Ints
    filter_px: Floats
    step_px: Floats


class Outlines(NamedTuple):
    """What the profiles of M outlines tell, (M,) px: their places inwards, the sd of each, and how much
    farther inwards all of an image are if its blur is wider by one sd.
    """

    place: Floats
    sd: Floats
    shared: Floats


def outlines_of(profiles: Floats, optics: Optics, weight: Floats) -> Outlines:
    """Outlines by their profiles (M, 2 REACH_STEPS + 1), from outside to inside.

    Each is explained by least squares, at each place and width; ``weight`` (M,) is what one counts for the
    blur of its image.
    """
    shapes = _shapes()
    unit = profiles / np.maximum(np.linalg.norm(profiles, axis=1), 1e-12)[:, None]
    like = (unit @ shapes.reshape(2 * REACH_STEPS + 1, -1)).reshape(len(unit), *shapes.shape[1:])
    place, rest, bend = _least(1.0 - (like**2).sum(axis=3), PLACES)
    rest = np.maximum(rest, 0.0)
    unlike = _at_widths(rest, _widths(BLURS_PX, optics))
    blur = np.empty((len(unit), 3))
    for image in np.unique(optics.image):
        of = optics.image == image
        blur[of] = _blur(unlike[of], weight[of])
    near = _widths(blur, optics)
    places, sds = (
        optics.step_px[:, None] * _at_widths(one, near) for one in (place, SD_OF_REST * np.sqrt(rest / bend))
    )
    return Outlines(places[:, 1], sds[:, 1], 0.5 * (places[:, 2] - places[:, 0]))


def _blur(unlike: Floats, weight: Floats) -> Floats:
    """The blur (3,) of an image, px, less one sd, as it is, and one sd more.

    ``unlike`` (M, B) is the share of each profile that each of BLURS_PX leaves unexplained.
    """
    (blur,), (rest,), (bend,) = _least((weight @ unlike)[None], BLURS_PX)
    alone = float(weight @ weight) / max(float(weight.sum()) ** 2, 1e-12)  # 1 over the number that count
    sd = min(math.sqrt(max(rest, 0.0) / bend * alone), MOST_BLUR_SD_PX)
    return np.asarray(SEEMING_BLUR_RATIO * blur + sd * np.array([-1.0, 0.0, 1.0]))


def _widths(blur_px: Floats, optics: Optics) -> Floats:
    """Of outlines that are blurred so, (N,) or (M, N) px, and filtered, in steps, (M, N)."""
    return np.asarray(np.sqrt(optics.filter_px[:, None] ** 2 + blur_px**2) / optics.step_px[:, None])


def _at_widths(values: Floats, widths: Floats) -> Floats:
    """Values (M, W) of M outlines, one for each of WIDTHS, between these at widths (M, N)."""
    at = np.clip((widths - WIDTHS[0]) / (WIDTHS[1] - WIDTHS[0]), 0.0, len(WIDTHS) - 1.001)
    low = at.astype(np.int64)
    before, after = (np.take_along_axis(values, low + k, 1) for k in (0, 1))
    return np.asarray(before + (at - low) * (after - before))


def _least(values: Floats, at: Floats) -> tuple[Floats, Floats, Floats]:
    """Where values (..., N) on an even grid ``at`` (N,) are least, between its points; how much they are
    there, and their second derivative.
    """
    middle = np.clip(values.argmin(axis=-1), 1, len(at) - 2)
    before, here, after = (
        np.take_along_axis(values, (middle + k)[..., None], -1)[..., 0] for k in (-1, 0, 1)
    )
    bend, step = np.maximum(before - 2.0 * here + after, 1e-8), at[1] - at[0]
    aside = np.clip(0.5 * (before - after) / bend, -1.0, 1.0)
    return at[middle] + step * aside, here - 0.25 * (before - after) * aside, bend / step**2


@cache
def _shapes() -> Floats:
    """What products with a profile tell of outlines by width and place, (2 REACH_STEPS + 1, W, P, 3).

    The squares of the three products are the share that step, root and slope explain together.
    """
    around, width = (np.arange(-REACH_STEPS, REACH_STEPS + 1.0) - PLACES[:, None], WIDTHS[:, None, None])
    rising = np.exp(-0.5 * ((around[..., None] - ROOTS**2) / width[..., None]) ** 2) * (ROOTS[1] - ROOTS[0])
    slope = rising @ (2.0 * ROOTS) / (math.sqrt(2.0 * math.pi) * width)
    parts = np.stack([np.exp(-0.5 * (around / width) ** 2), rising.sum(axis=-1), slope], axis=-1)
    normal = parts.swapaxes(2, 3) @ parts + np.diag([0.0, SHADING_PENALTY, SHADING_PENALTY])
    shapes = np.linalg.solve(np.linalg.cholesky(normal), parts.swapaxes(2, 3))
    return np.ascontiguousarray(shapes.transpose(3, 0, 1, 2))
