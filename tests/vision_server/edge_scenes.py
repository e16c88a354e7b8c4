"""Small rendered scenes with known edges, shared by the edge tests."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter

from numerics.arrays import Flags, Grey
from vision_server.edges.edge_map import EdgeMap


def step(
    angle_rad: float,
    shift_px: float,
    low: float,
    high: float,
    shape: tuple[int, int] = (96, 128),
    blur_px: float = 0.0,
    noise: float = 0.0,
    seed: int = 0,
) -> Grey:
    """A straight step edge through the middle, moved ``shift_px`` along its normal, area-sampled."""
    factor = 8
    height, width = shape
    y, x = np.mgrid[: height * factor, : width * factor]
    y, x = (y + 0.5) / factor - 0.5, (x + 0.5) / factor - 0.5
    distance = (x - (width - 1) / 2) * np.cos(angle_rad) + (y - (height - 1) / 2) * np.sin(angle_rad)
    fine = np.where(distance > shift_px, high, low)
    image = fine.reshape(height, factor, width, factor).mean(axis=(1, 3))
    if blur_px > 0.0:
        image = gaussian_filter(image, blur_px, mode="nearest")
    image = image + np.random.default_rng(seed).normal(0.0, noise, shape)
    return np.asarray(np.clip(np.round(image), 0, 255), dtype=np.uint8)


def polygon_with_shadows(count: int, noise: float = 1.0, shape: tuple[int, int] = (120, 160)) -> list[Grey]:
    """A bright square on a grey table, lit from ``count`` sides, each light with a shadow the other way."""
    height, width = shape
    y, x = np.mgrid[:height, :width]
    square = (abs(x - width / 2) < 30) & (abs(y - height / 2) < 25)
    images = []
    for number in range(count):
        angle = 2.0 * np.pi * number / count + 0.3
        moved = np.roll(square, (round(14 * np.sin(angle)), round(14 * np.cos(angle))), axis=(0, 1))
        scene = np.where(square, 180.0, np.where(moved, 35.0, 110.0))
        scene = gaussian_filter(scene, 0.6)
        scene += np.random.default_rng(number).normal(0.0, noise, shape)
        images.append(np.clip(np.round(scene), 0, 255).astype(np.uint8))
    return images


def square_outline(shape: tuple[int, int] = (120, 160)) -> Flags:
    """Pixels beside the outline of the square of `polygon_with_shadows`."""
    height, width = shape
    y, x = np.mgrid[:height, :width]
    inside = (abs(x - width / 2) < 30) & (abs(y - height / 2) < 25)
    grown = np.zeros_like(inside)
    for dy, dx in ((0, 1), (1, 0), (0, -1), (-1, 0)):
        grown |= np.roll(inside, (dy, dx), axis=(0, 1)) != inside
    return np.asarray(grown, dtype=np.bool_)


def edge_map_of(points: list[tuple[int, int, float]], shape: tuple[int, int] = (60, 80)) -> EdgeMap:
    """Edgels (x, y, normal) as an edge map."""
    ridge, orientation = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    for x, y, normal in points:
        ridge[y, x], orientation[y, x] = 10.0, normal % np.pi
    return EdgeMap.from_fields(ridge, orientation, np.zeros(shape, np.float32), 0.0)
