"""To which side each light's shadows fall: the rule of multi-flash cameras, learnt from the images.

A shadow falls away from its light. So where it ends, its dark side is towards the light as the image shows
it; and what is dark behind the outline that casts it is away from the light (Raskar et al. 2004). The two are
else hard to tell where the surface behind is like the one before. Where each light is need not be known:

- Most of what looks like the end of a light's shadow is one.
- Of what stands before the background, the sides towards a light are brighter by it.

Both say how likely each direction to a light is; what a side says of an edgel is the mean over all of them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from numerics.arrays import Field, Flags, Floats, Ints
from numerics.kernels import kernel
from numerics.logarithm import ONE, ZERO
from vision_server.kinds.sides import Sides

# Chosen by hand on renders: `python -m benchmarks.edge_kinds --levels`.
DIRECTIONS = 72  # that a light may be in
CONCENTRATION = 1.5  # von Mises, of the sides of a light's shadows about the direction to it
ANY_SIDE = 0.05  # share of shadows' ends that may face anywhere
BEHIND_OUTLINES = 0.2  # share of what looks like a shadow's end that is behind an outline
LIKE_ONE = 5.0  # sampled edgels that say no more than one: they are neighbours
SHADING = 15.0  # of the logarithm of how likely a direction is, if all outlines' shading is for it
PER_RAD = np.float32(DIRECTIONS / (2.0 * np.pi))
ANGLES = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
BELL = np.exp(CONCENTRATION * np.cos(ANGLES[:, None] - ANGLES))
# How much likelier than any other a dark side is: a row for each direction to the light, a column for each of
# the dark side.
AT_END = (1.0 - ANY_SIDE) * BELL / BELL.mean() + ANY_SIDE
BEHIND = np.roll(AT_END, DIRECTIONS // 2, axis=1)
LOG_EITHER = np.log((1.0 - BEHIND_OUTLINES) * AT_END + BEHIND_OUTLINES * BEHIND)


class Falling(NamedTuple):
    """How much likelier than any other each side of an edgel is to be the dark one, float32 (L, 72) each.

    Attributes
    ----------
    shadow, outline
        At the end of a light's shadow, and at an outline before a surface in it; by the direction of the
        dark side.
    """

    shadow: Field
    outline: Field

    def of(self, near: Field, axis: Field) -> tuple[Field, Field]:
        """For N edgels, (L, N) each.

        Parameters
        ----------
        near
            (L, 2, N), what each light gives behind and ahead of them; or (1, 2, N), what all do.
        axis
            (N,), direction ahead, rad.
        """
        shadow, outline = np.empty((2, len(self.shadow), len(axis)), np.float32)
        _of_dark_sides(self, near, axis, shadow, outline)
        return shadow, outline

    def of_most_changed(self, parts: Sides) -> Field:
        """For N edgels (N,), at the end of a shadow of the light whose part differs most; 1 at most.

        A dark side where it may be makes no shadow of what else is there, as of a dark leaf's outline.
        """
        changed = _most_changed(parts.near)
        at = changed, np.arange(len(changed))
        near = np.stack([parts.near[:, side][at] for side in (0, 1)])[None]
        return np.asarray(np.minimum(self.shadow[changed, _dark_side(near, parts.axis)[0]], 1.0))


def _most_changed(near: Field) -> Ints:
    """Number (N,) of the light whose part (L, 2, N) differs most between the sides."""
    return np.asarray(np.argmax(np.abs(near[:, 0] - near[:, 1]), axis=0))


@kernel(inline="always")
def _direction(axis: np.float32, behind: np.float32, ahead: np.float32) -> int:
    """Number of the direction, of the two of an axis, to the side that has less."""
    number = int(np.rint(axis * PER_RAD))
    return (number + DIRECTIONS // 2 if behind < ahead else number) % DIRECTIONS


@kernel()
def _dark_side(near: Field, axis: Field) -> Ints:
    """Number (L, N) of the direction to the side that each light gives less to."""
    numbers = np.empty((len(near), len(axis)), np.int64)
    for light in range(len(near)):
        for i in range(len(axis)):
            numbers[light, i] = _direction(axis[i], near[light, 0, i], near[light, 1, i])
    return numbers


@kernel()
def _of_dark_sides(falling: Falling, near: Field, axis: Field, shadow: Field, outline: Field) -> None:
    """As `Falling.of`; ``shadow`` and ``outline`` (L, N) are outputs."""
    last = len(near) - 1
    for light in range(len(shadow)):
        given = near[min(light, last)]
        for i in range(len(axis)):
            number = _direction(axis[i], given[0, i], given[1, i])
            shadow[light, i] = falling.shadow[light, number]
            outline[light, i] = falling.outline[light, number]


def learn_falling(parts: Sides, is_outline: Flags, is_shadow: Flags) -> Falling:
    """Learnt from some edgels of a set.

    Parameters
    ----------
    parts
        What each of L lights gives to both sides of N edgels.
    is_outline, is_shadow
        bool (N,), which are taken for outlines before the background, and for ends of shadows.
    """
    shading = _shading(parts, is_outline)
    ends = parts.of(np.flatnonzero(is_shadow))
    missing = _most_changed(ends.near)
    at = _dark_side(ends.near, ends.axis)
    number = DIRECTIONS * missing + at[missing, np.arange(len(missing))]
    seen = np.bincount(number, minlength=DIRECTIONS * len(shading)).reshape(-1, DIRECTIONS)
    likely = seen / LIKE_ONE @ LOG_EITHER.T
    likely += SHADING * shading @ np.stack([np.cos(ANGLES), np.sin(ANGLES)])
    likely = np.exp(likely - likely.max(axis=1, keepdims=True))
    shadow = (likely / likely.sum(axis=1, keepdims=True) @ AT_END).astype(np.float32)
    return Falling(shadow, np.roll(shadow, DIRECTIONS // 2, axis=1))


def _shading(parts: Sides, is_outline: Flags) -> Floats:
    """Mean direction (L, 2) from what stands before the background outwards, by what each light gives there
    beside its mean; its length is how much all outlines say the same."""
    towards = np.zeros((len(parts.near), 2))
    _sum_shading(parts.near, parts.axis, np.flatnonzero(is_outline), towards)
    return towards


@kernel()
def _sum_shading(near: Field, axis: Field, outlines: Ints, towards: Floats) -> None:
    """As `_shading`, by the numbers of the outlines; ``towards`` (L, 2) is an output."""
    lights, count = len(near), len(outlines)
    share, outwards = np.empty((lights, count)), np.empty((count, 2))
    for k in range(count):
        i = outlines[k]
        behind, ahead = ZERO, ZERO
        for light in range(lights):
            behind, ahead = behind + max(near[light, 0, i], ZERO), ahead + max(near[light, 1, i], ZERO)
        side, sign = (0, ONE) if behind > ahead else (1, -ONE)
        outwards[k, 0], outwards[k, 1] = sign * np.cos(axis[i]), sign * np.sin(axis[i])
        for light in range(lights):
            share[light, k] = max(near[light, side, i], ZERO) / max(behind, ahead, ONE)
    for light in range(lights):
        mean, total = share[light].sum() / max(count, 1), 1e-9
        for k in range(count):
            more = share[light, k] - mean
            total += abs(more)
            towards[light, 0] += more * outwards[k, 0]
            towards[light, 1] += more * outwards[k, 1]
        towards[light] /= total
