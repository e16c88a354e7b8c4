"""Shadows of known lights: at a shadow's end exactly one light is blocked, and on one side only.

The ends of two lights' shadows cross and do not run along each other. What is missing on one side is in
proportion to how far that one light was on in each channel, whatever the other lights are; this needs
neither as many channels as lights nor any that is clipped beside the edge. Where two lights or more are
missing beside the same edge, and the others are alike on both sides, there is an edge of the scene: what is
behind an outline lies in the shadow of what is before it.
"""

from __future__ import annotations

from functools import reduce

import numpy as np
from numpy.typing import NDArray

from vision_server.edges.densities import Floats, Scatter, either, log_normal, logarithms, sum_of_logs
from vision_server.edges.sides import Sides

# Of log-ratios; chosen by hand on renders and photographs: `python -m benchmarks.edge_kinds`.
FLAT_SD = 0.03  # of two places 4 px apart on one flat surface, from light to light
DEPTH_SD = 0.55  # of a shadow's depth in the channel that shows it best
ALIKE = 0.7  # share of the lights that are not blocked beside an outline
PART_SD = 0.7  # of a light's part of a crease from light to light
MEAN_SD = 0.7  # of a crease in its mean light
DARK_SHARE = 0.03  # of the brightest part: nothing
LEAST_DEPTH = 1e-6
TELLING_VARIANCE = 1.0  # of a channel's log-ratio: more, as of a black or clipped one, tells no depth


def shadow_of_one(
    sides: Sides, logs: Floats, noise: Floats, lights: NDArray[np.float64], parts: Sides | None
) -> Floats:
    """Log-likelihood (N,) that one of the lights is blocked on one side, each as likely.

    Parameters
    ----------
    sides
        Of N edgels in C channels.
    logs, noise
        As `densities.logarithms` gives them.
    lights
        float64 (C, L), how far each light is on.
    parts
        What each of the lights gives, where that is known: of the blocked one nothing on the darker side.
    """
    each = []
    for number, light in enumerate(lights.T):
        found, behind = one_blocked(sides, logs, noise, light)
        if parts is not None:
            found = found + np.where(parts.known[number], _nothing_of(parts, number, behind), 0.0)
        each.append(found)
    return np.asarray(reduce(either, each) - np.log(len(each)))


def one_blocked(
    sides: Sides, logs: Floats, noise: Floats, light: NDArray[np.float64]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Log-likelihood (N,) that a light, on as far as ``light`` (C,) says, is blocked on one side.

    Where one side has the intensity I in a channel, the other has I + m light: m is fitted. Also, whether the
    brighter side is the one behind.
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
    prior = -0.5 * (np.log(1.0 + DEPTH_SD**2 * told) + np.square(depth / DEPTH_SD))
    return np.asarray(fitted + prior), behind


def _nothing_of(parts: Sides, number: int, behind: NDArray[np.bool_]) -> Floats:
    """Log-likelihood (N,) that a light gives nothing to the darker side, less that it gives any amount up to
    what it gives to the brighter one."""
    near = np.maximum(parts.near, 0.0)
    darker = np.where(behind, parts.near[number, 1], parts.near[number, 0])
    brighter = np.where(behind, near[number, 0], near[number, 1])
    variance = np.square(parts.noise[number]) + np.square(np.float32(DARK_SHARE) * near.max(axis=(0, 1)))
    return np.asarray(log_normal(darker, variance) + np.log(brighter + np.sqrt(variance)))


def several_less_crease(parts: Sides) -> Floats:
    """Log-likelihood (N,) that two lights or more are blocked on one side and the rest is alike, less that of
    a crease, by what each light gives."""
    logs, noise = logarithms(parts)
    ratio = logs[:, 0] - logs[:, 1]
    near = np.maximum(parts.near, 0.0)
    darker, variance = near.min(axis=1), parts.noise**2 + (DARK_SHARE * near.max(axis=(0, 1))) ** 2
    # the density of nothing but noise, on either side, as one of the logarithm
    blocked = log_normal(darker, variance) + np.log((1.0 - ALIKE) * 0.5 * (darker + parts.dark))
    alike = log_normal(ratio, noise + FLAT_SD**2) + np.log(ALIKE)
    none, one, several = alike[0], blocked[0], np.full_like(alike[0], -np.inf)
    for free, ends in zip(alike[1:], blocked[1:], strict=True):
        several = either(several + either(free, ends), one + ends)
        one, none = either(one + free, none + ends), none + free
    return np.asarray(several - Scatter.of(ratio, noise + PART_SD**2).about_a_mean(MEAN_SD))
