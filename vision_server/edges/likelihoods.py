"""How likely each kind of edge is by what the channels show on both sides of an edgel: the densities.

What each kind answers to lights is in `edges.kinds`. A sum of logarithms over the channels is taken as the
logarithm of a product: that says the same at a third of the time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision_server.edges.light_parts import parts_of
from vision_server.edges.sides import Sides

Floats = NDArray[np.float64] | NDArray[np.float32]

KINDS = ("outline", "crease", "print", "shadow", "highlight", "noise")
OUTLINE, CREASE, PRINT, SHADOW, HIGHLIGHT, NOISE = range(len(KINDS))
FIXED = (OUTLINE, CREASE, PRINT)
"""Kinds of edges that are of the scene, not of its light."""

# Of log-ratios; chosen by hand on renders and photographs: `python -m benchmarks.edge_kinds`.
SURFACE_SD = 0.2  # of two places 4 px apart on one surface, from light to light: it is curved
FLAT_SD = 0.03  # of the same where it is flat
TEXTURE_SD = 0.15  # of the same in all lights alike: it is not of one grey
UNEVEN_SD = 0.1  # of both where there is no edge
FAINT_SD = 0.04  # of prints that are none
CONSTANT_SD = 0.02  # of what is the same in every light
PRINT_SD = 0.7  # of prints, and of creases in their mean light
CREASE_SD = 0.25  # of a crease from light to light
TOUCHED_SD = 1.0  # of a shadow's depth and a highlight's height
BACKGROUND_SD = 0.4  # of the background from place to place
UNKNOWN_SD = 10.0  # where a side is clipped
UNTOUCHED = 0.6  # share of the channels in which no shadow ends where one does in another
SIDE_STEEPNESS = 2.0  # how surely the side that changed tells shadow from highlight
MOST_STEEP = 30.0  # the logarithm of how surely: more changes no density and runs out of float32
ALIKE = 0.7  # share of the lights that are not blocked at a shadow's end
PART_SD = 0.7  # of a light's part of a crease from light to light
DARK_SHARE = 0.03  # of the brightest part: nothing
RARER_HIGHLIGHT = 4.0  # of its logarithm, where the lights' parts tell shadows: the rest is rather crease
FACTORS = 8  # so many values within what float32 holds have a product that float64 holds


def either(first: Floats | float, second: Floats) -> Floats:
    """Logarithm of the sum of what two logarithms are of: `np.logaddexp`, at many times its speed."""
    return np.asarray(np.maximum(first, second) + np.log(1.0 + np.exp(-np.abs(first - second))))


def sum_of_logs(values: Floats) -> NDArray[np.float64]:
    """Sum over the rows (C, N) of the logarithms of values within what float32 holds, float64 (N,)."""
    parts = range(0, len(values), FACTORS)
    products = [np.multiply.reduce(values[part : part + FACTORS], dtype=np.float64) for part in parts]
    return np.asarray(sum(np.log(product) for product in products))


def log_normal(x: Floats, variance: Floats) -> Floats:
    """Logarithm of the density of a Gaussian of mean 0."""
    return np.asarray(-0.5 * (x * x / variance + np.log(2.0 * np.pi * variance)))


def normal(x: Floats, variance: Floats) -> Floats:
    """Density of a Gaussian of mean 0."""
    return np.asarray(np.exp(-0.5 * x * x / variance) / np.sqrt(2.0 * np.pi * variance))


class Scatter(NamedTuple):
    """What is needed of values (C, N) of known variances to say how likely they are; (N,) each.

    Attributes
    ----------
    alone
        Logarithm of their density as Gaussians of mean 0.
    precision, pull
        Sums of 1 / variance, and of value / variance.
    """

    alone: Floats
    precision: Floats
    pull: Floats

    @classmethod
    def of(cls, x: Floats, variance: Floats) -> Scatter:
        """Of values (C, N) and their variances."""
        precision = 1.0 / variance
        pull = x * precision
        alone = -0.5 * (np.sum(pull * x, axis=0) + sum_of_logs(2.0 * np.pi * variance))
        return cls(alone, precision.sum(axis=0), pull.sum(axis=0))

    def about_a_mean(self, sd: float) -> Floats:
        """Log-likelihood (N,) that they scatter about a mean for each column, which itself is N(0, sd^2)."""
        wider = 1.0 + sd**2 * self.precision
        return np.asarray(self.alone + 0.5 * (sd * self.pull) ** 2 / wider - 0.5 * np.log(wider))


def likelihoods(sides: Sides, background: float, levels: NDArray[np.float64] | None = None) -> Floats:
    """Log-likelihood of each kind.

    Parameters
    ----------
    sides
        Of N edgels.
    background
        Grey of the background at reference exposure.
    levels
        float64 (C, L), of the lamps in each channel, as a share of the full one, where they are known.

    Returns
    -------
    float32 (6, N).
    """
    logs, noise = _logarithms(sides)
    ratio, surface = logs[:, 0] - logs[:, 1], noise + SURFACE_SD**2
    found = np.empty((len(KINDS), ratio.shape[1]), ratio.dtype)
    darkness = _darker_side(sides) - np.log(background + sides.dark)
    constant = Scatter.of(ratio, noise + CONSTANT_SD**2)
    found[OUTLINE] = Scatter.of(darkness, surface).about_a_mean(BACKGROUND_SD)
    found[CREASE] = Scatter.of(ratio, surface + CREASE_SD**2).about_a_mean(PRINT_SD)
    found[PRINT] = constant.about_a_mean(PRINT_SD)
    uneven = Scatter.of(ratio, noise + UNEVEN_SD**2).about_a_mean(UNEVEN_SD)
    found[NOISE] = either(constant.about_a_mean(FAINT_SD), uneven) - np.log(2.0)
    shadow, found[HIGHLIGHT] = _touched(logs, ratio, noise)
    parts = None if levels is None else parts_of(sides, levels)
    if parts is None or not parts.known.all():
        found[SHADOW] = either(shadow, _steady_shadow(sides, logs, noise)) - np.log(2.0)
    if parts is not None:
        found[SHADOW] = np.where(parts.known[0], found[CREASE] + _blocked_less_crease(parts), found[SHADOW])
        found[HIGHLIGHT] -= RARER_HIGHLIGHT
    return found


def _blocked_less_crease(parts: Sides) -> Floats:
    """Log-likelihood (N,) that lights are blocked on one side and else alike, less that of a crease."""
    logs, noise = _logarithms(parts)
    ratio = logs[:, 0] - logs[:, 1]
    near = np.maximum(parts.near, 0.0)
    darker, variance = near.min(axis=1), parts.noise**2 + (DARK_SHARE * near.max(axis=(0, 1))) ** 2
    # the density of nothing but noise, on either side, as one of the logarithm
    blocked = log_normal(darker, variance) + np.log(0.5 * (darker + parts.dark))
    alike = log_normal(ratio, noise + FLAT_SD**2)
    shadow = either(np.log(ALIKE) + alike, np.log(1.0 - ALIKE) + blocked).sum(axis=0)
    return np.asarray(shadow - Scatter.of(ratio, noise + PART_SD**2).about_a_mean(PRINT_SD))


def _touched(logs: Floats, ratio: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Log-likelihoods (N,) that light is blocked, and that it is mirrored, on one side in some channels."""
    variance = noise + SURFACE_SD**2
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


def _at_least(values: Floats, ranked: Floats) -> NDArray[np.float32]:
    """Of each column (C, N) the value where ``ranked`` is least: `argmin`, at a fifth of its time."""
    found, least = values[0].copy(), ranked[0].copy()
    for value, rank in zip(values[1:], ranked[1:], strict=True):
        np.copyto(found, value, where=rank < least)
        np.minimum(rank, least, out=least)
    return np.asarray(found, np.float32)


def _middle(logs: Floats) -> Floats:
    """Mean over the channels (C, 2, N), of three or more without the largest and the smallest."""
    if len(logs) < 3:
        return np.asarray(logs.mean(axis=0))
    return np.asarray((logs.sum(axis=0) - logs.max(axis=0) - logs.min(axis=0)) / (len(logs) - 2))


def _steady_shadow(sides: Sides, logs: Floats, noise: Floats) -> Floats:
    """Log-likelihood (N,) of the shadow of a light that is on in all channels: it adds as much to each."""
    variance, light = noise + CONSTANT_SD**2, np.exp(logs)
    weight = 1.0 / (variance * light.max(axis=1) ** 2)
    added = np.sum(weight * (sides.near[:, 0] - sides.near[:, 1]), axis=0) / weight.sum(axis=0)
    shaded = np.where(added > 0.0, light[:, 1], light[:, 0])
    ratio = np.sign(added) * np.log1p(np.abs(added) / shaded)
    precision = np.sum(1.0 / variance, axis=0)
    depth = np.sum(ratio / variance, axis=0) / precision
    prior = -0.5 * (np.log1p(PRINT_SD**2 * precision) + (depth / PRINT_SD) ** 2)
    return np.asarray(Scatter.of(logs[:, 0] - logs[:, 1] - ratio, variance).alone + prior)


def _logarithms(sides: Sides) -> tuple[Floats, Floats]:
    """Logarithms of the intensities (C, 2, N), and the variance (C, N) of their difference from noise.

    Where both sides are dark or one is clipped the difference says nothing, and its variance is large.
    """
    near = np.maximum(sides.near, 0.0) + np.float32(sides.dark)
    noise = np.sum(np.square(sides.noise[:, None] / near), axis=1)
    unlit = np.square(np.square(np.float32(sides.dark) / near.max(axis=1)))
    return np.log(near), noise + unlit + np.where(sides.known, np.float32(0.0), np.float32(UNKNOWN_SD**2))


def _darker_side(sides: Sides) -> Floats:
    """Logarithm (C, N) of the largest intensity on the side that is the darker one in its best light."""
    lit = sides.brightest.max(axis=0)
    darker = np.where(lit[0] < lit[1], sides.brightest[:, 0], sides.brightest[:, 1])
    return np.asarray(np.log(np.maximum(darker, 0.0) + np.float32(sides.dark)))
