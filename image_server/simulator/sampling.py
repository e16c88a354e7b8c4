"""Sampling: the places within a pixel, and the places on the sun's disc, that are looked at."""

import math

import numpy as np

from numerics.arrays import Floats

SAMPLES = 16  # per pixel at edges: true to 1/32 px (docs/simulator.md)
DISC_SAMPLES = 64  # places on the sun's disc that the places of a pixel look at, four each
RIM_VIEWS = 3  # places at the sun's rim that one pixel in four looks at
DISC_STEP = 11  # order in which the places of a pixel look at the disc: uncorrelated with where they lie


def pixel_places() -> Floats:
    """(SAMPLES, 2) offsets in px within a pixel: Hammersley's points, centred."""
    bits = int(math.log2(SAMPLES))
    reverse = [int(f"{index:0{bits}b}"[::-1], 2) for index in range(SAMPLES)]
    return (np.stack([np.arange(SAMPLES), reverse], axis=1) + 0.5) / SAMPLES - 0.5


def disc_directions(sun: Floats, radius_rad: float) -> Floats:
    """Directions (1 + D, 3): the sun's middle, then places on its disc: a golden spiral, rim first.

    The second half of the places lies opposite to the first, so that their mean is the middle. A point has
    none.
    """
    if radius_rad == 0:
        return sun[None]
    half = DISC_SAMPLES // 2
    helper = np.eye(3)[np.argmin(np.abs(sun))]
    u = np.cross(sun, helper)
    u /= np.linalg.norm(u)
    v = np.cross(sun, u)
    index = np.arange(half)
    radius = radius_rad * np.sqrt(1 - (index + 0.5) / half)
    angle = index * math.pi * (3 - math.sqrt(5))
    spread = np.outer(radius * np.cos(angle), u) + np.outer(radius * np.sin(angle), v)
    return np.concatenate([sun[None], sun + spread, sun - spread])
