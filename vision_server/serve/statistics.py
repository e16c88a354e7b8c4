"""How a frame is exposed and how sharp it is, in the region where the target should be."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import cv2
import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Flags, Grey
from vision_server.channels.channel import ChannelStatistics
from vision_server.channels.noise import SATURATED_GREY

MARGIN_PX = 10  # around the model's outline, or what is lit
DARK_GREY = 8  # below this there is nothing to see
# What is left to measure on where more is saturated is no edge of the target: of 162 blurred frames with
# more 94 were taken for sharp ones, of 126 with less none.
MOST_SATURATED = 0.1


def target_region(model: Model, camera: Camera, pose: Pose) -> Flags:
    """Pixels within MARGIN_PX of the model's outline, (H, W); all where it is not in front, or outside."""
    everything = np.ones((camera.height, camera.width), dtype=bool)
    points = camera.project(pose.apply(model.vertices))
    if not np.isfinite(points).all():
        return everything
    hull = cv2.convexHull(np.clip(points, -4.0 * camera.width, 5.0 * camera.width).astype(np.float32))
    mask = np.zeros((camera.height, camera.width), dtype=np.uint8)
    cv2.fillConvexPoly(mask, np.round(hull).astype(np.int32), 1)
    region = _around(mask)
    return region if region.any() else everything


def lit_region(frames: Iterable[Grey]) -> Flags:
    """Pixels within MARGIN_PX of what any of the frames (H, W) shows, (H, W); all where none shows a thing.

    Where the target may be anywhere: before black space it takes so few of the frame's pixels that by all of
    them it is dark, however overexposed. The median of nine pixels leaves stars and hot pixels out.
    """
    lit = np.maximum.reduce([cv2.medianBlur(frame, 3) for frame in frames]) >= DARK_GREY
    return _around(lit.astype(np.uint8)) if lit.any() else np.ones(lit.shape, dtype=bool)


def _around(mask: Grey) -> Flags:
    side = 2 * MARGIN_PX + 1
    return np.asarray(cv2.dilate(mask, np.ones((side, side), np.uint8)) > 0)


def frame_statistics(channel: ChannelStatistics, region: Flags, gamma: float = 1.0) -> dict[str, Any]:
    """Statistics of a frame over the target's region, and of the whole frame under ``frame``.

    Parameters
    ----------
    channel
        Edge statistics of the frame.
    region
        bool (H, W), where the target should be.
    gamma
        Tone curve of the frame, as in `channel_statistics`.

    Returns
    -------
    mean, p05, p50, p95
        Linear intensity as a share of full scale, 0..1: twice the light is twice the number.
    dark_fraction, saturated_fraction
        Shares of pixels under grey 8, and at 250 or more.
    sharpness
        95th percentile of the contrast over the spread p95 - p05: 1 for crisp edges, near 0 for none.
    noise
        Median standard deviation of the sensor noise, share of full scale.
    blur_px
        Standard deviation of the spread of the frame's lone edges, px; None where too few tell, or
        too much is saturated.
    """
    target = _of(channel, region, gamma)
    clipped = target["saturated_fraction"] > MOST_SATURATED
    blur = None if clipped else channel.lone_blur_px
    return {**target, "blur_px": blur, "frame": _of(channel, None, gamma)}


def _of(channel: ChannelStatistics, region: Flags | None, gamma: float) -> dict[str, float]:
    grey = channel.image.ravel() if region is None else channel.image[region]
    counts = np.bincount(grey, minlength=256)
    below = np.cumsum(counts)
    total = float(below[-1])
    linear = (np.arange(256) / 255.0) ** gamma
    low, middle, high = (float(linear[np.searchsorted(below, share * total)]) for share in (0.05, 0.5, 0.95))
    contrast = channel.contrast if region is None else channel.contrast[region]
    noise = channel.noise if region is None else channel.noise[region]
    spread = max(high - low, 1.0 / 255.0)
    edges = contrast[contrast > 0]
    sharp = float(np.percentile(edges, 95)) * channel.exposure / 255.0 / spread if len(edges) else 0.0
    return {
        "mean": float(counts @ linear) / total,
        "p05": low,
        "p50": middle,
        "p95": high,
        "dark_fraction": float(below[DARK_GREY - 1]) / total,
        "saturated_fraction": float(total - below[SATURATED_GREY - 1]) / total,
        "sharpness": min(1.0, sharp),
        "noise": float(np.median(noise[::7])) * channel.exposure / 255.0,
    }
