"""Lights whose levels nobody told, learnt from the ends of their shadows.

What is missing at a shadow's end is in proportion to how far its light was on in each image, whatever it
falls on. So the steps at all ends of one light's shadows are alike but for their size, and nothing in the
images in which it was off: they are a cluster. Where several lights change at once, as at creases, it is so
in all images in which one of them is on: such a cluster is left out, and so is a light that is on in more
than half of the images. One that is on in a single image needs no level.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from vision_server.edges.light_parts import KnownLights, known_lights, parts_of
from vision_server.edges.sides import Sides

Floats = NDArray[np.float64]

# Chosen by hand on renders: `python -m benchmarks.edge_kinds`.
FLAT_SD = 0.03  # of two places 4 px apart on one flat surface, of the intensity
SURE = 2.5  # standard deviations: less is no step
LIT_SHARE, LIT_GREY = 0.15, 12.0  # of the brighter side in its best light: in less it shows no light off
MOST_NOISE = 0.12  # of a step, as a share of the largest
LEAST_STEP = 0.25  # of the brighter side in its best light: other steps are rather prints and creases
MOST_STEPS = 500  # that are compared with each other
ALIKE = 0.08  # between steps of one cluster, as a share of the largest
APART = 0.2  # between clusters
FEWEST = 8  # steps of a cluster
FEWEST_OF_ALL = 4  # where the lights that are so learnt explain all there is
OFF = 0.15  # level that is none
MOST_TRIED = 32  # choices of a cluster for each lamp, large ones first
SAMPLE_STEP = 8  # of the edgels that say whether they are all
MOST_NEGATIVE = 0.05  # share of them with a light's part that is negative: of wrong levels .2 and more


class Cluster(NamedTuple):
    """Steps that are alike: their middle (C,), 0 where their light is off, and how many there are."""

    middle: Floats
    count: int


def learnt_lights(sides: Sides) -> KnownLights | None:
    """The lamps whose shadows end at some of N edgels in C channels, and the sun; None without any.

    They are all if there are as many as channels, each is on in others, and none gives less than nothing:
    which is so sure that smaller clusters may be lamps then.
    """
    clusters = _of_one_light(_clusters(_telling_steps(sides)))
    some = sides.of(slice(None, None, SAMPLE_STEP))
    tried = 0
    for levels in combinations((cluster for cluster, _ in clusters), len(sides.near) - 1):
        if len({(level > 0.0).tobytes() for level in levels}) < len(levels):
            continue
        lights = known_lights(np.array(levels).T)
        if _explains(lights, some):
            return lights
        tried += 1
        if tried == MOST_TRIED:
            break
    sure = [cluster for cluster, count in clusters if count >= FEWEST]
    return known_lights(np.array(sure).T)._replace(are_all=False) if sure else None


def _of_one_light(clusters: list[Cluster]) -> list[Cluster]:
    """Those that are on in half of the channels at most, and not wherever another one is."""
    on = [frozenset(np.flatnonzero(cluster.middle)) for cluster in clusters]
    return [
        cluster
        for cluster, here in zip(clusters, on, strict=True)
        if 1 < len(here) <= len(cluster.middle) / 2 and not any(other < here for other in on)
    ]


def _explains(lights: KnownLights, sides: Sides) -> bool:
    """Whether what each light gives to the sides is never less than nothing, but for noise."""
    parts = parts_of(sides, lights)
    if parts is None:
        return False
    negative = np.any(parts.near < -SURE * parts.noise[:, None] - sides.dark, axis=(0, 1))
    return bool(np.mean(negative & parts.known[0]) < MOST_NEGATIVE)


def _telling_steps(sides: Sides) -> Floats:
    """Steps (M, C) between the sides, as a share of the largest, where one light alone may be blocked."""
    near = sides.near
    step = near[:, 1] - near[:, 0]
    step = step * np.sign(step.sum(axis=0))
    bright, largest = near.max(axis=1), step.max(axis=0)
    sd = np.sqrt(2.0 * np.square(sides.noise) + np.square(FLAT_SD * near.min(axis=1)))
    best = bright.max(axis=0)
    lit = (bright > np.maximum(LIT_SHARE * best, LIT_GREY)) & (sd < LIT_SHARE * bright)
    off = lit & (np.abs(step) < SURE * sd)
    told = sides.known.all(axis=0) & off.any(axis=0) & (step > -SURE * sd).all(axis=0)
    told &= (sd.max(axis=0) < MOST_NOISE * largest) & (largest > LEAST_STEP * best)
    some = np.flatnonzero(told)
    some = some[:: len(some) // MOST_STEPS + 1]
    return np.asarray((step[:, some] / largest[some]).T, np.float64)


def _clusters(steps: Floats) -> list[Cluster]:
    """Clusters, from the largest on."""
    apart = cdist(steps, steps, "chebyshev")
    near, left = apart < ALIKE, np.ones(len(steps), np.bool_)
    clusters: list[Cluster] = []
    while left.any():
        count = near[:, left].sum(axis=1) * left
        most = count.argmax()
        if count[most] < FEWEST_OF_ALL:
            break
        middle = np.median(steps[near[most] & left], axis=0)
        clusters.append(Cluster(np.where(middle > OFF, middle, 0.0), int(count[most])))
        left &= apart[most] > APART
    return clusters
