"""Statues: bodies of bumpy capsules, ray traced under one light at a time that goes round them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from trimesh.ray.ray_pyembree import RayMeshIntersector

Floats = NDArray[np.float64]

SIDE_PX = 512
PX_PER_UNIT = 190.0  # a statue is two units high
LIGHTS = 12
ALBEDO, PAINTED, BACKGROUND = 0.6, (0.15, 0.45, 0.75), 0.01
GLOSS, GLOSS_POWER = 0.5, 40  # of a painted one
EXPOSURE = 1.2
PIXEL_BLUR_PX = 0.7
READ_NOISE, SHOT_NOISE = 0.003, 0.01  # of full scale; of its root
SHADOW_RAY_FROM = 2e-3  # units off the surface


class Statue(NamedTuple):
    """Images uint8 (512, 512), linear, one light each; where the statue is, bool (512, 512)."""

    images: list[NDArray[np.uint8]]
    mask: NDArray[np.bool_]


def statue(seed: int, painted: bool, elevation_deg: float) -> Statue:
    """A statue under `LIGHTS` lights all round it, each about so high above the image plane.

    A painted one has patches of three albedos and is glossy, any other is matt.
    """
    rng = np.random.default_rng(seed)
    body = _body(rng)
    rays: Any = RayMeshIntersector(body)
    y, x = (one.ravel() for one in np.mgrid[:SIDE_PX, :SIDE_PX])
    half = SIDE_PX / 2
    origins = np.stack([(x - half) / PX_PER_UNIT, (y - half) / PX_PER_UNIT, np.full(x.shape, -3.0)], axis=1)
    places, seen, faces = rays.intersects_location(
        origins, np.tile([0.0, 0.0, 1.0], (len(origins), 1)), multiple_hits=False
    )
    triangles: Any = trimesh.triangles  # trimesh's are untyped
    shares = triangles.points_to_barycentric(body.triangles[faces], places)
    normals = (body.vertex_normals[body.faces[faces]] * shares[..., None]).sum(axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    albedo = _paint(rng, places) if painted else np.full(len(places), ALBEDO)
    images = []
    for number in range(LIGHTS):
        light = _direction(
            2 * np.pi * number / LIGHTS + 0.15 * rng.normal(), elevation_deg + 8 * rng.normal()
        )
        lit = ~rays.intersects_any(places + SHADOW_RAY_FROM * normals, np.tile(light, (len(places), 1)))
        facing = np.clip(normals @ light, 0.0, None) * lit
        glow = albedo * facing
        if painted:
            between = light + np.array([0.0, 0.0, -1.0])
            mirrored = normals @ (between / np.linalg.norm(between))
            glow += GLOSS * np.clip(mirrored, 0.0, None) ** GLOSS_POWER * (facing > 0)
        image = np.full(SIDE_PX * SIDE_PX, BACKGROUND)
        image[seen] += glow
        images.append(_photographed(rng, image.reshape(SIDE_PX, SIDE_PX)))
    mask = np.zeros(SIDE_PX * SIDE_PX, np.bool_)
    mask[seen] = True
    return Statue(images, mask.reshape(SIDE_PX, SIDE_PX))


def _photographed(rng: np.random.Generator, glow: Floats) -> NDArray[np.uint8]:
    sharp = EXPOSURE * gaussian_filter(glow, PIXEL_BLUR_PX)
    noisy = sharp + rng.normal(size=sharp.shape) * np.hypot(READ_NOISE, SHOT_NOISE * np.sqrt(sharp))
    return np.asarray(np.round(255.0 * np.clip(noisy, 0.0, 1.0)), np.uint8)


def _direction(azimuth: float, elevation_deg: float) -> Floats:
    """To a light, a unit vector; the camera looks along z."""
    elevation = np.deg2rad(elevation_deg)
    return np.array(
        [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), -np.sin(elevation)]
    )


def _paint(rng: np.random.Generator, places: Floats) -> Floats:
    waves = sum(np.cos(places @ (7 * rng.normal(size=3)) + rng.uniform(0, 2 * np.pi)) for _ in range(4))
    dark, middle, bright = PAINTED
    return np.where(waves > 0.8, dark, np.where(waves < -0.8, bright, middle))


def _body(rng: np.random.Generator) -> trimesh.Trimesh:
    """Trunk, head, arms and legs; y points down."""

    def at(x: float, y: float, z: float, wander: float = 0.0) -> Floats:
        return np.array([x, y, z]) + wander * rng.normal(size=3)

    hip, chest, head = at(0, 0.2, 0, 0.08), at(0, -0.3, 0, 0.08), at(0, -0.8, -0.05, 0.06)
    parts = [
        _capsule(rng, hip, chest, rng.uniform(0.26, 0.36)),
        _capsule(rng, head, head + at(0, -0.08, 0), rng.uniform(0.17, 0.22)),
    ]
    for side in (-1, 1):
        shoulder = chest + at(0.33 * side, -0.05, 0)
        elbow = shoulder + at(side * rng.uniform(0.05, 0.3), rng.uniform(0.1, 0.35), -rng.uniform(0, 0.3))
        hand = elbow + at(side * rng.uniform(-0.3, 0.1), rng.uniform(-0.2, 0.3), -rng.uniform(0, 0.25))
        knee = hip + at(0.17 * side, 0.45, -rng.uniform(0, 0.15))
        foot = knee + at(side * rng.uniform(0, 0.1), 0.4, 0)
        parts += [_capsule(rng, shoulder, elbow, 0.09), _capsule(rng, elbow, hand, 0.07)]
        parts += [_capsule(rng, hip + at(0.14 * side, 0.1, 0), knee, 0.13), _capsule(rng, knee, foot, 0.09)]
    starts = np.cumsum([0, *(len(one.vertices) for one in parts[:-1])])
    return trimesh.Trimesh(
        np.concatenate([one.vertices for one in parts]),
        np.concatenate([one.faces + n for one, n in zip(parts, starts, strict=True)]),
        process=False,
    )


def _capsule(rng: np.random.Generator, start: Floats, end: Floats, radius: float) -> trimesh.Trimesh:
    ball = trimesh.creation.icosphere(subdivisions=4)
    bumps = sum(
        0.035 * np.cos(ball.vertices @ (rng.normal(size=3) * rng.uniform(2, 7)) + rng.uniform(0, 2 * np.pi))
        for _ in range(12)
    )
    far = ball.vertices @ (end - start) > 0
    vertices = radius * ball.vertices * (1 + bumps)[:, None] + np.where(far[:, None], end, start)
    return trimesh.Trimesh(vertices, ball.faces, process=False)
