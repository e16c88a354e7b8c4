"""How likely each kind of edge is by what the channels show on both sides of an edgel: the densities.

What each kind answers to lights is in `kinds.kinds`; what is blocked where the lights are known in
`kinds.each_light`, to which side shadows fall then in `kinds.falling`, and where there are fewer images than
lights in `kinds.blocked`.
"""

from __future__ import annotations

import math

import numpy as np

from numerics.arrays import Field, Flags, Grey, Reals
from numerics.kernels import kernel
from numerics.logarithm import ZERO, log_of_sum
from vision_server.kinds.alone import shadow_of_some
from vision_server.kinds.background import Background
from vision_server.kinds.blocked import DEPTH_SD, FLAT_SD, KNOWN_DEPTH_SD, shadow_of_one
from vision_server.kinds.densities import either, logarithms, normal, sum_of_logs
from vision_server.kinds.each_light import FACES_AWAY, TURNED_SD, LessCrease, less_crease
from vision_server.kinds.falling import Falling
from vision_server.kinds.ground import DARK_RATIO, NEITHER, ONE
from vision_server.kinds.light_parts import KnownLights, apparent_parts, parts_of
from vision_server.kinds.scatter import SURFACE_SD, scatter
from vision_server.kinds.sides import Sides

KINDS = ("outline", "crease", "print", "shadow", "highlight", "noise")
OUTLINE, CREASE, PRINT, SHADOW, HIGHLIGHT, NOISE = range(len(KINDS))
FIXED = (OUTLINE, CREASE, PRINT)
"""Kinds of edges that are of the scene, not of its light."""

# Of log-ratios; chosen by hand on renders and photographs: `python -m benchmarks.edge_kinds`.
TEXTURE_SD = 0.15  # of two places 4 px apart on one surface, in all lights alike: it is not of one grey
TOUCHED_SD = 1.0  # of a shadow's depth and a highlight's height
UNTOUCHED = 0.6  # share of the channels in which no shadow ends where one does in another
SIDE_STEEPNESS = 2.0  # how surely the side that changed tells shadow from highlight
MOST_STEEP = 30.0  # the logarithm of how surely: more changes no density and runs out of float32
AWAY_SD = 2.5  # of a crease's where a lamp reaches one face only, and hardly any other light does
RARER_TURNED = 6.0  # of its logarithm: what curved surfaces do in single lights is as far from alike
RARE_HIGHLIGHT = 0.25  # of its logarithm: what else than shadow there is in the light alone
RARER_HIGHLIGHT = 4.0  # of its logarithm, where known lights tell shadows: the rest is rather crease
RARER_GLARE = 4.0  # of the logarithm of a print where one light is mirrored
RARER_LIT = 6.0  # of the logarithm of an outline before a lit surface
# Of the logarithm of one light's shadow, by how far it is on in each image, beside those of lamps that have
# an image of their own.
RARER_ONE = 0.5
# How many times steeper creases and prints are than the slope between their sides: what is less is rather the
# shading of a curved surface. Nine tenths of those of renders have more, of what is in statues a third.
SHARP = 1.5
RARER_SLOPE = 4.0  # of their logarithm where the slope is even
WALL_SD = 0.05  # of a wall's grey from place to place
IN_SHADOW = 0.2  # share of the lights in which a wall beside an outline is in shadow
OFF_WALL = 1e-4  # density of a wall's grey anywhere
ANY_SD = 1.5  # of the logarithm of other greys, beside that of the wall
# Of the logarithm of an outline of which neither side meets a dark ground, for each pair of channels: all see
# the same place and are misled alike, so that what they say together is the less sure the more they are.
RARER_ENCLOSED = 0.35
RARER_OFF_WALL = 2.5  # the same where the ground is a wall, for each channel
LIKELIER_BEFORE_LIT = 1.0  # of the logarithm of an outline before a lit ground, beside a crease or a print
BLOCK = 16384  # edgels at a time: what is worked out of more goes through memory, at half the speed


def likelihoods(
    sides: Sides,
    background: Background,
    lights: KnownLights | None = None,
    falling: Falling | None = None,
) -> Reals:
    """Log-likelihood of each kind.

    Parameters
    ----------
    sides
        Of N edgels.
    background
        As they see it.
    lights
        Where the lamps' levels in each channel are known.
    falling
        To which side each light's shadows fall, where that is known.

    Returns
    -------
    float32 (6, N).
    """
    count = sides.noise.shape[1]
    found = np.empty((len(KINDS), count), np.float32)
    for first in range(0, count, BLOCK):
        block = slice(first, first + BLOCK)
        found[:, block] = _of_block(sides.of(block), background.of(block), lights, falling)
    return found


def _of_block(
    sides: Sides, background: Background, lights: KnownLights | None, falling: Falling | None
) -> Reals:
    """As `likelihoods`, of as many edgels as the processor's cache holds."""
    found = np.empty((len(KINDS), sides.noise.shape[1]), np.float32)
    found[: PRINT + 1], found[NOISE] = np.split(scatter(sides, background.dark), [PRINT + 1])
    if lights is not None and lights.are_all:
        _known_lights(found, sides, lights, falling)
    else:
        logs, noise = logarithms(sides)
        found[CREASE] = either(found[CREASE], _turned(logs, noise) - RARER_TURNED)
        on = np.ones((len(noise), 1)) if lights is None else lights.on
        touched, highlight = _touched(logs, noise)
        found[SHADOW] = either(touched, shadow_of_one(sides, logs, noise, on, DEPTH_SD)) - math.log(2.0)
        if falling is not None:
            found[SHADOW] += np.log(falling.of_most_changed(apparent_parts(sides)))
        found[HIGHLIGHT] = highlight - RARE_HIGHLIGHT
    if sides.sharpness is not None:  # a slope: 1 where it is even
        even = np.clip((SHARP - sides.sharpness) / (SHARP - 1.0), 0.0, 1.0)
        even *= np.float32(RARER_SLOPE)
        found[CREASE] -= even
        found[PRINT] -= even
    if background.wall is not None:
        logs, noise = logarithms(sides)
        beside = logs - np.log(background.wall + sides.dark)[:, None]
        # what is clipped is at least that bright, which tells which of its sides is no wall
        _before_wall(found, beside, np.where(sides.known, noise, np.float32(0.0)))
    if background.met is not None:
        _by_ground(found, sides, background, background.met)
    return found


def _by_ground(found: Reals, sides: Sides, background: Background, met: Grey) -> None:
    """Let the ground say what is outline in ``found`` (6, N), an output.

    An edge of which neither side meets it is hardly one. Before a ground that is lit, as a table, an outline
    answers lights as a crease or a print does; but one of its sides meets the ground, and the other does not.
    """
    count = len(sides.noise)
    if background.wall is None:
        rarer = RARER_ENCLOSED * count * (count - 1) / 2.0
        lit = np.float32(DARK_RATIO * (background.dark + sides.dark) - sides.dark)
        _before_lit(found, sides.brightest, met, lit)
    else:
        rarer = RARER_OFF_WALL * count
    found[OUTLINE] -= np.float32(rarer) * (met == NEITHER)


@kernel()
def _before_lit(found: Reals, brightest: Field, met: Grey, lit: np.float32) -> None:
    """Let an outline before a ground that is brighter than ``lit`` be what a crease or a print is, too."""
    likelier = np.float32(LIKELIER_BEFORE_LIT)
    for i in range(len(met)):
        if met[i] != ONE:
            continue
        one, other = ZERO, ZERO
        for channel in range(len(brightest)):
            one, other = max(one, brightest[channel, 0, i]), max(other, brightest[channel, 1, i])
        if min(one, other) > lit:
            step = max(found[CREASE, i], found[PRINT, i]) + likelier
            found[OUTLINE, i] = log_of_sum(found[OUTLINE, i], step)


def _before_wall(found: Reals, beside: Reals, noise: Reals) -> None:
    """Let a lit wall say what is outline, and what is on it, in ``found`` (6, N), an output.

    One side of an outline is of the wall's grey in each light, or in a shadow there, the other of any grey;
    of the end of a shadow on the wall both are of the wall. ``beside`` (C, 2, N) are logarithms of the
    intensities less that of the wall.
    """
    lit = normal(beside, noise[:, None] + WALL_SD**2)
    shaded = np.exp(np.minimum(beside, 0.0)) * (beside < 0.0)
    alike = normal(beside[:, 0] - beside[:, 1], noise + WALL_SD**2)
    any_grey = normal(beside, noise[:, None] + ANY_SD**2)
    outline, end = [], []
    for one, other in ((0, 1), (1, 0)):
        # all are densities of both sides' greys, less that of any grey on the one side, as those in `found`
        usual = sum_of_logs(any_grey[:, one])
        of_wall = (1.0 - IN_SHADOW) * lit[:, one] + IN_SHADOW * shaded[:, one] + OFF_WALL
        outline.append(sum_of_logs(of_wall) + sum_of_logs(any_grey[:, other]) - usual)
        on_wall = (1.0 - IN_SHADOW) * alike + IN_SHADOW * shaded[:, other]
        end.append(sum_of_logs(lit[:, one] * on_wall + OFF_WALL) - usual)
    found[OUTLINE] = either(*outline) - math.log(2.0)
    found[SHADOW] = either(found[SHADOW], either(*end) - math.log(2.0))


def _known_lights(found: Reals, sides: Sides, lights: KnownLights, falling: Falling | None) -> None:
    """Let known lights say what is shadow, highlight, print and outline in ``found`` (6, N), an output."""
    parts = parts_of(sides, lights)
    told = np.zeros(found.shape[1], np.bool_) if parts is None else parts.known[0]
    if parts is not None and told.any():
        fall = None if falling is None else falling.of(parts.near, parts.axis)
        less = less_crease(parts, fall)
        if lights.are_alone:  # then the parts are what the channels show
            np.copyto(found[CREASE], less.crease, where=told)
        _beside_crease(found, less, told)
    other = np.flatnonzero(~told)
    if len(other):
        some = sides.of(other)
        logs, noise = logarithms(some)
        found[CREASE, other] = either(found[CREASE, other], _turned(logs, noise) - RARER_TURNED)
        fall_to: Reals | float = 1.0
        if falling is not None and parts is None:
            fall_to = falling.of_most_changed(apparent_parts(some))
        elif falling is not None:
            fall_to = falling.of(some.near.sum(axis=0, keepdims=True), some.axis)[0]
        shadow = shadow_of_one(some, logs, noise, lights.on, KNOWN_DEPTH_SD, fall_to)
        if lights.are_alone_in_the_sun:
            at_end = np.ones(noise.shape, np.float32)
            if falling is not None:
                at_end = falling.of(apparent_parts(some).near, some.axis)[0][:-1]
            shadow = either(shadow_of_some(some, at_end), shadow - RARER_ONE)
        found[SHADOW, other] = shadow
        highlight = _touched(logs, noise)[1]
        found[HIGHLIGHT, other] = highlight - RARER_HIGHLIGHT


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _beside_crease(found: Reals, less: LessCrease, told: Flags) -> None:
    """Let what else edgels may be than creases say so in ``found`` (6, N), an output.

    Of what is not ``told`` shadow and highlight have no meaning then.
    """
    crease, shadow, highlight = found[CREASE], found[SHADOW], found[HIGHLIGHT]
    for i in range(len(told)):
        shadow[i] = crease[i] + less.shadow[i]
        highlight[i] = crease[i] + less.mirrored[i] - np.float32(RARER_HIGHLIGHT)
    printed, outline = found[PRINT], found[OUTLINE]
    for i in range(len(told)):
        more = log_of_sum(printed[i], crease[i] + less.glare[i] - np.float32(RARER_GLARE))
        printed[i] = more if told[i] else printed[i]
    for i in range(len(told)):
        more = log_of_sum(outline[i], crease[i] + less.outline[i] - np.float32(RARER_LIT))
        outline[i] = more if told[i] else outline[i]


def _turned(logs: Reals, noise: Reals) -> Reals:
    """Log-likelihood (N,) of a crease where most of the light in each image is of another lamp.

    Log-ratios do not depend on each other then, as in `kinds.each_light`.
    """
    ratio = logs[:, 0] - logs[:, 1]
    both = (1.0 - FACES_AWAY) * normal(ratio, noise + TURNED_SD**2)
    return sum_of_logs(both + FACES_AWAY * normal(ratio, noise + AWAY_SD**2))


def _touched(logs: Reals, noise: Reals) -> tuple[Reals, Reals]:
    """Log-likelihoods (N,) that light is blocked, and that it is mirrored, on one side in some channels."""
    ratio, variance = logs[:, 0] - logs[:, 1], noise + SURFACE_SD**2
    most = np.float32(2.0 * TEXTURE_SD)
    texture = np.minimum(np.maximum(_at_least(ratio, ratio * ratio / variance), -most), most)
    step = ratio - texture
    untouched = 0.5 * UNTOUCHED * (normal(step, noise + FLAT_SD**2) + normal(step, variance))
    touched = 2.0 * (1.0 - UNTOUCHED) * normal(step, variance + TOUCHED_SD**2)
    # by so much both sides are brighter than in the middle of the lights, as a share of the step
    change = np.sum(logs - _middle(logs), axis=1) / (np.abs(step) + TEXTURE_SD)
    brighter = 1.0 / (1.0 + np.exp(-np.clip(SIDE_STEEPNESS * change, -MOST_STEEP, MOST_STEEP)))
    usual = -0.5 * (texture / TEXTURE_SD) ** 2
    shadow = usual + sum_of_logs(untouched + touched * (1.0 - brighter))
    return shadow, usual + sum_of_logs(untouched + touched * brighter)


def _at_least(values: Reals, ranked: Reals) -> Field:
    """Of each column (C, N) the value where ``ranked`` is least: `argmin`, at a fifth of its time."""
    found, least = values[0].copy(), ranked[0].copy()
    for value, rank in zip(values[1:], ranked[1:], strict=True):
        np.copyto(found, value, where=rank < least)
        np.minimum(rank, least, out=least)
    return np.asarray(found, np.float32)


def _middle(logs: Reals) -> Reals:
    """Mean over the channels (C, 2, N), of three or more without the largest and the smallest."""
    if len(logs) < 3:
        return np.asarray(logs.mean(axis=0))
    return np.asarray((logs.sum(axis=0) - logs.max(axis=0) - logs.min(axis=0)) / (len(logs) - 2))
