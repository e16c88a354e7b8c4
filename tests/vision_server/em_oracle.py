"""The mixture of `vision_server.edges.mixture`, stated sample by sample in plain NumPy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vision_server.channels.channel import ChannelStatistics
from vision_server.edges.mixture import BACKGROUND_SD_RAD, EM_ITERATIONS, MAIN_SD_RAD

Floats = NDArray[np.float64]


def axial_difference(a: Floats | float, b: Floats | float) -> Floats:
    """Angle between axes, rad, 0 .. pi/2."""
    difference = np.mod(np.abs(np.asarray(a) - b), np.pi)
    return np.minimum(difference, np.pi - difference)


def von_mises(difference: Floats, sd_rad: float) -> Floats:
    """Density of an axis, per rad, whose doubled angle is von Mises with the spread of ``sd_rad``."""
    kappa = 1.0 / (2.0 * sd_rad) ** 2
    return np.asarray(np.exp(kappa * np.cos(2.0 * difference)) / (np.pi * np.i0(kappa)))


def axial_mean(angles: Floats, values: Floats) -> float:
    """Mean direction of weighted axes, by doubled angles."""
    return float(0.5 * np.arctan2(np.sum(values * np.sin(2 * angles)), np.sum(values * np.cos(2 * angles))))


def mixture_at(channels: Sequence[ChannelStatistics], y: int, x: int) -> tuple[float, float]:
    """Share of the main component and its orientation (rad, [0, pi)) at one pixel."""
    weights = np.sum([c.weight.astype(np.float64) for c in channels], axis=0)
    angles, values = [], []
    for channel in channels:
        window = np.s_[y - 1 : y + 2, x - 1 : x + 2]
        value = channel.weight[window].astype(np.float64) * channel.contrast[window] / weights[window]
        angles.append(channel.orientation[window].astype(np.float64)[value > 0])
        values.append(value[value > 0])
    angle, value = np.concatenate(angles), np.concatenate(values)
    mean = axial_mean(angle, value)
    background = von_mises(axial_difference(angle, mean), BACKGROUND_SD_RAD)
    share = 0.5
    for _ in range(EM_ITERATIONS):
        main = share * von_mises(axial_difference(angle, mean), MAIN_SD_RAD)
        mine = main / (main + (1.0 - share) * background) * value
        mean = axial_mean(angle, mine)
        share = min(float(mine.sum() / value.sum()), 0.999)
    return share, mean % np.pi
