"""Statues: bodies of bumpy capsules, ray traced under one light at a time that goes round them.

How they look, what stands behind them and what photographs them are varied (`LOOKS`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import cv2
import numpy as np
import trimesh
from scipy.ndimage import gaussian_filter
from trimesh.ray.ray_pyembree import RayMeshIntersector

from numerics.arrays import Flags, Floats, Grey, Ints

SIDE_PX = 512
PX_PER_UNIT = 190.0  # a statue is two units high
LIGHTS = 12
ALBEDO, PAINTED, BACKGROUND = 0.6, (0.15, 0.45, 0.75), 0.01
GLOSS, GLOSS_POWER = 0.5, 40  # of a painted one
EXPOSURE = 1.2
PIXEL_BLUR_PX = 0.7
READ_NOISE, SHOT_NOISE = 0.003, 0.01  # of full scale; of its root
SHADOW_RAY_FROM = 2e-3  # units off the surface
FOLDS, FOLD_DEPTH = 5.0, 0.05  # of carved ones: how many over a radius, of which share they are deep
LAMP_AT = 4.0  # units from the middle, of near lamps
WALL_AT, WALL_ALBEDO = 0.6, 0.35  # units behind the middle of the body
BOUNCED = 0.25  # of a room's light comes from all sides


class Camera(NamedTuple):
    """What becomes of the light.

    Attributes
    ----------
    gamma
        Of its tone curve: grey = light ** (1 / gamma).
    quality
        Of JPEG; 0: none.
    size
        Side of the images beside `SIDE_PX`.
    exposure
        Of a white surface that faces the light.
    noise
        Beside the usual one.
    """

    gamma: float = 1.0
    quality: int = 0
    size: float = 1.0
    exposure: float = EXPOSURE
    noise: float = 1.0


class Look(NamedTuple):
    """Of a statue: painted ones have patches of three albedos and are glossy, any other is matt.

    Attributes
    ----------
    carved
        With folds, creases 3 to 15 px apart.
    wall
        Behind it is a lit wall, on which its shadow falls.
    near_lamps
        Else the lights are as far as the sun.
    room
        And light comes from all sides, as from a room's walls.
    elevation_deg
        Of the lights, above the image plane.
    """

    painted: bool = False
    elevation_deg: float = 35.0
    carved: bool = False
    wall: bool = False
    near_lamps: bool = False
    room: bool = False
    camera: Camera = Camera()


PHONE = Camera(gamma=2.2, quality=75)
LOOKS = {
    "matt": Look(),
    "painted": Look(painted=True),
    "carved": Look(carved=True, elevation_deg=50.0),
    "carved, painted, high light": Look(painted=True, carved=True, elevation_deg=60.0),
    "matt, wall": Look(wall=True),
    "matt, wall, near lamps": Look(wall=True, near_lamps=True),
    "painted, room": Look(painted=True, wall=True, room=True),
    "carved, room, near lamps": Look(carved=True, wall=True, near_lamps=True, room=True),
    "matt, phone": Look(camera=PHONE),
    "painted, phone, room": Look(painted=True, wall=True, room=True, camera=PHONE),
    "carved, small, jpeg": Look(carved=True, camera=Camera(quality=60, size=0.5)),
    "matt, dim": Look(camera=Camera(exposure=0.3, noise=2.0)),
    "painted, bright": Look(painted=True, elevation_deg=50.0, camera=Camera(exposure=2.0)),
}
"""By name."""


class Statue(NamedTuple):
    """Images uint8 (H, W), one light each; where the statue is, bool (H, W)."""

    images: list[Grey]
    mask: Flags


class _Surface(NamedTuple):
    """What pixels show: which they are, int (N,); places and normals (N, 3); how much they reflect (N,)."""

    pixels: Ints
    places: Floats
    normals: Floats
    albedo: Floats
    gloss: float


def statue(seed: int, look: Look) -> Statue:
    """A statue under `LIGHTS` lights all round it."""
    rng = np.random.default_rng(seed)
    solid = body(rng, look.carved, 6 if look.carved else 4)
    rays: Any = RayMeshIntersector(solid)
    y, x = (one.ravel() for one in np.mgrid[:SIDE_PX, :SIDE_PX])
    half = SIDE_PX / 2
    origins = np.stack([(x - half) / PX_PER_UNIT, (y - half) / PX_PER_UNIT, np.full(x.shape, -3.0)], axis=1)
    places, seen, faces = rays.intersects_location(
        origins, np.tile([0.0, 0.0, 1.0], (len(origins), 1)), multiple_hits=False
    )
    triangles: Any = trimesh.triangles  # trimesh's are untyped
    shares = triangles.points_to_barycentric(solid.triangles[faces], places)
    normals = (solid.vertex_normals[solid.faces[faces]] * shares[..., None]).sum(axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    albedo = _paint(rng, places) if look.painted else np.full(len(places), ALBEDO)
    shown = [_Surface(seen, places, normals, albedo, GLOSS * look.painted)]
    mask = np.zeros(SIDE_PX * SIDE_PX, np.bool_)
    mask[seen] = True
    if look.wall:
        shown.append(_wall(origins, mask))
    images = []
    for number in range(LIGHTS):
        light = _direction(
            2 * np.pi * number / LIGHTS + 0.15 * rng.normal(), look.elevation_deg + 8 * rng.normal()
        )
        glow = np.full(SIDE_PX * SIDE_PX, BACKGROUND)
        for surface in shown:
            glow[surface.pixels] += _glow(rays, surface, light, look)
        images.append(_photographed(rng, glow.reshape(SIDE_PX, SIDE_PX), look.camera))
    seen_there = cv2.resize(
        mask.reshape(SIDE_PX, SIDE_PX).astype(np.uint8), images[0].shape[::-1], interpolation=cv2.INTER_AREA
    )
    return Statue(images, seen_there > 0)


def _wall(origins: Floats, mask: Flags) -> _Surface:
    """What is seen beside the body."""
    pixels = np.flatnonzero(~mask)
    places = origins[pixels] * [1.0, 1.0, 0.0] + [0.0, 0.0, WALL_AT]
    normals = np.tile([0.0, 0.0, -1.0], (len(pixels), 1))
    return _Surface(pixels, places, normals, np.full(len(pixels), WALL_ALBEDO), 0.0)


def _glow(rays: Any, surface: _Surface, light: Floats, look: Look) -> Floats:
    """What a surface sends to the camera under one light, a unit vector to it from the middle."""
    away, bounced = surface.places + SHADOW_RAY_FROM * surface.normals, BOUNCED * look.room
    to = LAMP_AT * light - look.near_lamps * surface.places
    distance = np.linalg.norm(to, axis=1, keepdims=True)
    lit = ~rays.intersects_any(away, to / distance)
    facing = np.sum(surface.normals * to, axis=1) * LAMP_AT**2 / distance[:, 0] ** 3
    facing = np.clip(facing, 0.0, None) * lit
    open_to = 0.5 - 0.5 * surface.normals[:, 2]
    glow = surface.albedo * ((1.0 - bounced) * facing + bounced * open_to)
    between = light + np.array([0.0, 0.0, -1.0])
    mirrored = surface.normals @ (between / np.linalg.norm(between))
    return np.asarray(glow + surface.gloss * np.clip(mirrored, 0.0, None) ** GLOSS_POWER * (facing > 0))


def _photographed(rng: np.random.Generator, glow: Floats, camera: Camera) -> Grey:
    sharp = camera.exposure * gaussian_filter(glow, PIXEL_BLUR_PX)
    if camera.size != 1.0:
        sharp = cv2.resize(sharp, None, fx=camera.size, fy=camera.size, interpolation=cv2.INTER_AREA)
    spread = camera.noise * np.hypot(READ_NOISE, SHOT_NOISE * np.sqrt(sharp))
    noisy = np.clip(sharp + rng.normal(size=sharp.shape) * spread, 0.0, 1.0) ** (1.0 / camera.gamma)
    image = np.asarray(np.round(255.0 * noisy), np.uint8)
    if not camera.quality:
        return image
    jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, camera.quality])[1]
    return np.asarray(cv2.imdecode(jpeg, cv2.IMREAD_GRAYSCALE), np.uint8)


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


def body(rng: np.random.Generator, carved: bool, subdivisions: int) -> trimesh.Trimesh:
    """Trunk, head, arms and legs, spheres of so many subdivisions each; y points down."""

    def at(x: float, y: float, z: float, wander: float = 0.0) -> Floats:
        return np.array([x, y, z]) + wander * rng.normal(size=3)

    hip, chest, head = at(0, 0.2, 0, 0.08), at(0, -0.3, 0, 0.08), at(0, -0.8, -0.05, 0.06)
    limbs = [(hip, chest, rng.uniform(0.26, 0.36)), (head, head + at(0, -0.08, 0), rng.uniform(0.17, 0.22))]
    for side in (-1, 1):
        shoulder = chest + at(0.33 * side, -0.05, 0)
        elbow = shoulder + at(side * rng.uniform(0.05, 0.3), rng.uniform(0.1, 0.35), -rng.uniform(0, 0.3))
        hand = elbow + at(side * rng.uniform(-0.3, 0.1), rng.uniform(-0.2, 0.3), -rng.uniform(0, 0.25))
        knee = hip + at(0.17 * side, 0.45, -rng.uniform(0, 0.15))
        foot = knee + at(side * rng.uniform(0, 0.1), 0.4, 0)
        limbs += [(shoulder, elbow, 0.09), (elbow, hand, 0.07)]
        limbs += [(hip + at(0.14 * side, 0.1, 0), knee, 0.13), (knee, foot, 0.09)]
    parts = [_capsule(rng, *limb, carved, subdivisions) for limb in limbs]
    starts = np.cumsum([0, *(len(one.vertices) for one in parts[:-1])])
    return trimesh.Trimesh(
        np.concatenate([one.vertices for one in parts]),
        np.concatenate([one.faces + n for one, n in zip(parts, starts, strict=True)]),
        process=False,
    )


def _capsule(
    rng: np.random.Generator, start: Floats, end: Floats, radius: float, carved: bool, subdivisions: int
) -> trimesh.Trimesh:
    ball = trimesh.creation.icosphere(subdivisions=subdivisions)

    def waves(least: float, most: float) -> Floats:
        direction = rng.normal(size=3) * rng.uniform(least, most)
        return np.asarray(np.cos(ball.vertices @ direction + rng.uniform(0, 2 * np.pi)))

    bumps = 0.035 * np.sum([waves(2, 7) for _ in range(12)], axis=0)
    if carved:
        bumps = bumps - FOLD_DEPTH * np.abs(waves(FOLDS, 2 * FOLDS) + waves(1, 3))
    far = ball.vertices @ (end - start) > 0
    vertices = radius * ball.vertices * (1 + bumps)[:, None] + np.where(far[:, None], end, start)
    return trimesh.Trimesh(vertices, ball.faces, process=False)
