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
exactly one of them is blocked at a shadow's end (`kinds.each_light`, `kinds.blocked`), on the side towards it
(`kinds.falling`). Neighbours on one edge are of one kind (`kinds.along`). `kinds.likelihoods` states the
densities, `fit_kinds` is EM: how likely each edgel is of each kind, given how frequent the kinds are
(E-step), and how frequent they are, given that (M-step). The orientations of the channels are mixed before
(`edges.mixture`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from numerics.arrays import Field, Floats, Grey, Ints, Reals
from numerics.kernels import kernel
from numerics.logarithm import ONE, ZERO
from vision_server.channels.channel import ChannelStatistics
from vision_server.channels.depth import rounded
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.merging import merge_channels
from vision_server.kinds.along import mean_along
from vision_server.kinds.background import Background, background_of
from vision_server.kinds.dark_room import lamps_in_the_dark
from vision_server.kinds.fading import with_fading
from vision_server.kinds.falling import Falling, learn_falling
from vision_server.kinds.ground import ONE as ONE_SIDE
from vision_server.kinds.learnt_lights import learnt_lights
from vision_server.kinds.light_parts import KnownLights, apparent_parts, known_lights, lights_of, parts_of
from vision_server.kinds.likelihoods import FIXED, KINDS, NOISE, OUTLINE, SHADOW, likelihoods
from vision_server.kinds.sides import DARK_GREY, Sides, evenly_weighted, sides_of

TOLD, LEARNT, UNKNOWN = "told", "learnt", "unknown"
"""Where the levels of the lights are from."""

# Chosen by hand on renders and photographs: `python -m benchmarks.edge_kinds`.
SAMPLE_STEP = 16  # of the pixels that say whether a channel tells kinds
FALLING_STEP = 8  # of the edgels that say where lights are: with every fourth one nothing is surer
SUMMED = 1024  # edgels whose sums of likelihoods the processor's cache holds
EM_ITERATIONS = 10  # more change no probability by 0.01
LEAST_LOG = -8.0  # of a likelihood, beside the edgel's largest: no single edgel is surer
# Edgels that neighbours on the same edge count for: what misleads one misleads them, too, less so where each
# light's part is known.
COHERENCE, KNOWN_COHERENCE = 1.3, 2.5
LESS_SURE = 0.6  # of the logarithm of one kind to another but outline, where levels are unknown
MEAN_FLOOR_RATIO = 5.0  # a mean contrast under so many standard deviations of its own noise is none
LEAST = 1e-12  # of a probability
LEAST_SHARE = 0.03  # of a kind: one that is absent may come
LEAST_CLEAR = 0.5  # share of a channel's edges that are not beside clipped pixels
# Of the share of the middle one of the set: of twelve photographs the least has .90 of it, of six drawn
# statues' images that are 4 and 12 times overexposed the most has .77 (`benchmarks.statues`).
LEAST_CLEAR_OF_MIDDLE = 0.83
# Share of a channel's edges that are beside what is lit and so many standard deviations out of its noise: of
# those of a black one, which are its noise, none is.
LEAST_SURE, SURE_RATIO = 0.01, 6.0


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
    levels
        TOLD; LEARNT, all from the images; or UNKNOWN, of some lamps or of all: then creases, shadows and
        highlights are easily taken for each other.
    """

    edges: EdgeMap
    sides: Sides
    probability: Reals
    share: Reals
    used: tuple[int, ...]
    levels: str

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


def fit_kinds(likelihood: Reals) -> tuple[Reals, Reals]:
    """Probability (6, N) of each kind for each edgel, and how frequent they are (6,), by EM."""
    likely = np.exp(likelihood - likelihood.max(axis=0), dtype=np.float32)
    share = _shares_of_kinds(likely)
    return likely * share[:, None] / (share @ likely), share


@kernel()
def less_sure_shadows(probability: Reals) -> None:
    """Let shadows (6, N) that are likelier than all else but outlines have the root of their odds.

    Lights that were found in the images mislead edgels alike, which no density knows. The likeliest kind
    stays the likeliest.
    """
    for i in range(probability.shape[1]):
        others = 1.0 - probability[OUTLINE, i]
        rest = others - probability[SHADOW, i]
        if rest < probability[SHADOW, i]:
            root, of_rest = np.sqrt(probability[SHADOW, i]), np.sqrt(max(rest, LEAST))
            shadow = others * root / (root + of_rest)
            for kind in range(len(probability)):
                if kind not in (OUTLINE, SHADOW):
                    probability[kind, i] *= (others - shadow) / max(rest, LEAST)
            probability[SHADOW, i] = shadow


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _shares_of_kinds(likely: Field) -> Floats:
    """How frequent kinds are (K,), by how likely N edgels are of each (K, N)."""
    kinds, count = likely.shape
    share, of_all = np.full(kinds, 1.0 / kinds), np.empty(SUMMED, np.float32)
    for _ in range(EM_ITERATIONS):
        sums = np.zeros(kinds)
        for first in range(0, count, SUMMED):
            some = min(SUMMED, count - first)
            # E-step: the probability of a kind is its share times its likelihood, over the sum of these
            of_all[:] = ZERO
            for kind in range(kinds):
                row, of_kind = likely[kind, first : first + some], np.float32(share[kind])
                for i in range(some):
                    of_all[i] += of_kind * row[i]
            for i in range(some):
                of_all[i] = ONE / of_all[i]
            for kind in range(kinds):
                row, total = likely[kind, first : first + some], ZERO
                for i in range(some):
                    total += row[i] * of_all[i]
                sums[kind] += total
        # M-step: how frequent the kinds are is the mean of that
        share = np.maximum(share * sums / count, LEAST_SHARE)
        share /= share.sum()
    return share


def edge_kinds(
    channels: Sequence[ChannelStatistics],
    levels: Floats | None = None,
    images: Sequence[int] | None = None,
) -> EdgeKinds:
    """The edgels of a set of at least two channels, and their kinds; one that is given twice counts once.

    Parameters
    ----------
    levels
        float64 (C, L), of the lamps in each channel, as a share of the full one, where they are known.
    images
        Number of the image that each channel is of, where colours of one image are channels of their own:
        they are of one light.

    Raises
    ------
    BadInput
        Fewer that differ: no light was changed; or channels of different sizes.
    """
    once = different(channels)
    if len(once) < 2:
        raise BadInput("The kinds of edges need images under different lights.", "Give two images or more.")
    used = [once[number] for number in telling([channels[number] for number in once])]
    # the noise of one channel tells nothing of another's: that of their mean is so much smaller
    floor_ratio = MEAN_FLOOR_RATIO / math.sqrt(len(used))
    edges = merge_channels([evenly_weighted(channels[number]) for number in used], floor_ratio)
    told, of = (None if one is None else np.asarray(one)[used] for one in (levels, images))
    return kinds_of(with_fading(edges), told, tuple(used), of)


def different(channels: Sequence[ChannelStatistics]) -> list[int]:
    """Numbers of the channels that are not alike to the last pixel to an earlier one."""
    return [
        number
        for number, channel in enumerate(channels)
        if not any(channel.same_picture(earlier) for earlier in channels[:number])
    ]


def telling(channels: Sequence[ChannelStatistics]) -> list[int]:
    """Numbers of the channels that are neither black, white nor clipped more than most; all if one is left.

    Where a set is clipped alike, as before a white table, what is clipped is left out edge by edge instead.
    """
    clear, sure = np.array([_clear_and_sure(channel) for channel in channels]).T
    right = (clear >= LEAST_CLEAR) & (sure >= LEAST_SURE)
    if right.any():
        right &= clear >= LEAST_CLEAR_OF_MIDDLE * np.median(clear[right])
    return np.flatnonzero(right).tolist() if right.sum() > 1 else list(range(len(channels)))


def _clear_and_sure(channel: ChannelStatistics) -> tuple[float, float]:
    """Shares of a channel's edges that are not beside clipped pixels, and that stand out where it is lit."""
    light, gradient = channel.light, channel.gradient
    level, of_channel = rounded(light.level), (channel.shape[1], channel.clipped_from)
    return _shares(gradient.places, gradient.magnitude, level, light.noise_of, light.reach, of_channel)


@kernel()
def _shares(
    places: NDArray[np.int32], magnitude: Field, level: Grey, noise_of: Field, reach: int,
    of_channel: tuple[int, int],
) -> tuple[float, float]:  # fmt: skip
    """As `_clear_and_sure`, of some of N gradients; ``of_channel``: its width, and grey that is clipped."""
    rows, columns = level.shape
    width, clipped_from = of_channel
    some = clear = sure = 0
    for i in range(0, len(places), SAMPLE_STEP):
        y = places[i] // width
        v, u = min(y >> 1, rows - 1), min((places[i] - y * width) >> 1, columns - 1)
        brightest = 0
        for near_v in range(max(v - reach, 0), min(v + reach + 1, rows)):
            for near_u in range(max(u - reach, 0), min(u + reach + 1, columns)):
                brightest = max(brightest, level[near_v, near_u])
        some += 1
        clear += brightest < clipped_from
        sure += (brightest > DARK_GREY) & (magnitude[i] >= SURE_RATIO * noise_of[level[v, u]])
    return clear / max(some, 1), sure / max(some, 1)


def kinds_of(
    edges: EdgeMap, levels: Floats | None = None, used: tuple[int, ...] = (), images: Ints | None = None
) -> EdgeKinds:
    """The kinds of the edgels of a merged set, of which ``used`` says which of some channels it is of.

    ``levels`` and ``images`` are those of these, as in `edge_kinds`.
    """
    sides = sides_of(edges)
    if len(edges) == 0:
        none = np.zeros((len(KINDS), 0)), np.full(len(KINDS), 1.0 / len(KINDS))
        return EdgeKinds(edges, sides, *none, used, _levels_from(levels, None))
    background = background_of(edges, sides)
    is_wall = background.wall is not None
    lights = _learnt(sides, is_wall, images) if levels is None else known_lights(levels)
    if levels is not None and lights is not None and lights.share is None:
        lights = lamps_in_the_dark(levels, sides) or lights
    falling = _falling_of(sides, background, lights)
    likelihood = likelihoods(sides, background, lights, falling)
    likelihood -= likelihood.max(axis=0)
    np.maximum(likelihood, LEAST_LOG, out=likelihood)
    found = _levels_from(levels, lights)
    likelihood = (COHERENCE if levels is None else KNOWN_COHERENCE) * mean_along(edges, likelihood)
    if found == UNKNOWN:
        others = [kind for kind in range(len(KINDS)) if kind != OUTLINE]
        best = likelihood[others].max(axis=0)
        likelihood[others] = best + LESS_SURE * (likelihood[others] - best)
    probability, share = fit_kinds(likelihood)
    if found == LEARNT:
        less_sure_shadows(probability)
    if background.met is not None:
        # what fades and is no contour, as it does not meet the ground, the merge was right to leave out
        left_out = np.flatnonzero((edges.mass == 0.0) & (background.met != ONE_SIDE))
        probability[:, left_out] = np.eye(len(KINDS))[:, [NOISE]]
    return EdgeKinds(edges, sides, probability, share, used, found)


def _learnt(sides: Sides, is_wall: bool, images: Ints | None) -> KnownLights | None:
    """The lamps that the images tell of, by the mean of what the colours of one image show."""
    if images is None:
        return learnt_lights(sides, is_wall)
    _, number = np.unique(images, return_inverse=True)
    lights = learnt_lights(sides.mean_of(number), is_wall) if number.max() else None
    return None if lights is None else lights_of(lights.on[number])._replace(are_all=lights.are_all)


def _levels_from(levels: Floats | None, lights: KnownLights | None) -> str:
    """TOLD where there are levels; else what ``lights``, where any were found in the images, are."""
    if levels is not None:
        return TOLD
    return LEARNT if lights is not None and lights.are_all else UNKNOWN


def _falling_of(sides: Sides, background: Background, lights: KnownLights | None) -> Falling:
    """To which side each light's shadows fall, by some edgels; as it appears if they are not told apart."""
    clear = FALLING_STEP * np.flatnonzero(sides.known[:, ::FALLING_STEP].all(axis=0))
    some, background = sides.of(clear), background.of(clear)
    parts = parts_of(some, lights) if lights is not None and lights.are_all else None
    parts = apparent_parts(some) if parts is None else parts
    likeliest = likelihoods(some, background, lights).argmax(axis=0)
    return learn_falling(parts, likeliest == OUTLINE, likeliest == SHADOW)
