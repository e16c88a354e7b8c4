"""Moving lines to the middle of blurred edges.

Across an edge that defocus or motion has smeared over many pixels the gradient is a plateau, and its ridge
lies wherever noise and texture put it. The middle of the plateau, averaged along the line, is where the edge
was at mid-exposure; it is what the refinement and the model mean by the edge."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel

# Chosen by hand where nothing else is said.
STEP_PX = 0.5  # between samples of a profile across the line
LOBE_RATIO = 0.5  # of the peak: what belongs to the edge
MIN_TURNED_PX = 20.0  # shorter lines are shifted only: their two ends say too little about direction


@kernel()
def _profile(
    mass: NDArray[np.float32],
    ax: float,
    ay: float,
    bx: float,
    by: float,
    nx: float,
    ny: float,
    profile: NDArray[np.float64],
) -> None:
    """Mean of the field along the stretch a-b, at each offset across it; bilinear, 0 outside."""
    rows, columns = mass.shape
    half = len(profile) // 2
    count = int(np.hypot(bx - ax, by - ay)) + 1
    for i in range(len(profile)):
        offset = (i - half) * STEP_PX
        total = 0.0
        for k in range(count):
            t = (k + 0.5) / count
            x = ax + t * (bx - ax) + offset * nx
            y = ay + t * (by - ay) + offset * ny
            u, v = int(np.floor(x)), int(np.floor(y))
            if u < 0 or v < 0 or u + 1 >= columns or v + 1 >= rows:
                continue
            fx, fy = x - u, y - v
            total += (1.0 - fy) * ((1.0 - fx) * mass[v, u] + fx * mass[v, u + 1]) + fy * (
                (1.0 - fx) * mass[v + 1, u] + fx * mass[v + 1, u + 1]
            )
        profile[i] = total / count


@kernel()
def _middle(profile: NDArray[np.float64]) -> float:
    """Offset of the middle of the lobe at the centre, px; NaN when it is not all in sight."""
    half = len(profile) // 2
    near = max(half // 3, 1)
    peak = half
    for i in range(half - near, half + near + 1):
        if profile[i] > profile[peak]:
            peak = i
    limit = LOBE_RATIO * profile[peak]
    first, last = peak, peak
    while first > 0 and profile[first - 1] > limit:
        first -= 1
    while last < len(profile) - 1 and profile[last + 1] > limit:
        last += 1
    if first == 0 or last == len(profile) - 1:
        return np.nan
    total, moment = 0.0, 0.0
    for i in range(first, last + 1):
        total += profile[i] - limit
        moment += (profile[i] - limit) * (i - half)
    return moment / total * STEP_PX if total > 0.0 else 0.0


@kernel()
def _line_weight(weight: NDArray[np.float32], ax: float, ay: float, bx: float, by: float) -> float:
    """Mean of the field along the stretch a-b."""
    rows, columns = weight.shape
    count = int(np.hypot(bx - ax, by - ay)) + 1
    total = 0.0
    for k in range(count):
        t = (k + 0.5) / count
        x = min(max(int(np.round(ax + t * (bx - ax))), 0), columns - 1)
        y = min(max(int(np.round(ay + t * (by - ay))), 0), rows - 1)
        total += weight[y, x]
    return total / count


@kernel()
def _add_profiles(
    endpoints: NDArray[np.float64],
    contrast: NDArray[np.float32],
    weight: NDArray[np.float32],
    profiles: NDArray[np.float64],
) -> None:
    """Add one channel's profiles across the first and the second half of each line, (N, 2, K)."""
    profile = np.zeros(profiles.shape[2])
    for s in range(len(endpoints)):
        ax, ay, bx, by = endpoints[s]
        length = np.hypot(bx - ax, by - ay)
        if length < 1.0:
            continue
        nx, ny = -(by - ay) / length, (bx - ax) / length
        w = _line_weight(weight, ax, ay, bx, by)
        mx, my = 0.5 * (ax + bx), 0.5 * (ay + by)
        _profile(contrast, ax, ay, mx, my, nx, ny, profile)
        for k in range(len(profile)):
            profiles[s, 0, k] += w * profile[k]
        _profile(contrast, mx, my, bx, by, nx, ny, profile)
        for k in range(len(profile)):
            profiles[s, 1, k] += w * profile[k]


@kernel()
def _move(
    endpoints: NDArray[np.float64], profiles: NDArray[np.float64], reach_px: float
) -> NDArray[np.float64]:
    """Each line moved so that its halves lie in the middle of their profiles."""
    out = endpoints.copy()
    for s in range(len(endpoints)):
        ax, ay, bx, by = endpoints[s]
        length = np.hypot(bx - ax, by - ay)
        if length < 1.0:
            continue
        nx, ny = -(by - ay) / length, (bx - ax) / length
        if length < MIN_TURNED_PX:
            start = end = _middle(profiles[s, 0] + profiles[s, 1])
        else:
            first, second = _middle(profiles[s, 0]), _middle(profiles[s, 1])
            start, end = 1.5 * first - 0.5 * second, 1.5 * second - 0.5 * first
        if np.isnan(start) or np.isnan(end) or max(abs(start), abs(end)) > reach_px:
            continue
        out[s, 0] += start * nx
        out[s, 1] += start * ny
        out[s, 2] += end * nx
        out[s, 3] += end * ny
    return out


def centre_lines(
    endpoints: NDArray[np.float64],
    channels: Iterable[tuple[NDArray[np.float32], NDArray[np.float32]]],
    reach_px: float,
) -> NDArray[np.float64]:
    """Lines moved to the middle of the edges that they lie on.

    Parameters
    ----------
    endpoints
        float64 (N, 4), x0, y0, x1, y1, px.
    channels
        Contrast and weight of each channel, float32 (H, W) each. A channel's weight is taken on the line
        itself, so that its change across the edge cannot move the line.
    reach_px
        How far to either side an edge may extend; lines on edges that extend farther are left alone.

    Returns
    -------
    float64 (N, 4).
    """
    profiles = np.zeros((len(endpoints), 2, 2 * int(np.ceil(reach_px / STEP_PX)) + 1))
    for contrast, weight in channels:
        _add_profiles(endpoints, contrast, weight, profiles)
    return np.asarray(_move(endpoints, profiles, reach_px))
