"""Procedural textures: albedo at a point of a surface, as a compiled kernel.

Noise is in space, so it needs no texture coordinates and runs over corners; panels, lines and the checker
live in the plane of the face.
"""

import math

import numpy as np

from image_server.simulator.material import TEXTURES
from numerics.arrays import Floats
from numerics.kernels import kernel

# columns of a surface's row of numbers
ALBEDO, TEXTURE, SIZE, CONTRAST, GRAIN, SPECULAR, ALPHA, OFFSET = range(8)
HALF_U, HALF_V = 8, 9  # half the face's extent along its two axes, metres
CRINKLE = 10
COLUMNS = 11

PLAIN, NOISE, VEINS, PANELS, LINES, CHECKER = range(len(TEXTURES))
GRAIN_SIZE_M = 0.0025  # chosen by hand: paint and blasted metal
LINE_WIDTH = 0.18  # of a printed line, fraction of the line distance
GAP_WIDTH = 0.08  # between solar cells, fraction of a cell
VEIN_SHARPNESS = 3.0  # chosen by hand
NOISE_SLOPE = 0.331  # standard deviation of one component of the gradient of `noise`, per cell
SLOPE_STEP = 0.05  # of a cell, over which that gradient is taken


@kernel(inline="always")
def _hashed(x: int, y: int, z: int) -> float:
    """A number in [0, 1) of three integers; no pattern that can be seen."""
    h = np.uint32(x) * np.uint32(374761393) + np.uint32(y) * np.uint32(668265263)
    h = np.uint32(h + np.uint32(z) * np.uint32(2246822519))
    h = np.uint32((h ^ (h >> np.uint32(15))) * np.uint32(2246822519))
    h = np.uint32((h ^ (h >> np.uint32(13))) * np.uint32(3266489917))
    h = np.uint32(h ^ (h >> np.uint32(16)))
    return float(h) * (1.0 / 4294967296.0)


@kernel()
def noise(x: float, y: float, z: float) -> float:
    """Value noise in [0, 1], one value per unit cell, joined smoothly."""
    fx, fy, fz = math.floor(x), math.floor(y), math.floor(z)
    i, j, k = int(fx), int(fy), int(fz)
    u, v, w = x - fx, y - fy, z - fz
    u = u * u * (3.0 - 2.0 * u)
    v = v * v * (3.0 - 2.0 * v)
    w = w * w * (3.0 - 2.0 * w)
    low = (1 - v) * ((1 - u) * _hashed(i, j, k) + u * _hashed(i + 1, j, k)) + v * (
        (1 - u) * _hashed(i, j + 1, k) + u * _hashed(i + 1, j + 1, k)
    )
    high = (1 - v) * ((1 - u) * _hashed(i, j, k + 1) + u * _hashed(i + 1, j, k + 1)) + v * (
        (1 - u) * _hashed(i, j + 1, k + 1) + u * _hashed(i + 1, j + 1, k + 1)
    )
    return (1 - w) * low + w * high


@kernel()
def albedo(surface: Floats, x: float, y: float, z: float, u: float, v: float) -> float:
    """Albedo at a point.

    Parameters
    ----------
    surface : (COLUMNS,) the surface's numbers.
    x, y, z : the point in the frame of the thing it belongs to, metres.
    u, v : the point in the plane of its face, from the face's middle, metres.
    """
    kind = int(surface[TEXTURE])
    size = surface[SIZE]
    shift = surface[OFFSET]
    value = 1.0
    if kind == NOISE:
        p, q, r = x / size + shift, y / size, z / size
        value = (
            noise(p, q, r) * 0.55
            + noise(2 * p + 7, 2 * q, 2 * r) * 0.3
            + noise(4 * p + 3, 4 * q, 4 * r) * 0.15
        )
    elif kind == VEINS:
        p, q, r = x / size + shift, y / size, z / size
        bend = noise(p * 0.7 + 11, q * 0.7, r * 0.7) - 0.5
        ridge = abs(2 * noise(p + bend, q + bend, r + bend) - 1)
        fine = abs(2 * noise(2.1 * p + 5, 2.1 * q, 2.1 * r) - 1)
        value = min(1.0, VEIN_SHARPNESS * min(ridge, 0.3 + fine))
    elif kind == PANELS:
        cell_u, cell_v = u / size, v / (1.5 * size)
        part_u, part_v = cell_u - math.floor(cell_u), cell_v - math.floor(cell_v)
        if min(part_u, 1 - part_u) < GAP_WIDTH or min(part_v, 1 - part_v) < GAP_WIDTH * 0.67:
            value = 1.0
        else:
            value = 0.25 * _hashed(math.floor(cell_u) + 17, math.floor(cell_v), int(shift))
    elif kind == LINES:
        border = min(surface[HALF_U] - abs(u), surface[HALF_V] - abs(v)) / size
        part = border - math.floor(border)
        if border >= 0.5 and abs(part - 0.5) < LINE_WIDTH / 2:
            value = 0.0
    elif kind == CHECKER:
        value = float((math.floor(u / size) + math.floor(v / size)) % 2)
    out: float = surface[ALBEDO] * (1.0 - surface[CONTRAST] * (1.0 - value))
    if surface[GRAIN] > 0.0:
        g = GRAIN_SIZE_M
        out *= 1.0 - surface[GRAIN] * noise(x / g + shift, y / g, z / g)
    return out


@kernel()
def crinkled(surface: Floats, x: float, y: float, z: float, slope: Floats) -> None:
    """Slope of the folds at a point: writes the three components of their gradient to `slope` (3,).

    The normal leans against it: n - slope, less what lies along n.
    """
    size, shift = surface[SIZE], surface[OFFSET]
    p, q, r = x / size + shift, y / size, z / size
    scale = surface[CRINKLE] / NOISE_SLOPE / (2.0 * SLOPE_STEP)
    slope[0] = scale * (noise(p + SLOPE_STEP, q, r) - noise(p - SLOPE_STEP, q, r))
    slope[1] = scale * (noise(p, q + SLOPE_STEP, r) - noise(p, q - SLOPE_STEP, r))
    slope[2] = scale * (noise(p, q, r + SLOPE_STEP) - noise(p, q, r - SLOPE_STEP))
