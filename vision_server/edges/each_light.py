"""Shadows by what each light gives to both sides of an edgel, where that is known (`edges.light_parts`).

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

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vision_server.edges.densities import Floats, any_of, either, log_normal, logarithms
from vision_server.edges.sides import Sides

# As measured on simulated creases (`benchmarks.edge_kinds`), where the log-ratios of two lights do not depend
# on each other.
TURNED_SD = 0.8  # of a light's log-ratio between two faces
# Chosen by hand there.
FACES_AWAY = 0.1  # share of the lights that reach only one of the faces
FLAT_SD = 0.04  # of a log-ratio of two places 4 px apart on one flat surface
DARK_SHARE = 0.03  # of what the brightest light gives: nothing
TWO_ENDS = 0.15  # share of the shadows' ends beside which another light's shadow ends
IN_PART = 0.3  # share of the lights with such an end that still give something
ON_PRINT = 0.1  # share of the shadows' ends that lie on a print
SHADED_PRINT_SD = 0.2  # of the log-ratio of that print
GLARING_PRINT_SD = 0.7  # of the log-ratio of prints that a light is mirrored in
BEHIND = 0.3  # share of the lights that are missing behind an outline, before a surface that is alike
BEHIND_ANY = 0.5  # before any other, and on the same side
RARER_ANY = 1.0  # of the logarithm of an outline before any other, beside those before one that is alike
SUREST = 12.0  # the logarithm of how sure one light alone may be


class EachLight(NamedTuple):
    """Log-likelihoods that each of L lights is alike, gives nothing to the darker side, and is turned.

    Each is less that of what it is at a crease; float32 (L, N).
    """

    alike: Floats
    nothing: Floats
    turned: Floats


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
    """

    shadow: Floats
    outline: Floats
    mirrored: Floats
    glare: Floats


def less_crease(parts: Sides, dark_side: tuple[Floats, Floats] | None = None) -> LessCrease:
    """What else than a crease N edgels may be.

    Parameters
    ----------
    parts
        What each of L lights gives to both sides of N edgels.
    dark_side
        As `falling.Falling.of` gives it; else the dark side of a shadow may be on any side.
    """
    logs, noise = logarithms(parts)
    ratio = logs[:, 0] - logs[:, 1]
    each, count = _each_light(parts, ratio, noise), len(parts.noise)
    at_end, behind = (np.ones_like(each.alike),) * 2 if dark_side is None else dark_side
    sure = EachLight(*(np.asarray(np.clip(value, -SUREST, SUREST), np.float32) for value in each))
    base = sure.alike.sum(axis=0)
    nothing, turned = np.exp(sure.nothing - sure.alike), np.exp(sure.turned - sure.alike)
    others_alike = _but_one(each.alike, ratio, noise)
    clear_end = base + np.log1p(-ON_PRINT) + _log(_shadow_end(at_end * nothing, turned))
    printed_end = any_of(each.nothing + np.log(at_end) + others_alike(SHADED_PRINT_SD))
    before_any = _before_any(parts, turned, behind * nothing) - RARER_ANY
    return LessCrease(
        shadow=either(clear_end, printed_end + np.log(ON_PRINT)),
        outline=base + either(_before_alike(behind * nothing), before_any),
        mirrored=base + _log(turned.sum(axis=0) / count),
        glare=any_of(sure.turned + others_alike(GLARING_PRINT_SD)),
    )


def _log(values: Floats) -> Floats:
    return np.asarray(np.log(np.maximum(values, np.finfo(values.dtype).tiny)))


def _shadow_end(nothing: Floats, turned: Floats) -> Floats:
    """How much likelier than that all lights are alike, (N,): one of them ends, or two do."""
    count = len(nothing)
    end = (1.0 - IN_PART) * nothing + IN_PART * turned
    one = two = np.zeros_like(nothing[0])
    for another_end in end:
        two, one = two + one * another_end, one + another_end
    pairs = max(count * (count - 1) / 2, 1.0)
    return np.asarray((1.0 - TWO_ENDS) / count * nothing.sum(axis=0) + TWO_ENDS / pairs * two)


def _before_alike(nothing: Floats) -> Floats:
    """Logarithm of how much likelier than all lights alike, (N,): some are missing, the others alike."""
    share = 1.0 - BEHIND + BEHIND * nothing
    return _log(np.prod(share, axis=0, dtype=np.float64) - (1.0 - BEHIND) ** len(nothing))


def _before_any(parts: Sides, turned: Floats, nothing: Floats) -> Floats:
    """Logarithm of how much likelier than all lights alike, (N,): each is turned, or missing behind."""
    turned, missing = (1.0 - BEHIND_ANY) * turned, BEHIND_ANY * nothing
    darker = parts.near[:, 0] < parts.near[:, 1]
    # the density of nothing is of either side: that of the one that is behind is twice as large
    each = (turned + 2.0 * missing * side for side in (darker, ~darker))
    return _log(sum(0.5 * np.prod(of_side, axis=0, dtype=np.float64) for of_side in each))


def _but_one(alike: Floats, ratio: Floats, noise: Floats) -> Callable[[float], Floats]:
    """How much likelier than a crease, (L, N): all lights but one have the same log-ratio, N(0, sd^2)."""
    precision = 1.0 / (noise + FLAT_SD**2)
    pull = ratio * precision
    alike, precision, pull = (value.sum(axis=0) - value for value in (alike, precision, pull))

    def of(sd: float) -> Floats:
        wider = 1.0 + sd**2 * precision
        return np.asarray(alike + 0.5 * ((sd * pull) ** 2 / wider - np.log(wider)))

    return of


def _each_light(parts: Sides, ratio: Floats, noise: Floats) -> EachLight:
    """What each light by itself is to N edgels, by their log-ratios and their variances, (L, N) each."""
    near = np.maximum(parts.near, 0.0)
    darker, variance = near.min(axis=1), parts.noise**2 + (DARK_SHARE * near.max(axis=(0, 1))) ** 2
    # the density of nothing but noise, on either side, as one of the log-ratio
    nothing = log_normal(darker, variance) + np.log(0.5 * (darker + parts.dark))
    turned = log_normal(ratio, noise + TURNED_SD**2)
    crease = either(turned + np.log(1.0 - FACES_AWAY), nothing + np.log(FACES_AWAY))
    alike = log_normal(ratio, noise + FLAT_SD**2)
    return EachLight(alike - crease, nothing - crease, turned - crease)
