"""Shadows of a light whose levels are known: at a shadow's end it is blocked, on one side only.

What is missing there is in proportion to how far that one light was on in each channel, whatever the other
lights are. This needs neither as many channels as lights nor any that is clipped beside the edge; where there
are as many, `kinds.each_light` says more.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Field, Floats, Reals
from numerics.kernels import kernel
from numerics.logarithm import HALF, ONE, ZERO, log_of
from vision_server.kinds.densities import TAU, any_of, sum_of_logs
from vision_server.kinds.sides import Sides

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
    each = np.empty((lights.shape[1], noise.shape[1]), np.float32)
    for light, on in enumerate(np.ascontiguousarray(lights.T, np.float32)):
        _one_blocked(sides.near, np.float32(sides.dark), logs, noise, on, np.float32(depth_sd), each[light])
    return any_of(np.asarray(each + np.log(dark_side), np.float32))


def one_blocked(sides: Sides, logs: Reals, noise: Reals, light: Floats, depth_sd: float) -> Reals:
    """Log-likelihood (N,) that a light, on as far as ``light`` (C,) says, is blocked on one side.

    This is the definition. Where one side has the intensity I in a channel, the other has I + m light: m is
    fitted.
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


@kernel(fastmath={"reassoc", "contract", "nsz"})
def _one_blocked(
    near: Field, dark: np.float32, logs: Reals, noise: Reals, light: Field, depth_sd: np.float32, found: Field
) -> None:
    """As `one_blocked`; ``found`` (N,) is an output."""
    channels, count = noise.shape
    flat, telling = np.float32(FLAT_SD**2), np.float32(TELLING_VARIANCE)
    room = np.zeros((5, count), np.float32)
    missing, of_light, depth, told, squares = room[0], room[1], room[2], room[3], room[4]
    for channel in range(channels):
        on, back, ahead, of_noise = light[channel], near[channel, 0], near[channel, 1], noise[channel]
        for i in range(count):
            brighter = max(back[i], ahead[i], ZERO) + dark
            weight = on / ((of_noise[i] + flat) * brighter * brighter)
            missing[i] += weight * (back[i] - ahead[i])
            of_light[i] += weight * on
    for i in range(count):
        missing[i] /= of_light[i]
        depth[i] = np.float32(LEAST_DEPTH)
    for channel in range(channels):
        on, back, ahead, of_noise = light[channel], near[channel, 0], near[channel, 1], noise[channel]
        log_back, log_ahead = logs[channel, 0], logs[channel, 1]
        for i in range(count):
            is_behind, variance = missing[i] > ZERO, of_noise[i] + flat
            darker = max(ahead[i] if is_behind else back[i], ZERO) + dark
            ratio = log_of(ONE + abs(missing[i]) * on / darker)
            left = log_back[i] - log_ahead[i] - (ratio if is_behind else -ratio)
            depth[i] = max(depth[i], ratio if variance < telling else ZERO)
            told[i] += ratio * ratio / variance
            squares[i] += left * left / variance + log_of(TAU * variance)
    for i in range(count):
        share = depth[i] / depth_sd
        found[i] = -HALF * (squares[i] + log_of(ONE + told[i] / (share * share)) + share * share)
