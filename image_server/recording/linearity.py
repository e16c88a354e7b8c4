"""Linear radiance from frames: undoing the tone curve, uniting shutters, and measures of linearity."""

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Flags, Floats, Grey

Radiance = Floats

LOWEST, HIGHEST = 8, 247
"""Grey values that are told from black and from saturation, noise included."""
ENOUGH_PIXELS = 100  # chosen by hand: noise of 5 % a pixel leaves 0.5 %


def linear(frame: NDArray[np.floating] | Grey, gamma: float) -> Radiance:
    """Signal in 0..1 of grey values (H, W): (frame / 255)^gamma."""
    signal: Radiance = (np.asarray(frame, np.float64) / 255.0) ** gamma
    return signal


def united(frames: Sequence[Radiance], saturated: Sequence[Flags], exposures: Sequence[float]) -> Radiance:
    """Radiance from linear frames under several exposures.

    Photon noise makes sum(signal) / sum(exposure) the best estimate; saturated pixels do not take part, and a
    pixel that is saturated in all frames gets the value of the shortest.

    Parameters
    ----------
    frames : signals (H, W) in 0..1.
    saturated : where each frame is.
    exposures : relative to the reference, gain included.
    """
    signal = np.zeros_like(frames[0])
    exposure = np.zeros_like(frames[0])
    for frame, clipped, weight in zip(frames, saturated, exposures, strict=True):
        signal += np.where(clipped, 0.0, frame)
        exposure += np.where(clipped, 0.0, weight)
    shortest = int(np.argmin(exposures))
    everywhere = exposure > 0
    united_ = frames[shortest] / exposures[shortest]
    united_[everywhere] = signal[everywhere] / exposure[everywhere]
    return united_


def measured_ratio(
    low: NDArray[np.floating] | Grey, high: NDArray[np.floating] | Grey, gamma: float
) -> float | None:
    """How many times brighter `high` is than `low`, on linear signal; None where too few pixels tell.

    The ratio of sums over the pixels that are neither black nor saturated in either frame.
    """
    usable = (low >= LOWEST) & (high >= LOWEST) & (low <= HIGHEST) & (high <= HIGHEST)
    if int(usable.sum()) < ENOUGH_PIXELS:
        return None
    return float(linear(high[usable], gamma).sum() / linear(low[usable], gamma).sum())


def fitted_gamma(frames: Sequence[Grey], exposures: Sequence[float]) -> float | None:
    """Gamma of a camera from frames of one scene under several exposures; None where they do not tell.

    Grey values g = 255 · signal^(1/gamma) make log g fall on a line over log exposure, of slope 1/gamma,
    whatever the scene: the least-squares slope over all usable pixels of neighbouring exposures.
    """
    along = across = 0.0
    order = np.argsort(exposures)
    for first, second in itertools.pairwise(order):
        step = float(np.log(exposures[second] / exposures[first]))
        low, high = frames[first], frames[second]
        usable = (low >= LOWEST) & (high >= LOWEST) & (low <= HIGHEST) & (high <= HIGHEST)
        if step <= 0 or int(usable.sum()) < ENOUGH_PIXELS:
            continue
        rise = np.log(high[usable].astype(np.float64)) - np.log(low[usable].astype(np.float64))
        along += step * float(rise.mean())
        across += step * step
    return across / along if across > 0 and along > 0 else None
