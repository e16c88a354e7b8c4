"""Shadows by what each light gives to both sides of an edgel, where that is known (`kinds.light_parts`).

To an edge, one light by itself is one of three things:

- *alike*: it gives the same to both sides;
- *nothing*: on one side it gives nothing;
- *turned*: it gives any amount to either side.

At the end of a shadow one light gives nothing to one side, and all others are alike. Now and then the ends of
two lights' shadows lie within what is read of the sides: then two are not alike, and the second one may be
seen in part. Behind an outline some lights may be missing, where a surface in its shadow is like the one
before it; or it is another one, and what is missing is so on the same side. At a crease each light is turned,
or falls on one of the faces only, whatever the others do: that all others are alike is then a coincidence.

So it is where one light is mirrored: that one is turned. And where all lights but one have the same ratio,
and it is not 1, there is a print as well: under the end of a shadow, or of what that light is mirrored in.

All are told as the logarithm of how much likelier they are than a crease.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from numerics.arrays import Field
from numerics.kernels import kernel
from numerics.logarithm import HALF, ONE, TWO, ZERO, exp_of, log_of, log_of_sum
from vision_server.kinds.densities import log_normal, of_a_mean, ratio_of
from vision_server.kinds.sides import Sides

# As measured on simulated creases (`benchmarks.edge_kinds`), where the log-ratios of two lights do not depend
# on each other.
TURNED_SD = 0.8  # of a light's log-ratio between two faces
# Chosen by hand there.
FACES_AWAY = 0.1  # share of the lights that reach only one of the faces
FLAT_SD = 0.04  # of a log-ratio of two places 4 px apart on one flat surface
DARK_SHARE = 0.03  # of what the brightest light gives: nothing
TWO_ENDS = 0.15  # share of the shadows' ends beside which another light's shadow ends
IN_PART = np.float32(0.3)  # share of the lights with such an end that still give something
ON_PRINT = np.float32(0.1)  # share of the shadows' ends that lie on a print
SHADED_PRINT_SD = 0.2  # of the log-ratio of that print
GLARING_PRINT_SD = 0.7  # of the log-ratio of prints that a light is mirrored in
# Share of the lights that are missing behind an outline, before a surface that is alike ...
BEHIND = np.float32(0.3)
BEHIND_ANY = np.float32(0.5)  # ... and before any other, on the same side
RARER_ANY = 1.0  # of the logarithm of an outline before any other, beside those before one that is alike
SUREST = np.float32(12.0)  # the logarithm of how sure one light alone may be
NEVER = np.float32(-1e9)  # the logarithm of how likely
LEAST = 1e-300  # of what a logarithm is taken of


class LessCrease(NamedTuple):
    """How much likelier than a crease N edgels are something else: differences of log-likelihoods, (N,).

    Attributes
    ----------
    shadow
        The end of a shadow.
    outline
        An outline before a lit surface.
    mirrored
        The end of what one light is mirrored in.
    glare
        A print on what one light is mirrored in.
    crease
        Log-likelihood of a crease itself, by the log-ratios of the parts.
    """

    shadow: Field
    outline: Field
    mirrored: Field
    glare: Field
    crease: Field


class EachLight(NamedTuple):
    """What each of L lights is to N edgels: float32 (L, N) each.

    Attributes
    ----------
    alike, nothing, turned
        Log-likelihoods that it is alike, gives nothing to the darker side, and is turned, less that of what
        it is at a crease.
    crease
        Log-likelihood of what it is at a crease.
    precision, pull
        Of its log-ratio on a flat surface: 1 / variance, and that times the log-ratio.
    """

    alike: Field
    nothing: Field
    turned: Field
    crease: Field
    precision: Field
    pull: Field


def less_crease(parts: Sides, dark_side: tuple[Field, Field] | None = None) -> LessCrease:
    """What else than a crease N edgels may be.

    Parameters
    ----------
    parts
        What each of L lights gives to both sides of N edgels.
    dark_side
        As `falling.Falling.of` gives it; else the dark side of a shadow may be on any side.
    """
    shape = parts.noise.shape
    at_end, behind = (np.ones(shape, np.float32),) * 2 if dark_side is None else dark_side
    each = EachLight(*np.empty((6, *shape), np.float32))
    less = LessCrease(*np.empty((5, shape[1]), np.float32))
    _each_light(parts.near, parts.noise, np.float32(parts.dark), each)
    _others_alike(each, parts.near, at_end, behind, less)
    _on_prints(each, at_end, less)
    return less


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _each_light(near: Field, noise: Field, dark: np.float32, each: EachLight) -> None:
    """What each light by itself is to N edgels: ``each`` is an output."""
    lights, count = noise.shape
    flat, turned_too = np.float32(FLAT_SD**2), np.float32(TURNED_SD**2)
    both_faces, one_face = np.float32(math.log(1.0 - FACES_AWAY)), np.float32(math.log(FACES_AWAY))
    brightest = np.zeros(count, np.float32)
    for light in range(lights):
        for i in range(count):
            brightest[i] = max(brightest[i], near[light, 0, i], near[light, 1, i])
    for light in range(lights):
        for i in range(count):
            ratio, variance = ratio_of(near[light, 0, i], near[light, 1, i], noise[light, i], dark)
            darker, sd = max(min(near[light, 0, i], near[light, 1, i]), ZERO), noise[light, i]
            dim = np.float32(DARK_SHARE) * brightest[i]
            # the density of nothing but noise, on either side, as one of the log-ratio
            nothing = log_normal(darker, sd * sd + dim * dim) + log_of(HALF * (darker + dark))
            turned = log_normal(ratio, variance + turned_too)
            crease = log_of_sum(turned + both_faces, nothing + one_face)
            each.alike[light, i] = log_normal(ratio, variance + flat) - crease
            each.nothing[light, i] = nothing - crease
            each.turned[light, i] = turned - crease
            each.crease[light, i] = crease
            each.precision[light, i] = ONE / (variance + flat)
            each.pull[light, i] = ratio / (variance + flat)


@kernel(inline="always")
def _sure(value: np.float32) -> np.float32:
    return min(max(value, -SUREST), SUREST)


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _others_alike(each: EachLight, near: Field, at_end: Field, behind: Field, less: LessCrease) -> None:
    """Where all lights are alike but one that ends or is mirrored, or some that are missing.

    ``less`` is an output, without glare and crease. All is told beside ``base``, that all lights are alike.
    """
    lights, count = each.alike.shape
    sums, products = np.zeros((7, count), np.float32), np.ones((3, count), np.float64)
    # unpacked, each would have strides of any length
    base, nothing, turned, mirrored = sums[0], sums[1], sums[2], sums[3]
    ends, one, two = sums[4], sums[5], sums[6]
    before_alike, is_back, is_ahead = products[0], products[1], products[2]
    for light in range(lights):
        for i in range(count):
            alike = _sure(each.alike[light, i])
            nothing[i] = exp_of(_sure(each.nothing[light, i]) - alike)
            turned[i] = exp_of(_sure(each.turned[light, i]) - alike)
            base[i] += alike
            mirrored[i] += turned[i]
        for i in range(count):
            gone = at_end[light, i] * nothing[i]
            end = (ONE - IN_PART) * gone + IN_PART * turned[i]
            ends[i] += gone
            two[i] += one[i] * end
            one[i] += end
        for i in range(count):
            # the density of nothing is of either side: that of the one that is behind is twice as large
            missing, here = behind[light, i] * nothing[i], (ONE - BEHIND_ANY) * turned[i]
            gone = here + TWO * BEHIND_ANY * missing
            is_darker_back = near[light, 0, i] < near[light, 1, i]
            before_alike[i] *= ONE - BEHIND + BEHIND * missing
            is_back[i] *= gone if is_darker_back else here
            is_ahead[i] *= here if is_darker_back else gone
    single = np.float32((1.0 - TWO_ENDS) / lights)
    pair = np.float32(TWO_ENDS / max(lights * (lights - 1) / 2, 1.0))
    none_missing, rarer = (1.0 - BEHIND) ** lights, 0.5 * math.exp(-RARER_ANY)
    for i in range(count):
        less.shadow[i] = base[i] + log_of((ONE - ON_PRINT) * (single * ends[i] + pair * two[i]))
        less.mirrored[i] = base[i] + log_of(mirrored[i] / np.float32(lights))
        some_missing = before_alike[i] - none_missing + rarer * (is_back[i] + is_ahead[i])
        less.outline[i] = base[i] + np.float32(math.log(max(some_missing, LEAST)))


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _on_prints(each: EachLight, at_end: Field, less: LessCrease) -> None:
    """Where all lights but one have the same log-ratio: adds to ``less``' shadow; gives glare, and crease."""
    lights, count = each.alike.shape
    shaded_print, glaring_print = np.float32(SHADED_PRINT_SD**2), np.float32(GLARING_PRINT_SD**2)
    sums, densities = np.zeros((4, count), np.float32), np.full((2, count), NEVER)
    alike, precision, pull, crease = sums[0], sums[1], sums[2], sums[3]
    shaded, glare = densities[0], densities[1]
    for light in range(lights):
        for i in range(count):
            alike[i] += each.alike[light, i]
            precision[i] += each.precision[light, i]
            pull[i] += each.pull[light, i]
            crease[i] += each.crease[light, i]
    for light in range(lights):
        for i in range(count):
            others = alike[i] - each.alike[light, i]
            among, pulled = precision[i] - each.precision[light, i], pull[i] - each.pull[light, i]
            end = each.nothing[light, i] + log_of(at_end[light, i])
            shaded[i] = log_of_sum(shaded[i], end + others + of_a_mean(among, pulled, shaded_print))
            mirrored = _sure(each.turned[light, i])
            glare[i] = log_of_sum(glare[i], mirrored + others + of_a_mean(among, pulled, glaring_print))
    mean = np.float32(-math.log(lights))
    for i in range(count):
        less.glare[i], less.crease[i] = glare[i] + mean, crease[i]
        less.shadow[i] = log_of_sum(less.shadow[i], shaded[i] + mean + log_of(ON_PRINT))
