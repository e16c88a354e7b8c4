"""Shadows by what each light gives to both sides of an edgel, where that is known (`edges.light_parts`).

To an edge, one light by itself is one of three things:

- *alike*: it gives the same to both sides;
- *nothing*: on one side it gives nothing;
- *turned*: it gives any amount to either side.

At the end of a shadow one light gives nothing to one side, and all others are alike. Now and then the ends of
two lights' shadows lie within what is read of the sides: then two are not alike, and the second one may be
seen in part. Behind an outline two lights or more may be missing, where a surface in its shadow is like the
one before it. At a crease each light is turned, or falls on one of the faces only, whatever the others do:
that all others are alike is then a coincidence.

All are told as the logarithm of how much likelier they are than a crease.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vision_server.edges.densities import Floats, either, log_normal, logarithms
from vision_server.edges.sides import Sides

# As measured on simulated creases (`benchmarks.edge_kinds`), where the log-ratios of two lights do not depend
# on each other.
TURNED_SD = 0.8  # of a light's log-ratio between two faces
# Chosen by hand there.
FACES_AWAY = 0.1  # share of the lights that reach only one of the faces
FLAT_SD = 0.04  # of a log-ratio of two places 4 px apart on one flat surface
DARK_SHARE = 0.03  # of what the brightest light gives: nothing
TWO_ENDS = 0.1  # share of the shadows' ends beside which another light's shadow ends
IN_PART = 0.3  # share of the lights with such an end that still give something
BEHIND = 0.3  # share of the lights that are missing behind an outline
SUREST = 12.0  # the logarithm of how sure one light alone may be


def less_crease(parts: Sides) -> tuple[Floats, Floats]:
    """How much likelier than a crease a shadow's end is, and an outline before a surface that is alike.

    Parameters
    ----------
    parts
        What each of L lights gives to both sides of N edgels.

    Returns
    -------
    Differences of log-likelihoods, (N,) each.
    """
    count = len(parts.noise)
    alike, nothing, turned = _each(parts)
    base = alike.sum(axis=0)
    nothing, turned = np.exp(nothing - alike), np.exp(turned - alike)
    end = (1.0 - IN_PART) * nothing + IN_PART * turned
    missing = BEHIND / (1.0 - BEHIND) * nothing
    first = two = one_missing = several = np.zeros_like(base)
    for another_end, is_missing in zip(end, missing, strict=True):
        two, first = two + first * another_end, first + another_end
        several = several * (1.0 + is_missing) + one_missing * is_missing
        one_missing = one_missing + is_missing
    pairs = max(count * (count - 1) / 2, 1.0)
    shadow = (1.0 - TWO_ENDS) / count * nothing.sum(axis=0) + TWO_ENDS / pairs * two
    least = np.finfo(base.dtype).tiny
    outline = np.log(np.maximum(several, least)) + count * np.log(1.0 - BEHIND)
    return base + np.log(np.maximum(shadow, least)), base + outline


def _each(parts: Sides) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Log-likelihoods (L, N) that each light is alike, gives nothing to the darker side, and is turned, each
    less that of what it is at a crease."""
    logs, noise = logarithms(parts)
    ratio, near = logs[:, 0] - logs[:, 1], np.maximum(parts.near, 0.0)
    darker, variance = near.min(axis=1), parts.noise**2 + (DARK_SHARE * near.max(axis=(0, 1))) ** 2
    # the density of nothing but noise, on either side, as one of the log-ratio
    nothing = log_normal(darker, variance) + np.log(0.5 * (darker + parts.dark))
    turned = log_normal(ratio, noise + TURNED_SD**2)
    crease = either(turned + np.log(1.0 - FACES_AWAY), nothing + np.log(FACES_AWAY))
    alike = log_normal(ratio, noise + FLAT_SD**2)
    sure = (np.clip(value - crease, -SUREST, SUREST) for value in (alike, nothing, turned))
    alike, nothing, turned = (value.astype(np.float64) for value in sure)
    return alike, nothing, turned
