"""What kind each edgel is: the paper's mixture of true edge and rest, grown up: its components are kinds.

The light was changed on purpose, and each kind of edge answers that in its own way. With a and b the
intensities on both sides of an edgel in each channel, at reference exposure, and r = log a - log b:

- *outline*: the darker side is background: as far as it is looked at it is as dark as that in every light.
- *crease*: r changes with the light's direction.
- *print*: r is the same in every light.
- *shadow*: r = 0, but for the channels whose light is blocked on one side, and there that side is darker than
  else. Or the shadow is of a light that is on in all channels, as the sun: then a - b is the same in all.
- *highlight*: r = 0, but for the channels whose light is mirrored on one side: there that side is brighter.
- *noise*: r = 0.

All of it up to noise, and to what surfaces do to r beside their edges. Where the lights' levels are known,
shadows are looked for in each light's own part of the intensities (`edges.light_parts`). Neighbours on one
edge are of one kind (`edges.along`). `likelihoods` states the densities,
`fit_kinds` is EM: how likely each edgel is of each kind, given how frequent the kinds are (E-step), and how
frequent they are, given that (M-step). The orientations of the channels are mixed before (`edges.mixture`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from vision_server.channels.channel import ChannelStatistics
from vision_server.edges.along import mean_along
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.light_parts import parts_of
from vision_server.edges.merging import merge_channels
from vision_server.edges.sides import Sides, evenly_weighted, sides_of

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
BACKGROUND_SHARE = 0.02  # of the pixels, in their best lights, that are darker than what counts as background
SAMPLE_STEP = 4  # of the pixels that are ranked for it
ALIKE = 0.7  # share of the lights that are not blocked at a shadow's end
PART_SD = 0.7  # of a light's part of a crease from light to light
DARK_SHARE = 0.03  # of the brightest part: nothing
RARER_HIGHLIGHT = 4.0  # of its logarithm, where the lights' parts tell shadows: the rest is rather crease
EM_ITERATIONS = 10  # more change no probability by 0.01
LEAST_LOG = -8.0  # of a likelihood, beside the edgel's largest: no single edgel is surer
COHERENCE = 1.3  # edgels that neighbours on the same edge count for: what misleads one misleads them, too
LEAST_SHARE = 1e-3  # of a kind: one that is absent may come
LEAST_CLEAR = 0.5  # share of a channel's edges that are not beside clipped pixels


class EdgeKinds(NamedTuple):
    """The edgels of an image set with what kinds they are.

    Attributes
    ----------
    edges
        N edgels, merged with all channels alike: those of shadows and highlights are among them.
    sides
        What the channels show beside them.
    probability
        float64 (6, N), of each of KINDS; they sum to 1.
    share
        float64 (6,), how frequent the kinds are.
    used
        Numbers of the channels that they are told by: those that are not black, white or clipped.
    """

    edges: EdgeMap
    sides: Sides
    probability: Floats
    share: Floats
    used: tuple[int, ...]

    def of_kinds(self, kinds: Sequence[int]) -> EdgeMap:
        """The edgels, as strong as they are likely to be of these kinds.

        What is fixed is as strong as the step between its sides, each in its best light; what is of the light
        is as strong as in the channel that shows it best.
        """
        near = self.sides.near
        if set(kinds) <= set(FIXED):
            step = np.abs(near[:, 0].max(axis=0) - near[:, 1].max(axis=0))
        else:
            step = np.abs(near[:, 0] - near[:, 1]).max(axis=0)
        strength = (step * self.probability[list(kinds)].sum(axis=0)).astype(np.float32)
        return replace(self.edges, strength=strength)


def either(first: Floats | float, second: Floats) -> Floats:
    """Logarithm of the sum of what two logarithms are of: `np.logaddexp`, at many times its speed."""
    return np.asarray(np.maximum(first, second) + np.log(1.0 + np.exp(-np.abs(first - second))))


def log_normal(x: Floats, variance: Floats) -> Floats:
    """Logarithm of the density of a Gaussian of mean 0."""
    return np.asarray(-0.5 * (x * x / variance + np.log(2.0 * np.pi * variance)))


def log_normal_of_one_mean(x: Floats, variance: Floats, mean: float, sd: float) -> Floats:
    """The same of values (C, N) that scatter around a mean for each column, which itself is N(mean, sd^2)."""
    x = x - mean
    precision, pull = np.sum(1.0 / variance, axis=0), np.sum(x / variance, axis=0)
    wider = 1.0 + sd**2 * precision
    return np.asarray(
        log_normal(x, variance).sum(axis=0) + 0.5 * (sd * pull) ** 2 / wider - 0.5 * np.log(wider)
    )


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
    float64 (6, N).
    """
    logs, noise = _logarithms(sides)
    ratio, surface = logs[:, 0] - logs[:, 1], noise + SURFACE_SD**2
    found = np.empty((len(KINDS), ratio.shape[1]), ratio.dtype)
    darkness = _darker_side(sides) - np.log(background + sides.dark)
    found[OUTLINE] = log_normal_of_one_mean(darkness, surface, 0.0, BACKGROUND_SD)
    found[CREASE] = log_normal_of_one_mean(ratio, surface + CREASE_SD**2, 0.0, PRINT_SD)
    found[PRINT] = log_normal_of_one_mean(ratio, noise + CONSTANT_SD**2, 0.0, PRINT_SD)
    even = log_normal_of_one_mean(ratio, noise + CONSTANT_SD**2, 0.0, FAINT_SD)
    uneven = log_normal_of_one_mean(ratio, noise + UNEVEN_SD**2, 0.0, UNEVEN_SD)
    found[NOISE] = either(even, uneven) - np.log(2.0)
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
    return np.asarray(shadow - log_normal_of_one_mean(ratio, noise + PART_SD**2, 0.0, PRINT_SD))


def _touched(logs: Floats, ratio: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Log-likelihoods (N,) that light is blocked, and that it is mirrored, on one side in some channels."""
    variance = noise + SURFACE_SD**2
    least = np.abs(ratio / np.sqrt(variance)).argmin(axis=0)[None]
    texture = np.clip(np.take_along_axis(ratio, least, axis=0), -2.0 * TEXTURE_SD, 2.0 * TEXTURE_SD)
    step = ratio - texture
    flat, curved = log_normal(step, noise + FLAT_SD**2), log_normal(step, variance)
    untouched = np.log(0.5 * UNTOUCHED) + either(flat, curved)
    touched = np.log(2.0 * (1.0 - UNTOUCHED)) + log_normal(step, variance + TOUCHED_SD**2)
    # by so much both sides are brighter than in the middle of the lights, as a share of the step
    change = np.sum(logs - _middle(logs), axis=1) / (np.abs(step) + TEXTURE_SD)
    usual = -0.5 * (texture[0] / TEXTURE_SD) ** 2
    darker, brighter = (
        usual + either(untouched, touched - either(0.0, sign * SIDE_STEEPNESS * change)).sum(axis=0)
        for sign in (1.0, -1.0)
    )
    return darker, brighter


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
    return np.asarray(log_normal(logs[:, 0] - logs[:, 1] - ratio, variance).sum(axis=0) + prior)


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


def fit_kinds(likelihood: Floats) -> tuple[Floats, Floats]:
    """Probability (6, N) of each kind for each edgel, and how frequent they are (6,), by EM."""
    share = np.full(len(KINDS), 1.0 / len(KINDS))
    likely = np.exp(likelihood - likelihood.max(axis=0)).astype(np.float64)
    for _ in range(EM_ITERATIONS):
        # E-step: the probability of a kind is its share times its likelihood, over the sum of these
        # M-step: how frequent the kinds are is the mean of that
        share = np.maximum(share * (likely @ (1.0 / (share @ likely))) / likely.shape[1], LEAST_SHARE)
        share /= share.sum()
    return likely * share[:, None] / (share @ likely), share


def background_grey(channels: Sequence[ChannelStatistics]) -> float:
    """Grey at reference exposure that only few pixels stay under in their best light."""
    sampled = [
        channel.linear[::SAMPLE_STEP, ::SAMPLE_STEP] / np.float32(channel.exposure) for channel in channels
    ]
    return float(np.quantile(np.max(sampled, axis=0), BACKGROUND_SHARE))


def edge_kinds(channels: Sequence[ChannelStatistics], levels: NDArray[np.float64] | None = None) -> EdgeKinds:
    """The edgels of a set of at least two channels, and their kinds.

    Parameters
    ----------
    levels
        As in `likelihoods`.

    Raises
    ------
    BadInput
        Fewer channels: no light was changed; or channels of different sizes.
    """
    if len(channels) < 2:
        raise BadInput("The kinds of edges need images under different lights.", "Give two images or more.")
    used = [number for number, channel in enumerate(channels) if tells(channel)]
    if len(used) < 2:
        used = list(range(len(channels)))
    edges = merge_channels([evenly_weighted(channels[number]) for number in used])
    return kinds_of(edges, None if levels is None else levels[used], tuple(used))


def tells(channel: ChannelStatistics) -> bool:
    """Whether a channel is neither black nor white, and most of its edges are not beside clipped pixels."""
    y, x = np.divmod(channel.gradient.places, np.int32(channel.shape[1]))
    clear = channel.light.clear
    seen = clear[np.minimum(y >> 1, clear.shape[0] - 1), np.minimum(x >> 1, clear.shape[1] - 1)]
    return len(seen) > 0 and bool(seen.mean() >= LEAST_CLEAR)


def kinds_of(
    edges: EdgeMap, levels: NDArray[np.float64] | None = None, used: tuple[int, ...] = ()
) -> EdgeKinds:
    """The kinds of the edgels of a merged set, of which ``used`` says which of some channels it is of."""
    sides = sides_of(edges)
    if len(edges) == 0:
        none = np.zeros((len(KINDS), 0)), np.full(len(KINDS), 1.0 / len(KINDS))
        return EdgeKinds(edges, sides, *none, used)
    likelihood = likelihoods(sides, background_grey(edges.channels), levels)
    likelihood = np.maximum(likelihood - likelihood.max(axis=0), LEAST_LOG)
    return EdgeKinds(edges, sides, *fit_kinds(COHERENCE * mean_along(edges, likelihood)), used)
