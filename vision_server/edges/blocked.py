"""Shadows of a light whose levels are known: at a shadow's end it is blocked, on one side only.

What is missing there is in proportion to how far that one light was on in each channel, whatever the other
lights are. This needs neither as many channels as lights nor any that is clipped beside the edge; where there
are as many, `edges.each_light` says more.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats, Reals
from vision_server.edges.densities import any_of, sum_of_logs
from vision_server.edges.sides import Sides

# Of log-ratios; chosen by hand on renders and photographs: `python -m benchmarks.edge_kinds`.
FLAT_SD = 0.02  # of two places 4 px apart on one flat surface, from light to light
DEPTH_SD = 0.55  # of a shadow's depth in the channel that shows it best
KNOWN_DEPTH_SD = 0.65  # where the lights' levels are known: else deeper ones are rather creases
LEAST_DEPTH = 1e-6
TELLING_VARIANCE = 1.0  # of a channel's log-ratio: more, as of a black or clipped one, tells no depth


def shadow_of_one(
    sides: Sides,
    logs: Reals,
    noise: Reals,
    lights: Floats,
    depth_sd: float,
    dark_side: Reals | float = 1.0,
) -> Reals:
    """Log-likelihood (N,) that one of the lights is blocked on one side, each as likely.

    Parameters
    ----------
    sides
        Of N edgels in C channels.
    logs, noise
        As `densities.logarithms` gives them.
    lights
        float64 (C, L), how far each light is on.
    depth_sd
        DEPTH_SD or KNOWN_DEPTH_SD.
    dark_side
        (L, N), how much likelier than any other the dark side is to be that of a shadow of each light.
    """
    each = [one_blocked(sides, logs, noise, light, depth_sd) for light in lights.T]
    return any_of(np.asarray(np.asarray(each) + np.log(dark_side), np.float32))


def one_blocked(
    sides: Sides, logs: Reals, noise: Reals, light: Floats, depth_sd: float
) -> Reals:
    """Log-likelihood (N,) that a light, on as far as ``light`` (C,) says, is blocked on one side.

    Where one side has the intensity I in a channel, the other has I + m light: m is fitted.
    """
    on, variance = light.astype(np.float32)[:, None], noise + np.float32(FLAT_SD**2)
    both, precision = np.maximum(sides.near, 0.0) + np.float32(sides.dark), 1.0 / variance
    weight = on * precision / np.square(np.maximum(both[:, 0], both[:, 1]))
    missing = np.sum(weight * (sides.near[:, 0] - sides.near[:, 1]), axis=0) / np.sum(weight * on, axis=0)
    behind = missing > 0.0
    ratio = np.log(1.0 + np.abs(missing) * on / np.where(behind, both[:, 1], both[:, 0]))
    depth = np.maximum(np.max(ratio * (variance < TELLING_VARIANCE), axis=0), np.float32(LEAST_DEPTH))
    told = np.sum(np.square(ratio) * precision, axis=0) / np.square(depth)
    left = logs[:, 0] - logs[:, 1] - np.where(behind, ratio, -ratio)
    fitted = -0.5 * (np.sum(np.square(left) * precision, axis=0) + sum_of_logs(2.0 * np.pi * variance))
    # Laplace's integral over the depth: its prior, and by how much that is wider than what is left of it
    prior = -0.5 * (np.log(1.0 + depth_sd**2 * told) + np.square(depth / depth_sd))
    return np.asarray(fitted + prior)
