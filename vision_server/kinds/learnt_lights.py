"""Lights whose levels nobody told, learnt from the ends of their shadows.

What is missing at a shadow's end is in proportion to how far its light was on in each image, whatever it
falls on. So the steps at all ends of one light's shadows are alike but for their size, and nothing in the
images in which it was off: they are a cluster. Where several lights change at once, as at creases, it is so
in all images in which one of them is on: such a cluster is left out. A light that is on in more than half of
the images is not learnt, and steps that are clearly so are none of the others'. Lamps that are on alone in
one image each are told without any shadow beside one of the sun or of all of them; in the dark, or beside
the sun in all, by their shadows (`kinds.dark_room`, `kinds.alone`). In two or three images with the sun in
all there may be a lamp for each that is on in several.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from numerics.arrays import Field, Flags, Floats, Ints
from numerics.kernels import kernel
from numerics.logarithm import ONE, ZERO
from vision_server.kinds.alone import FEWEST, MOST_NOISE, ON_BY_ONE, lamps_are_alone
from vision_server.kinds.dark_room import LEAST_STEP, SURE, lamps_in_the_dark, unsure_and_lit
from vision_server.kinds.light_parts import KnownLights, known_lights, parts_of
from vision_server.kinds.sides import Sides
from vision_server.kinds.together import alone_and_together, are_lights

# Chosen by hand on renders: `python -m benchmarks.edge_kinds`.
MOST_STEPS = 500  # that are compared with each other
ALIKE = 0.08  # between steps of one cluster, as a share of the largest
APART = 0.2  # between clusters
FEWEST_ALONE = 3  # images by which lamps that are alone are told by what their shadows leave
# With more images as many clusters as images say too little: on curved bodies there are such, of shading.
MOST_IMAGES = 3
FEWEST_OF_ALL = 4  # where the lights that are so learnt explain all there is
ON_BY_MANY = 0.15  # level, as a share of the largest, from which on a light is on, by the median of a cluster
MOST_TRIED = 32  # choices of a cluster for each lamp, large ones first
SAMPLE_STEP = 8  # of the edgels that say whether they are all


class Cluster(NamedTuple):
    """Steps that are alike: their middle (C,), 0 where their light is off, and how many there are."""

    middle: Floats
    steps: int


def learnt_lights(sides: Sides, before_wall: bool = False) -> KnownLights | None:
    """The lamps that N edgels in C channels tell of, and the sun; None without any.

    Lamps that are alone beside the sun are not asked for before a lit wall: shadows on it show them, too,
    where the bodies before it are curved, of which the shading would be taken for creases then.

    They are all if there are as many as channels, each is on in others, and none gives less than nothing:
    which is so sure that smaller clusters may be lamps then. So they are where each is alone in an image,
    and there is an image of all or of none of them, or no sun.
    """
    images = len(sides.near)
    clusters = _clusters(_telling_steps(sides, images // 2))
    some = sides.of(slice(None, None, SAMPLE_STEP))
    lights = _that_explain(_of_one_light(clusters, 2, images // 2), some) or alone_and_together(some)
    lights = lights or lamps_in_the_dark(np.eye(images), sides)
    if lights is None and not before_wall and images >= FEWEST_ALONE and lamps_are_alone(sides):
        lights = known_lights(np.eye(images))
    lights = lights or _as_many_as_images(sides)
    if lights is not None:
        return lights
    sure = [cluster for cluster in clusters if cluster.steps >= FEWEST]
    sure = _of_one_light(sure, 2, images // 2)
    return known_lights(_levels(sure))._replace(are_all=False) if sure else None


def _as_many_as_images(sides: Sides) -> KnownLights | None:
    """As many lamps as there are C images, and the sun in all; None if the ends of shadows show fewer.

    What each gives cannot be told apart then, but how far each is on is enough to ask for its shadows. Where
    an image has ends that no other one shows, a lamp is on in it alone; where only such ends are found, and
    in most of the images, the others have a lamp of their own as well. Steps in several images are the ends
    of one lamp that is on in all of these, or of two shadows that fall together.
    """
    images = len(sides.near)
    if images > MOST_IMAGES:
        return None
    clusters = [one for one in _clusters(_telling_steps(sides, images - 1)) if one.steps >= FEWEST]
    lamps: dict[bytes, Cluster] = {}
    for cluster in _of_one_light(clusters, 1, images - 1):  # large ones first
        lamps.setdefault((cluster.middle > 0.0).tobytes(), cluster)
    if len(lamps) <= images / 2:
        return None
    levels = _levels(list(lamps.values()))
    if (np.count_nonzero(levels, axis=0) == 1).all():
        return known_lights(np.eye(images))
    if len(lamps) != images or np.linalg.matrix_rank(levels) < images:
        return None
    return known_lights(levels)


def _levels(clusters: Sequence[Cluster]) -> Floats:
    """Levels (C, K) of the lights of some clusters."""
    return np.array([cluster.middle for cluster in clusters]).T


def _that_explain(clusters: list[Cluster], sides: Sides) -> KnownLights | None:
    """The lamps among some clusters that are as many as C channels allow and explain what they show."""
    tried = 0
    for some in combinations(clusters, len(sides.near) - 1):
        if len({(cluster.middle > 0.0).tobytes() for cluster in some}) < len(some):
            continue
        lights = known_lights(_levels(some))
        parts = parts_of(sides, lights)
        if parts is not None and are_lights(parts):
            return lights
        tried += 1
        if tried == MOST_TRIED:
            break
    return None


def _of_one_light(clusters: list[Cluster], fewest_on: int, most_on: int) -> list[Cluster]:
    """Those that are on in so many channels, and not wherever another one is that is on in fewer."""
    on = [frozenset(np.flatnonzero(cluster.middle)) for cluster in clusters]
    return [
        cluster
        for cluster, here in zip(clusters, on, strict=True)
        if fewest_on <= len(here) <= most_on and not any(other < here for other in on)
    ]


def _telling_steps(sides: Sides, most_on: int) -> Floats:
    """Steps (M, C) between the sides, as a share of the largest, where one light alone may be blocked.

    ``most_on`` is in how many of the C channels it is on at most.
    """
    sd, lit = unsure_and_lit(sides)
    some = _telling(sides, sd, lit, most_on)
    some = some[:: len(some) // MOST_STEPS + 1]
    step = sides.near[:, 1, some] - sides.near[:, 0, some]
    step *= np.sign(step.sum(axis=0))
    return np.asarray((step / step.max(axis=0)).T, np.float64)


@kernel()
def _telling(of: Sides, sd: Field, lit: Flags, most_on: int) -> Ints:
    """Which of N edgels step in ``most_on`` of C channels at most; of `unsure_and_lit` ``sd`` and ``lit``."""
    channels, count = of.noise.shape
    near, sure, least = of.near, np.float32(SURE), np.float32(LEAST_STEP)
    room, marks = np.zeros((3, count), np.float32), np.zeros((3, count), np.int32)
    total, best, largest = room[0], room[1], room[2]
    untold, off, on = marks[0], marks[1], marks[2]
    for channel in range(channels):
        for i in range(count):
            total[i] += near[channel, 1, i] - near[channel, 0, i]
            best[i] = max(best[i], near[channel, 0, i], near[channel, 1, i])
    for i in range(count):
        total[i] = ONE if total[i] > ZERO else -ONE
    for channel in range(channels):
        for i in range(count):
            largest[i] = max(largest[i], total[i] * (near[channel, 1, i] - near[channel, 0, i]))
    for channel in range(channels):
        for i in range(count):
            step = total[i] * (near[channel, 1, i] - near[channel, 0, i])
            limit = sure * sd[channel, i]
            untold[i] |= (step <= -limit) | (sd[channel, i] >= MOST_NOISE * largest[i])
            on[i] += step > ON_BY_ONE * largest[i]
        for i in range(count):
            step, limit = near[channel, 1, i] - near[channel, 0, i], sure * sd[channel, i]
            untold[i] |= not of.known[channel, i]
            off[i] |= lit[channel, i] & (abs(step) < limit)
    for i in range(count):
        untold[i] |= (largest[i] <= least * best[i]) | (off[i] == 0) | (on[i] > most_on)
    return np.flatnonzero(untold == 0)


def _clusters(steps: Floats) -> list[Cluster]:
    """Clusters, from the largest on."""
    clusters: list[Cluster] = []
    left, near = np.ones(len(steps), np.bool_), np.empty(len(steps), np.bool_)
    apart = _apart(steps)
    while (count := _largest(apart, left, near)) >= FEWEST_OF_ALL:
        middle = np.median(steps[near], axis=0)
        clusters.append(Cluster(np.where(middle > ON_BY_MANY, middle, 0.0), count))
    return clusters


@kernel()
def _largest(apart: Floats, left: Flags, near: Flags) -> int:
    """How many of the steps that are left (M,) are in the largest cluster, which is not left then.

    ``left`` and ``near``, those that are in it, are outputs; ``apart`` is what `_apart` gives.
    """
    largest, most = 0, 0
    for i in range(len(left)):
        count = 0
        if left[i]:
            for k in range(len(left)):
                count += left[k] & (apart[i, k] < ALIKE)
        if count > largest:
            largest, most = count, i
    if largest >= FEWEST_OF_ALL:
        for k in range(len(left)):
            near[k] = left[k] & (apart[most, k] < ALIKE)
            left[k] &= apart[most, k] > APART
    return largest


@kernel()
def _apart(steps: Floats) -> Floats:
    """By how much each of M steps (M, C) differs from each other one at most, float64 (M, M)."""
    apart = np.zeros((len(steps), len(steps)))
    for i in range(len(steps)):
        for k in range(i):
            most = 0.0
            for channel in range(steps.shape[1]):
                most = max(most, abs(steps[i, channel] - steps[k, channel]))
            apart[i, k] = apart[k, i] = most
    return apart
