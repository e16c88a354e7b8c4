"""Bodies lit from one side at a time, each side dark in most images: sphere, cylinder, folded sheet."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.ndimage import gaussian_filter

from numerics.arrays import Flags, Floats, Grey, Ints

Body = Literal["sphere", "cylinder", "folded sheet"]
BODIES: tuple[Body, ...] = ("sphere", "cylinder", "folded sheet")

SHAPE = (240, 320)
ALBEDO = 0.7
BACKGROUND = 0.02
LIGHT_ELEVATION_DEG = 30.0
PIXEL_BLUR_PX = 0.7
NOISE = 0.005  # of full scale


def _surface(body: Body) -> tuple[Flags, Floats, Ints]:
    """Where the body is, its unit normals (3, H, W) towards the camera (-z), and a number for each face."""
    height, width = SHAPE
    y, x = np.mgrid[:height, :width].astype(np.float64)
    x, y = x - (width - 1) / 2, y - (height - 1) / 2
    face = np.zeros(SHAPE, np.int64)
    if body == "sphere":
        radius = 80.0
        squared = (x**2 + y**2) / radius**2
        return (
            squared < 1.0,
            np.stack([x / radius, y / radius, -np.sqrt(np.clip(1.0 - squared, 0.0, 1.0))]),
            face,
        )
    turn = np.deg2rad(25.0 if body == "cylinder" else 20.0)
    u, v = x * np.cos(turn) + y * np.sin(turn), -x * np.sin(turn) + y * np.cos(turn)
    if body == "cylinder":
        radius = 55.0
        slope = np.clip(u / radius, -1.0, 1.0)
        inside = (np.abs(u) < radius) & (np.abs(v) < 85.0)
    else:
        face = np.floor((u + 100.0) / 40.0).astype(np.int64)
        slope = np.where(face % 2 == 0, 1.0, -1.0) * np.sin(np.deg2rad(50.0))
        inside = (np.abs(u) < 100.0) & (np.abs(v) < 70.0)
    normals = np.stack([slope * np.cos(turn), slope * np.sin(turn), -np.sqrt(1.0 - slope**2)])
    return inside, normals, face


def attached_shadow_set(body: Body, lights: int) -> tuple[list[Grey], Flags]:
    """Images of a body, one light each from all round, and its true edges.

    Returns
    -------
    images
        uint8 (240, 320), linear.
    edges
        bool (240, 320), outline and folds.
    """
    inside, normals, face = _surface(body)
    rng = np.random.default_rng(0)
    elevation = np.deg2rad(LIGHT_ELEVATION_DEG)
    images = []
    for number in range(lights):
        azimuth = 2.0 * np.pi * number / lights
        light = np.array(
            [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), -np.sin(elevation)]
        )
        shading = np.clip(np.tensordot(light, normals, axes=1), 0.0, None)
        image = gaussian_filter(np.where(inside, ALBEDO * shading, BACKGROUND), PIXEL_BLUR_PX)
        image += rng.normal(0.0, NOISE, SHAPE)
        images.append(np.round(255.0 * np.clip(image, 0.0, 1.0)).astype(np.uint8))
    edges = inside & ~np.roll(inside, 1, axis=0) | inside & ~np.roll(inside, -1, axis=0)
    edges |= inside & ~np.roll(inside, 1, axis=1) | inside & ~np.roll(inside, -1, axis=1)
    edges[:, :-1] |= inside[:, :-1] & inside[:, 1:] & (face[:, :-1] != face[:, 1:])
    return images, edges
